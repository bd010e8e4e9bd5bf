//! Files that clients transfer, which are stored in a separate folder under names without folders.
//!
//! An input log contains the name of a loaded file, not its content. So a file that was loaded stays in the folder, and
//! so do those stored next to it; erasing such a file only removes its name. Files of other runs are never replaced.

use std::{collections::BTreeMap, fs, io, path::PathBuf};

use tatu_plugin_api::{
    abi::{TATU_FILE_NEW, TATU_FILE_WRITE},
    safe::{Fail, Result, Turn},
};

/// Name of the folder, within the one in which scripts open files.
const FOLDER: &str = "transferred";
/// Limits on the size of a file, on the size of all files in the folder, and on their number.
const MOST: usize = 64 << 20;
const MOST_IN_ALL: u64 = 256 << 20;
const MOST_FILES: usize = 1000;
/// Limits on the length of a name, and on the number of files whose names differ only by a number.
const LONGEST: usize = 100;
const MOST_ALIKE: usize = 1000;
/// Extensions of native libraries, which are refused: a scene may request plugins in its own folder, and that folder
/// may be trusted.
const LIBRARIES: &[&str] = &[".so", ".dylib", ".dll"];
/// Prefix, followed by a random number, of the names that the client library gives to files transferred only to be
/// loaded.
const PASSING: &str = "REMOTE_API_TEMPFILE_";

/// The files that clients transferred since the service was started.
#[derive(Default)]
pub struct Files {
    names: BTreeMap<String, Stored>,
}

/// A file as stored in the folder.
struct Stored {
    name: String,
    /// Whether it must be kept because an input log may need it: it was loaded, stored next to a loaded file, or
    /// existed before.
    stays: bool,
}

/// The folder and its content.
struct Folder {
    path: PathBuf,
    /// Names and sizes, sorted by name, since the order in a folder differs between machines.
    files: BTreeMap<String, u64>,
}

impl Files {
    /// Stores a file. An earlier file of the same name is replaced.
    pub fn transfer(&mut self, turn: &Turn<'_>, name: &[u8], bytes: &[u8]) -> Result {
        let name = checked(name)?;
        if bytes.len() > MOST {
            let size = bytes.len();
            return Err(Fail::argument(format!("`{name}` has {size} bytes; transferred files are limited to {MOST}")));
        }
        if LIBRARIES.contains(&parts(name).1.to_lowercase().as_str()) {
            return Err(Fail::unsupported(format!("`{name}` is a native library, which cannot be transferred"))
                .help("plugins are installed on the simulator's side only"));
        }
        let mut folder = Folder::open(turn)?;
        let known = self.names.len() - usize::from(self.names.contains_key(name));
        let old = self.names.get(name).filter(|s| !s.stays).map(|s| s.name.clone());
        if let Some(there) = folder.same(name, bytes, old.as_deref())? {
            room(known, 0, 0)?;
            self.forget(&folder, name)?;
            self.names.values_mut().filter(|s| s.name == there).for_each(|s| s.stays = true);
            self.names.insert(name.to_owned(), Stored { name: there, stays: true });
            return Ok(());
        }
        if let Some(old) = &old {
            folder.files.remove(old);
        }
        room(known.max(folder.files.len()), folder.files.values().sum(), bytes.len() as u64)?;
        self.forget(&folder, name)?;
        let stored = folder.write(turn, &with_ending(name, bytes), bytes)?;
        self.names.insert(name.to_owned(), Stored { name: stored, stays: false });
        Ok(())
    }

    /// Returns the path by which commands find a file: that of the stored file, or the name itself if there is none.
    pub fn path(&self, name: &[u8]) -> Vec<u8> {
        match std::str::from_utf8(name).ok().and_then(|n| self.names.get(n)) {
            Some(stored) => format!("{FOLDER}/{}", stored.name).into_bytes(),
            None => name.to_vec(),
        }
    }

    /// Notes that a file is being loaded. If it was transferred, all files next to it must be kept, since they may be
    /// read too.
    pub fn load(&mut self, name: &[u8]) {
        if std::str::from_utf8(name).is_ok_and(|n| self.names.contains_key(n)) {
            self.names.values_mut().for_each(|s| s.stays = true);
        }
    }

