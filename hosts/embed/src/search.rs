//! Determines the folders that are searched for plugins and models.

use std::{
    ffi::OsString,
    path::{Path, PathBuf},
};

use crate::pack;
use tatu_core::{
    document::{self, SourceFiles, UserSettings},
    errors::Error,
    plugins::{MODEL_FILE, SearchPath},
};
use tatu_plugin_api::safe::{MAX_FILE_BYTES, folders_beside, program_file, read_plain_text};

/// The folders that are searched for plugins and models, and the folders of the scene that are excluded.
pub struct SearchFolders {
    /// The search path.
    pub search: SearchPath,
    /// Plugin folders of the scene that contain libraries, and that the user has not allowed.
    pub untrusted: Vec<PathBuf>,
}

/// Returns the names of the program's plugin packages, which the build script reads from the manifest.
pub fn built_plugins() -> Vec<&'static str> {
    env!("TATU_BUILT_PLUGINS").split(',').filter(|s| !s.is_empty()).collect()
}

/// Returns the folders to search for plugins and models, for a scene file or, if `scene` is `None`, without a scene.
/// `allow` contains the values of `--allow`.
pub fn search_folders(scene: Option<&Path>, sources: &SourceFiles, allow: &[String]) -> Result<SearchFolders, Error> {
    let exe = program_file();
    let environment = std::env::var_os("TATU_PLUGIN_PATH");
    let mut search = SearchPath::standard(exe.as_deref(), environment.as_deref(), &built_plugins());
    let mut untrusted = Vec::new();
    if let Some(scene) = scene {
        for folder in document::plugin_folders(scene, sources).map_err(|e| similar_scene(e, scene))? {
            let known = search.folders.iter().any(|(f, _)| same_folder(f, &folder));
            let mut own = SearchPath { built: search.built.clone(), ..SearchPath::default() };
            own.add_scene_folder(folder.clone());
            // A folder without libraries cannot run any code.
            if !known && !own.candidates().is_empty() && !allow.iter().any(|a| a == "plugins") && !is_trusted(&folder) {
                untrusted.push(folder);
            } else {
                search.add_scene_folder(folder);
            }
        }
    }
    if let Some(folder) = user_folder() {
        search.add_user_folder(folder);
    }
    let of_program = std::mem::take(&mut search.models);
    let (of_scene, of_user) = model_folders(scene);
    search.models = of_scene.iter().cloned().chain(of_user).chain(of_program).collect();
    search.models_of_scene = of_scene;
    search.packages = package_folders(|name| std::env::var_os(name));
    Ok(SearchFolders { search, untrusted })
}

/// Returns the error for a scene whose plugins the user has not allowed. The caller adds the hint.
pub fn untrusted_plugins_error(scene: &Path, folder: &Path) -> Error {
    let shown = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    let text = format!(
        "{} loads plugins from {}, which you have not allowed; plugins are native code that has all of your permissions",
        scene.display(),
        shown.display()
    );
    Error::new("E312", text)
}

/// Returns the folders that are searched for models before those of the program, in order: `models` beside the scene
/// or, without a scene, in the working folder; the parent folder, if the scene is the file of a model; the folders in
/// `TATU_MODEL_PATH`; and the user's folder. The first list contains those that come with the scene.
fn model_folders(scene: Option<&Path>) -> (Vec<PathBuf>, Vec<PathBuf>) {
    let here = scene.and_then(Path::parent).unwrap_or(Path::new(""));
    let mut folders = vec![here.join("models")];
    // A model that is opened as a scene can refer to its sibling folders by name.
    if scene.and_then(Path::file_name).is_some_and(|n| n == MODEL_FILE) {
        folders.extend(std::path::absolute(here).ok().and_then(|f| f.parent().map(Path::to_owned)));
    }
    let given = std::env::var_os("TATU_MODEL_PATH").unwrap_or_default();
    let of_user: Vec<_> = std::env::split_paths(&given).filter(|f| !f.as_os_str().is_empty()).collect();
    (folders, of_user.into_iter().chain(user_folder().map(|f| f.with_file_name("models"))).collect())
}

