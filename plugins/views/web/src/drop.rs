//! Receives files that are dropped on the page. They arrive in parts, are stored in a separate folder, and never
//! replace an existing file.

use std::path::Path;

use base64::{Engine, engine::general_purpose::STANDARD};
use tatu_plugin_api::{
    abi::{TATU_FILE_FOLDERS, TATU_FILE_NEW, TATU_FILE_READ, TATU_FILE_WRITE},
    safe::{Fail, Result, Turn},
};

/// Name of the folder for dropped files, within the folder in which scripts may open files.
const FOLDER: &str = "dropped";
/// Allowed extensions of a single file, and of the files that are dropped together with a scene.
const ENDINGS: &[&str] = &["toml", "ttt", "ttm", "urdf"];
const ENDINGS_WITH_SCENE: &[&str] = &[
    "toml", "ttt", "ttm", "urdf", "xacro", "lua", "obj", "mtl", "stl", "ply", "dae", "png", "jpg", "jpeg", "svg",
    "csv", "json", "txt", "md",
];
/// Maximum size of a file, bytes.
const MOST: usize = 64 << 20;
/// Maximum length of a file or folder name, bytes.
const LONGEST: usize = 100;
/// Maximum number of files, or of folders, with names that differ only in the appended number.
const MOST_ALIKE: usize = 1000;
/// Maximum number of files in a folder.
const MOST_FILES: usize = 1000;
/// Maximum total size of the files in a folder, bytes.
const MOST_TOGETHER: usize = 256 << 20;
/// Maximum number of components of a file's path within its folder, including the name of the file.
const DEEPEST: usize = 8;

/// Checks the name of a single file or folder, which must not be a path.
fn check(name: &str) -> Result {
    let plain = |c: char| c.is_alphanumeric() || " ._-()+".contains(c);
    if name.is_empty() || name.len() > LONGEST || name.starts_with('.') || !name.chars().all(plain) {
        return Err(Fail::argument(format!(
            "`{name}` is not a valid file name: expected 1 to {LONGEST} bytes, only letters, digits, spaces and \
             the characters . _ - ( ) +, and no period at the start"
        )));
    }
    Ok(())
}

/// Checks that the extension of a file name is one of `endings`; case does not matter.
fn check_ending(name: &str, endings: &[&str]) -> Result {
    let ending = Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
    if endings.contains(&ending.as_str()) {
        return Ok(());
    }
    let expected = endings.join(", ");
    Err(Fail::argument(format!("`{name}` does not have an accepted file extension: expected one of {expected}")))
}

/// A folder for a scene and its files, which are dropped together.
pub struct Folder {
    /// Path of the folder, relative to the folder in which scripts may open files.
    name: String,
    /// Number of files of which at least a part was received.
    files: usize,
    /// Total size of the files that were received completely, bytes.
    bytes: usize,
}

impl Folder {
    /// Chooses an unused name for the folder, based on `name`, which must not be a path. The folder itself is created
    /// with its first file.
    pub fn new(turn: &Turn<'_>, name: &str) -> Result<Folder> {
        check(name)?;
        for n in 1..=MOST_ALIKE {
            let name = if n == 1 { format!("{FOLDER}/{name}") } else { format!("{FOLDER}/{name}-{n}") };
            let is_there = |path: Vec<u8>| Path::new(&*String::from_utf8_lossy(&path)).symlink_metadata().is_ok();
            if !turn.file(name.as_bytes(), TATU_FILE_READ).is_ok_and(is_there) {
                return Ok(Folder { name, files: 0, bytes: 0 });
            }
        }
        Err(Fail::new(format!("there are already {MOST_ALIKE} folders named `{name}` in `{FOLDER}`"))
            .help("remove some of them"))
    }

    /// Returns the path of the folder, as commands and scripts use it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Starts to receive a file for the folder; `name` may be a path with subfolders.
    pub fn file(&mut self, name: &str) -> Result<Dropped> {
        let parts: Vec<&str> = name.split('/').collect();
        if parts.len() > DEEPEST {
            return Err(Fail::argument(format!(
                "`{name}` has too many folders: expected at most {DEEPEST} path components, including the file name"
            )));
        }
        parts.iter().try_for_each(|part| check(part))?;
        check_ending(name, ENDINGS_WITH_SCENE)?;
        self.files += 1;
        if self.files > MOST_FILES {
            return Err(Fail::argument(format!(
                "too many files for the folder `{}`: expected at most {MOST_FILES}",
                self.name
            )));
        }
        Ok(Dropped { name: name.to_owned(), folder: self.name.clone(), bytes: Vec::new() })
    }

