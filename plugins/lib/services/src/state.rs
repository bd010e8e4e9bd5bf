//! Private files of the user that services store for later runs. They are in `$XDG_STATE_HOME/tatu`, by default
//! `~/.local/state/tatu`, or `%LOCALAPPDATA%\tatu` on Windows.
//!
//! Files that are links are not read. On Unix, the folder and its files are created such that only the user can access
//! them, and a file that belongs to another user or can be accessed by other users is not read, because other users may
//! have written it or may know its contents.

use std::{
    fs,
    io::{self, Read, Write},
    path::PathBuf,
};

use tatu_plugin_api::safe::state_folder;

/// The user's folder for private files.
#[derive(Debug, Clone)]
pub struct PrivateFolder {
    folder: PathBuf,
}

impl PrivateFolder {
    /// Opens the folder of this user, and creates it if necessary.
    pub fn of_user() -> io::Result<PrivateFolder> {
        let folder = state_folder().ok_or_else(|| {
            let text = "the folder for private files is not known: set `HOME` or `XDG_STATE_HOME` to an absolute path";
            io::Error::new(io::ErrorKind::NotFound, text)
        })?;
        PrivateFolder::at(folder)
    }

    /// Opens the folder at a path, and creates it if necessary.
    pub fn at(folder: PathBuf) -> io::Result<PrivateFolder> {
        #[cfg_attr(not(unix), expect(unused_mut, reason = "the mode exists only on Unix"))]
        let mut builder = fs::DirBuilder::new();
        #[cfg(unix)]
        std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
        builder.recursive(true).create(&folder)?;
        Ok(PrivateFolder { folder })
    }

    /// Returns the contents of a file. Returns `None` if the file does not exist, is larger than `most` bytes, or
    /// cannot be trusted.
    pub fn read(&self, name: &str, most: u64) -> Option<Vec<u8>> {
        let path = self.folder.join(name);
        if !fs::symlink_metadata(&path).ok()?.is_file() {
            return None;
        }
        let file = fs::File::open(&path).ok()?;
        // The opened file is checked again, because another file may have been moved to this name in the meantime.
        let about = file.metadata().ok()?;
        if !about.is_file() || about.len() > most || !self.is_private(&about).ok()? {
            return None;
        }
        let mut bytes = Vec::new();
        file.take(most).read_to_end(&mut bytes).ok()?;
        Some(bytes)
    }

    /// Writes a file atomically, so that a failure leaves an existing file unchanged. A link with this name is
    /// replaced, not followed.
    pub fn write(&self, name: &str, bytes: &[u8]) -> io::Result<()> {
        // `NamedTempFile` creates a file that only the user can access.
        let mut file = tempfile::NamedTempFile::new_in(&self.folder)?;
        file.write_all(bytes)?;
        file.persist(self.folder.join(name)).map_err(|e| e.error)?;
        Ok(())
    }

    /// Removes a file if it exists.
    pub fn remove(&self, name: &str) -> io::Result<()> {
        match fs::remove_file(self.folder.join(name)) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
            _ => Ok(()),
        }
    }

    /// Returns whether a file belongs to this user and is inaccessible to others.
    #[cfg(unix)]
    fn is_private(&self, about: &fs::Metadata) -> io::Result<bool> {
        use std::os::unix::fs::MetadataExt;
        // The standard library does not provide the id of the user, but a new file belongs to the user.
        let own = tempfile::tempfile_in(&self.folder)?.metadata()?.uid();
        Ok(about.uid() == own && about.mode() & 0o077 == 0)
    }
    #[cfg(not(unix))]
    fn is_private(&self, _: &fs::Metadata) -> io::Result<bool> {
        Ok(true)
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::{
        os::unix::fs::{PermissionsExt, symlink},
        path::Path,
    };

    use super::*;

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).unwrap().permissions().mode() & 0o777
    }

    #[test]
    fn private_files_are_accessible_to_their_owner_only() {
        let place = tempfile::tempdir().unwrap();
        let state = PrivateFolder::at(place.path().join("a/tatu")).unwrap();
        assert_eq!(state.read("x", 10), None);
        state.write("x", b"one").unwrap();
        state.write("x", b"two").unwrap();
        assert_eq!(state.read("x", 10).unwrap(), b"two");
        assert_eq!(state.read("x", 2), None, "it is too large");
        let file = place.path().join("a/tatu/x");
        assert_eq!((mode(&file), mode(file.parent().unwrap())), (0o600, 0o700));
        for bits in [0o640, 0o604, 0o620] {
            fs::set_permissions(&file, PermissionsExt::from_mode(bits)).unwrap();
            assert_eq!(state.read("x", 10), None, "{bits:o}");
        }
        state.remove("x").unwrap();
        state.remove("x").unwrap();
        assert!(!file.exists());
    }

    #[test]
    fn links_are_replaced_and_not_followed() {
        let place = tempfile::tempdir().unwrap();
        let state = PrivateFolder::at(place.path().join("tatu")).unwrap();
        let other = place.path().join("other");
        fs::write(&other, "theirs").unwrap();
        fs::set_permissions(&other, PermissionsExt::from_mode(0o600)).unwrap();
        symlink(&other, place.path().join("tatu/x")).unwrap();
        assert_eq!(state.read("x", 10), None);
        state.write("x", b"own").unwrap();
        assert_eq!(fs::read_to_string(&other).unwrap(), "theirs");
        assert_eq!(state.read("x", 10).unwrap(), b"own");
    }
}
