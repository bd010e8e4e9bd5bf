//! Stores the files that clients transfer in a separate folder. Their names must not contain folders.
//!
//! An input log contains the name of a loaded file, not its content. Therefore, a file that was loaded is kept in the
//! folder, with all files that were in the folder then; erasing such a file only makes its name unavailable to clients.
//! Files of other runs are never replaced.

use std::{collections::BTreeMap, fs, io, path::PathBuf};

use tatu_plugin_api::{
    abi::{TATU_FILE_NEW, TATU_FILE_WRITE},
    safe::{Fail, Result, Turn},
};

/// Name of the folder, within the folder in which scripts may open files.
const FOLDER: &str = "transferred";
/// Maximum size of a file, bytes.
const MAX_FILE_BYTES: usize = 64 << 20;
/// Maximum total size of the files in the folder, bytes.
const MAX_FOLDER_BYTES: u64 = 256 << 20;
/// Maximum number of files in the folder.
const MAX_FILES: usize = 1000;
/// Maximum length of a name, bytes.
const MAX_NAME_BYTES: usize = 100;
/// Maximum number of files with names that differ only in the appended number.
const MAX_NUMBERED_NAMES: usize = 1000;
/// Extensions of native libraries, which are rejected: a scene may request plugins from its own folder, and that folder
/// may be trusted.
const LIBRARY_EXTENSIONS: &[&str] = &[".so", ".dylib", ".dll"];
/// Prefix of the names that the client library assigns to files that are transferred only to be loaded. A random number
/// follows it.
const TEMPORARY_PREFIX: &str = "REMOTE_API_TEMPFILE_";

/// The files that clients have transferred since the service was started.
#[derive(Default)]
pub struct TransferredFiles {
    /// The stored files, by the name that the client uses.
    names: BTreeMap<String, StoredFile>,
}

/// A file in the folder.
struct StoredFile {
    /// Name of the file in the folder.
    name: String,
    /// Whether the file must be kept because an input log may need it: the file was loaded, was in the folder when
    /// another one was loaded, or existed before.
    retained: bool,
}

/// The folder and a list of its files.
struct TransferFolder {
    path: PathBuf,
    /// Sizes of the files, bytes, by name. They are sorted, because the order of files in a folder depends on the
    /// machine.
    files: BTreeMap<String, u64>,
}

impl TransferredFiles {
    /// Stores a file under a name. The file that was transferred under this name before is removed, unless an input log
    /// may need it.
    pub fn transfer(&mut self, turn: &Turn<'_>, name: &[u8], bytes: &[u8]) -> Result {
        let name = checked_name(name)?;
        if bytes.len() > MAX_FILE_BYTES {
            let size = bytes.len();
            return Err(Fail::argument(format!(
                "`{name}` has {size} bytes: transferred files must have at most {MAX_FILE_BYTES}"
            )));
        }
        if LIBRARY_EXTENSIONS.contains(&split_extension(name).1.to_lowercase().as_str()) {
            return Err(Fail::unsupported(format!("`{name}` is a native library, which cannot be transferred"))
                .help("install plugins on the machine on which the simulator runs"));
        }
        let mut folder = TransferFolder::open(turn)?;
        let known = self.names.len() - usize::from(self.names.contains_key(name));
        let old = self.names.get(name).filter(|s| !s.retained).map(|s| s.name.clone());
        if let Some(there) = folder.find_duplicate(name, bytes, old.as_deref())? {
            check_quota(known, 0, 0)?;
            self.forget(&folder, name)?;
            self.names.values_mut().filter(|s| s.name == there).for_each(|s| s.retained = true);
            self.names.insert(name.to_owned(), StoredFile { name: there, retained: true });
            return Ok(());
        }
        if let Some(old) = &old {
            folder.files.remove(old);
        }
        check_quota(known.max(folder.files.len()), folder.files.values().sum(), bytes.len() as u64)?;
        self.forget(&folder, name)?;
        let stored = folder.write(turn, &with_extension(name, bytes), bytes)?;
        self.names.insert(name.to_owned(), StoredFile { name: stored, retained: false });
        Ok(())
    }

