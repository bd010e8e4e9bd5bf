//! The files that a document may name: those in and below a few folders.

use std::{
    fs, io,
    path::{Path, PathBuf},
    sync::Arc,
};

use tatu_errors::{Error, Result};
use tatu_plugin_api::{
    abi::TATU_FILE_READ,
    safe::{MAX_FILE_BYTES, folders_beside, program_file, read_opened, read_plain},
};
use tatu_plugins::Registry;

use super::packages;
use crate::folders::{Folder, OpenError, normalize};

/// The folders that must contain, at any depth, the files that a document names: its scripts, models, meshes, images
/// and imports, and the files that these name in turn. These are the folders in which the scripts of the scene may read
/// files, and the folders of models and scenes that come with the program or that the user has installed. For files
/// that a model from such a folder names, the model's own folder is included.
///
/// Documents can access the files that they name only through `file`.
#[derive(Debug, Clone)]
pub struct AllowedFolders {
    /// The folder that relative paths start from.
    working_folder: PathBuf,
    /// The folders of the scene and of its scripts.
    scene_folders: Arc<[Arc<Folder>]>,
    /// The folders that do not depend on the scene.
    shared: Arc<[Arc<Folder>]>,
    /// The folder of the model that is being read, if the model was found in one of the shared folders.
    model: Option<Arc<Folder>>,
}

impl AllowedFolders {
    /// Returns the folders for a scene in `file`: the working folder and that of the file.
    pub fn of(file: &Path, registry: &Registry) -> Self {
        let here = std::env::current_dir().unwrap_or_default();
        let folder = normalize(&here.join(file.parent().unwrap_or(Path::new(""))));
        AllowedFolders::within(&here, [here.as_path(), &folder], registry)
    }

    /// Returns a set of absolute folders. Relative paths start from `here`.
    pub fn within<'a>(here: &Path, folders: impl IntoIterator<Item = &'a Path>, registry: &Registry) -> Self {
        let mut own: Vec<&Path> = folders.into_iter().collect();
        own.dedup();
        let installed = registry.search.models.iter().filter(|f| !registry.search.is_beside_scene(f)).cloned();
        let scenes = program_file().into_iter().flat_map(|program| folders_beside(&program, "scenes"));
        let folder = |path: PathBuf| Arc::new(Folder::new(normalize(&here.join(path))));
        AllowedFolders {
            working_folder: here.to_owned(),
            scene_folders: own.into_iter().map(|path| folder(path.to_owned())).collect(),
            shared: installed.chain(scenes).map(folder).collect(),
            model: None,
        }
    }

    /// Returns the empty set, for a document that names no files.
    pub(super) fn none() -> Self {
        AllowedFolders {
            working_folder: PathBuf::new(),
            scene_folders: Arc::default(),
            shared: Arc::default(),
            model: None,
        }
    }

    /// Returns the folders for a model in a folder that the user or the program has chosen. It replaces the folder of
    /// the model that contains this one.
    pub(super) fn with_model_folder(&self, folder: &Path) -> Self {
        AllowedFolders {
            model: Some(Arc::new(Folder::new(normalize(&self.working_folder.join(folder))))),
            ..self.clone()
        }
    }

    fn folders(&self) -> impl Iterator<Item = &Arc<Folder>> {
        self.scene_folders.iter().chain(&self.model).chain(self.shared.iter())
    }

    /// Returns the file with a path if the document may name it; otherwise the error E105, which does not reveal
    /// whether the file exists. `name` is the name in the document. If `is_stored` is set, the contents of all files
    /// are stored, and nothing is read from disk.
    pub(super) fn file(&self, path: &Path, name: &str, is_stored: bool) -> Result<AllowedFile> {
        let allowed = |how| Ok(AllowedFile { path: path.to_owned(), origin: how });
        if is_stored {
            return allowed(FileOrigin::Stored);
        }
        let full = normalize(&self.working_folder.join(path));
        if let Ok(real) = fs::canonicalize(&full) {
            return match self.folders().find(|folder| folder.below(&real, path).is_some()) {
                Some(folder) => allowed(FileOrigin::Below(folder.clone(), real)),
                None => Err(self.outside_error(name)),
            };
        }
        match self.folders().any(|folder| full.starts_with(folder.path())) {
            true => allowed(FileOrigin::Stored),
            false => Err(self.outside_error(name)),
        }
    }

    /// Returns a path without `.` and `..`, from the working folder if it is relative.
    pub(super) fn absolute(&self, path: &Path) -> PathBuf {
        normalize(&self.working_folder.join(path))
    }

    /// Returns a file with a path if it is below this folder, not in a hidden folder, and of the kind that its name
    /// tells, also when links are followed.
    pub(super) fn file_below(&self, folder: &Path, path: &Path) -> Option<AllowedFile> {
        let real_folder = fs::canonicalize(folder).ok()?;
        let folder = Arc::new(Folder::new(folder.to_owned()));
        let real = fs::canonicalize(self.absolute(path)).ok()?;
        folder.below(&real, path)?;
        if packages::enters_hidden(real.strip_prefix(&real_folder).ok()?) || !packages::same_kind(&real, path) {
            return None;
        }
        Some(AllowedFile { path: path.to_owned(), origin: FileOrigin::Below(folder, real) })
    }

    /// Returns a mesh, an image or a part of a description with a path if it is in the package that contains the folder
    /// of a document; without a package, a mesh, an image or the description of a model that is in or below the folder
    /// above.
    pub(super) fn file_near(&self, folder: &Path, path: &Path) -> Option<AllowedFile> {
        let folder = self.absolute(folder);
        let is_near = packages::is_asset(path) || packages::is_model(path);
        let is_part = is_near || packages::is_description(path);
        match packages::enclosing(&folder).filter(|_| is_part) {
            Some(package) => self.file_below(&package, path),
            // Meshes are often in a folder beside that of the document.
            None => {
                let above = folder.parent().filter(|above| above.parent().is_some() && is_near)?;
                self.file_below(above, path)
            }
        }
    }

    /// Returns whether a document may name the file with a path, which need not exist.
    pub(super) fn contains(&self, path: &Path) -> bool {
        self.file(path, "", false).is_ok()
    }

    /// Returns the error for a name of a file outside these folders.
    pub(super) fn outside_error(&self, name: &str) -> Error {
        let shown = |folder: &Arc<Folder>| format!("`{}`", folder.path().display());
        let folders: Vec<String> = self.scene_folders.iter().chain(&self.model).map(shown).collect();
        Error::new("E105", format!("the file `{name}` is outside the folders that may be read"))
            .expected(format!("a file below {}", folders.join(" or ")))
            .help("move it there, or run the program in a folder that contains both it and the scene")
    }
}

