//! Packed scenes: zip archives that contain a scene file and all files that it names.

use std::{
    collections::BTreeSet,
    fmt::Write as _,
    fs,
    io::{Cursor, Read, Write as _},
    path::{Component, Path, PathBuf},
};

use sha2::{Digest, Sha256};
use tatu_core::{errors::Error, state::write_atomically};
use tatu_plugin_api::safe::{MAX_FILE_BYTES, cache_folder, read_plain};
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter, result::ZipError, write::SimpleFileOptions};

/// The suffix of packed scenes.
pub const PACK_SUFFIX: &str = "tatu";
/// The scene file of a packed scene.
pub const PACKED_SCENE: &str = "scene.toml";

/// Maximum number of files in a packed scene.
const MAX_ENTRIES: usize = 20_000;
/// Maximum size of all unpacked files, in bytes.
const MAX_UNPACKED_BYTES: u64 = 1 << 30;
/// How much larger than the archive its files may be, beyond `FREE_BYTES`. Text rarely shrinks to less than a twentieth.
const MAX_RATIO: u64 = 200;
const FREE_BYTES: u64 = 16 << 20;

/// Returns whether a path has the suffix of packed scenes.
pub fn is_pack(path: &Path) -> bool {
    path.extension().is_some_and(|suffix| suffix.eq_ignore_ascii_case(PACK_SUFFIX))
}

/// Writes a packed scene. `files` are names with `/` as the separator, and contents. The same files give the same bytes.
///
/// # Errors
/// The file cannot be written, or could not be opened: it is too large, or two names differ only in case.
pub fn write(file: &Path, files: &[(String, Vec<u8>)]) -> Result<(), Error> {
    let packed = || -> Result<Vec<u8>, ZipError> {
        // Without the time at which it was packed, and without the permissions of files.
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .last_modified_time(DateTime::default());
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, bytes) in files {
            archive.start_file(name.as_str(), options)?;
            archive.write_all(bytes)?;
        }
        Ok(archive.finish()?.into_inner())
    };
    let bytes = packed().map_err(|e| cannot("write", file, &e))?;
    // What is written can also be opened.
    let limit = if bytes.len() as u64 > MAX_FILE_BYTES { Err("it is too large".to_owned()) } else { Ok(()) };
    limit.and_then(|()| entries(&bytes)).map_err(|why| cannot("write", file, &why))?;
    write_atomically(file, &bytes).map_err(|e| cannot("write", file, &e))
}

/// Unpacks a packed scene into a folder, which is created, and returns its scene file. Files in the folder that are equal
/// to those in the archive are left as they are; others with the same names are replaced.
///
/// # Errors
/// The archive cannot be read, is too large, or contains something that does not belong in it, in which case nothing is
/// written; or a file cannot be written.
pub fn unpack(file: &Path, into: &Path) -> Result<PathBuf, Error> {
    unpack_bytes(file, &read(file)?, into)
}

/// Returns the scene file of a packed scene, which is unpacked into a folder of the user's cache, once for each content.
///
/// # Errors
/// Like those of [`unpack`]; or the environment does not define a cache folder.
pub fn open(file: &Path) -> Result<PathBuf, Error> {
    let bytes = read(file)?;
    let cache = cache_folder().ok_or_else(|| {
        cannot("unpack", file, &"there is no folder for it")
            .help("set HOME, or XDG_CACHE_HOME to an absolute folder; or unpack it yourself: `tatu unpack`")
    })?;
    let digest = Sha256::digest(&bytes);
    let mut name = file.file_stem().unwrap_or_default().to_os_string();
    name.push(digest[..8].iter().fold("-".to_owned(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    }));
    unpack_bytes(file, &bytes, &cache.join("packs").join(name))
}

fn read(file: &Path) -> Result<Vec<u8>, Error> {
    read_plain(file, MAX_FILE_BYTES).map_err(|e| cannot("read", file, &e))
}

fn unpack_bytes(file: &Path, bytes: &[u8], into: &Path) -> Result<PathBuf, Error> {
    let files = entries(bytes).map_err(|why| {
        cannot("unpack", file, &why)
            .expected("a file that `tatu pack` has written")
            .help("it may be truncated or damaged: copy it again")
    })?;
    for (name, bytes) in &files {
        let path = into.join(name);
        let written = match read_plain(&path, MAX_UNPACKED_BYTES) {
            Ok(old) if old == *bytes => Ok(()),
            _ => path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| write_atomically(&path, bytes)),
        };
        written.map_err(|e| cannot("write", &path, &e))?;
    }
    Ok(into.join(PACKED_SCENE))
}