    /// Adds the size of a received file to the total if the file is in this folder. Fails if the total exceeds the
    /// limit.
    pub fn count(&mut self, file: &Dropped) -> Result {
        if file.folder == self.name {
            self.bytes += file.bytes.len();
        }
        if self.bytes > MOST_TOGETHER {
            return Err(Fail::argument(format!(
                "the files in `{}` are too large: expected at most {MOST_TOGETHER} bytes in total",
                self.name
            )));
        }
        Ok(())
    }
}

/// A file that is being received.
pub struct Dropped {
    name: String,
    folder: String,
    bytes: Vec<u8>,
}

impl Dropped {
    /// Starts to receive a single file; `name` must not be a path.
    pub fn new(name: &str) -> Result<Dropped> {
        check(name)?;
        check_ending(name, ENDINGS)?;
        Ok(Dropped { name: name.to_owned(), folder: FOLDER.to_owned(), bytes: Vec::new() })
    }

    /// Appends a part of the file, which is encoded in base64.
    pub fn take(&mut self, part: &str) -> Result {
        let bytes =
            STANDARD.decode(part).map_err(|_| Fail::argument("a part of a dropped file is not valid base64"))?;
        if self.bytes.len() + bytes.len() > MOST {
            return Err(Fail::argument(format!("`{}` is too large: expected at most {MOST} bytes", self.name)));
        }
        self.bytes.extend(bytes);
        Ok(())
    }

    /// Writes the file and returns its path, as commands and scripts use it. A single file gets a number appended to
    /// its name if the name is in use.
    pub fn write(self, turn: &Turn<'_>) -> Result<String> {
        let (stem, ending) = self.name.rsplit_once('.').unwrap_or((&self.name, ""));
        // Files of a scene refer to each other by name, so they must not be renamed.
        let most = if self.folder == FOLDER { MOST_ALIKE } else { 1 };
        for n in 1..=most {
            let name = if n == 1 { self.name.clone() } else { format!("{stem}-{n}.{ending}") };
            let name = format!("{}/{name}", self.folder);
            if turn.file(name.as_bytes(), TATU_FILE_READ).is_ok() && n < most {
                continue;
            }
            let mode = TATU_FILE_WRITE | TATU_FILE_NEW | TATU_FILE_FOLDERS;
            let mut file = turn.open_file(name.as_bytes(), mode)?;
            return match std::io::Write::write_all(&mut file, &self.bytes) {
                Ok(()) => Ok(name),
                Err(e) => Err(Fail::new(format!("`{name}` cannot be written: {e}"))),
            };
        }
        Err(Fail::new(format!("there are already {MOST_ALIKE} files named `{}` in `{FOLDER}`", self.name)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_nowhere_else() {
        for bad in
            ["../x.ttt", "/etc/x.ttt", "a\\b.ttt", ".x.ttt", "x.lua", "x", "", "a:b.ttt", "x.ttt\0", &"y".repeat(200)]
        {
            assert!(Dropped::new(bad).is_err(), "{bad}");
        }
        assert!(Dropped::new("My scene (2).ttt").is_ok() && Dropped::new("robot.URDF").is_ok());
    }

    #[test]
    fn files_of_a_scene_stay_below_its_folder() {
        let mut folder = Folder { name: "dropped/room".to_owned(), files: 0, bytes: 0 };
        for bad in ["../a.toml", "a/../b.toml", "/a.toml", "a//b.lua", "a/.b.lua", "a\\b.lua", "b.so", "a/b", "b.lua/"]
        {
            assert!(folder.file(bad).is_err(), "{bad}");
        }
        assert!(folder.file(&format!("{}x.lua", "a/".repeat(DEEPEST))).is_err());
        let file = folder.file("scripts/drive.lua").unwrap();
        assert_eq!((file.folder.as_str(), file.name.as_str()), ("dropped/room", "scripts/drive.lua"));
        assert!((1..MOST_FILES).all(|_| folder.file("x.png").is_ok()) && folder.file("x.png").is_err());
        let large =
            Dropped { name: String::new(), folder: "dropped/room".to_owned(), bytes: vec![0; MOST_TOGETHER / 2] };
        assert!(folder.count(&large).is_ok() && folder.count(&large).is_ok() && folder.count(&file).is_ok());
        let one = Dropped { bytes: vec![0], ..file };
        assert!(folder.count(&one).is_err());
    }

    #[test]
    fn no_more_is_taken_than_may_come() {
        let mut file = Dropped::new("x.ttt").unwrap();
        let part = STANDARD.encode(vec![0; 3 << 20]);
        assert!((0..21).all(|_| file.take(&part).is_ok()) && file.take(&part).is_err());
        assert!(file.take("no base64!").is_err());
    }
}
