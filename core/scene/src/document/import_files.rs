//! Files that a document names.

use std::{
    io::ErrorKind,
    path::{Path, PathBuf},
};

use tatu_errors::{Error, Result};

use super::{DocumentBuilder, reach::AllowedFile};

/// The source from which objects are built.
pub(super) struct BuildSource {
    /// Name of the source file, which precedes the reports about it.
    pub name: Option<String>,
    /// The folder that file names are relative to; `None` if no files can be read.
    pub folder: Option<PathBuf>,
    /// Whether the source is the scene itself, rather than a part of one.
    pub is_scene: bool,
}

impl DocumentBuilder<'_> {
    /// Returns a file that the document names, if it may; see [`AllowedFolders::file`](super::AllowedFolders::file).
    /// `name` is the name as written in the document.
    pub(super) fn allow_file(&self, path: &Path, name: &str) -> Result<AllowedFile> {
        self.reach.file(path, name, self.document.sources.are_closed())
    }

    /// Reads a file that the document names, relative to a folder. Returns `None` if the file does not exist or is not
    /// a regular file, in which case a plugin can try a different name. A file outside the permitted folders is an
    /// error.
    pub(super) fn read_named_file(&self, folder: &Path, name: &str) -> Result<Option<Vec<u8>>> {
        let allowed = self.allow_file(&folder.join(name), name)?;
        match self.document.sources.read(&allowed) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::InvalidInput) => Ok(None),
            Err(e) => Err(Error::new("E105", format!("cannot read the file `{name}`: {e}"))),
        }
    }
}
