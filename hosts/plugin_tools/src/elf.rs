//! Reads what a library needs and exports from its file, without running any of its code.

use std::collections::{BTreeSet, HashSet};

use object::{
    Endianness, elf,
    read::elf::{Dyn as _, ElfFile64, FileHeader as _, ProgramHeader as _, Rela as _, Sym as _},
};
use tatu_plugin_api::abi::tatu_plugin_t;

/// The symbol that a plugin exports.
pub const PLUGIN_SYMBOL: &str = "tatu_plugin";

/// The type of an ELF file, according to its header and dynamic section.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ElfKind {
    Library,
    Program,
    /// An object file, compiled from one source file.
    Object,
}

/// The properties of a library that can be read from its file.
pub struct Elf {
    pub sort: ElfKind,
    pub soname: Option<String>,
    /// The names of the libraries that the library is linked with.
    pub needed: Vec<String>,
    /// The folders in which these are searched: for this library and everything it needs (`rpath`), or for this library
    /// only (`runpath`).
    pub rpath: Vec<String>,
    pub runpath: Vec<String>,
    /// The symbols that other libraries can use.
    pub exports: HashSet<String>,
    /// The symbols that other libraries must provide; weak symbols, which may be missing, are not included.
    pub uses: Vec<String>,
    /// The symbol versions that the library defines, and those that it requires from other libraries, each as library
    /// and version.
    pub versions: BTreeSet<String>,
    pub needs_versions: Vec<(String, String)>,
    pub entry: SymbolEntry,
    /// The draft numbers of the extensions that the library names.
    pub drafts: BTreeSet<u32>,
}

/// How a library contains the symbol `tatu_plugin`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SymbolEntry {
    Exported(Option<Descriptor>),
    /// The symbol is a function.
    Function,
    /// The symbol is used but not defined.
    Used,
    /// The symbol is local: `static` or hidden; after linking, both look the same.
    Local,
    /// The symbol has a name mangled by a C++ compiler.
    Mangled(String),
    Absent,
}

/// The contents of the descriptor, as far as they can be read from the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Descriptor {
    pub size: u32,
    pub abi: (u16, u16),
    pub id: Option<String>,
    pub version: Option<String>,
}

type ParsedFile<'a> = ElfFile64<'a, Endianness, &'a [u8]>;

/// Reads a 64-bit ELF file; returns `None` if the file has another format, or if its tables are inconsistent.
pub fn read(bytes: &[u8]) -> Option<Elf> {
    let file = ParsedFile::parse(bytes).ok()?;
    let e = file.endian();
    let text = |b: &[u8]| String::from_utf8_lossy(b).into_owned();
    let mut out = Elf {
        sort: match file.elf_header().e_type(e) {
            elf::ET_REL => ElfKind::Object,
            elf::ET_EXEC => ElfKind::Program,
            _ => ElfKind::Library,
        },
        soname: None,
        needed: Vec::new(),
        rpath: Vec::new(),
        runpath: Vec::new(),
        exports: HashSet::new(),
        uses: Vec::new(),
        versions: BTreeSet::new(),
        needs_versions: Vec::new(),
        entry: SymbolEntry::Absent,
        drafts: drafts(&file),
    };
    let dynamic = file.elf_dynamic_table().ok()?;
    let folders = |s: String| s.split(':').filter(|f| !f.is_empty()).map(str::to_owned).collect::<Vec<_>>();
    for d in dynamic.iter() {
        let value = || dynamic.string(d).map(text).unwrap_or_default();
        match d.tag {
            elf::DT_NEEDED => out.needed.push(value()),
            elf::DT_SONAME => out.soname = Some(value()),
            elf::DT_RPATH => out.rpath = folders(value()),
            elf::DT_RUNPATH => out.runpath = folders(value()),
            // A position-independent program has the same type as a library, but the loader refuses it.
            elf::DT_FLAGS_1 if d.val & elf::DF_1_PIE.0 != 0 => out.sort = ElfKind::Program,
            _ => {}
        }
    }
    let symbols = file.elf_dynamic_symbol_table();
    for symbol in symbols.iter() {
        let Ok(name) = symbols.symbol_name(e, symbol).map(text) else { continue };
        if name.is_empty() || symbol.st_bind() == elf::STB_LOCAL {
            continue;
        }
        match (symbol.is_undefined(e), symbol.is_weak()) {
            (false, _) => drop(out.exports.insert(name)),
            (true, false) => out.uses.push(name),
            (true, true) => {}
        }
    }
    out.uses.sort();
    read_versions(&file, &mut out);
    out.entry = entry(&file, &out);
    Some(out)
}

