//! Replaces the addresses of imported functions in loaded libraries (ELF, 64 bits).

use std::ffi::{CStr, c_char, c_int, c_void};

use object::elf;

/// A library that is loaded in this process.
pub struct LoadedLibrary {
    /// The name of its file, without folders.
    pub name: String,
    base: usize,
    dynamic: *const Dynamic,
}

/// An entry of a dynamic section.
#[repr(C)]
struct Dynamic {
    tag: i64,
    value: usize,
}

#[repr(C)]
struct Relocation {
    offset: usize,
    info: u64,
    addend: i64,
}

#[repr(C)]
struct Symbol {
    name: u32,
    info: u8,
    other: u8,
    section: u16,
    value: u64,
    size: u64,
}

/// The types of relocations that store the address of a symbol.
#[cfg(target_arch = "x86_64")]
const ADDRESS_TYPES: [u32; 3] = [1, 6, 7]; // R_X86_64_64, GLOB_DAT, JUMP_SLOT
#[cfg(not(target_arch = "x86_64"))]
const ADDRESS_TYPES: [u32; 3] = [257, 1025, 1026]; // R_AARCH64_ABS64, GLOB_DAT, JUMP_SLOT

/// Lists the libraries that are loaded in this process.
pub fn loaded_libraries() -> Vec<LoadedLibrary> {
    let mut out: Vec<LoadedLibrary> = Vec::new();
    // SAFETY: the function calls `add` for each library, with `out`, which lives until it returns.
    unsafe { libc::dl_iterate_phdr(Some(add), (&raw mut out).cast()) };
    out
}

unsafe extern "C" fn add(info: *mut libc::dl_phdr_info, _: usize, out: *mut c_void) -> c_int {
    // SAFETY: `dl_iterate_phdr` passes a valid description, and the pointer that `loaded_libraries` passed to it.
    let (info, out) = unsafe { (&*info, &mut *out.cast::<Vec<LoadedLibrary>>()) };
    let (base, n) = (info.dlpi_addr as usize, usize::from(info.dlpi_phnum));
    // SAFETY: the loader's description refers to `n` program headers and to a string.
    let (headers, path) = unsafe {
        let path = if info.dlpi_name.is_null() { c"" } else { CStr::from_ptr(info.dlpi_name) };
        (std::slice::from_raw_parts(info.dlpi_phdr, n), path.to_string_lossy().into_owned())
    };
    if let Some(at) = headers.iter().find(|h| h.p_type == elf::PT_DYNAMIC.0) {
        let name = path.rsplit('/').next().unwrap_or_default().to_owned();
        out.push(LoadedLibrary { name, base, dynamic: (base + at.p_vaddr as usize) as *const Dynamic });
    }
    0
}

/// Replaces the addresses of imported functions by those of the doubles, by name.
pub fn redirect(library: &LoadedLibrary, doubles: &[(&str, *const c_void)]) {
    let (mut symbols, mut strings, mut tables) = (0, 0, [(0, 0); 2]);
    let mut at = library.dynamic;
    // SAFETY: the loader has mapped the dynamic section, which ends with a null entry.
    while let entry @ Dynamic { tag: 1.., value } = unsafe { &*at } {
        // glibc has added the base to the addresses.
        match u32::try_from(entry.tag).unwrap_or(u32::MAX) {
            5 => strings = *value,      // DT_STRTAB
            6 => symbols = *value,      // DT_SYMTAB
            7 => tables[0].0 = *value,  // DT_RELA
            8 => tables[0].1 = *value,  // DT_RELASZ
            23 => tables[1].0 = *value, // DT_JMPREL
            2 => tables[1].1 = *value,  // DT_PLTRELSZ
            _ => {}
        }
        at = at.wrapping_add(1);
    }
    if symbols < library.base || strings < library.base {
        return;
    }
    for (table, bytes) in tables.into_iter().filter(|(table, _)| *table >= library.base && *table != 0) {
        for i in 0..bytes / size_of::<Relocation>() {
            // SAFETY: the table has this many entries, which refer to existing symbols and strings.
            let (relocation, name) = unsafe {
                let relocation = &*(table as *const Relocation).add(i);
                let symbol = &*(symbols as *const Symbol).add((relocation.info >> 32) as usize);
                (relocation, CStr::from_ptr((strings + symbol.name as usize) as *const c_char))
            };
            let double = doubles.iter().find(|(double, _)| name.to_bytes() == double.as_bytes());
            if let (true, Some((_, double))) = (ADDRESS_TYPES.contains(&(relocation.info as u32)), double) {
                write((library.base + relocation.offset) as *mut usize, double.addr() + relocation.addend as usize);
            }
        }
    }
}

/// Writes a word of a table that the loader may have made read-only.
fn write(place: *mut usize, value: usize) {
    // SAFETY: the place is a word of a loaded library, which is never unloaded. Its page becomes writable, and remains
    // so. No other thread runs code of the library yet.
    unsafe {
        let page = libc::sysconf(libc::_SC_PAGESIZE) as usize;
        let begin = place.addr() & !(page - 1);
        if libc::mprotect(begin as *mut c_void, page, libc::PROT_READ | libc::PROT_WRITE) == 0 {
            place.write(value);
        }
    }
}
