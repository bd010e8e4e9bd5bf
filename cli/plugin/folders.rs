//! Lists the folders that are searched, and their contents.

use std::{
    fs,
    io::ErrorKind,
    path::{Path, PathBuf},
};

use serde_json::{Value, json};
use tatu_core::plugins::Source;

use super::names;
use tatu_embed::search::Searched;

/// The state of a folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum State {
    There,
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
    pub source: Source,
    pub state: State,
    /// The files that are opened, in order.
    pub candidates: Vec<PathBuf>,
    /// The other entries: files with other names, and folders.
    pub others: Vec<PathBuf>,
}

/// Returns all folders in search order; a scene's folders that are not allowed come before the user's own folder.
pub fn look(searched: &Searched) -> Vec<Folder> {
    let Searched { search, untrusted } = searched;
    let mut all: Vec<(&PathBuf, Source, bool)> = search.folders.iter().map(|(f, s)| (f, *s, true)).collect();
    let at = all.iter().position(|(_, s, _)| *s == Source::User).unwrap_or(all.len());
    all.splice(at..at, untrusted.iter().map(|f| (f, Source::Scene, false)));
    let folder = |(path, source, allowed): (&PathBuf, Source, bool)| {
        let (mut state, entries) = read(path);
        if !allowed {
            state = State::NotAllowed;
        }
        let (candidates, others) = entries.into_iter().partition(|f| search.may_be_plugin(f, source));
        Folder { path: path.clone(), source, state, candidates, others }
    };
    all.into_iter().map(folder).collect()
}

/// Returns the state of a folder, and its entries sorted by name.
fn read(folder: &Path) -> (State, Vec<PathBuf>) {
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(e) => {
            let state = match e.kind() {
                ErrorKind::NotFound => State::Missing,
                ErrorKind::NotADirectory => State::NoFolder,
                _ => State::Unreadable(e.to_string()),
            };
            return (state, Vec::new());
        }
    };
    let mut files: Vec<PathBuf> = entries.filter_map(|e| e.ok().map(|e| e.path())).collect();
    files.sort();
    (State::There, files)
}

impl Folder {
    /// Returns the origin of the folder, for display.
    pub fn origin(&self) -> &'static str {
        match self.source {
            Source::Environment => "TATU_PLUGIN_PATH",
            Source::Installed => "next to the program",
            Source::Built => "built with the program",
            Source::Scene => "named by the scene",
            Source::User => "your own, for `tatu plugin install`",
        }
    }
    /// Returns the origin of the folder as a single word, for programs and tables.
    pub fn word(&self) -> &'static str {
        match self.source {
            Source::Environment => "environment",
            Source::Installed => "installed",
            Source::Built => "built",
            Source::Scene => "scene",
            Source::User => "user",
        }
    }
    /// Returns the problem with the folder, or a summary of its contents. `found` lists the files in it that match the
    /// search.
    pub fn note(&self, found: &[&Path]) -> String {
        match &self.state {
            State::Missing => "not there".into(),
            State::NoFolder => "not a folder".into(),
            State::Unreadable(why) => format!("cannot be read: {why}"),
            State::NotAllowed => "not searched without `--allow plugins`".into(),
            State::There if found.is_empty() => match self.candidates.len() {
                0 => "no plugins".into(),
                1 => "1 plugin with a different name".into(),
                n => format!("{n} plugins with different names"),
            },
            State::There => found.iter().map(|f| names::name(f)).collect::<Vec<_>>().join(", "),
        }
    }
    pub fn json(&self, found: &[&Path]) -> Value {
        let (state, why) = match &self.state {
            State::There => ("there", None),
            State::Missing => ("missing", None),
            State::NoFolder => ("not-a-folder", None),
            State::Unreadable(why) => ("unreadable", Some(why)),
            State::NotAllowed => ("not-allowed", None),
        };
        let found: Vec<String> = found.iter().map(|f| names::name(f)).collect();
        json!({
            "path": self.path.display().to_string(), "source": self.word(), "state": state, "why": why,
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