/// Reads the symbol versions that a library defines, and those that it requires.
fn read_versions(file: &ParsedFile<'_>, out: &mut Elf) {
    let (e, data, sections) = (file.endian(), file.data(), file.elf_section_table());
    let text = |b: &[u8]| String::from_utf8_lossy(b).into_owned();
    if let Ok(Some((mut all, link))) = sections.gnu_verdef(e, data)
        && let Ok(strings) = sections.strings(e, data, link)
    {
        while let Ok(Some((_, mut names))) = all.next() {
            // The first name is the version itself; the others are its predecessors.
            if let Ok(Some(name)) = names.next() {
                out.versions.extend(name.name(e, strings).ok().map(text));
            }
        }
    }
    if let Ok(Some((mut all, link))) = sections.gnu_verneed(e, data)
        && let Ok(strings) = sections.strings(e, data, link)
    {
        while let Ok(Some((of, mut names))) = all.next() {
            let library = of.file(e, strings).map(text).unwrap_or_default();
            while let Ok(Some(version)) = names.next() {
                let optional = version.vna_flags.get(e).0 & elf::VER_FLG_WEAK.0 != 0;
                if let (false, Ok(name)) = (optional, version.name(e, strings)) {
                    out.needs_versions.push((library.clone(), text(name)));
                }
            }
        }
    }
}

/// Returns how a library contains the symbol `tatu_plugin`.
fn entry(file: &ParsedFile<'_>, read: &Elf) -> SymbolEntry {
    let e = file.endian();
    let exported = file.elf_dynamic_symbol_table();
    let named = |s: &&elf::Sym64<Endianness>| exported.symbol_name(e, s).is_ok_and(|n| n == PLUGIN_SYMBOL.as_bytes());
    if let Some(symbol) = exported.iter().find(named) {
        return match (symbol.is_undefined(e), symbol.st_type()) {
            (true, _) => SymbolEntry::Used,
            (false, elf::STT_FUNC | elf::STT_GNU_IFUNC) => SymbolEntry::Function,
            (false, _) => SymbolEntry::Exported(descriptor(file, symbol.st_value(e))),
        };
    }
    // C++ puts the length before a name, and gives a constant at file scope internal linkage.
    let mangled =
        |name: &str| name.starts_with("_Z") && name.contains(&format!("{}{PLUGIN_SYMBOL}", PLUGIN_SYMBOL.len()));
    if let Some(name) = read.exports.iter().filter(|n| mangled(n)).min() {
        return SymbolEntry::Mangled(name.clone());
    }
    let all = file.elf_symbol_table();
    for symbol in all.iter() {
        let Ok(name) = all.symbol_name(e, symbol).map(String::from_utf8_lossy) else { continue };
        if name == PLUGIN_SYMBOL && !symbol.is_undefined(e) {
            return SymbolEntry::Local;
        }
        if mangled(&name) {
            return SymbolEntry::Mangled(name.into_owned());
        }
    }
    SymbolEntry::Absent
}

/// Returns the bytes at an address of the loaded library; parts that are not stored in the file are zero.
fn bytes_at(file: &ParsedFile<'_>, address: u64, length: usize) -> Option<Vec<u8>> {
    let e = file.endian();
    let holds = |s: &&elf::ProgramHeader64<Endianness>| {
        s.p_type(e) == elf::PT_LOAD && (s.p_vaddr(e)..s.p_vaddr(e).saturating_add(s.p_memsz(e))).contains(&address)
    };
    let segment = file.elf_program_headers().iter().find(holds)?;
    let from = address - segment.p_vaddr(e);
    let in_file = usize::try_from(segment.p_filesz(e).saturating_sub(from)).ok()?.min(length);
    let start = usize::try_from(segment.p_offset(e).checked_add(from)?).ok()?;
    let mut out = match in_file {
        0 => Vec::new(),
        n => file.data().get(start..)?.get(..n)?.to_vec(),
    };
    out.resize(length, 0);
    Some(out)
}

