//! The folders in which scripts open files.

use std::{
    cell::RefCell,
    ffi::OsString,
    fs,
    path::{Path, PathBuf},
    rc::Rc,
};

use tatu_plugin_api::abi::*;
use tatu_plugins::Registry;
use tatu_scene::{
    document::{AllowedFolders, Document},
    folders::{Folder, FoundFile, OpenError, locate, missing_file, normalize},
};

/// The folders in which a world's scripts may open files.
#[derive(Debug)]
pub(crate) struct ScriptFolders {
    working: Folder,
    scene: Option<Folder>,
    /// The folder that the program has chosen in place of the working folder, if any.
    chosen: RefCell<Option<Folder>>,
    /// Folders that contain script files of the document or of a model, each with the suffix of these files. Scripts
    /// may read files with this suffix in the folder, which are modules.
    of_scripts: RefCell<Vec<(Rc<Folder>, OsString)>>,
}

impl ScriptFolders {
    /// Returns the folders for a world whose scene is in `file`.
    pub fn new(file: Option<&Path>) -> Self {
        let working = std::env::current_dir().unwrap_or_default();
        let scene = file.and_then(Path::parent).map(|p| normalize(&working.join(p))).filter(|p| *p != working);
        let scene = scene.map(Folder::new);
        let of_scripts = RefCell::default();
        ScriptFolders { working: Folder::new(working), scene, chosen: RefCell::default(), of_scripts }
    }

    /// Lets scripts read modules, which are files beside the script files of a document that have the same suffix.
    pub fn allow_modules_of(&self, document: &Document) {
        let mut all = self.of_scripts.borrow_mut();
        for (folder, suffix) in &document.modules {
            let folder = normalize(&self.working.path().join(folder));
            if all.iter().all(|(f, s)| f.path() != folder || s != suffix) {
                all.push((Rc::new(Folder::new(folder)), suffix.clone()));
            }
        }
    }

    /// Returns the folders in which documents that are read during the run may name files: those in which scripts may
    /// read.
    pub fn reach(&self, registry: &Registry) -> AllowedFolders {
        let chosen = self.chosen.borrow();
        let here = chosen.as_ref().unwrap_or(&self.working).path();
        let roots = std::iter::once(here).chain(self.scene.as_ref().map(Folder::path));
        AllowedFolders::within(self.working.path(), roots, registry)
    }

    /// Replaces the working folder by the folder at this absolute path.
    pub fn set_working_folder(&self, folder: PathBuf) {
        *self.chosen.borrow_mut() = Some(Folder::new(folder));
    }

    /// Returns the path of a file that may be opened in this mode (`TATU_FILE_*` bits).
    pub fn resolve(&self, name: &Path, mode: u32) -> Result<PathBuf, OpenError> {
        self.find(name, mode, |found| Ok(found.path))
    }

    /// Opens a regular file; `mode` consists of `TATU_FILE_*` bits.
    pub fn open(&self, name: &Path, mode: u32) -> Result<fs::File, OpenError> {
        self.find(name, mode, |found| found.open(name, mode))
    }

    /// Looks up a name in the folders in order, and calls `f` with the first match.
    fn find<T>(
        &self,
        name: &Path,
        mode: u32,
        f: impl FnOnce(FoundFile<'_>) -> Result<T, OpenError>,
    ) -> Result<T, OpenError> {
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
            match locate(&normalize(&root.path().join(name)), &among, writes, mode & TATU_FILE_FOLDERS != 0) {
                Ok(Some(found)) => return f(found),
                Ok(None) => {}
                Err(why) => refused = refused.or(Some(why)),
            }
        }
        // The names of scripts are relative to the working folder, even if another folder was chosen.
        let beside: Vec<&Folder> = of_scripts().collect();
        if let Ok(Some(found)) = locate(&normalize(&self.working.path().join(name)), &beside, writes, false) {
            return f(found);
        }
        Err(refused.unwrap_or_else(|| missing_file(name, &roots.iter().map(|r| r.path()).collect::<Vec<_>>())))
    }
}
