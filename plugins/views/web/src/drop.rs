//! Files that are dropped on the page. They arrive in parts, are stored in a separate folder, and never replace a file.

use std::path::Path;

use base64::{Engine, engine::general_purpose::STANDARD};
use tatu_plugin_api::{
    abi::{TATU_FILE_FOLDERS, TATU_FILE_NEW, TATU_FILE_READ, TATU_FILE_WRITE},
    safe::{Fail, Result, Turn},
};

/// Name of the folder, within the one in which scripts open files.
const FOLDER: &str = "dropped";
/// Allowed extensions of a file on its own, and of those that come with a scene.
const ENDINGS: &[&str] = &["toml", "ttt", "ttm", "urdf"];
const ENDINGS_WITH_SCENE: &[&str] = &[
    "toml", "ttt", "ttm", "urdf", "xacro", "lua", "obj", "mtl", "stl", "ply", "dae", "png", "jpg", "jpeg", "svg",
    "csv", "json", "txt", "md",
];
/// Limits on the size of a file, the length of its name, and the number of files with the same name.
const MOST: usize = 64 << 20;
const LONGEST: usize = 100;
const MOST_ALIKE: usize = 1000;
/// Limits on the number of files in a folder, their total size in bytes, and their depth.
const MOST_FILES: usize = 1000;
const MOST_TOGETHER: usize = 256 << 20;
const DEEPEST: usize = 8;

/// Checks a name without folders.
fn check(name: &str) -> Result {
    let plain = |c: char| c.is_alphanumeric() || " ._-()+".contains(c);
    if name.is_empty() || name.len() > LONGEST || name.starts_with('.') || !name.chars().all(plain) {
        return Err(Fail::argument(format!(
            "`{name}` is not a valid file name: it may have letters, digits, spaces and . _ - ( ) +, and at most {LONGEST} bytes"
        )));
    }
    Ok(())
}

/// Checks the extension of a name.
fn check_ending(name: &str, endings: &[&str]) -> Result {
    let ending = Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
    if endings.contains(&ending.as_str()) {
        return Ok(());
    }
    let expected = endings.join(", ");
    Err(Fail::argument(format!("`{name}` is not accepted: expected a name that ends with {expected}")))
}

/// A new folder for a scene and its files.
pub struct Folder {
    name: String,
    files: usize,
    bytes: usize,
}

impl Folder {
    /// Finds a free name for the folder, based on `name`, which must not contain folders.
    pub fn new(turn: &Turn<'_>, name: &str) -> Result<Folder> {
        check(name)?;
        for n in 1..=MOST_ALIKE {
            let name = if n == 1 { format!("{FOLDER}/{name}") } else { format!("{FOLDER}/{name}-{n}") };
            let is_there = |path: Vec<u8>| Path::new(&*String::from_utf8_lossy(&path)).symlink_metadata().is_ok();
            if !turn.file(name.as_bytes(), TATU_FILE_READ).is_ok_and(is_there) {
                return Ok(Folder { name, files: 0, bytes: 0 });
            }
        }
        Err(Fail::new(format!("there are already {MOST_ALIKE} folders named `{name}`")).help("remove some of them"))
    }

    /// Returns the name of the folder for commands.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Starts a file in the folder; its name may contain folders.
    pub fn file(&mut self, name: &str) -> Result<Dropped> {
        let parts: Vec<&str> = name.split('/').collect();
        if parts.len() > DEEPEST {
            return Err(Fail::argument(format!("`{name}` is too deep: expected at most {DEEPEST} folders")));
        }
        parts.iter().try_for_each(|part| check(part))?;
        check_ending(name, ENDINGS_WITH_SCENE)?;
        self.files += 1;
        if self.files > MOST_FILES {
            return Err(Fail::argument(format!("`{}` has more than {MOST_FILES} files", self.name)));
        }
        Ok(Dropped { name: name.to_owned(), folder: self.name.clone(), bytes: Vec::new() })
    }

    /// Adds a received file to the totals. Fails if they exceed the limits.
    pub fn count(&mut self, file: &Dropped) -> Result {
        if file.folder == self.name {
            self.bytes += file.bytes.len();
        }
        if self.bytes > MOST_TOGETHER {
            return Err(Fail::argument(format!("the files of `{}` have more than {MOST_TOGETHER} bytes", self.name)));
        }
        Ok(())
    }
}

/// A partially received file.
pub struct Dropped {
    name: String,
    folder: String,
    bytes: Vec<u8>,
}

impl Dropped {
    /// Starts a file; its name must not contain folders.
    pub fn new(name: &str) -> Result<Dropped> {
        check(name)?;
        check_ending(name, ENDINGS)?;
        Ok(Dropped { name: name.to_owned(), folder: FOLDER.to_owned(), bytes: Vec::new() })
    }

    /// Adds a part.
    pub fn take(&mut self, part: &str) -> Result {
        let bytes = STANDARD.decode(part).map_err(|_| Fail::argument("expected part of a file in base64"))?;
        if self.bytes.len() + bytes.len() > MOST {
            return Err(Fail::argument(format!("`{}` is larger than {MOST} bytes", self.name)));
        }
        self.bytes.extend(bytes);
        Ok(())
    }

    /// Writes the file; returns its name for commands.
    pub fn write(self, turn: &Turn<'_>) -> Result<String> {
        let (stem, ending) = self.name.rsplit_once('.').unwrap_or((&self.name, ""));
        // Files of a scene refer to each other, so they are not renamed.
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
        Err(Fail::new(format!("there are already {MOST_ALIKE} files named `{}`", self.name)))
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
