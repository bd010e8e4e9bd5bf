//! Receives files that are dropped on the page. They arrive in parts, are stored in a separate folder, and never
//! replace an existing file.

use std::path::Path;

use base64::{Engine, engine::general_purpose::STANDARD};
use tatu_plugin_api::{
    abi::{TATU_FILE_FOLDERS, TATU_FILE_NEW, TATU_FILE_READ, TATU_FILE_WRITE},
    safe::{Fail, Result, Turn},
};

/// Name of the folder for dropped files, within the folder in which scripts may open files.
const DROP_FOLDER: &str = "dropped";
/// Allowed extensions of a single file, and of the files that are dropped together with a scene.
const SCENE_EXTENSIONS: &[&str] =
    &["toml", "ttt", "ttm", "urdf", "xacro", "sdf", "world", "xml", "mjcf", "obj", "stl", "ply", "dae", "gltf", "glb"];
const SCENE_FOLDER_EXTENSIONS: &[&str] = &[
    "toml", "ttt", "ttm", "urdf", "xacro", "sdf", "world", "xml", "mjcf", "config", "yaml", "yml", "lua", "obj", "mtl",
    "stl", "ply", "dae", "gltf", "glb", "bin", "msh", "png", "jpg", "jpeg", "svg", "csv", "json", "txt", "md",
];
/// Maximum size of a file, bytes.
const MAX_FILE_BYTES: usize = 64 << 20;
/// Maximum length of a file or folder name, bytes.
const MAX_NAME_BYTES: usize = 100;
/// Maximum number of files, or of folders, with names that differ only in the appended number.
const MAX_NUMBERED_NAMES: usize = 1000;
/// Maximum number of files in a folder.
const MAX_FILES: usize = 1000;
/// Maximum total size of the files in a folder, bytes.
const MAX_FOLDER_BYTES: usize = 256 << 20;
/// Maximum number of components of a file's path within its folder, including the name of the file.
const MAX_PATH_COMPONENTS: usize = 8;

/// Checks the name of a single file or folder, which must not be a path.
fn check_name(name: &str) -> Result {
    let plain = |c: char| c.is_alphanumeric() || " ._-()+".contains(c);
    if name.is_empty() || name.len() > MAX_NAME_BYTES || name.starts_with('.') || !name.chars().all(plain) {
        return Err(Fail::argument(format!(
            "`{name}` is not a valid file name: expected 1 to {MAX_NAME_BYTES} bytes, only letters, digits, spaces and \
             the characters . _ - ( ) +, and no period at the start"
        )));
    }
    Ok(())
}

/// Checks that the extension of a file name is one of `endings`; case does not matter.
fn check_extension(name: &str, endings: &[&str]) -> Result {
    let ending = Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
    if endings.contains(&ending.as_str()) {
        return Ok(());
    }
    let expected = endings.join(", ");
    Err(Fail::argument(format!("`{name}` does not have an accepted file extension: expected one of {expected}")))
}

/// A folder for a scene and its files, which are dropped together.
pub struct DropFolder {
    /// Path of the folder, relative to the folder in which scripts may open files.
    name: String,
    /// Number of files of which at least a part was received.
    files: usize,
    /// Total size of the files that were received completely, bytes.
    bytes: usize,
}

impl DropFolder {
    /// Chooses an unused name for the folder, based on `name`, which must not be a path. The folder itself is created
    /// with its first file.
    pub fn new(turn: &Turn<'_>, name: &str) -> Result<DropFolder> {
        check_name(name)?;
        for n in 1..=MAX_NUMBERED_NAMES {
            let name = if n == 1 { format!("{DROP_FOLDER}/{name}") } else { format!("{DROP_FOLDER}/{name}-{n}") };
            let is_there = |path: Vec<u8>| Path::new(&*String::from_utf8_lossy(&path)).symlink_metadata().is_ok();
            if !turn.file(name.as_bytes(), TATU_FILE_READ).is_ok_and(is_there) {
                return Ok(DropFolder { name, files: 0, bytes: 0 });
            }
        }
        Err(Fail::new(format!("there are already {MAX_NUMBERED_NAMES} folders named `{name}` in `{DROP_FOLDER}`"))
            .help("remove some of them"))
    }

    /// Returns the path of the folder, as commands and scripts use it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Starts to receive a file for the folder; `name` may be a path with subfolders.
    pub fn file(&mut self, name: &str) -> Result<DroppedFile> {
        let parts: Vec<&str> = name.split('/').collect();
        if parts.len() > MAX_PATH_COMPONENTS {
            return Err(Fail::argument(format!(
                "`{name}` has too many folders: expected at most {MAX_PATH_COMPONENTS} path components, including the file name"
            )));
        }
        parts.iter().try_for_each(|part| check_name(part))?;
        check_extension(name, SCENE_FOLDER_EXTENSIONS)?;
        self.files += 1;
        if self.files > MAX_FILES {
            return Err(Fail::argument(format!(
                "too many files for the folder `{}`: expected at most {MAX_FILES}",
                self.name
            )));
        }
        Ok(DroppedFile { name: name.to_owned(), folder: self.name.clone(), bytes: Vec::new() })
    }