    /// Erases a transferred file.
    pub fn erase(&mut self, turn: &Turn<'_>, name: &[u8]) -> Result {
        let name = checked(name)?;
        if !self.names.contains_key(name) {
            return Err(Fail::missing(format!(
                "no file `{name}` was transferred since the service was started, or it has already been erased"
            ))
            .help("only transferred files are erased; remove others by hand"));
        }
        self.forget(&Folder::open(turn)?, name)
    }

    /// Removes a name, and also its file unless a log may need it.
    fn forget(&mut self, folder: &Folder, name: &str) -> Result {
        if let Some(stored) = self.names.get(name).filter(|s| !s.stays) {
            match fs::remove_file(folder.path.join(&stored.name)) {
                Err(e) if e.kind() != io::ErrorKind::NotFound => {
                    return Err(Fail::new(format!("`{FOLDER}/{}` cannot be removed: {e}", stored.name)));
                }
                _ => {}
            }
        }
        self.names.remove(name);
        Ok(())
    }
}

impl Folder {
    fn open(turn: &Turn<'_>) -> Result<Folder> {
        let path = turn.file(FOLDER.as_bytes(), TATU_FILE_WRITE)?;
        let path = PathBuf::from(String::from_utf8_lossy(&path).into_owned());
        let fail = |e: io::Error| {
            Fail::new(format!("the folder `{FOLDER}` for transferred files cannot be created or read: {e}"))
        };
        fs::create_dir_all(&path).map_err(fail)?;
        Folder::read(path).map_err(fail)
    }

    fn read(path: PathBuf) -> io::Result<Folder> {
        let mut files = BTreeMap::new();
        for entry in fs::read_dir(&path)? {
            let entry = entry?;
            files.insert(entry.file_name().to_string_lossy().into_owned(), entry.metadata()?.len());
        }
        Ok(Folder { path, files })
    }

    /// Returns an existing file with the same content, so that a file that is loaded repeatedly under random names is
    /// stored only once.
    fn same(&self, name: &str, bytes: &[u8], except: Option<&str>) -> Result<Option<String>> {
        let name = with_ending(name, bytes);
        let (stem, ending) = parts(&name);
        let numbered = |rest: &str| {
            rest.is_empty() || rest.strip_prefix('-').is_some_and(|n| n.chars().all(|c| c.is_ascii_digit()))
        };
        let alike = |other: &str| {
            let (of_other, ending_of_other) = parts(other);
            let passing = stem.starts_with(PASSING) && of_other.starts_with(PASSING);
            ending == ending_of_other && (passing || of_other.strip_prefix(stem).is_some_and(numbered))
        };
        for (other, size) in &self.files {
            if *size == bytes.len() as u64 && alike(other) && except != Some(other.as_str()) {
                let path = self.path.join(other);
                // Links and other entries that are not regular files are skipped.
                let plain = path.symlink_metadata().is_ok_and(|m| m.is_file());
                if plain && fs::read(&path).is_ok_and(|b| b == bytes) {
                    return Ok(Some(other.clone()));
                }
            }
        }
        Ok(None)
    }

    /// Writes a new file; returns its name.
    fn write(&self, turn: &Turn<'_>, name: &str, bytes: &[u8]) -> Result<String> {
        let (stem, ending) = parts(name);
        for n in 1..=MOST_ALIKE {
            let name = if n == 1 { name.to_owned() } else { format!("{stem}-{n}{ending}") };
            if self.files.contains_key(&name) {
                continue;
            }
            let mut file = turn.open_file(format!("{FOLDER}/{name}").as_bytes(), TATU_FILE_WRITE | TATU_FILE_NEW)?;
            return match io::Write::write_all(&mut file, bytes) {
                Ok(()) => Ok(name),
                Err(e) => {
                    let _ = fs::remove_file(self.path.join(&name));
                    Err(Fail::new(format!("`{FOLDER}/{name}` cannot be written: {e}")))
                }
            };
        }
        Err(Fail::new(format!("the folder `{FOLDER}` already has {MOST_ALIKE} files named `{name}`"))
            .help("remove those that no input log needs"))
    }
}

