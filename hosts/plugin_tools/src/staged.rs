//! Installs the files of a plugin as a whole: they are copied into a temporary folder under their final names, so that
//! they can be tested there, and are then moved.

use std::{
    ffi::OsString,
    fs::{self, File},
    io,
    path::{Path, PathBuf},
};

use tatu_core::{
    errors::{Error, Result},
    plugins::assets_folder,
};
use tempfile::TempDir;

use super::assets;

/// A copy of a plugin, with its assets and the libraries beside it. It is deleted when the value is dropped.
pub struct StagedPlugin {
    dir: TempDir,
    library: PathBuf,
    /// The names of all files and folders of the plugin. That of the library is the last, so that the plugin is not
    /// there before what it needs.
    names: Vec<OsString>,
    /// The folder where it will be installed.
    folder: PathBuf,
}

impl StagedPlugin {
    /// Copies a plugin, its folder of assets and the libraries `beside` it into a temporary folder in `folder`.
    pub fn new(library: &Path, beside: &[PathBuf], folder: &Path) -> Result<Self> {
        make_folder(folder).map_err(|e| unwritten(folder, &e))?;
        // No plugin is searched in folders whose names begin with a dot.
        let dir = tempfile::Builder::new().prefix(".tatu-").tempdir_in(folder).map_err(|e| unwritten(folder, &e))?;
        let mut names = Vec::new();
        for file in beside.iter().map(PathBuf::as_path).chain([library]) {
            let name = file.file_name().unwrap_or_default().to_owned();
            copy(file, &dir.path().join(&name))?;
            names.push(name);
        }
        let copy = dir.path().join(library.file_name().unwrap_or_default());
        if let (Some(from), Some(to)) = (assets_folder(library).filter(|f| f.is_dir()), assets_folder(&copy)) {
            assets::replace(&from, &to).map_err(|e| unwritten(&to, &e))?;
        }
        // An installed plugin loses its old assets even if it has no new ones.
        names.splice(0..0, assets_folder(&copy).and_then(|f| f.file_name().map(OsString::from)));
        Ok(StagedPlugin { library: copy, dir, names, folder: folder.to_owned() })
    }

    /// Returns the copied library of the plugin.
    pub fn library(&self) -> &Path {
        &self.library
    }

    /// Returns the temporary folder.
    pub fn folder(&self) -> &Path {
        self.dir.path()
    }

    /// Moves all files to their final places; what is there already is replaced.
    pub fn place(&self) -> Result<PlacedPlugin<'_>> {
        let mut placed = PlacedPlugin { moved: Vec::new(), of: self };
        for (i, name) in self.names.iter().enumerate() {
            let [new, target] = [self.dir.path(), &self.folder].map(|f| f.join(name));
            let old = self.dir.path().join(format!("old.{i}"));
            let moved = placed.rename(&target, old).and_then(|()| placed.rename(&new, target.clone()));
            moved.map_err(|e| unwritten(&target, &e))?;
        }
        Ok(placed)
    }
}

/// A plugin that was moved to its place. When the value is dropped, the previous files return.
pub struct PlacedPlugin<'a> {
    /// The renames that were done, each from the first path to the second.
    moved: Vec<(PathBuf, PathBuf)>,
    of: &'a StagedPlugin,
}

impl PlacedPlugin<'_> {
    /// Renames a file or folder, if it exists.
    fn rename(&mut self, from: &Path, to: PathBuf) -> io::Result<()> {
        if from.symlink_metadata().is_err() {
            return Ok(());
        }
        fs::rename(from, &to)?;
        self.moved.push((from.to_owned(), to));
        Ok(())
    }

    /// Makes the change permanent.
    pub fn keep(mut self) {
        self.moved.clear();
        // Not all systems can write a folder to disk on request; they do so later.
        let _ = File::open(&self.of.folder).and_then(|f| f.sync_all());
    }
}

impl Drop for PlacedPlugin<'_> {
    fn drop(&mut self) {
        for (from, to) in self.moved.iter().rev() {
            // A rename that cannot be undone is no reason to leave the others.
            let _ = fs::rename(to, from);
        }
    }
}

/// Copies a library.
fn copy(from: &Path, to: &Path) -> Result {
    let mut source = File::open(from).map_err(|e| {
        Error::new("E105", format!("cannot read {}: {e}", from.display())).help("check that it is readable")
    })?;
    let fail = |e: io::Error| unwritten(to, &e);
    let mut copy = File::create_new(to).map_err(fail)?;
    io::copy(&mut source, &mut copy).map_err(fail)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        copy.set_permissions(fs::Permissions::from_mode(0o644)).map_err(fail)?;
    }
    copy.sync_all().map_err(fail)
}

/// Creates the folder, readable by all users.
fn make_folder(folder: &Path) -> io::Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    let mut builder = fs::DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o755);
    builder.recursive(true).create(folder)
}

pub fn unwritten(file: &Path, e: &io::Error) -> Error {
    Error::new("E105", format!("cannot write {}: {e}", file.display()))
        .help("check that the folder exists and is writable")
}
