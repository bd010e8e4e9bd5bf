//! Folders with files that come with a program.

use std::path::{Path, PathBuf};

/// Returns the places of a folder that comes with a program, such as `models`, in the order in which they are searched:
/// beside the program, in `../share/tatu`, and in the repository if cargo has built the program there. They may not
/// exist.
pub fn folders_beside(program: &Path, name: &str) -> Vec<PathBuf> {
    let Some(dir) = program.parent() else { return Vec::new() };
    let mut folders = vec![dir.join(name)];
    folders.extend(dir.parent().map(|up| up.join("share/tatu").join(name)));
    // Beside `deps` the program is one that cargo has built, in `target/PROFILE` of the repository.
    if dir.join("deps").is_dir() {
        folders.extend(dir.parent().and_then(Path::parent).map(|root| root.join(name)));
    }
    folders
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_installed_program_has_two_places() {
        let of = |program: &str| folders_beside(Path::new(program), "models");
        assert_eq!(of("/opt/bin/tatu"), ["/opt/bin/models", "/opt/share/tatu/models"].map(PathBuf::from));
        assert_eq!(of("/"), [""; 0].map(PathBuf::from));
    }
}
