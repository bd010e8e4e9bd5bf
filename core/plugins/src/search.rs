//! The folders that are searched for plugins, and the files that can be plugins.

use std::{
    fs::File,
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
};

use tatu_errors::{Error, Result};
use tatu_plugin_api::safe::{MAX_FILE_BYTES, folders_beside, read_plain};
use tempfile::TempDir;

/// The origin of a folder on the search path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FolderOrigin {
    /// Listed in the environment variable `TATU_PLUGIN_PATH`.
    Environment,
    /// Next to the program: `plugins`, or `../lib/tatu/plugins`.
    Installed,
    /// Next to the program as built by cargo: only packages listed in its manifest are opened there.
    Built,
    /// Listed in a scene.
    Scene,
    /// The user's own folder, to which `tatu plugin install` installs plugins.
    User,
}

/// Returns the name of a library that may be a plugin, without the system's prefix and suffix.
fn stem(name: &str) -> Option<&str> {
    let stem = name.strip_suffix(std::env::consts::DLL_SUFFIX)?;
    Some(stem.strip_prefix(std::env::consts::DLL_PREFIX).unwrap_or(stem)).filter(|s| s.starts_with("tatu_"))
}

/// The search path. If several plugins have the same id, the one that is found first is used.
#[derive(Debug, Clone, Default)]
pub struct SearchPath {
    /// Folders, in search order.
    pub folders: Vec<(PathBuf, FolderOrigin)>,
    /// Libraries that are opened before those in the folders, whatever their names.
    pub files: Vec<PathBuf>,
    /// Names of libraries (without prefix and suffix) that may be opened from `FolderOrigin::Built` folders.
    pub built: Vec<String>,
    /// If set, libraries are opened as copies in this folder, which allows their files to be overwritten while in use.
    pub copies: Option<Arc<CopyFolder>>,
    /// The only file that is opened, whatever its name and folder; used to test a single plugin.
    pub only: Option<PathBuf>,
    /// Folders that are searched for models by name, in order.
    pub models: Vec<PathBuf>,
    /// The folders in `models` that come with the scene, rather than with the program or from the user.
    pub models_of_scene: Vec<PathBuf>,
    /// Folders in and below which the user has packages, to which documents refer by name, in order.
    pub packages: Vec<PathBuf>,
}

/// A temporary folder for copies of libraries, deleted on drop.
#[derive(Debug)]
pub struct CopyFolder {
    folder: TempDir,
    made: AtomicUsize,
    /// Locked as long as this process lives, however it ends.
    _lock: File,
}

/// The prefix of folders with copies, and the name of the lock in each.
const FOLDER_PREFIX: &str = "tatu-plugins-";
const LOCK_NAME: &str = "lock";

impl CopyFolder {
    /// Creates an empty temporary folder, and removes those of processes that were killed, each of which can occupy 250
    /// MB.
    pub fn new() -> Result<Self> {
        remove_abandoned(&std::env::temp_dir());
        let create = || -> std::io::Result<(TempDir, File)> {
            let folder = TempDir::with_prefix(FOLDER_PREFIX)?;
            // The file is renamed to the name of the lock only after it has been locked, so other processes never find
            // it unlocked.
            let unlocked = folder.path().join("unlocked");
            let lock = File::create(&unlocked)?;
            lock.lock()?;
            std::fs::rename(unlocked, folder.path().join(LOCK_NAME))?;
            Ok((folder, lock))
        };
        let (folder, lock) = create().map_err(|e| {
            let text = format!("cannot create a folder for copies of plugins: {e}");
            Error::new("E105", text).help("set TMPDIR to a folder that can be written")
        })?;
        Ok(CopyFolder { folder, made: AtomicUsize::new(0), _lock: lock })
    }

    /// Copies a file into a folder of its own. The path must be unique because the loader would return the first library
    /// again for a second one with the same path.
    pub fn copy(&self, file: &Path) -> std::io::Result<PathBuf> {
        let number = self.made.fetch_add(1, Ordering::Relaxed);
        let folder = self.folder.path().join(number.to_string());
        std::fs::create_dir(&folder)?;
        let copy = folder.join(file.file_name().unwrap_or_default());
        std::fs::copy(file, &copy).map(|_| copy)
    }
}

/// Returns whether another library in the folder of a file contains its name, as one that needs it does.
fn is_named_beside(file: &Path) -> bool {
    let (Some(folder), Some(name)) = (file.parent(), file.file_name()) else { return false };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path());
    let suffix = Path::new(std::env::consts::DLL_EXTENSION);
    let mut others = entries.filter(|f| f != file && f.extension() == Some(suffix.as_os_str()));
    others.any(|other| {
        let bytes = read_plain(&other, MAX_FILE_BYTES).unwrap_or_default();
        bytes.split(|b| *b == 0).any(|text| text == name.as_encoded_bytes())
    })
}