/// A file that may be read: one that the user or the program has chosen, or one that a document may name.
#[derive(Debug)]
pub struct AllowedFile {
    path: PathBuf,
    origin: FileOrigin,
}

#[derive(Debug)]
enum FileOrigin {
    /// The path comes from the user or from the program.
    Chosen,
    /// The canonical path, which is in or below this folder.
    Below(Arc<Folder>, PathBuf),
    /// The file is not on disk; its contents may be stored.
    Stored,
}

impl AllowedFile {
    /// Allows a file that the user or the program has chosen. A path that was taken from a document, or from any other
    /// file, must not be passed here.
    pub fn chosen(path: &Path) -> Self {
        AllowedFile { path: path.to_owned(), origin: FileOrigin::Chosen }
    }

    /// Returns the path under which the file was named.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Reads the file from disk. It must be a regular file of at most 256 MB.
    pub(super) fn read(&self) -> io::Result<Vec<u8>> {
        let gone = || io::Error::new(io::ErrorKind::NotFound, "there is no such file");
        let kind = |real: &Path| if real.is_dir() { "it is a folder" } else { "it is not a plain file" };
        match &self.origin {
            FileOrigin::Chosen => read_plain(&self.path, MAX_FILE_BYTES),
            // The error of the operating system states why the file cannot be read.
            FileOrigin::Stored => Err(fs::metadata(&self.path).err().unwrap_or_else(gone)),
            FileOrigin::Below(folder, real) => {
                let found = folder.below(real, &self.path).ok_or_else(gone)?;
                let file = found.open(&self.path, TATU_FILE_READ).map_err(|why| match why {
                    OpenError::Missing(text) => io::Error::new(io::ErrorKind::NotFound, text),
                    OpenError::Irregular(_) => io::Error::new(io::ErrorKind::InvalidInput, kind(real)),
                    OpenError::Forbidden(text) => io::Error::new(io::ErrorKind::PermissionDenied, text),
                })?;
                read_opened(file, MAX_FILE_BYTES)
            }
        }
    }
}
