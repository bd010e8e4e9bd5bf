//! Files that are dropped on the page. They arrive in parts, are stored in a separate folder, and never replace a file.

use std::path::Path;

use base64::{Engine, engine::general_purpose::STANDARD};
use tatu_plugin_api::{
    abi::{TATU_FILE_FOLDERS, TATU_FILE_NEW, TATU_FILE_READ, TATU_FILE_WRITE},
    safe::{Fail, Result, Turn},
};

/// Name of the folder, within the one in which scripts open files.
const FOLDER: &str = "dropped";
/// Allowed extensions.
const ENDINGS: &[&str] = &["toml", "ttt", "ttm", "urdf"];
/// Limits on the size of a file, the length of its name, and the number of files with the same name.
const MOST: usize = 64 << 20;
const LONGEST: usize = 100;
const MOST_ALIKE: usize = 1000;

/// A partially received file.
pub struct Dropped {
    name: String,
    bytes: Vec<u8>,
}

impl Dropped {
    /// Begins a file; its name must not contain folders.
    pub fn new(name: &str) -> Result<Dropped> {
        let ending = Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
        let plain = |c: char| c.is_alphanumeric() || " ._-()+".contains(c);
        if name.len() > LONGEST || name.starts_with('.') || !name.chars().all(plain) {
            return Err(Fail::argument(format!(
                "`{name}` is not a valid file name: it may have letters, digits, spaces and . _ - ( ) +, and at most {LONGEST} bytes"
            )));
        }
        if !ENDINGS.contains(&ending.as_str()) {
            return Err(Fail::argument(format!(
                "`{name}` is not a scene, model or robot file: expected a name that ends with {}",
                ENDINGS.join(", ")
            )));
        }
        Ok(Dropped { name: name.to_owned(), bytes: Vec::new() })
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
        let path = Path::new(&self.name);
        let part = |p: Option<&std::ffi::OsStr>| p.unwrap_or_default().to_string_lossy().into_owned();
        let (stem, ending) = (part(path.file_stem()), part(path.extension()));
        for n in 1..=MOST_ALIKE {
            let name = if n == 1 { self.name.clone() } else { format!("{stem}-{n}.{ending}") };
            let name = format!("{FOLDER}/{name}");
            if turn.file(name.as_bytes(), TATU_FILE_READ).is_ok() {
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
    fn no_more_is_taken_than_may_come() {
        let mut file = Dropped::new("x.ttt").unwrap();
        let part = STANDARD.encode(vec![0; 3 << 20]);
        assert!((0..21).all(|_| file.take(&part).is_ok()) && file.take(&part).is_err());
        assert!(file.take("no base64!").is_err());
    }
}