/// Links the folders of assets beside `original` beside its copy, since libraries may be in them.
pub(crate) fn link_assets(original: &Path, copy: &Path) {
    let (Some(from), Some(to)) = (original.parent(), copy.parent()) else { return };
    for entry in std::fs::read_dir(from).into_iter().flatten().flatten() {
        let folder = entry.path();
        if folder.extension().is_some_and(|e| e == "assets") && folder.is_dir() {
            // Without the link, the loader reports what it misses.
            let _ = link(&folder, &to.join(entry.file_name()));
        }
    }
}

/// Links the library beside `original` that the loader did not find beside its copy. `message` is that of the loader,
/// which names the library. Returns whether there was one.
pub(crate) fn link_beside(original: &Path, copy: &Path, message: &str) -> bool {
    let (Some(from), Some(to)) = (original.parent(), copy.parent()) else { return false };
    let is_named = |name: &str| {
        let words = message.split(|c: char| c.is_whitespace() || "\"'`:;,()".contains(c));
        words.filter_map(|word| word.rsplit(['/', '\\']).next()).any(|word| word == name)
    };
    let own = original.file_name();
    let mut linked = false;
    for entry in std::fs::read_dir(from).into_iter().flatten().flatten() {
        let (file, name) = (entry.path(), entry.file_name());
        let is_needed = Some(name.as_os_str()) != own && is_named(&name.to_string_lossy()) && file.is_file();
        if is_needed {
            linked |= link(&file, &to.join(&name)).is_ok();
        }
    }
    linked
}

/// Makes a file or folder available under another path, which must be free.
fn link(file: &Path, at: &Path) -> std::io::Result<()> {
    let file = std::path::absolute(file)?;
    #[cfg(unix)]
    return std::os::unix::fs::symlink(file, at);
    #[cfg(not(unix))]
    match at.exists() {
        true => Err(std::io::ErrorKind::AlreadyExists.into()),
        false => std::fs::copy(file, at).map(drop),
    }
}

/// Removes the folders with copies whose lock is free. Those of other users, and whatever cannot be removed, stay.
fn remove_abandoned(parent: &Path) {
    for entry in std::fs::read_dir(parent).into_iter().flatten().flatten() {
        if !entry.file_name().to_string_lossy().starts_with(FOLDER_PREFIX) {
            continue;
        }
        let mut options = File::options();
        options.write(true);
        // A pipe of this name, which anybody can create in a folder for temporary files, must not block.
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK | libc::O_NOFOLLOW);
        let lock = options.open(entry.path().join(LOCK_NAME));
        if lock.is_ok_and(|lock| lock.try_lock().is_ok()) {
            let _ = std::fs::remove_dir_all(entry.path());
        }
    }
}

impl SearchPath {
    /// Returns the usual search path of a program: the folders of the environment variable, then those around `exe`;
    /// models are searched only around `exe`.
    pub fn standard(exe: Option<&Path>, environment: Option<&std::ffi::OsStr>, built: &[&str]) -> Self {
        let mut folders: Vec<_> = environment
            .map(|path| std::env::split_paths(path).filter(|p| !p.as_os_str().is_empty()).collect::<Vec<_>>())
            .unwrap_or_default()
            .into_iter()
            .map(|p| (p, FolderOrigin::Environment))
            .collect();
        if let Some(dir) = exe.and_then(Path::parent) {
            folders.push((dir.join("plugins"), FolderOrigin::Installed));
            folders.push((dir.join("deps"), FolderOrigin::Built));
            if let Some(up) = dir.parent() {
                folders.push((up.join("lib/tatu/plugins"), FolderOrigin::Installed));
            }
        }
        let models = exe.map(|exe| folders_beside(exe, "models")).unwrap_or_default();
        SearchPath { folders, built: built.iter().map(|s| (*s).to_owned()).collect(), models, ..SearchPath::default() }
    }

    /// Adds a folder that a scene lists, before the user's own folder.
    pub fn add_scene_folder(&mut self, folder: PathBuf) {
        let at = self.folders.iter().position(|(_, s)| *s == FolderOrigin::User).unwrap_or(self.folders.len());
        self.folders.insert(at, (folder, FolderOrigin::Scene));
    }

    /// Adds the user's own folder. It is searched last, so its plugins cannot hide those in other folders.
    pub fn add_user_folder(&mut self, folder: PathBuf) {
        self.folders.push((folder, FolderOrigin::User));
    }

