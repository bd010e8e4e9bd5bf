//! Collects everything known about one file: first by reading it, then by opening it in a separate process.

use std::{
    fs::File,
    io::Read,
    path::{Path, PathBuf},
};

use serde_json::{Value, json};
use tatu_core::errors::nearest;
use tatu_plugin_api::abi::{TATU_ABI_MAJOR, TATU_ABI_MINOR};

use super::{
    elf::{Descriptor, Elf, ElfKind, PLUGIN_SYMBOL, SymbolEntry},
    file,
    folders::{Folder, same_entry, same_file},
    loader::{Loader, NeededLibrary},
    probe::{self, ProbeReport},
    reason::{RejectReason, list_some},
};

/// Whether this program can parse this system's library files (64-bit little-endian ELF) without loading them.
pub const CAN_READ_LIBRARIES: bool =
    cfg!(all(target_os = "linux", target_pointer_width = "64", target_endian = "little"));

/// Examines files; caches the system libraries that it has read.
pub struct FileExaminer {
    loader: Loader,
    /// Time limit for the start of a plugin, in s.
    limit: f64,
}

/// What is known about a file.
pub struct FileReport {
    pub file: PathBuf,
    /// The targets of symbolic links, in the order in which they are followed.
    pub links: Vec<PathBuf>,
    pub descriptor: Option<Descriptor>,
    /// The drafts of the plugin interface that the library names.
    pub drafts: Vec<u32>,
    pub needs: Vec<NeededLibrary>,
    /// The result of opening the file in a separate process, if it was opened.
    pub report: Option<ProbeReport>,
    /// The reason that the file cannot be loaded, if any.
    pub reason: Option<RejectReason>,
}

impl FileExaminer {
    pub fn new(limit: f64) -> Self {
        FileExaminer { loader: Loader::new(), limit }
    }

    /// Returns an examiner that has not read any file.
    pub fn anew(&self) -> Self {
        FileExaminer::new(self.limit)
    }

    /// Returns whether the loader searches a folder for every library.
    pub fn is_system_folder(&self, folder: &Path) -> bool {
        self.loader.is_system_folder(folder)
    }

    /// Examines a file; opens it only if reading it revealed no problem.
    pub fn examine(&mut self, file: &Path) -> FileReport {
        let mut out = self.read(file);
        if out.reason.is_none() {
            match probe::probe(file, self.limit) {
                Ok(report) => out.report = Some(report),
                Err(reason) => out.reason = Some(reason),
            }
        }
        out
    }

    /// Like `examine`, but never opens the file.
    pub fn read(&mut self, file: &Path) -> FileReport {
        let (links, reason) = file::links(file);
        let mut out = FileReport {
            file: file.to_owned(),
            links,
            descriptor: None,
            drafts: Vec::new(),
            needs: Vec::new(),
            report: None,
            reason: reason.or_else(|| file::rejection(file)),
        };
        if out.reason.is_some() || !CAN_READ_LIBRARIES {
            return out;
        }
        out.reason = other_processor(file).or_else(|| {
            let unfit = tatu_core::plugins::check_library(file).err()?;
            Some(RejectReason::new("truncated", unfit.text, unfit.help))
        });
        // If the tables of a file are inconsistent, the system's loader decides.
        let Some(elf) = self.loader.elf(file).filter(|_| out.reason.is_none()) else { return out };
        let libraries;
        (out.needs, libraries) = self.loader.needs(file, &elf);
        out.drafts = elf.drafts.iter().copied().collect();
        if let SymbolEntry::Exported(descriptor) = &elf.entry {
            out.descriptor = descriptor.clone();
        }
        out.reason = no_library(elf.sort)
            .or_else(|| no_entry(&elf))
            .or_else(|| self.loader.missing_parts(file, &elf, &out.needs, &libraries))
            .or_else(|| out.descriptor.as_ref().and_then(unusable));
        out
    }

    /// Returns the id in a file's descriptor. Opens the file only on systems where libraries cannot be read.
    pub fn id(&mut self, file: &Path) -> Option<String> {
        if CAN_READ_LIBRARIES { self.read(file).descriptor?.id } else { self.examine(file).id() }
    }

    /// Returns the first file in the search order that has the same id and can be loaded, and that therefore hides this
    /// file.
    pub fn hidden_by(&mut self, file: &Path, id: &str, folders: &[Folder]) -> Option<PathBuf> {
        for other in folders.iter().flat_map(|f| &f.candidates) {
            // The file itself, or a link to it, does not hide it.
            if same_entry(other, file) || same_file(other, file) {
                return None;
            }
            let states = self.id(other);
            if states.as_deref().is_some_and(|other| other != id) || CAN_READ_LIBRARIES && states.is_none() {
                continue;
            }
            let examined = self.examine(other);
            if examined.id().as_deref() == Some(id) && examined.reason.is_none() {
                return Some(other.clone());
            }
        }
        None
    }
}

