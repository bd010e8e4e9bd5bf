//! Folders below which files are opened.
//!
//! Each folder is opened once, and files are opened relative to its handle. Therefore, neither `..`, nor a link, nor a
//! change of the working folder gives access to files outside the folder. Only regular files are opened, never folders,
//! pipes, devices or sockets.

use std::{
    fs,
    io::{self, ErrorKind},
    path::{Component, Path, PathBuf},
    sync::OnceLock,
};

use cap_std::{ambient_authority, fs::Dir};
use tatu_plugin_api::abi::*;

/// A folder in which files may be opened.
#[derive(Debug)]
pub struct Folder {
    /// Absolute path.
    path: PathBuf,
    /// Canonical path and open handle, obtained at the first use; `None` if the folder cannot be opened.
    opened: OnceLock<Option<(PathBuf, Dir)>>,
}

impl Folder {
    /// Creates the folder at an absolute path, which need not exist. It is opened when it is first needed.
    pub fn new(path: PathBuf) -> Self {
        Folder { path, opened: OnceLock::new() }
    }

    /// Returns the absolute path that was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn open_handle(&self) -> Option<&(PathBuf, Dir)> {
        let open =
            || Some((fs::canonicalize(&self.path).ok()?, Dir::open_ambient_dir(&self.path, ambient_authority()).ok()?));
        self.opened.get_or_init(open).as_ref()
    }

    /// Returns the file with a canonical path if it is in or below this folder. `path` is its path for messages.
    pub fn below(&self, real: &Path, path: &Path) -> Option<FoundFile<'_>> {
        let (root, dir) = self.open_handle()?;
        let name = real.strip_prefix(root).ok()?;
        let name = if name.as_os_str().is_empty() { PathBuf::from(".") } else { name.to_owned() };
        Some(FoundFile { path: path.to_owned(), dir, name })
    }
}

/// The reason why a file is not opened.
#[derive(Debug)]
pub enum OpenError {
    /// The file is in none of the folders.
    Missing(String),
    /// The file is not a regular file.
    Irregular(String),
    /// The file is outside the folders, or the system refuses to open it.
    Forbidden(String),
}

impl OpenError {
    /// Returns the message, which contains the path.
    pub fn text(self) -> String {
        match self {
            OpenError::Missing(text) | OpenError::Irregular(text) | OpenError::Forbidden(text) => text,
        }
    }
}

/// A file found in one of the folders.
#[derive(Debug)]
pub struct FoundFile<'a> {
    /// Path of the file, for messages and for plugins that open the file by path.
    pub path: PathBuf,
    dir: &'a Dir,
    /// Path of the file relative to `dir`, without links.
    name: PathBuf,
}

impl FoundFile<'_> {
    /// Opens the file, which must be a regular one; `mode` consists of `TATU_FILE_*` bits. `name` is the name of the
    /// file as it was given, for messages.
    pub fn open(&self, name: &Path, mode: u32) -> Result<fs::File, OpenError> {
        if mode & TATU_FILE_FOLDERS != 0
            && let Some(above) = self.name.parent().filter(|p| !p.as_os_str().is_empty())
        {
            self.dir.create_dir_all(above).map_err(|e| system_error(&self.path, &e))?;
        }
        // The type is checked before opening, because opening alone can have effects, for example on a device.
        if self.dir.symlink_metadata(&self.name).is_ok_and(|about| !about.is_file()) {
            return Err(irregular_file(&self.path));
        }
        let file = self.dir.open_with(&self.name, &options(mode)).map_err(|e| match e.kind() {
            ErrorKind::NotFound => missing_file(name, &[&self.path]),
            _ => system_error(&self.path, &e),
        })?;
        let plain = file.metadata().is_ok_and(|about| about.is_file());
        if plain { Ok(file.into_std()) } else { Err(irregular_file(&self.path)) }
    }
}

/// Finds a path in one of the folders. Returns `None` if the path does not exist or does not begin with the path of a
/// folder.
pub fn locate<'a>(
    full: &Path,
    among: &[&'a Folder],
    writes: bool,
    makes_folders: bool,
) -> Result<Option<FoundFile<'a>>, OpenError> {
    if !among.iter().any(|folder| full.starts_with(&folder.path)) {
        return Ok(None);
    }
    let real = match fs::canonicalize(full) {
        Ok(real) => real,
        // Opening a dangling link for writing would create its target.
        Err(_) if fs::symlink_metadata(full).is_ok_and(|m| m.file_type().is_symlink()) => {
            return Err(OpenError::Forbidden(format!(
                "`{}` is a dangling link, which is not followed; remove it, or open a different file",
                full.display()
            )));
        }
        Err(e) if e.kind() == ErrorKind::NotFound && writes => match path_to_create(full, makes_folders) {
            Some(real) => real,
            None => return Ok(None),
        },
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(system_error(full, &e)),
    };
    if let Some(found) = among.iter().find_map(|folder| folder.below(&real, full)) {
        return Ok(Some(found));
    }
    let list: Vec<_> = among.iter().map(|f| f.path.display().to_string()).collect();
    Err(OpenError::Forbidden(format!(
        "`{}` links to a path outside the folders that scripts may use: {}",
        full.display(),
        list.join(", ")
    )))
}

/// Returns the canonical path of a file to be created, or `None` if its folder neither exists nor will be created.
fn path_to_create(full: &Path, makes_folders: bool) -> Option<PathBuf> {
    let (above, last) = (full.parent()?, full.file_name()?);
    match fs::canonicalize(above) {
        Ok(real) => Some(real.join(last)),
        Err(_) if makes_folders && fs::symlink_metadata(above).is_err() => {
            Some(path_to_create(above, true)?.join(last))
        }
        Err(_) => None,
    }
}

fn options(mode: u32) -> cap_std::fs::OpenOptions {
    let has = |bit| mode & bit != 0;
    let writes = has(TATU_FILE_WRITE);
    let mut options = cap_std::fs::OpenOptions::new();
    options.read(has(TATU_FILE_READ)).append(has(TATU_FILE_APPEND)).create(has(TATU_FILE_APPEND));
    if writes {
        options.write(true).create_new(has(TATU_FILE_NEW));
        options.create(!has(TATU_FILE_UPDATE)).truncate(!has(TATU_FILE_UPDATE) && !has(TATU_FILE_NEW));
    }
    // Opening a pipe without a writer would block the run. In non-blocking mode, the pipe can be opened, and is then
    // refused.
    #[cfg(unix)]
    cap_std::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK | libc::O_NOCTTY);
    options
}

/// Returns the refusal of a file that is in none of the folders.
pub fn missing_file(name: &Path, folders: &[&Path]) -> OpenError {
    let list: Vec<_> = folders.iter().map(|r| r.display().to_string()).collect();
    let name = name.display();
    OpenError::Missing(format!("there is no file `{name}` in the folders that scripts may use: {}", list.join(", ")))
}

fn irregular_file(path: &Path) -> OpenError {
    OpenError::Irregular(format!("`{}` is not a regular file; scripts can open only regular files", path.display()))
}

fn system_error(path: &Path, e: &io::Error) -> OpenError {
    OpenError::Forbidden(format!("`{}` cannot be opened: {e}", path.display()))
}

/// Returns a path without `.` and `..`, resolved lexically: links are not followed.
pub fn normalize(path: &Path) -> PathBuf {
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