    /// Returns whether a file comes with the program. The names of the program's plugins take precedence over those of
    /// other plugins. If the program's plugins are unknown, all plugins are considered to come with it, except those in
    /// folders of a scene or the user.
    pub fn is_of_program(&self, file: &Path) -> bool {
        let known = || file.file_name().and_then(|n| n.to_str()).and_then(stem).is_some_and(|s| self.is_built(s));
        !self.is_of_scene(file) && !self.lies_in(file, FolderOrigin::User) && (self.built.is_empty() || known())
    }

    /// Returns whether a file is in the user's own folder.
    pub fn is_of_user(&self, file: &Path) -> bool {
        self.lies_in(file, FolderOrigin::User)
    }

    /// Returns whether a file is in a folder that a scene lists.
    pub fn is_of_scene(&self, file: &Path) -> bool {
        self.lies_in(file, FolderOrigin::Scene)
    }

    /// Returns whether the contents of a folder of models come with the scene.
    pub fn is_beside_scene(&self, folder: &Path) -> bool {
        self.models_of_scene.iter().any(|f| f == folder)
    }

    fn lies_in(&self, file: &Path, source: FolderOrigin) -> bool {
        self.folders.iter().any(|(f, s)| *s == source && file.starts_with(f))
    }

    fn is_built(&self, stem: &str) -> bool {
        self.built.iter().any(|b| b == stem)
    }

    /// Returns the libraries in explicitly specified plugin folders whose file names are not valid for plugins, without
    /// those that a library beside them names, because it needs them.
    pub fn misnamed(&self) -> Vec<PathBuf> {
        let is_named = |s: &FolderOrigin| {
            self.only.is_none() && matches!(s, FolderOrigin::Environment | FolderOrigin::Scene | FolderOrigin::User)
        };
        let named = self.folders.iter().filter(|(_, s)| is_named(s));
        let entries = named.filter_map(|(folder, _)| std::fs::read_dir(folder).ok()).flatten();
        let other = |p: &PathBuf| {
            let name = p.file_name().and_then(|n| n.to_str()).unwrap_or_default();
            name.ends_with(std::env::consts::DLL_SUFFIX) && stem(name).is_none()
        };
        let mut files: Vec<_> = entries.filter_map(|e| e.ok().map(|e| e.path())).filter(other).collect();
        files.retain(|file| !is_named_beside(file));
        files.sort();
        files
    }

    /// Returns the files that may be plugins: first those specified individually, then those in the folders in search
    /// order, sorted by name within each folder.
    pub fn candidates(&self) -> Vec<PathBuf> {
        if let Some(only) = &self.only {
            return vec![only.clone()];
        }
        let mut out = self.files.clone();
        for (folder, source) in &self.folders {
            let Ok(entries) = std::fs::read_dir(folder) else { continue };
            let mut files: Vec<_> =
                entries.filter_map(|e| e.ok().map(|e| e.path())).filter(|p| self.may_be_plugin(p, *source)).collect();
            files.sort();
            out.extend(files);
        }
        out
    }

    /// Returns whether a file with this name is opened in a folder of this kind.
    pub fn may_be_plugin(&self, path: &Path, source: FolderOrigin) -> bool {
        let Some(name) = path.file_name().and_then(|n| n.to_str()) else { return false };
        stem(name).is_some_and(|stem| source != FolderOrigin::Built || self.is_built(stem))
    }

    /// Returns the folders as a list for messages; missing ones are marked.
    pub fn describe(&self) -> String {
        let mut out = String::new();
        for (folder, _) in &self.folders {
            let note = if folder.is_dir() { "" } else { " (does not exist)" };
            out += &format!("\n    {}{note}", folder.display());
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_of_killed_processes_are_removed_and_others_are_not() {
        let parent = tempfile::tempdir().unwrap();
        let folder = |name: &str| {
            let folder = parent.path().join(name);
            std::fs::create_dir(&folder).unwrap();
            folder
        };
        let abandoned = folder("tatu-plugins-abandoned");
        File::create(abandoned.join(LOCK_NAME)).unwrap();
        File::create(abandoned.join("0-libtatu_example.so")).unwrap();
        let in_use = folder("tatu-plugins-in-use");
        let lock = File::create(in_use.join(LOCK_NAME)).unwrap();
        lock.lock().unwrap();
        let not_yet_locked = folder("tatu-plugins-not-yet-locked");
        let other = folder("tatu-other");
        File::create(other.join(LOCK_NAME)).unwrap();
        remove_abandoned(parent.path());
        assert!(!abandoned.exists());
        assert!(in_use.exists() && not_yet_locked.exists() && other.exists());
    }
}