impl FileReport {
    /// Returns the plugin's id, if it is known.
    pub fn id(&self) -> Option<String> {
        let loaded = self.report.as_ref().and_then(|r| r.plugin.as_ref()).map(|p| p.id.clone());
        loaded.or_else(|| self.descriptor.as_ref()?.id.clone())
    }
    /// Returns the plugin's version, if it is known.
    pub fn version(&self) -> Option<String> {
        let loaded = self.report.as_ref().and_then(|r| r.plugin.as_ref()).map(|p| p.version.clone());
        loaded.or_else(|| self.descriptor.as_ref()?.version.clone())
    }
    /// Returns the ABI that the plugin was built for, if it is known.
    pub fn abi(&self) -> Option<(u16, u16)> {
        let loaded = self.report.as_ref().and_then(|r| r.plugin.as_ref()).map(|p| p.abi);
        loaded.or_else(|| self.descriptor.as_ref().filter(|d| d.size >= 8).map(|d| d.abi))
    }
    /// Returns the reason that nothing of a plugin is used, although it can be loaded.
    pub fn offers_nothing(&self) -> Option<RejectReason> {
        let report = self.report.as_ref().filter(|r| r.offers.is_empty())?;
        let remark = report.remarks.iter().find(|r| r.code != "E321" && r.code != "E323")?;
        let file = std::path::absolute(&self.file).unwrap_or_else(|_| self.file.clone());
        let text = remark.text.replace(&format!("the plugin {} ", file.display()), "it ");
        let text = text.trim_end_matches(": that part of it is not used");
        let kind = if remark.code == "E320" { "other-draft" } else { "offers-nothing" };
        Some(RejectReason::new(
            kind,
            format!("it can be opened, but nothing of it is used: {text}"),
            remark.help.clone(),
        ))
    }

    pub fn json(&self, hidden_by: Option<&Path>) -> Value {
        let path = |p: &Path| p.display().to_string();
        let need = |n: &NeededLibrary| json!({ "name": n.name, "by": n.by.as_deref().map(path), "found": n.found.as_deref().map(path) });
        let remark = |r: &probe::ProbeRemark| json!({ "code": r.code, "text": r.text, "help": r.help });
        let report = self.report.as_ref();
        json!({
            "file": path(&self.file),
            "links": self.links.iter().map(|l| path(l)).collect::<Vec<_>>(),
            "id": self.id(),
            "version": self.version(),
            "abi": self.abi().map(|(major, minor)| format!("{major}.{minor}")),
            "drafts": self.drafts,
            "needs": self.needs.iter().map(need).collect::<Vec<_>>(),
            "offers": report.map(|r| r.offers.iter().cloned().collect::<std::collections::BTreeMap<_, _>>()),
            "remarks": report.map(|r| r.remarks.iter().map(remark).collect::<Vec<_>>()),
            "hidden_by": hidden_by.map(path),
            "reason": self.reason.as_ref().map(RejectReason::json),
        })
    }
}

/// Returns the reason that a library for a different processor is refused, which makes reading its other tables
/// unnecessary.
fn other_processor(file: &Path) -> Option<RejectReason> {
    let mut header = [0; 20];
    File::open(file).and_then(|mut f| f.read_exact(&mut header)).ok()?;
    let machine = u16::from_le_bytes([header[18], header[19]]);
    let name = |machine: u16| match machine {
        3 => "32-bit x86".to_owned(),
        8 => "MIPS".to_owned(),
        20 | 21 => "PowerPC".to_owned(),
        22 => "s390".to_owned(),
        40 => "32-bit ARM".to_owned(),
        62 => "x86-64".to_owned(),
        183 => "aarch64".to_owned(),
        243 => "RISC-V".to_owned(),
        258 => "LoongArch".to_owned(),
        n => format!("an unknown processor (ELF machine {n})"),
    };
    let own = match std::env::consts::ARCH {
        "x86_64" => 62,
        "aarch64" => 183,
        "riscv64" => 243,
        _ => return None,
    };
    let text = match (header[4], header[5]) {
        (_, 2) => "it is built for a processor with a different byte order (big-endian)".to_owned(),
        (1, _) if machine == own => "it is a 32-bit library, but this is a 64-bit program".to_owned(),
        _ if machine != own => format!("it is built for {}, but this program runs on {}", name(machine), name(own)),
        (1, _) => "it is a 32-bit library, but this is a 64-bit program".to_owned(),
        _ => return None,
    };
    Some(RejectReason::new("other-processor", text, "build it for this processor, or get the author's build for it"))
}

