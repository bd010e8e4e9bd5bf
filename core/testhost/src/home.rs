//! Where the program is, beside which its plugins are searched.

use std::path::{Path, PathBuf};

/// Packages of plugins that belong to the program.
pub fn built() -> Vec<&'static str> {
    env!("TATU_BUILT_PLUGINS").split(',').filter(|s| !s.is_empty()).collect()
}

/// A file beside the program: this library, or the program that it is part of. None: the system does not tell.
pub fn program() -> Option<PathBuf> {
    let file = own_file().or_else(|| std::env::current_exe().ok())?;
    // Cargo builds libraries in a folder below that of the program, installations have one beside it.
    let folder = file.parent()?;
    Some(match folder.file_name().and_then(|name| name.to_str()) {
        Some("deps") => folder.with_file_name("tatu"),
        Some("tatu") => folder.parent().and_then(Path::parent)?.join("bin/tatu"),
        _ => file,
    })
}

/// The file that holds this code.
#[cfg(unix)]
fn own_file() -> Option<PathBuf> {
    use std::{
        ffi::{CStr, OsStr},
        os::unix::ffi::OsStrExt,
    };
    // SAFETY: all zeros is a value of this structure.
    let mut about: libc::Dl_info = unsafe { std::mem::zeroed() };
    let here: fn() -> Option<PathBuf> = own_file;
    // SAFETY: any address may be asked for; the answer is written to `about`.
    if unsafe { libc::dladdr(here as *const libc::c_void, &raw mut about) } == 0 || about.dli_fname.is_null() {
        return None;
    }
    // SAFETY: a name that ends with 0 and lives as long as the library.
    let name = unsafe { CStr::from_ptr(about.dli_fname) };
    let file = Path::new(OsStr::from_bytes(name.to_bytes()));
    // The program itself is named as it was started, which tells nothing about where it lies.
    let is_library = file.file_name()?.to_str()?.contains(std::env::consts::DLL_SUFFIX);
    if is_library { file.canonicalize().ok() } else { None }
}
#[cfg(not(unix))]
fn own_file() -> Option<PathBuf> {
    None
}
