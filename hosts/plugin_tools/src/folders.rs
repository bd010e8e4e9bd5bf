//! Lists the folders that are searched, and their contents.

use std::{
    fs,
    io::ErrorKind,
    path::{Path, PathBuf},
};

use serde_json::{Value, json};
use tatu_core::plugins::FolderOrigin;

use super::names;
use tatu_embed::search::SearchFolders;

/// The state of a folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FolderState {
    Present,
    Missing,
    /// The path is a file, most likely the library itself.
    NoFolder,
    Unreadable(String),
    /// Only a scene names the folder, and the user has not allowed loading plugins from it.
    NotAllowed,
}

/// A folder of the search order.
pub struct Folder {
    pub path: PathBuf,
    pub source: FolderOrigin,
    pub state: FolderState,
    /// The files that are opened, in order.
    pub candidates: Vec<PathBuf>,
    /// The other entries: files with other names, and folders.
    pub others: Vec<PathBuf>,
}

/// Returns all folders in search order; a scene's folders that are not allowed come before the user's own folder.
pub fn list_folders(searched: &SearchFolders) -> Vec<Folder> {
    let SearchFolders { search, untrusted } = searched;
    let mut all: Vec<(&PathBuf, FolderOrigin, bool)> = search.folders.iter().map(|(f, s)| (f, *s, true)).collect();
    let at = all.iter().position(|(_, s, _)| *s == FolderOrigin::User).unwrap_or(all.len());
    all.splice(at..at, untrusted.iter().map(|f| (f, FolderOrigin::Scene, false)));
    let folder = |(path, source, allowed): (&PathBuf, FolderOrigin, bool)| {
        let (mut state, entries) = read(path);
        if !allowed {
            state = FolderState::NotAllowed;
        }
        let (candidates, others) = entries.into_iter().partition(|f| search.may_be_plugin(f, source));
        Folder { path: path.clone(), source, state, candidates, others }
    };
    all.into_iter().map(folder).collect()
}

/// Returns the state of a folder, and its entries sorted by name.
fn read(folder: &Path) -> (FolderState, Vec<PathBuf>) {
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(e) => {
            let state = match e.kind() {
                ErrorKind::NotFound => FolderState::Missing,
                ErrorKind::NotADirectory => FolderState::NoFolder,
                _ => FolderState::Unreadable(e.to_string()),
            };
            return (state, Vec::new());
        }
    };
    let mut files: Vec<PathBuf> = entries.filter_map(|e| e.ok().map(|e| e.path())).collect();
    files.sort();
    (FolderState::Present, files)
}

impl Folder {
    /// Returns the origin of the folder, for display.
    pub fn origin(&self) -> &'static str {
        match self.source {
            FolderOrigin::Environment => "TATU_PLUGIN_PATH",
            FolderOrigin::Installed => "next to the program",
            FolderOrigin::Built => "built with the program",
            FolderOrigin::Scene => "named by the scene",
            FolderOrigin::User => "your own, for `tatu plugin install`",
        }
    }
    /// Returns the origin of the folder as a single word, for programs and tables.
    pub fn origin_word(&self) -> &'static str {
        match self.source {
            FolderOrigin::Environment => "environment",
            FolderOrigin::Installed => "installed",
            FolderOrigin::Built => "built",
            FolderOrigin::Scene => "scene",
            FolderOrigin::User => "user",
        }
    }
    /// Returns the problem with the folder, or a summary of its contents. `found` lists the files in it that match the
    /// search.
    pub fn summary(&self, found: &[&Path]) -> String {
        match &self.state {
            FolderState::Missing => "does not exist".into(),
            FolderState::NoFolder => "not a folder".into(),
            FolderState::Unreadable(why) => format!("cannot be read: {why}"),
            FolderState::NotAllowed => "not searched without `--allow plugins`".into(),
            FolderState::Present if found.is_empty() => match self.candidates.len() {
                0 => "no plugins".into(),
                1 => "1 plugin with a different name".into(),
                n => format!("{n} plugins with different names"),
            },
            FolderState::Present => found.iter().map(|f| names::name(f)).collect::<Vec<_>>().join(", "),
        }
    }
    pub fn json(&self, found: &[&Path]) -> Value {
        let (state, why) = match &self.state {
            FolderState::Present => ("there", None),
            FolderState::Missing => ("missing", None),
            FolderState::NoFolder => ("not-a-folder", None),
            FolderState::Unreadable(why) => ("unreadable", Some(why)),
            FolderState::NotAllowed => ("not-allowed", None),
        };
        let found: Vec<String> = found.iter().map(|f| names::name(f)).collect();
        json!({
            "path": self.path.display().to_string(), "source": self.origin_word(), "state": state, "why": why,
            "plugins": self.candidates.len(), "found": found,
        })
    }
}

/// Returns whether two paths refer to the same file.
pub fn same_file(a: &Path, b: &Path) -> bool {
    a == b || matches!((fs::canonicalize(a), fs::canonicalize(b)), (Ok(a), Ok(b)) if a == b)
}

/// Returns whether two paths refer to the same directory entry, even if that is a link.
pub fn same_entry(a: &Path, b: &Path) -> bool {
    let folder = |p: &Path| p.parent().map(|f| if f.as_os_str().is_empty() { Path::new(".") } else { f }.to_owned());
    a.file_name() == b.file_name() && matches!((folder(a), folder(b)), (Some(a), Some(b)) if same_file(&a, &b))
}