/// Checks that there is room for one more file.
fn room(files: usize, all: u64, more: u64) -> Result {
    let help =
        "erase files that are not needed; files of earlier runs and files that were loaded must be removed by hand";
    if files >= MOST_FILES {
        return Err(Fail::new(format!("there are {files} transferred files: {MOST_FILES} is the limit")).help(help));
    }
    if all.saturating_add(more) > MOST_IN_ALL {
        let text =
            format!("the folder `{FOLDER}` has {all} bytes; {more} more would exceed the limit of {MOST_IN_ALL}");
        return Err(Fail::new(text).help(help));
    }
    Ok(())
}

/// Returns a name if it is valid and contains no folder.
fn checked(name: &[u8]) -> Result<&str> {
    let plain = |c: char| !c.is_control() && !"/\\:".contains(c);
    match std::str::from_utf8(name) {
        Ok(n) if !n.is_empty() && n.len() <= LONGEST && !n.starts_with('.') && n.chars().all(plain) => Ok(n),
        _ => {
            let name = String::from_utf8_lossy(name).escape_debug().take(2 * LONGEST).collect::<String>();
            Err(Fail::argument(format!(
                "`{name}` is not a valid name for a transferred file: expected 1 to {LONGEST} bytes, without folders \
                 (no / \\ :), a leading dot or control characters"
            )))
        }
    }
}

/// Splits a name into stem and extension, the latter with its dot.
fn parts(name: &str) -> (&str, &str) {
    name.rfind('.').map_or((name, ""), |at| name.split_at(at))
}

/// Returns the name with the extension that its content requires: the client library gives every model the extension
/// `.ttm` and every scene `.ttt`.
fn with_ending(name: &str, bytes: &[u8]) -> String {
    let (stem, ending) = parts(name);
    if !stem.starts_with(PASSING) || !matches!(ending, ".ttm" | ".ttt") || bytes.starts_with(b"VREP") {
        return name.to_owned();
    }
    match std::str::from_utf8(bytes) {
        Ok(text) if text.trim_start_matches('\u{feff}').trim_start().starts_with('<') => format!("{stem}.urdf"),
        Ok(_) => format!("{stem}.toml"),
        Err(_) => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_nowhere_else() {
        let long = "y".repeat(101);
        for bad in ["", ".", "..", "../x.ttm", "/etc/x", "a/b", "a\\b", "c:x", ".x.ttm", "x\n", "x\u{7f}", &long] {
            assert!(checked(bad.as_bytes()).is_err(), "{bad:?}");
        }
        assert!(checked(b"\xff.ttm").is_err());
        for good in ["REMOTE_API_TEMPFILE_7722.ttm", "My model (2).ttt", "ação.lua", "x", "a..b"] {
            assert!(checked(good.as_bytes()).is_ok(), "{good}");
        }
    }

    #[test]
    fn a_model_ends_as_what_is_inside_asks_for() {
        let name = "REMOTE_API_TEMPFILE_1.ttm";
        assert_eq!(with_ending(name, b"VREP\x01"), name);
        assert_eq!(with_ending(name, b"format = 1\n"), "REMOTE_API_TEMPFILE_1.toml");
        assert_eq!(with_ending(name, b"<?xml version=\"1.0\"?><robot/>"), "REMOTE_API_TEMPFILE_1.urdf");
        assert_eq!(with_ending("mine.ttm", b"format = 1\n"), "mine.ttm");
        assert_eq!(with_ending("REMOTE_API_TEMPFILE_1.ttb", b"x"), "REMOTE_API_TEMPFILE_1.ttb");
    }

    #[test]
    fn a_folder_has_room_for_so_much() {
        assert!(room(MOST_FILES - 1, 0, MOST_IN_ALL).is_ok());
        assert!(room(MOST_FILES, 0, 0).is_err() && room(0, MOST_IN_ALL, 1).is_err() && room(0, 1, u64::MAX).is_err());
    }
}
