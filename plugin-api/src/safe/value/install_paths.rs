//! Locates the folders that are installed with a program, and the folders of the user for private files and for copies.

use std::{
    ffi::OsString,
    path::{Path, PathBuf},
};

/// Returns the possible paths of a folder that is installed with a program, such as `models`, in the order in which
/// they are searched: beside the program, in `../share/tatu`, and in the repository if cargo has built the program
/// there. The paths need not exist.
pub fn folders_beside(program: &Path, name: &str) -> Vec<PathBuf> {
    let Some(dir) = program.parent() else { return Vec::new() };
    let mut folders = vec![dir.join(name)];
    folders.extend(dir.parent().map(|up| up.join("share/tatu").join(name)));
    // A program beside a folder `deps` is in `target/PROFILE` of the repository, where cargo has built it.
    if dir.join("deps").is_dir() {
        folders.extend(dir.parent().and_then(Path::parent).map(|root| root.join(name)));
    }
    folders
}

/// Returns the user's folder for files that are stored for later runs: `$XDG_STATE_HOME/tatu`, by default
/// `~/.local/state/tatu`, or `%LOCALAPPDATA%\tatu` on Windows. Returns `None` if the environment does not contain an
/// absolute path. The folder need not exist.
pub fn state_folder() -> Option<PathBuf> {
    user_folder_of("XDG_STATE_HOME", ".local/state", |name| std::env::var_os(name))
}

/// Returns the user's folder for files that can be made again at any time: `$XDG_CACHE_HOME/tatu`, by default
/// `~/.cache/tatu`, or `%LOCALAPPDATA%\tatu` on Windows. Returns `None` if the environment does not contain an absolute
/// path. The folder need not exist.
pub fn cache_folder() -> Option<PathBuf> {
    user_folder_of("XDG_CACHE_HOME", ".cache", |name| std::env::var_os(name))
}

/// Returns the folder that the variable `xdg` names, by default one below the user's home, given a function that returns
/// environment variables.
fn user_folder_of(xdg: &str, below_home: &str, variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    // Relative paths are ignored, because they would depend on the working folder.
    let folder = |name: &str| variable(name).map(PathBuf::from).filter(|p: &PathBuf| Path::is_absolute(p));
    let parent = folder(xdg).or_else(|| match cfg!(windows) {
        true => folder("LOCALAPPDATA"),
        false => Some(folder("HOME")?.join(below_home)),
    })?;
    Some(parent.join("tatu"))
}

/// Returns the path of the program `tatu`, for [`folders_beside`]. This is the program of the current process or, if
/// another program has opened the simulator or a plugin as a library, the path that `tatu` would have in the
/// installation to which the library belongs. Returns `None` if the system does not provide the path.
///
/// The file need not exist.
pub fn program_file() -> Option<PathBuf> {
    own_library().map_or_else(|| std::env::current_exe().ok(), |library| Some(program_of(library)))
}

/// Returns the path that the program has in the installation of a library, or the path of the library itself if its
/// folder is not that of an installation.
fn program_of(library: PathBuf) -> PathBuf {
    const PROGRAM_NAME: &str = "tatu";
    let named = |folder: Option<&Path>, name: &str| folder.and_then(Path::file_name).is_some_and(|n| n == name);
    let folder = library.parent();
    let above = folder.and_then(Path::parent);
    let root = above.and_then(Path::parent);
    let found = if named(folder, "deps") {
        above.map(|profile| profile.join(PROGRAM_NAME))
    } else if named(folder, "plugins") && named(above, "tatu") && named(root, "lib") {
        root.and_then(Path::parent).map(|prefix| prefix.join("bin").join(PROGRAM_NAME))
    } else if named(folder, "plugins") {
        above.map(|dir| dir.join(PROGRAM_NAME))
    } else if named(folder, "tatu") && named(above, "lib") {
        root.map(|prefix| prefix.join("bin").join(PROGRAM_NAME))
    } else if named(folder, "lib") {
        above.map(|prefix| prefix.join("bin").join(PROGRAM_NAME))
    } else {
        None
    };
    found.unwrap_or(library)
}

/// Returns the library that contains this code, or `None` if the program itself does.
#[cfg(unix)]
fn own_library() -> Option<PathBuf> {
    use std::{
        ffi::{CStr, OsStr, c_char, c_int, c_void},
        os::unix::ffi::OsStrExt,
    };
    /// `Dl_info` of `dlfcn.h`, whose layout is the same on Linux, macOS and the BSDs.
    #[repr(C)]
    struct DlInfo {
        file: *const c_char,
        base: *mut c_void,
        symbol: *const c_char,
        address: *mut c_void,
    }
    unsafe extern "C" {
        fn dladdr(address: *const c_void, about: *mut DlInfo) -> c_int;
    }
    let null = std::ptr::null_mut::<c_void>();
    let mut about = DlInfo { file: null.cast(), base: null, symbol: null.cast(), address: null };
    let here: fn() -> Option<PathBuf> = own_library;
    // SAFETY: `dladdr` accepts any address and writes `about`, which has the layout of `Dl_info`.
    if unsafe { dladdr(here as *const c_void, &raw mut about) } == 0 || about.file.is_null() {
        return None;
    }
    // SAFETY: the name is NUL-terminated, and lives as long as the library is loaded, which contains this code.
    let name = unsafe { CStr::from_ptr(about.file) };
    let file = Path::new(OsStr::from_bytes(name.to_bytes()));
    // For the program itself, `dladdr` returns the name by which it was started, which may lack the folder.
    let is_library = file.file_name()?.to_str()?.contains(std::env::consts::DLL_SUFFIX);
    if is_library { file.canonicalize().ok() } else { None }
}
#[cfg(not(unix))]
fn own_library() -> Option<PathBuf> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn folders_of_the_user_are_absolute() {
        let of = |all: &[(&str, &str)]| {
            user_folder_of("XDG_STATE_HOME", ".local/state", |name| {
                all.iter().find(|(n, _)| *n == name).map(|(_, value)| OsString::from(value))
            })
        };
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[("HOME", "/h")]), Some(PathBuf::from("/h/.local/state/tatu")));
        assert_eq!(of(&[("HOME", "/h"), ("XDG_STATE_HOME", "/s")]), Some(PathBuf::from("/s/tatu")));
        assert_eq!(of(&[("HOME", "/h"), ("XDG_STATE_HOME", "s")]), Some(PathBuf::from("/h/.local/state/tatu")));
    }

    #[test]
    fn installed_program_has_two_model_folders() {
        let of = |program: &str| folders_beside(Path::new(program), "models");
        assert_eq!(of("/opt/bin/tatu"), ["/opt/bin/models", "/opt/share/tatu/models"].map(PathBuf::from));
        assert_eq!(of("/"), [""; 0].map(PathBuf::from));
    }

    #[test]
    fn program_path_is_derived_from_library_path() {
        for (library, program) in [
            ("/t/target/debug/deps/libtatu_views_web.so", "/t/target/debug/tatu"),
            ("/usr/lib/tatu/plugins/libtatu_views_web.so", "/usr/bin/tatu"),
            ("/usr/lib/tatu/libtatuhost.so", "/usr/bin/tatu"),
            ("/usr/lib/libtatu.so", "/usr/bin/tatu"),
            ("/opt/tatu/plugins/libtatu_views_web.so", "/opt/tatu/tatu"),
            ("/py/tatu_sim/_native.abi3.so", "/py/tatu_sim/_native.abi3.so"),
        ] {
            assert_eq!(program_of(library.into()), PathBuf::from(program), "{library}");
        }
    }
}
