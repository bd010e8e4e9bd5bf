//! Writes files atomically.

use std::{
    fs::{self, File},
    io::{Error, ErrorKind, Result, Write},
    path::{Path, PathBuf},
};

/// Writes a temporary file next to `path`, then renames it to `path`. If `path` is a link, its target is replaced. An
/// existing file keeps its permissions. If `path` is not a regular file, for example a pipe or a device, writing is
/// refused, because renaming would replace it.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<()> {
    let path = target(path)?;
    let before = match fs::metadata(&path) {
        Ok(m) if m.is_file() => Some(m.permissions()),
        Ok(_) => return Err(Error::new(ErrorKind::InvalidInput, "the path exists, but is not a plain file")),
        Err(e) if e.kind() == ErrorKind::NotFound => None,
        Err(e) => return Err(e),
    };
    if before.as_ref().is_some_and(fs::Permissions::readonly) {
        return Err(Error::new(ErrorKind::PermissionDenied, "the existing file is read-only"));
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut part = builder().tempfile_in(folder)?;
    part.write_all(bytes)?;
    part.flush()?;
    if let Some(mode) = before {
        File::set_permissions(part.as_file(), mode)?;
    }
    part.persist(&path).map(drop).map_err(|e| e.error)
}

/// Follows links from `path`, and returns the final target, which need not exist.
fn target(path: &Path) -> Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..40 {
        match fs::read_link(&path) {
            Ok(next) => path = path.parent().unwrap_or(Path::new("")).join(next),
            Err(_) => return Ok(path),
        }
    }
    Err(Error::new(ErrorKind::InvalidInput, "there are too many links in a chain, or a link refers to itself"))
}

/// Configures temporary files with a unique name, so that two processes do not share one, and with the permissions of a
/// new file.
fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".tatu-").suffix(".part");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
}