/// Variables in which Gazebo has the folders of its models.
const MODEL_VARIABLES: [&str; 4] =
    ["GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "SDF_PATH", "GAZEBO_MODEL_PATH"];

/// Returns the folders of packages that the environment names: those of Tatu, then those of ROS and of Gazebo.
fn package_folders(variable: impl Fn(&str) -> Option<OsString>) -> Vec<PathBuf> {
    let folders = |name: &str| {
        let folders: Vec<PathBuf> = std::env::split_paths(&variable(name).unwrap_or_default()).collect();
        // An empty entry would be the working folder.
        folders.into_iter().filter(|folder| !folder.as_os_str().is_empty())
    };
    let of_tatu = variable("TATU_PACKAGE_PATH").unwrap_or_default();
    let of_tatu: Vec<_> = std::env::split_paths(&of_tatu).filter(|f| !f.as_os_str().is_empty()).collect();
    let installed = folders("AMENT_PREFIX_PATH").map(|prefix| prefix.join("share"));
    let of_gazebo = MODEL_VARIABLES.iter().flat_map(|name| folders(name));
    of_tatu.into_iter().chain(folders("ROS_PACKAGE_PATH")).chain(installed).chain(of_gazebo).collect()
}

/// Returns the file of a scene: the path itself if it exists; otherwise a scene that comes with the program, by its
/// path below `scenes` (with or without this prefix), or by its file name if exactly one scene has this name. The
/// suffix `.toml` may be omitted. If there is no such scene, the path is returned unchanged. A packed scene is unpacked
/// into the user's cache, and the path of its scene file is returned.
///
/// # Errors
/// A packed scene cannot be read or unpacked.
pub fn scene_file(given: &Path) -> Result<PathBuf, Error> {
    if pack::is_pack(given) && given.is_file() {
        return pack::open(given);
    }
    Ok(found_scene(given))
}

fn found_scene(given: &Path) -> PathBuf {
    if given.as_os_str().is_empty() || given.is_absolute() || given.exists() {
        return given.to_owned();
    }
    let name = given.strip_prefix("scenes").unwrap_or(given);
    let mut wanted = vec![name.to_owned()];
    if name.extension().is_none() {
        wanted.push(name.with_extension("toml"));
    }
    let is_name = name.components().count() == 1;
    for folder in folders_of_program("scenes") {
        if let Some(file) = wanted.iter().map(|name| folder.join(name)).find(|file| file.is_file()) {
            return file;
        }
        let below = std::fs::read_dir(&folder).into_iter().flatten().flatten().map(|e| e.path()).filter(|p| p.is_dir());
        let mut found: Vec<PathBuf> = below
            .filter(|_| is_name)
            .flat_map(|sub| wanted.iter().map(move |name| sub.join(name)))
            .filter(|file| file.is_file())
            .collect();
        if found.len() == 1 {
            return found.remove(0);
        }
    }
    given.to_owned()
}

/// Adds the hint "did you mean ...?" to the error for a scene that does not exist, if a scene that comes with the
/// program has a similar name.
fn similar_scene(error: Error, given: &Path) -> Error {
    if given.exists() {
        return error;
    }
    let entries = |folder: &Path| std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path());
    let folders = folders_of_program("scenes").into_iter().flat_map(|folder| entries(&folder).collect::<Vec<_>>());
    let files = folders.flat_map(|folder| entries(&folder).collect::<Vec<_>>());
    let scenes = files.filter(|file| file.extension().is_some_and(|e| e == "toml"));
    // A name without a folder can also lack the suffix, so it is compared without.
    let given = given.strip_prefix("scenes").unwrap_or(given);
    let is_name = given.components().count() == 1;
    let mut names: Vec<String> = scenes
        .filter_map(|file| match is_name {
            true => Some(file.file_stem()?.to_string_lossy().into_owned()),
            false => {
                let folder = file.parent()?.file_name()?.to_string_lossy().into_owned();
                Some(format!("{folder}/{}", file.file_name()?.to_string_lossy()))
            }
        })
        .collect();
    names.sort();
    let given = if is_name { Path::new(given.file_stem().unwrap_or_default()) } else { given };
    error.nearest(&given.to_string_lossy(), names.iter().map(String::as_str))
}