/// Returns the descriptor at an address, or `None` if the file does not contain it.
fn descriptor(file: &ParsedFile<'_>, address: u64) -> Option<Descriptor> {
    let number = |offset: usize, length: usize| {
        let bytes = bytes_at(file, address.checked_add(offset as u64)?, length)?;
        let all = bytes.iter().enumerate();
        Some(all.map(|(i, b)| u64::from(*b) << (8 * i)).sum::<u64>())
    };
    // Only little-endian files are read, as on the hosts that can load them.
    if file.endian() != Endianness::Little {
        return None;
    }
    let size = u32::try_from(number(0, 4)?).ok()?;
    let text = |offset: usize| {
        let has = size as usize >= offset + 8;
        let place = address.checked_add(offset as u64)?;
        let to = relocated_pointer(file, place).or_else(|| number(offset, 8)).filter(|p| has && *p != 0)?;
        let bytes = (to..).map_while(|p| bytes_at(file, p, 1).map(|b| b[0])).take_while(|b| *b != 0).take(256);
        Some(tatu_core::plugins::texts::label(&bytes.collect::<Vec<_>>())).filter(|t| !t.is_empty())
    };
    Some(Descriptor {
        size,
        abi: (
            u16::try_from(number(core::mem::offset_of!(tatu_plugin_t, abi_major), 2)?).ok()?,
            u16::try_from(number(core::mem::offset_of!(tatu_plugin_t, abi_minor), 2)?).ok()?,
        ),
        id: text(core::mem::offset_of!(tatu_plugin_t, id)),
        version: text(core::mem::offset_of!(tatu_plugin_t, version)),
    })
}

/// Returns the pointer that the loader will write at an address, if the relocation table contains it.
fn relocated_pointer(file: &ParsedFile<'_>, place: u64) -> Option<u64> {
    let e = file.endian();
    let dynamic = file.elf_dynamic_table().ok()?;
    let of = |tag| dynamic.dynamics().iter().find(|d| d.d_tag(e) == tag).map(|d| d.d_val(e));
    let (table, bytes) = (of(elf::DT_RELA)?, of(elf::DT_RELASZ)?);
    let size = size_of::<elf::Rela64<Endianness>>() as u64;
    let all = bytes_at(file, table, usize::try_from(bytes.min(64 << 20)).ok()?)?;
    let all =
        object::pod::slice_from_bytes::<elf::Rela64<Endianness>>(&all, (all.len() as u64 / size) as usize).ok()?.0;
    let found = all.iter().find(|r| r.r_offset(e) == place)?;
    // A pointer into the library itself has no symbol.
    (found.r_info.get(e) >> 32 == 0).then(|| u64::try_from(found.r_addend(e)).ok()).flatten()
}

/// Returns the draft numbers of the extensions that a library names, as in `tatu.command/draft.4`.
fn drafts(file: &ParsedFile<'_>) -> BTreeSet<u32> {
    const DRAFT_MARK: &[u8] = b"/draft.";
    let e = file.endian();
    let mut out = BTreeSet::new();
    for segment in file.elf_program_headers().iter().filter(|s| s.p_type(e) == elf::PT_LOAD) {
        let Ok(data) = segment.data(e, file.data()) else { continue };
        for i in memchr::memmem::find_iter(data, DRAFT_MARK) {
            let is_name = |b: &&u8| b.is_ascii_lowercase() || matches!(b, b'_' | b'.');
            let length = data[..i].iter().rev().take_while(is_name).count();
            let name = &data[i - length..i];
            let digits: Vec<u8> = data[i + DRAFT_MARK.len()..].iter().copied().take_while(u8::is_ascii_digit).collect();
            let number = std::str::from_utf8(&digits).ok().and_then(|d| d.parse::<u32>().ok());
            // Drafts of host services (`tatu.host.*`) are not counted. In the string table, a name may directly follow
            // another one.
            let is_extension = name.windows(5).any(|w| w == b"tatu.") && !name.windows(10).any(|w| w == b"tatu.host.");
            out.extend(number.filter(|_| is_extension));
        }
    }
    out
}

#[cfg(all(test, target_os = "linux", target_pointer_width = "64", target_endian = "little"))]
mod tests {
    use super::*;

    #[test]
    fn program_is_not_a_library_and_lists_its_needs() {
        let own = read(&std::fs::read(std::env::current_exe().unwrap()).unwrap()).unwrap();
        assert_eq!((own.sort, own.entry), (ElfKind::Program, SymbolEntry::Absent));
        assert!(own.needed.iter().any(|n| n.starts_with("libc.")), "{:?}", own.needed);
        assert!(own.uses.iter().any(|n| n == "malloc"));
    }

    #[test]
    fn other_files_are_not_read_as_elf() {
        assert!(read(b"").is_none() && read(b"\x7fELF").is_none() && read(&[0; 4096]).is_none());
    }
}
