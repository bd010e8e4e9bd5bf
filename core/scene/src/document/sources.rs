//! The source files of a document.

use std::{
    collections::BTreeMap,
    io,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

use super::reach::AllowedFile;

/// Reads the files of a document and caches them. The cache allows the document to be rebuilt without the disk.
///
/// Clones share the cache. Each file is read from disk only once; create new `SourceFiles` to see changed files.
#[derive(Debug, Clone, Default)]
pub struct SourceFiles(Arc<SourceCache>);

#[derive(Debug, Default)]
struct SourceCache {
    files: Mutex<BTreeMap<PathBuf, Arc<[u8]>>>,
    /// Whether only cached files are available, and nothing is read from disk.
    closed: bool,
    /// Whether the files differ from those on disk, because they were recovered.
    recovered: bool,
}

impl SourceFiles {
    /// Creates a closed set of files, identified by the paths under which they were read.
    pub fn of(files: impl IntoIterator<Item = (PathBuf, Vec<u8>)>) -> Self {
        let files = files.into_iter().map(|(p, b)| (p, b.into())).collect();
        SourceFiles(Arc::new(SourceCache { files: Mutex::new(files), closed: true, recovered: false }))
    }

    /// Creates sources in which these files replace those on disk with the same paths.
    pub fn with_replacements(files: impl IntoIterator<Item = (PathBuf, Vec<u8>)>, recovered: bool) -> Self {
        let files = files.into_iter().map(|(p, b)| (p, b.into())).collect();
        SourceFiles(Arc::new(SourceCache { files: Mutex::new(files), closed: false, recovered }))
    }

    /// Returns whether files were recovered, in which case those on disk are older.
    pub fn are_recovered(&self) -> bool {
        self.0.recovered
    }

    /// Returns whether the files are a closed set, in which case nothing is read from disk.
    pub fn are_closed(&self) -> bool {
        self.0.closed
    }

    /// Returns whether a file is cached, in which case it is not read from disk.
    pub fn has(&self, path: &Path) -> bool {
        self.0.files.lock().unwrap_or_else(PoisonError::into_inner).contains_key(path)
    }

    /// Adds a file that belongs to the document although nothing in it refers to the file.
    pub fn add_file(&self, path: &Path, bytes: Vec<u8>) {
        self.0.files.lock().unwrap_or_else(PoisonError::into_inner).insert(path.to_owned(), bytes.into());
    }

    /// Returns the bytes of a file that is cached. Nothing is read from disk.
    pub fn cached(&self, path: &Path) -> Option<Arc<[u8]>> {
        self.0.files.lock().unwrap_or_else(PoisonError::into_inner).get(path).cloned()
    }

    /// Returns the bytes of a file. A file that is not cached is read from disk and cached, or is an error if the
    /// sources are a closed set.
    pub fn read(&self, file: &AllowedFile) -> io::Result<Vec<u8>> {
        let mut files = self.0.files.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(bytes) = files.get(file.path()) {
            return Ok(bytes.to_vec());
        }
        if self.0.closed {
            return Err(io::Error::new(io::ErrorKind::NotFound, "it is not among the stored files"));
        }
        let bytes = file.read()?;
        files.insert(file.path().to_owned(), bytes.as_slice().into());
        Ok(bytes)
    }

    /// Returns a file as text; invalid UTF-8 is an error.
    pub fn read_text(&self, file: &AllowedFile) -> io::Result<String> {
        String::from_utf8(self.read(file)?).map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e.utf8_error()))
    }

    /// Returns all files that have been read or added, in ascending order of their paths.
    pub fn files(&self) -> Vec<(PathBuf, Arc<[u8]>)> {
        let files = self.0.files.lock().unwrap_or_else(PoisonError::into_inner);
        files.iter().map(|(p, b)| (p.clone(), b.clone())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cached_files_are_read_without_the_disk() {
        let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        let disk = SourceFiles::default();
        let text = disk.read_text(&AllowedFile::chosen(&manifest)).unwrap();
        assert!(text.contains("[package]"));
        assert!(disk.read(&AllowedFile::chosen(Path::new("no/such/file"))).is_err());
        let kept = SourceFiles::of(disk.files().into_iter().map(|(p, b)| (p, b.to_vec())));
        assert_eq!(kept.read_text(&AllowedFile::chosen(&manifest)).unwrap(), text);
        // The library's source exists on disk, but was not read.
        let other = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs");
        assert!(other.exists() && kept.read(&AllowedFile::chosen(&other)).is_err());
    }
}