    /// Returns the path by which commands open a file: that of the file transferred under this name, or the name itself
    /// if there is none.
    pub fn path(&self, name: &[u8]) -> Vec<u8> {
        match std::str::from_utf8(name).ok().and_then(|n| self.names.get(n)) {
            Some(stored) => format!("{FOLDER}/{}", stored.name).into_bytes(),
            None => name.to_vec(),
        }
    }

    /// Records that a file is being loaded. If it was transferred, all transferred files must be kept, because the
    /// loaded file may refer to them.
    pub fn mark_loaded(&mut self, name: &[u8]) {
        if std::str::from_utf8(name).is_ok_and(|n| self.names.contains_key(n)) {
            self.names.values_mut().for_each(|s| s.retained = true);
        }
    }

    /// Erases a file that was transferred since the service was started.
    pub fn erase(&mut self, turn: &Turn<'_>, name: &[u8]) -> Result {
        let name = checked_name(name)?;
        if !self.names.contains_key(name) {
            return Err(Fail::missing(format!(
                "no file `{name}` was transferred since the service was started, or it has already been erased"
            ))
            .help("only transferred files can be erased by a client; remove other files by hand"));
        }
        self.forget(&TransferFolder::open(turn)?, name)
    }

    /// Removes a name, and its file unless an input log may need it.
    fn forget(&mut self, folder: &TransferFolder, name: &str) -> Result {
        if let Some(stored) = self.names.get(name).filter(|s| !s.retained) {
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

impl TransferFolder {
    /// Creates the folder if necessary, and lists its files.
    fn open(turn: &Turn<'_>) -> Result<TransferFolder> {
        let path = turn.file(FOLDER.as_bytes(), TATU_FILE_WRITE)?;
        let path = PathBuf::from(String::from_utf8_lossy(&path).into_owned());
        let fail = |e: io::Error| {
            Fail::new(format!("the folder `{FOLDER}` for transferred files cannot be created or read: {e}"))
        };
        fs::create_dir_all(&path).map_err(fail)?;
        TransferFolder::read(path).map_err(fail)
    }

    /// Lists the files in a folder.
    fn read(path: PathBuf) -> io::Result<TransferFolder> {
        let mut files = BTreeMap::new();
        for entry in fs::read_dir(&path)? {
            let entry = entry?;
            files.insert(entry.file_name().to_string_lossy().into_owned(), entry.metadata()?.len());
        }
        Ok(TransferFolder { path, files })
    }

    /// Returns the name of an existing file with the same content and a similar name, other than `except`. It is used
    /// instead of a copy, so that a file that is loaded repeatedly under random names is stored only once.
    fn find_duplicate(&self, name: &str, bytes: &[u8], except: Option<&str>) -> Result<Option<String>> {
        let name = with_extension(name, bytes);
        let (stem, ending) = split_extension(&name);
        let numbered = |rest: &str| {
            rest.is_empty() || rest.strip_prefix('-').is_some_and(|n| n.chars().all(|c| c.is_ascii_digit()))
        };
        let alike = |other: &str| {
            let (of_other, ending_of_other) = split_extension(other);
            let passing = stem.starts_with(TEMPORARY_PREFIX) && of_other.starts_with(TEMPORARY_PREFIX);
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

    /// Writes a new file, with a number appended to its name if the name is in use. Returns its name.
    fn write(&self, turn: &Turn<'_>, name: &str, bytes: &[u8]) -> Result<String> {
        let (stem, ending) = split_extension(name);
        for n in 1..=MAX_NUMBERED_NAMES {
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
        Err(Fail::new(format!("there are already {MAX_NUMBERED_NAMES} files named `{name}` in the folder `{FOLDER}`"))
            .help("remove files that no input log needs"))
    }
}

/// Checks that one more file may be added: the folder contains `files` files of `all` bytes in total, and the new one
/// has `more` bytes.
fn check_quota(files: usize, all: u64, more: u64) -> Result {
    let help =
        "erase files that are not needed; files of earlier runs and files that were loaded must be removed by hand";
    if files >= MAX_FILES {
        return Err(Fail::new(format!("there are already {files} transferred files: at most {MAX_FILES} are allowed"))
            .help(help));
    }
    if all.saturating_add(more) > MAX_FOLDER_BYTES {
        let text = format!(
            "the files in the folder `{FOLDER}` have {all} bytes in total: {more} more would exceed the limit of {MAX_FOLDER_BYTES}"
        );
        return Err(Fail::new(text).help(help));
    }
    Ok(())
}

/// Returns the name as a string. Fails if it is not a valid file name or contains folders.
fn checked_name(name: &[u8]) -> Result<&str> {
    let plain = |c: char| !c.is_control() && !"/\\:".contains(c);
    match std::str::from_utf8(name) {
        Ok(n) if !n.is_empty() && n.len() <= MAX_NAME_BYTES && !n.starts_with('.') && n.chars().all(plain) => Ok(n),
        _ => {
            let name = String::from_utf8_lossy(name).escape_debug().take(2 * MAX_NAME_BYTES).collect::<String>();
            Err(Fail::argument(format!(
                "`{name}` is not a valid name for a transferred file: expected 1 to {MAX_NAME_BYTES} bytes, without folders \
                 (no / \\ :), a leading dot or control characters"
            )))
        }
    }
}

/// Splits a name into its stem and its extension, which includes the dot.
fn split_extension(name: &str) -> (&str, &str) {
    name.rfind('.').map_or((name, ""), |at| name.split_at(at))
}

/// Returns the name with the extension that the content of the file requires, because the client library assigns the
/// extension `.ttm` to every model and `.ttt` to every scene.
fn with_extension(name: &str, bytes: &[u8]) -> String {
    let (stem, ending) = split_extension(name);
    if !stem.starts_with(TEMPORARY_PREFIX) || !matches!(ending, ".ttm" | ".ttt") || bytes.starts_with(b"VREP") {
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
    fn names_with_folders_are_refused() {
        let long = "y".repeat(101);
        for bad in ["", ".", "..", "../x.ttm", "/etc/x", "a/b", "a\\b", "c:x", ".x.ttm", "x\n", "x\u{7f}", &long] {
            assert!(checked_name(bad.as_bytes()).is_err(), "{bad:?}");
        }
        assert!(checked_name(b"\xff.ttm").is_err());
        for good in ["REMOTE_API_TEMPFILE_7722.ttm", "My model (2).ttt", "ação.lua", "x", "a..b"] {
            assert!(checked_name(good.as_bytes()).is_ok(), "{good}");
        }
    }

    #[test]
    fn model_extension_follows_its_content() {
        let name = "REMOTE_API_TEMPFILE_1.ttm";
        assert_eq!(with_extension(name, b"VREP\x01"), name);
        assert_eq!(with_extension(name, b"format = 1\n"), "REMOTE_API_TEMPFILE_1.toml");
        assert_eq!(with_extension(name, b"<?xml version=\"1.0\"?><robot/>"), "REMOTE_API_TEMPFILE_1.urdf");
        assert_eq!(with_extension("mine.ttm", b"format = 1\n"), "mine.ttm");
        assert_eq!(with_extension("REMOTE_API_TEMPFILE_1.ttb", b"x"), "REMOTE_API_TEMPFILE_1.ttb");
    }

    #[test]
    fn folder_size_and_file_count_are_limited() {
        assert!(check_quota(MAX_FILES - 1, 0, MAX_FOLDER_BYTES).is_ok());
        assert!(
            check_quota(MAX_FILES, 0, 0).is_err()
                && check_quota(0, MAX_FOLDER_BYTES, 1).is_err()
                && check_quota(0, 1, u64::MAX).is_err()
        );
    }
}