/// Returns all files of an archive, or why it is refused.
fn entries(bytes: &[u8]) -> Result<Vec<(PathBuf, Vec<u8>)>, String> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|e| e.to_string())?;
    if archive.len() > MAX_ENTRIES {
        return Err(format!("it contains more than {MAX_ENTRIES} files"));
    }
    let mut left = MAX_UNPACKED_BYTES.min(FREE_BYTES + MAX_RATIO * bytes.len() as u64);
    let (mut files, mut names) = (Vec::new(), BTreeSet::new());
    for i in 0..archive.len() {
        let mut entry = archive.by_index(i).map_err(|e| e.to_string())?;
        let shown = String::from_utf8_lossy(entry.name_raw()).escape_debug().to_string();
        if entry.is_dir() {
            continue;
        }
        if !entry.is_file() {
            return Err(format!("it contains `{shown}`, which is not a regular file"));
        }
        let name = plain_name(entry.name_raw())
            .ok_or_else(|| format!("it contains `{shown}`, a path that leads out of its folder"))?;
        // Names that differ only in case are the same file on some systems.
        if !names.insert(name.to_string_lossy().to_lowercase()) {
            return Err(format!("it contains `{shown}` twice"));
        }
        let mut contents = Vec::new();
        let read = entry.by_ref().take(left + 1).read_to_end(&mut contents).map_err(|e| format!("`{shown}`: {e}"))?;
        left = left.checked_sub(read as u64).ok_or("its files are too large")?;
        files.push((name, contents));
    }
    match names.contains(PACKED_SCENE) {
        true => Ok(files),
        false => Err(format!("it contains no `{PACKED_SCENE}`")),
    }
}

/// Returns the name of an entry as a relative path of plain names.
fn plain_name(name: &[u8]) -> Option<PathBuf> {
    let name = std::str::from_utf8(name).ok().filter(|name| !name.contains(['\\', ':', '\0']))?;
    let path = Path::new(name);
    let is_plain = |c| matches!(c, Component::Normal(_));
    (path.components().next().is_some() && path.components().all(is_plain)).then(|| path.to_owned())
}

fn cannot(what: &str, file: &Path, why: &dyn std::fmt::Display) -> Error {
    Error::new("E105", format!("cannot {what} {}: {why}", file.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, bytes) in files {
            archive.start_file(*name, SimpleFileOptions::default()).unwrap();
            archive.write_all(bytes).unwrap();
        }
        archive.finish().unwrap().into_inner()
    }

    #[test]
    fn archives_that_could_do_harm_are_refused() {
        assert_eq!(entries(&archive(&[("scene.toml", b"a"), ("files/b.lua", b"c")])).unwrap().len(), 2);
        let zeros = vec![0; 64 << 20];
        for (files, why) in [
            (vec![("files/b.lua", b"c".as_slice())], "contains no `scene.toml`"),
            (vec![("scene.toml", b"a".as_slice()), ("../b", b"")], "leads out"),
            (vec![("scene.toml", b"a".as_slice()), ("/b", b"")], "leads out"),
            (vec![("scene.toml", b"a".as_slice()), ("a\\..\\..\\b", b"")], "leads out"),
            (vec![("scene.toml", b"a".as_slice()), ("Scene.toml", b"")], "twice"),
            (vec![("scene.toml", b"a".as_slice()), ("zeros", zeros.as_slice())], "too large"),
        ] {
            let refused = entries(&archive(&files)).unwrap_err();
            assert!(refused.contains(why), "{refused}");
        }
        let whole = archive(&[("scene.toml", b"a")]);
        assert!(entries(&whole[..whole.len() / 2]).is_err() && entries(b"").is_err());
    }

    #[test]
    fn packs_that_could_not_be_opened_are_not_written() {
        let folder = std::env::temp_dir().join(format!("tatu-pack-{}", std::process::id()));
        let file = folder.with_extension(PACK_SUFFIX);
        let scene = || (PACKED_SCENE.to_owned(), b"format = 1".to_vec());
        for (other, why) in [("Scene.toml", "twice"), ("zeros", "too large")] {
            let refused = write(&file, &[scene(), (other.to_owned(), vec![0; 64 << 20])]).unwrap_err();
            assert!(refused.text.contains(why) && !file.exists(), "{refused}");
        }
        write(&file, &[scene()]).unwrap();
        assert_eq!(std::fs::read(unpack(&file, &folder).unwrap()).unwrap(), scene().1);
        std::fs::remove_file(&file).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn links_are_refused() {
        let mut links = ZipWriter::new(Cursor::new(archive(&[])));
        links.start_file("scene.toml", SimpleFileOptions::default()).unwrap();
        links.add_symlink("files", "/etc", SimpleFileOptions::default()).unwrap();
        let refused = entries(&links.finish().unwrap().into_inner()).unwrap_err();
        assert!(refused.contains("not a regular file"), "{refused}");
    }
}