    /// Adds the size of a received file to the total if the file is in this folder. Fails if the total exceeds the
    /// limit.
    pub fn add_size(&mut self, file: &DroppedFile) -> Result {
        if file.folder == self.name {
            self.bytes += file.bytes.len();
        }
        if self.bytes > MAX_FOLDER_BYTES {
            return Err(Fail::argument(format!(
                "the files in `{}` are too large: expected at most {MAX_FOLDER_BYTES} bytes in total",
                self.name
            )));
        }
        Ok(())
    }
}

/// A file that is being received.
pub struct DroppedFile {
    name: String,
    folder: String,
    bytes: Vec<u8>,
}

impl DroppedFile {
    /// Starts to receive a single file; `name` must not be a path.
    pub fn new(name: &str) -> Result<DroppedFile> {
        check_name(name)?;
        check_extension(name, SCENE_EXTENSIONS)?;
        Ok(DroppedFile { name: name.to_owned(), folder: DROP_FOLDER.to_owned(), bytes: Vec::new() })
    }

    /// Appends a part of the file, which is encoded in base64.
    pub fn append(&mut self, part: &str) -> Result {
        let bytes =
            STANDARD.decode(part).map_err(|_| Fail::argument("a part of a dropped file is not valid base64"))?;
        if self.bytes.len() + bytes.len() > MAX_FILE_BYTES {
            return Err(Fail::argument(format!(
                "`{}` is too large: expected at most {MAX_FILE_BYTES} bytes",
                self.name
            )));
        }
        self.bytes.extend(bytes);
        Ok(())
    }

    /// Writes the file and returns its path, as commands and scripts use it. A single file gets a number appended to
    /// its name if the name is in use.
    pub fn write(self, turn: &Turn<'_>) -> Result<String> {
        let (stem, ending) = self.name.rsplit_once('.').unwrap_or((&self.name, ""));
        // Files of a scene refer to each other by name, so they must not be renamed.
        let most = if self.folder == DROP_FOLDER { MAX_NUMBERED_NAMES } else { 1 };
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
        Err(Fail::new(format!("there are already {MAX_NUMBERED_NAMES} files named `{}` in `{DROP_FOLDER}`", self.name)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_folders_are_refused() {
        for bad in
            ["../x.ttt", "/etc/x.ttt", "a\\b.ttt", ".x.ttt", "x.lua", "x", "", "a:b.ttt", "x.ttt\0", &"y".repeat(200)]
        {
            assert!(DroppedFile::new(bad).is_err(), "{bad}");
        }
        assert!(DroppedFile::new("My scene (2).ttt").is_ok() && DroppedFile::new("robot.URDF").is_ok());
    }

    #[test]
    fn files_of_a_scene_stay_below_its_folder() {
        let mut folder = DropFolder { name: "dropped/room".to_owned(), files: 0, bytes: 0 };
        for bad in ["../a.toml", "a/../b.toml", "/a.toml", "a//b.lua", "a/.b.lua", "a\\b.lua", "b.so", "a/b", "b.lua/"]
        {
            assert!(folder.file(bad).is_err(), "{bad}");
        }
        assert!(folder.file(&format!("{}x.lua", "a/".repeat(MAX_PATH_COMPONENTS))).is_err());
        let file = folder.file("scripts/drive.lua").unwrap();
        assert_eq!((file.folder.as_str(), file.name.as_str()), ("dropped/room", "scripts/drive.lua"));
        assert!((1..MAX_FILES).all(|_| folder.file("x.png").is_ok()) && folder.file("x.png").is_err());
        let large = DroppedFile {
            name: String::new(),
            folder: "dropped/room".to_owned(),
            bytes: vec![0; MAX_FOLDER_BYTES / 2],
        };
        assert!(folder.add_size(&large).is_ok() && folder.add_size(&large).is_ok() && folder.add_size(&file).is_ok());
        let one = DroppedFile { bytes: vec![0], ..file };
        assert!(folder.add_size(&one).is_err());
    }

    #[test]
    fn dropped_file_size_is_limited() {
        let mut file = DroppedFile::new("x.ttt").unwrap();
        let part = STANDARD.encode(vec![0; 3 << 20]);
        assert!((0..21).all(|_| file.append(&part).is_ok()) && file.append(&part).is_err());
        assert!(file.append("no base64!").is_err());
    }
}
