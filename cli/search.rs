//! Where this program searches for plugins.

use std::{
    ffi::OsString,
    path::{Path, PathBuf},
};

use tatu_core::{
    document::{self, Sources},
    errors::Error,
    plugins::Search,
};

/// The folders that are searched, and those that a scene names and that are not.
pub struct Searched {
    pub search: Search,
    /// Folders of the scene with libraries that nobody has allowed to load.
    pub untrusted: Vec<PathBuf>,
}

/// Packages of plugins that belong to the program, as build.rs found them in the manifest.
pub fn built() -> Vec<&'static str> {
    env!("TATU_BUILT_PLUGINS").split(',').filter(|s| !s.is_empty()).collect()
}

/// The folders for a scene, or for none; `allow`: what the command line allows.
pub fn searched(scene: Option<&Path>, sources: &Sources, allow: &[String]) -> Result<Searched, Error> {
    let exe = std::env::current_exe().ok();
    let environment = std::env::var_os("TATU_PLUGIN_PATH");
    let mut search = Search::standard(exe.as_deref(), environment.as_deref(), &built());
    let mut untrusted = Vec::new();
    if let Some(scene) = scene {
        for folder in document::plugin_folders(scene, sources)? {
            let known = search.folders.iter().any(|(f, _)| same_folder(f, &folder));
            let mut own = Search { built: search.built.clone(), ..Search::default() };
            own.add_scene_folder(folder.clone());
            // A folder without libraries runs nothing.
            if !known && !own.candidates().is_empty() && !allow.iter().any(|a| a == "plugins") && !trusted(&folder) {
                untrusted.push(folder);
            } else {
                search.add_scene_folder(folder);
            }
        }
    }
    if let Some(folder) = user_folder() {
        search.add_user_folder(folder);
    }
    Ok(Searched { search, untrusted })
}

/// The folder for plugins that the user installs, whether it is there or not. `None`: the environment names no home.
pub fn user_folder() -> Option<PathBuf> {
    user_folder_of(|name| std::env::var_os(name))
}

fn user_folder_of(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    // A relative name would mean another folder wherever the program is started.
    let folder = |name: &str| variable(name).map(PathBuf::from).filter(|p| p.is_absolute());
    let data = if cfg!(windows) {
        folder("APPDATA")?
    } else if cfg!(target_vendor = "apple") {
        folder("HOME")?.join("Library/Application Support")
    } else {
        folder("XDG_DATA_HOME").or_else(|| Some(folder("HOME")?.join(".local/share")))?
    };
    Some(data.join("tatu").join("plugins"))
}

fn same_folder(a: &Path, b: &Path) -> bool {
    a == b || a.canonicalize().ok().is_some_and(|a| b.canonicalize().is_ok_and(|b| a == b))
}

/// Whether a folder is one of those that TATU_TRUST names, or below one.
fn trusted(folder: &Path) -> bool {
    let (Some(all), Ok(folder)) = (std::env::var_os("TATU_TRUST"), folder.canonicalize()) else { return false };
    // A relative name would mean another folder wherever the program is started.
    std::env::split_paths(&all)
        .filter(|p| p.is_absolute())
        .any(|p| p.canonicalize().is_ok_and(|p| folder.starts_with(p)))
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn the_users_folder_is_absolute() {
        let of = |all: &[(&str, &str)]| {
            let all: Vec<(String, OsString)> = all.iter().map(|(n, v)| ((*n).to_owned(), OsString::from(v))).collect();
            user_folder_of(|name| all.iter().find(|(n, _)| n == name).map(|(_, v)| v.clone()))
        };
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[("HOME", "/h")]), Some(PathBuf::from("/h/.local/share/tatu/plugins")));
        assert_eq!(of(&[("HOME", "/h"), ("XDG_DATA_HOME", "/d")]), Some(PathBuf::from("/d/tatu/plugins")));
        // As the specification of these folders asks for.
        assert_eq!(of(&[("HOME", "/h"), ("XDG_DATA_HOME", "d")]), Some(PathBuf::from("/h/.local/share/tatu/plugins")));
        assert_eq!(of(&[("HOME", "")]), None);
    }
}
