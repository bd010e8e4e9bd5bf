//! The folders in which scripts open files.
//!
//! Each folder is opened once, and files are opened relative to its handle. Neither `..`, nor a link, nor a change of
//! the working folder therefore gives access to files outside the folder. Only regular files are opened, never folders,
//! pipes, devices or sockets.

use std::{
    cell::{OnceCell, RefCell},
    ffi::OsString,
    fs,
    io::{self, ErrorKind},
    path::{Path, PathBuf},
    rc::Rc,
};

use cap_std::{ambient_authority, fs::Dir};
use tatu_plugin_api::abi::*;
use tatu_scene::document::{Document, normal};

/// A folder in which files may be opened.
#[derive(Debug)]
struct Folder {
    /// Absolute path.
    path: PathBuf,
    /// Canonical path and open handle, obtained at the first use; `None` if the folder cannot be opened.
    opened: OnceCell<Option<(PathBuf, Dir)>>,
}

impl Folder {
    fn new(path: PathBuf) -> Self {
        Folder { path, opened: OnceCell::new() }
    }
    fn opened(&self) -> Option<&(PathBuf, Dir)> {
        let open =
            || Some((fs::canonicalize(&self.path).ok()?, Dir::open_ambient_dir(&self.path, ambient_authority()).ok()?));
        self.opened.get_or_init(open).as_ref()
    }
}

/// The folders in which a world's scripts may open files.
#[derive(Debug)]
pub(crate) struct Folders {
    working: Folder,
    scene: Option<Folder>,
    /// The folder that the program has chosen in place of the working folder, if any.
    chosen: RefCell<Option<Folder>>,
    /// Folders that contain script files of the document or of a model, each with the suffix of these files. Scripts
    /// may read files with this suffix in the folder, which are modules.
    of_scripts: RefCell<Vec<(Rc<Folder>, OsString)>>,
}

/// The reason why a file is not opened.
#[derive(Debug)]
pub(crate) enum Refused {
    /// The file is in none of the folders.
    Missing(String),
    /// The file is outside the folders, is not a regular file, or the system refuses to open it.
    Forbidden(String),
}

impl Refused {
    /// Returns the message, which contains the path.
    pub fn text(self) -> String {
        match self {
            Refused::Missing(text) | Refused::Forbidden(text) => text,
        }
    }
}

/// A file found in one of the folders.
struct Found<'a> {
    /// Path of the file, for messages and for plugins that open the file by path.
    path: PathBuf,
    dir: &'a Dir,
    /// Path of the file relative to `dir`, without links.
    name: PathBuf,
}

impl Folders {
    /// Returns the folders for a world whose scene is in `file`.
    pub fn new(file: Option<&Path>) -> Self {
        let working = std::env::current_dir().unwrap_or_default();
        let scene = file.and_then(Path::parent).map(|p| normal(&working.join(p))).filter(|p| *p != working);
        let scene = scene.map(Folder::new);
        let of_scripts = RefCell::default();
        Folders { working: Folder::new(working), scene, chosen: RefCell::default(), of_scripts }
    }

    /// Lets scripts read modules, which are files beside the script files of a document that have the same suffix.
    pub fn read_beside(&self, document: &Document) {
        let scripts = document.objects.iter().flat_map(|o| &o.scripts).map(|s| Path::new(&s.name));
        let mut all = self.of_scripts.borrow_mut();
        // The name of a script that is not a file is an arbitrary string.
        for file in scripts.filter(|file| document.sources.has(file)) {
            let (Some(folder), Some(suffix)) = (file.parent(), file.extension()) else { continue };
            let folder = normal(&self.working.path.join(folder));
            if all.iter().all(|(f, s)| f.path != folder || s != suffix) {
                all.push((Rc::new(Folder::new(folder)), suffix.to_owned()));
            }
        }
    }

    /// Replaces the working folder by the folder at this absolute path.
    pub fn choose(&self, folder: PathBuf) {
        *self.chosen.borrow_mut() = Some(Folder::new(folder));
    }

    /// Returns the path of a file that may be opened in this mode (`TATU_FILE_*` bits).
    pub fn resolve(&self, name: &Path, mode: u32) -> Result<PathBuf, Refused> {
        self.find(name, mode, |found| Ok(found.path))
    }

    /// Opens a regular file; `mode` consists of `TATU_FILE_*` bits.
    pub fn open(&self, name: &Path, mode: u32) -> Result<fs::File, Refused> {
        self.find(name, mode, |found| {
            if mode & TATU_FILE_FOLDERS != 0
                && let Some(above) = found.name.parent().filter(|p| !p.as_os_str().is_empty())
            {
                found.dir.create_dir_all(above).map_err(|e| system(&found.path, &e))?;
            }
            // The type is checked before opening, because opening alone can have effects, for example on a device.
            if found.dir.symlink_metadata(&found.name).is_ok_and(|about| !about.is_file()) {
                return Err(not_plain(&found.path));
            }
            let file = found.dir.open_with(&found.name, &options(mode)).map_err(|e| match e.kind() {
                ErrorKind::NotFound => missing(name, &[&found.path]),
                _ => system(&found.path, &e),
            })?;
            let plain = file.metadata().is_ok_and(|about| about.is_file());
            if plain { Ok(file.into_std()) } else { Err(not_plain(&found.path)) }
        })
    }