fn no_library(sort: ElfKind) -> Option<RejectReason> {
    let (text, help) = match sort {
        ElfKind::Library => return None,
        ElfKind::Program => ("it is a program, not a library", "link it with `-shared -fPIC`, without `-pie`"),
        ElfKind::Object => (
            "it is an object file, which has not been linked",
            "link it into a library: `cc -shared -o libtatu_NAME.so FILE.o`, compiled with -fPIC",
        ),
    };
    Some(RejectReason::new("not-a-library", text, help))
}

/// Returns the reason that a library's `tatu_plugin` symbol is not visible.
fn no_entry(elf: &Elf) -> Option<RejectReason> {
    const EXPORT_HELP: &str = "write `TATU_EXPORT const tatu_plugin_t tatu_plugin = ...`, as in plugin-api/README.md";
    let (text, help) = match &elf.entry {
        SymbolEntry::Exported(_) => return None,
        SymbolEntry::Local => (
            format!(
                "it defines `{PLUGIN_SYMBOL}`, but does not export it: it is `static`, or hidden (-fvisibility=hidden, a \
                 version script)"
            ),
            EXPORT_HELP,
        ),
        SymbolEntry::Mangled(name) => (
            format!(
                "it exports no `{PLUGIN_SYMBOL}`: C++ has mangled the name to `{name}`, since `extern \"C\"` is missing"
            ),
            "include tatu.h before it is defined, or write `extern \"C\" TATU_EXPORT const tatu_plugin_t tatu_plugin`",
        ),
        SymbolEntry::Function => (
            format!("its `{PLUGIN_SYMBOL}` is a function, but must be a constant of the type `tatu_plugin_t`"),
            EXPORT_HELP,
        ),
        SymbolEntry::Used => (
            format!("it uses `{PLUGIN_SYMBOL}`, but does not define it"),
            "compile the file that defines it into the library",
        ),
        SymbolEntry::Absent => return Some(symbol_absent(elf)),
    };
    Some(RejectReason::new("no-entry", text, help))
}

fn symbol_absent(elf: &Elf) -> RejectReason {
    let mut names: Vec<&str> = elf.exports.iter().map(String::as_str).filter(|n| !n.starts_with('_')).collect();
    names.sort_unstable();
    let is_foreign = |n: &&str| matches!(*n, "v_repStart" | "simStart" | "simInit");
    if let Some(name) = names.iter().find(|n| is_foreign(n)) {
        let text = format!("it exports `{name}` and no `{PLUGIN_SYMBOL}`: it is a plugin of V-REP or CoppeliaSim");
        return RejectReason::new(
            "no-entry",
            text,
            "these have a different interface; their commands may already be available: `tatu list commands`",
        );
    }
    if let Some(near) = nearest(PLUGIN_SYMBOL, names.iter().copied()) {
        let text = format!("it exports no `{PLUGIN_SYMBOL}`, but `{near}`");
        return RejectReason::new("no-entry", text, format!("rename the constant to `{PLUGIN_SYMBOL}`"));
    }
    let text = match names.as_slice() {
        [] => format!("it exports no symbols, and therefore no `{PLUGIN_SYMBOL}`"),
        names => format!("it exports no `{PLUGIN_SYMBOL}`, but {}", list_some(names, 3)),
    };
    let help = "a plugin exports a `tatu_plugin_t` of that name: compile the file that defines it into the library; \
                in C++ include tatu.h before defining it";
    RejectReason::new("no-entry", text, help)
}

/// Returns the reason that this program cannot use a descriptor.
fn unusable(d: &Descriptor) -> Option<RejectReason> {
    if d.size < 8 {
        let what = if d.size == 0 { "empty" } else { "too short" };
        let text = format!("its descriptor `{PLUGIN_SYMBOL}` is {what}: its `size` is {} bytes", d.size);
        return Some(RejectReason::new(
            "incomplete",
            text,
            "set `size` to sizeof(tatu_plugin_t), and fill in all required fields",
        ));
    }
    (d.abi.0 != TATU_ABI_MAJOR).then(|| {
        let (major, minor) = d.abi;
        let text = format!("it was built for ABI {major}.{minor}, but this host has {TATU_ABI_MAJOR}.{TATU_ABI_MINOR}");
        RejectReason::new("other-abi", text, tatu_core::plugins::remedy(major > TATU_ABI_MAJOR))
    })
}
