//! Copies and removes a plugin's folder of assets, which is beside the plugin's library.

use std::{fs, io, path::Path};

/// Maximum nesting depth of a folder of assets. Without a limit, a symbolic link to a parent folder would cause endless
/// recursion.
const MAX_FOLDER_DEPTH: usize = 16;

/// Replaces the folder `to` by a copy of the folder `from`. The copy is made under a temporary name and then renamed.
pub fn replace(from: &Path, to: &Path) -> io::Result<()> {
    let parent = to.parent().unwrap_or(Path::new("."));
    let new = tempfile::Builder::new().prefix(".tatu-").tempdir_in(parent)?;
    copy(from, new.path(), MAX_FOLDER_DEPTH)?;
    remove(to)?;
    fs::rename(new.keep(), to)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(to, fs::Permissions::from_mode(0o755))?;
    }
    Ok(())
}

/// Removes a folder of assets, if it exists.
pub fn remove(folder: &Path) -> io::Result<()> {
    match fs::remove_dir_all(folder) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
        _ => Ok(()),
    }
}

/// Copies the files and folders of a folder; anything else, such as a pipe, is an error.
fn copy(from: &Path, to: &Path, depth: usize) -> io::Result<()> {
    if depth == 0 {
        return Err(io::Error::other(format!("folders are nested more than {MAX_FOLDER_DEPTH} levels deep")));
    }
    for entry in fs::read_dir(from)? {
        let (path, name) = entry.map(|e| (e.path(), e.file_name()))?;
        let about = fs::metadata(&path)?;
        if about.is_dir() {
            fs::create_dir(to.join(&name))?;
            copy(&path, &to.join(&name), depth - 1)?;
        } else if about.is_file() {
            fs::copy(&path, to.join(&name))?;
        } else {
            return Err(io::Error::other(format!("{} is neither a file nor a folder", path.display())));
        }
    }
    Ok(())
}