    /// Looks up a name in the folders in order, and calls `f` with the first match.
    fn find<T>(&self, name: &Path, mode: u32, f: impl FnOnce(Found<'_>) -> Result<T, Refused>) -> Result<T, Refused> {
        let chosen = self.chosen.borrow();
        let here = chosen.as_ref().unwrap_or(&self.working);
        let writes = mode & !TATU_FILE_READ != 0;
        let scene = self.scene.as_ref().filter(|_| !writes);
        let roots: Vec<&Folder> = std::iter::once(here).chain(scene).collect();
        // Files in these folders are found only by their full path, so that a relative name has the same meaning for
        // all scripts.
        let of_scripts = if writes { Vec::new() } else { self.of_scripts.borrow().clone() };
        let of_scripts = || of_scripts.iter().filter(|(_, s)| name.extension() == Some(s)).map(|(f, _)| f.as_ref());
        let mut refused = None;
        for root in &roots {
            // If a folder was chosen, it must contain all files that are opened in it. Otherwise, a link in one of the
            // two folders may point into the other.
            let among = if chosen.is_some() { std::slice::from_ref(root) } else { roots.as_slice() };
            let among: Vec<&Folder> = among.iter().copied().chain(of_scripts()).collect();
            match locate(&normal(&root.path.join(name)), &among, writes, mode & TATU_FILE_FOLDERS != 0) {
                Ok(Some(found)) => return f(found),
                Ok(None) => {}
                Err(why) => refused = refused.or(Some(why)),
            }
        }
        // The names of scripts are relative to the working folder, even if another folder was chosen.
        let beside: Vec<&Folder> = of_scripts().collect();
        if let Ok(Some(found)) = locate(&normal(&self.working.path.join(name)), &beside, writes, false) {
            return f(found);
        }
        Err(refused.unwrap_or_else(|| missing(name, &roots.iter().map(|r| r.path.as_path()).collect::<Vec<_>>())))
    }
}

/// Finds a path in one of the folders. Returns `None` if the path does not exist or does not begin with the path of a
/// folder.
fn locate<'a>(
    full: &Path,
    among: &[&'a Folder],
    writes: bool,
    makes_folders: bool,
) -> Result<Option<Found<'a>>, Refused> {
    if !among.iter().any(|folder| full.starts_with(&folder.path)) {
        return Ok(None);
    }
    let real = match fs::canonicalize(full) {
        Ok(real) => real,
        // Opening a dangling link for writing would create its target.
        Err(_) if fs::symlink_metadata(full).is_ok_and(|m| m.file_type().is_symlink()) => {
            return Err(Refused::Forbidden(format!(
                "`{}` is a dangling link, which is not followed; remove it, or open a different file",
                full.display()
            )));
        }
        Err(e) if e.kind() == ErrorKind::NotFound && writes => match not_yet(full, makes_folders) {
            Some(real) => real,
            None => return Ok(None),
        },
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(system(full, &e)),
    };
    for folder in among {
        if let Some((root, dir)) = folder.opened()
            && let Ok(name) = real.strip_prefix(root)
        {
            let name = if name.as_os_str().is_empty() { PathBuf::from(".") } else { name.to_owned() };
            return Ok(Some(Found { path: full.to_owned(), dir, name }));
        }
    }
    let list: Vec<_> = among.iter().map(|f| f.path.display().to_string()).collect();
    Err(Refused::Forbidden(format!(
        "`{}` links to a path outside the folders that scripts may use: {}",
        full.display(),
        list.join(", ")
    )))
}

/// Returns the canonical path of a file to be created, or `None` if its folder neither exists nor will be created.
fn not_yet(full: &Path, makes_folders: bool) -> Option<PathBuf> {
    let (above, last) = (full.parent()?, full.file_name()?);
    match fs::canonicalize(above) {
        Ok(real) => Some(real.join(last)),
        Err(_) if makes_folders && fs::symlink_metadata(above).is_err() => Some(not_yet(above, true)?.join(last)),
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

fn missing(name: &Path, folders: &[&Path]) -> Refused {
    let list: Vec<_> = folders.iter().map(|r| r.display().to_string()).collect();
    let name = name.display();
    Refused::Missing(format!("there is no file `{name}` in the folders that scripts may use: {}", list.join(", ")))
}

fn not_plain(path: &Path) -> Refused {
    Refused::Forbidden(format!("`{}` is not a regular file; scripts can open only regular files", path.display()))
}

fn system(path: &Path, e: &io::Error) -> Refused {
    Refused::Forbidden(format!("`{}` cannot be opened: {e}", path.display()))
}