/// Returns the existing folders named `name` that come with the program.
pub fn folders_of_program(name: &str) -> Vec<PathBuf> {
    let program = program_file();
    let all = program.iter().flat_map(|program| folders_beside(program, name));
    all.filter(|folder| folder.is_dir()).collect()
}

/// Returns the folder in which the user installs plugins, which need not exist, or `None` if the environment does not
/// define the user's data folder by an absolute path.
pub fn user_folder() -> Option<PathBuf> {
    user_folder_of(|name| std::env::var_os(name))
}

fn user_folder_of(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    // A relative path would depend on the working folder.
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

/// Reads the user's settings. Without a settings file, returns the defaults.
pub fn user_settings() -> Result<UserSettings, Error> {
    let Some(file) = user_folder().and_then(|f| Some(f.parent()?.join("settings.toml"))) else {
        return Ok(UserSettings::default());
    };
    match read_plain_text(&file, MAX_FILE_BYTES) {
        Ok(text) => UserSettings::parse(&file, &text),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(UserSettings::default()),
        Err(e) => Err(Error::new("E105", format!("cannot read your settings {}: {e}", file.display()))),
    }
}

fn same_folder(a: &Path, b: &Path) -> bool {
    a == b || a.canonicalize().ok().is_some_and(|a| b.canonicalize().is_ok_and(|b| a == b))
}

/// Returns whether `folder` is listed in `TATU_TRUST`, or is inside a folder that is.
fn is_trusted(folder: &Path) -> bool {
    let (Some(all), Ok(folder)) = (std::env::var_os("TATU_TRUST"), folder.canonicalize()) else { return false };
    // A relative path would depend on the working folder.
    std::env::split_paths(&all)
        .filter(|p| p.is_absolute())
        .any(|p| p.canonicalize().is_ok_and(|p| folder.starts_with(p)))
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn packages_are_searched_where_ros_and_gazebo_have_them() {
        let all = [
            ("TATU_PACKAGE_PATH", "own"),
            ("ROS_PACKAGE_PATH", "/a/src:"),
            ("AMENT_PREFIX_PATH", "/b:/c"),
            ("GAZEBO_MODEL_PATH", "/d"),
            ("GZ_SIM_RESOURCE_PATH", "/e"),
        ];
        let folders = package_folders(|name| all.iter().find(|(n, _)| *n == name).map(|(_, v)| OsString::from(*v)));
        let folders: Vec<_> = folders.iter().map(|f| f.to_str().unwrap()).collect();
        assert_eq!(folders, ["own", "/a/src", "/b/share", "/c/share", "/e", "/d"]);
    }

    #[test]
    fn the_users_folder_is_absolute() {
        let of = |all: &[(&str, &str)]| {
            let all: Vec<(String, OsString)> = all.iter().map(|(n, v)| ((*n).to_owned(), OsString::from(v))).collect();
            user_folder_of(|name| all.iter().find(|(n, _)| n == name).map(|(_, v)| v.clone()))
        };
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[("HOME", "/h")]), Some(PathBuf::from("/h/.local/share/tatu/plugins")));
        assert_eq!(of(&[("HOME", "/h"), ("XDG_DATA_HOME", "/d")]), Some(PathBuf::from("/d/tatu/plugins")));
        // The XDG base directory specification requires that relative paths are ignored.
        assert_eq!(of(&[("HOME", "/h"), ("XDG_DATA_HOME", "d")]), Some(PathBuf::from("/h/.local/share/tatu/plugins")));
        assert_eq!(of(&[("HOME", "")]), None);
    }
}
