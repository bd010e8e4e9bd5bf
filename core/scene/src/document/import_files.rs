//! Files that a model or importer reads in addition to its source, restricted to permitted folders.

use std::path::{Component, Path, PathBuf};

use tatu_errors::{Error, Result};

use super::sources::Sources;

/// The source from which objects are built.
pub(super) struct Source {
    /// Name of the source file, which precedes the reports about it.
    pub name: Option<String>,
    /// The folder that file names are relative to; `None` if no files can be read.
    pub folder: Option<PathBuf>,
    /// The permitted folders: files must be in or below one of them.
    pub roots: Vec<PathBuf>,
    /// Whether the source is the scene itself, rather than a part of one.
    pub whole: bool,
}

/// Maximum size of a file to be read, bytes.
pub(super) const MOST_BYTES: u64 = 1 << 28;

impl Source {
    /// Reads a file relative to the source. Returns `None` if the file does not exist, in which case the plugin can try
    /// a different name. Leaving the permitted folders by `..`, by an absolute path or by a link is an error.
    pub fn read(&self, name: &str, sources: &Sources) -> Result<Option<Vec<u8>>> {
        let Some(folder) = &self.folder else { return Ok(None) };
        let wanted = folder.join(name);
        // Cached files were checked when they were read.
        if sources.are_kept() || sources.has(&wanted) {
            return Ok(sources.read(&wanted).ok());
        }
        let real = |p: &Path| std::fs::canonicalize(if p.as_os_str().is_empty() { Path::new(".") } else { p });
        let outside = || {
            let shown = |r: &PathBuf| if r.as_os_str().is_empty() { ".".into() } else { r.display().to_string() };
            let roots: Vec<_> = self.roots.iter().map(|r| format!("`{}`", shown(r))).collect();
            Error::new("E105", format!("the file `{name}` is outside the folders that may be read"))
                .expected(format!("a file below {}", roots.join(" or ")))
                .help("move it there, or put the scene file into a folder that contains both")
        };
        let Ok(path) = real(&wanted) else {
            // Whether a file exists must not be revealed, so a name outside the folders is refused in any case.
            return if escapes(name, folder, &self.roots) { Err(outside()) } else { Ok(None) };
        };
        if !self.roots.iter().filter_map(|r| real(r).ok()).any(|r| path.starts_with(r)) {
            return Err(outside());
        }
        let fail = |e: String| Error::new("E105", format!("cannot read the file `{name}`: {e}"));
        let about = std::fs::metadata(&path).map_err(|e| fail(e.to_string()))?;
        if !about.is_file() {
            return Ok(None);
        }
        if about.len() > MOST_BYTES {
            return Err(fail(format!("it has {} bytes, but the limit is {MOST_BYTES}", about.len())));
        }
        sources.read(&wanted).map(Some).map_err(|e| fail(e.to_string()))
    }
}

/// Returns whether the name of a missing file is outside the permitted folders.
fn escapes(name: &str, folder: &Path, roots: &[PathBuf]) -> bool {
    let Ok(here) = std::env::current_dir() else { return true };
    let full = normal(&here.join(folder).join(name));
    !roots.iter().any(|r| full.starts_with(normal(&here.join(r))))
}

/// Returns a path without `.` and `..`, resolved lexically: links are not followed.
pub fn normal(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for c in path.components() {
        match c {
            Component::ParentDir => {
                out.pop();
            }
            Component::CurDir => {}
            c => out.push(c),
        }
    }
    out
}
