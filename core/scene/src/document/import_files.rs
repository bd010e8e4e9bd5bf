//! Files that a document names.

use std::{
    io::ErrorKind,
    path::{Path, PathBuf},
};

use tatu_errors::{Error, Result};

use super::{
    BuildReport, DocumentBuilder,
    packages::{self, PackageEntry, PackageReference, PackageScheme},
    reach::AllowedFile,
};

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
        self.read_allowed(&self.allow_file(&folder.join(name), name)?, name)
    }

    /// Reads a file that an imported file names, relative to the folder of that file or as a URI (`package://`,
    /// `model://` or `file://`). It may be beneath the permitted folders, in the package of the file, or near it. A name
    /// that leads elsewhere is reported: those in a file from another computer refer to folders of that computer.
    pub(super) fn read_file_of_import(&mut self, folder: &Path, name: &str) -> Result<Option<Vec<u8>>> {
        if let Some(reference) = PackageReference::parse(name) {
            return match reference {
                Ok(reference) => self.read_package_file(folder, &reference, name),
                Err(why) => Ok(self.report_once(why)),
            };
        }
        let (path, is_uri) = match name.strip_prefix("file://") {
            Some(path) => (folder.join(path), true),
            None => (folder.join(name), false),
        };
        let near = || if is_uri { None } else { self.reach.file_near(folder, &path) };
        match self.allow_file(&path, name) {
            Ok(allowed) => self.read_allowed(&allowed, name),
            Err(e) => match near() {
                Some(allowed) => self.read_allowed(&allowed, name),
                None => Ok(self.report_once(e.text)),
            },
        }
    }

    fn read_allowed(&self, file: &AllowedFile, name: &str) -> Result<Option<Vec<u8>>> {
        match self.document.sources.read(file) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::InvalidInput) => Ok(None),
            Err(e) => Err(Error::new("E105", format!("cannot read the file `{name}`: {e}"))),
        }
    }

    /// Reads a file of a package, and reports why it cannot be read.
    fn read_package_file(
        &mut self,
        folder: &Path,
        reference: &PackageReference,
        name: &str,
    ) -> Result<Option<Vec<u8>>> {
        if self.document.sources.are_closed() {
            let stored = self.document.sources.files();
            let stored = stored.iter().map(|(path, bytes)| (path.as_path(), &**bytes));
            return match packages::find_stored(reference, stored) {
                Some(path) => self.read_allowed(&self.allow_file(&path, name)?, name),
                None => Ok(None),
            };
        }
        let start = self.reach.absolute(folder);
        let Some(package) = packages::find(reference, &start, &self.registry.search.packages) else {
            let sought = match reference.scheme {
                PackageScheme::ByManifest => "package",
                PackageScheme::ByFolder => "folder of the model",
            };
            return Ok(self.report_once(format!(
                "the {sought} `{}` was not found above the file, beside its package, or in {}; name the folder that \
                 contains it by `--package-path` or TATU_PACKAGE_PATH",
                reference.package,
                packages::shown_roots(&self.registry.search.packages)
            )));
        };
        let shown = package.folder.display();
        if package.manifest.is_none() && packages::is_description(&reference.file) {
            let text = format!("`{name}` is not read: {shown} has no `package.xml` that states its name");
            return Ok(self.report_once(text));
        }
        let file = match packages::look_up(&package.folder, &reference.file) {
            PackageEntry::Exact => reference.file.clone(),
            PackageEntry::OtherCase(file) => {
                self.report_once(format!("`{name}` is `{}` in {shown}, with other capitals", file.display()));
                file
            }
            PackageEntry::Missing(_) if reference.is_optional() => return Ok(None),
            PackageEntry::Missing(near) => {
                let hint = near.map(|near| format!("; there is `{}`", near.display())).unwrap_or_default();
                // Importers count what they miss, so one report for each package suffices.
                if self.document.reading.incomplete_packages.insert(package.folder.clone()) {
                    self.report_once(format!("`{name}` does not exist in {shown}{hint}"));
                }
                return Ok(None);
            }
        };
        let Some(allowed) = self.reach.file_below(&package.folder, &package.folder.join(file)) else {
            return Ok(self.report_once(format!("`{name}` is a link that leads out of {shown}, and is not followed")));
        };
        let read = self.read_allowed(&allowed, name)?;
        if let Some(manifest) = package.manifest.filter(|_| read.is_some()) {
            // With its manifest, the package can be found among stored files.
            self.document.sources.add_file(&packages::manifest_path(&package.folder), manifest);
        }
        Ok(read)
    }

    /// Adds a warning, unless there is the same one already, and returns that there is no file.
    fn report_once(&mut self, text: String) -> Option<Vec<u8>> {
        if !self.document.reports.iter().any(|report| report.text == text) {
            self.document.reports.push(BuildReport::warning(text));
        }
        None
    }
}
