//! Where plugins are looked for, and which files may be some.

use std::path::{Path, PathBuf};

/// Where a folder of the path comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// `TATU_PLUGIN_PATH`.
    Environment,
    /// Beside the program: `plugins`, or `../lib/tatu/plugins`.
    Installed,
    /// Beside the program as cargo builds it: only packages that its manifest lists are opened there.
    Built,
    /// Named in the scene.
    Scene,
}

/// The folders that are searched, in order: the first that has an id wins it.
#[derive(Debug, Clone, Default)]
pub struct Search {
    /// Folders.
    pub folders: Vec<(PathBuf, Source)>,
    /// Names of libraries (without prefix and suffix) that may be opened in `Source::Built` folders.
    pub built: Vec<String>,
}

impl Search {
    /// The usual path of a program: the environment's folders, then those around `exe`.
    pub fn standard(exe: Option<&Path>, environment: Option<&std::ffi::OsStr>, built: &[&str]) -> Self {
        let mut folders: Vec<_> = environment
            .map(|path| std::env::split_paths(path).filter(|p| !p.as_os_str().is_empty()).collect::<Vec<_>>())
            .unwrap_or_default()
            .into_iter()
            .map(|p| (p, Source::Environment))
            .collect();
        if let Some(dir) = exe.and_then(Path::parent) {
            folders.push((dir.join("plugins"), Source::Installed));
            folders.push((dir.join("deps"), Source::Built));
            if let Some(up) = dir.parent() {
                folders.push((up.join("lib/tatu/plugins"), Source::Installed));
            }
        }
        Search { folders, built: built.iter().map(|s| (*s).to_owned()).collect() }
    }

    /// Adds a folder that a scene names.
    pub fn add_scene_folder(&mut self, folder: PathBuf) {
        self.folders.push((folder, Source::Scene));
    }

    /// Files that may be plugins, in order of folders, then of names.
    pub fn candidates(&self) -> Vec<PathBuf> {
        let mut out = Vec::new();
        for (folder, source) in &self.folders {
            let Ok(entries) = std::fs::read_dir(folder) else { continue };
            let mut files: Vec<_> =
                entries.filter_map(|e| e.ok().map(|e| e.path())).filter(|p| self.may_be_plugin(p, *source)).collect();
            files.sort();
            out.extend(files);
        }
        out
    }

    fn may_be_plugin(&self, path: &Path, source: Source) -> bool {
        let Some(name) = path.file_name().and_then(|n| n.to_str()) else { return false };
        let Some(stem) = name
            .strip_suffix(std::env::consts::DLL_SUFFIX)
            .map(|s| s.strip_prefix(std::env::consts::DLL_PREFIX).unwrap_or(s))
            .filter(|s| s.starts_with("tatu_"))
        else {
            return false;
        };
        source != Source::Built || self.built.iter().any(|b| b == stem)
    }

    /// The folders as a list for messages, with what is wrong with each.
    pub fn describe(&self) -> String {
        let mut out = String::new();
        for (folder, _) in &self.folders {
            let note = if folder.is_dir() { "" } else { " (not there)" };
            out += &format!("\n    {}{note}", folder.display());
        }
        out
    }
}
