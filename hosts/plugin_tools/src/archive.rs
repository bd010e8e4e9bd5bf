//! Unpacks archives of plugins. Every entry is checked before anything is used: only regular files and folders are
//! allowed, and only plugin libraries are unpacked.

use std::{
    fs::{self, File},
    io::{self, Read},
    path::{Path, PathBuf},
};

use super::{names, reason::RejectReason};

/// Maximum unpacked size of an archive, in bytes.
const MAX_UNPACKED_BYTES: u64 = 256 << 20;
/// Maximum number of entries, that is files and folders, in an archive.
const MAX_ENTRIES: usize = 10_000;

const PACKING_HELP: &str = "pack regular files with relative names: `tar czf hello.tar.gz libtatu_hello.so`";

/// The format of an archive, recognized by its first bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ArchiveFormat {
    Tar,
    Gzip,
    Zip,
}

/// A library that was unpacked from an archive.
pub struct UnpackedLibrary {
    /// The library's name in the archive.
    pub name: String,
    /// The library's path after unpacking.
    pub file: PathBuf,
}

/// Returns the format of a file, if it is an archive.
pub fn format(file: &Path) -> Option<ArchiveFormat> {
    let mut begin = Vec::new();
    File::open(file).ok()?.take(512).read_to_end(&mut begin).ok()?;
    match begin.as_slice() {
        b if b.starts_with(b"\x1f\x8b") => Some(ArchiveFormat::Gzip),
        b if b.starts_with(b"PK\x03\x04") || b.starts_with(b"PK\x05\x06") => Some(ArchiveFormat::Zip),
        b if b.get(257..262) == Some(b"ustar") => Some(ArchiveFormat::Tar),
        _ => None,
    }
}

/// Unpacks the plugin libraries of an archive into the folder `into`.
pub fn unpack(file: &Path, format: ArchiveFormat, into: &Path) -> Result<Vec<UnpackedLibrary>, RejectReason> {
    let packed = File::open(file).map_err(|e| damaged(&e))?;
    let mut target = UnpackTarget { into, left: MAX_UNPACKED_BYTES, entries: 0, out: Vec::new() };
    match format {
        ArchiveFormat::Tar => tar(LimitedReader { from: packed, left: 2 * MAX_UNPACKED_BYTES }, &mut target)?,
        ArchiveFormat::Gzip => {
            let plain = flate2::read::MultiGzDecoder::new(packed);
            tar(LimitedReader { from: plain, left: 2 * MAX_UNPACKED_BYTES }, &mut target)?;
        }
        ArchiveFormat::Zip => zip(packed, &mut target)?,
    }
    Ok(target.out)
}

fn damaged(e: &dyn std::fmt::Display) -> RejectReason {
    RejectReason::new(
        "damaged-archive",
        format!("it cannot be unpacked: {e}"),
        "it may be truncated or damaged: download or copy it again",
    )
}

fn too_large() -> RejectReason {
    let text =
        format!("it unpacks to more than {} MiB, or has more than {MAX_ENTRIES} entries", MAX_UNPACKED_BYTES >> 20);
    RejectReason::new("too-large", text, "pack only the library of the plugin")
}

/// The type of an entry of an archive.
enum EntryKind {
    File,
    Folder,
    /// Any other type, described in words.
    Other(&'static str),
}

/// The target folder, and the remaining limits.
struct UnpackTarget<'a> {
    into: &'a Path,
    left: u64,
    entries: usize,
    out: Vec<UnpackedLibrary>,
}

impl UnpackTarget<'_> {
    /// Processes one entry; returns an error if the whole archive must be refused.
    fn unpack_entry(
        &mut self,
        name: &[u8],
        sort: EntryKind,
        size: u64,
        data: &mut dyn Read,
    ) -> Result<(), RejectReason> {
        let shown = tatu_core::plugins::texts::label(name);
        self.entries += 1;
        self.left = self.left.checked_sub(size).filter(|_| self.entries <= MAX_ENTRIES).ok_or_else(too_large)?;
        if let Some(why) = path_escape(name) {
            let text = format!("it contains `{shown}`, {why}");
            return Err(RejectReason::new("archive-path", text, PACKING_HELP));
        }
        match sort {
            EntryKind::Folder => return Ok(()),
            EntryKind::Other(what) => {
                let text = format!("it contains `{shown}`, which is {what}, not a regular file");
                return Err(RejectReason::new("archive-link", text, PACKING_HELP));
            }
            EntryKind::File => {}
        }
        let last = shown.rsplit(['/', '\\']).next().unwrap_or_default();
        if !names::is_plugin_name(Path::new(last)) {
            return Ok(());
        }
        // Each library gets a separate folder, because two libraries can have the same name.
        let folder = self.into.join(self.out.len().to_string());
        let file = folder.join(last);
        let mut write = || -> io::Result<u64> {
            fs::create_dir_all(&folder)?;
            io::copy(&mut data.take(size.saturating_add(1)), &mut File::create_new(&file)?)
        };
        // The data can be longer than the size that the archive declares.
        if write().map_err(|e| damaged(&e))? > size {
            return Err(damaged(&format!("`{shown}` is longer than the {size} bytes that the archive declares")));
        }
        self.out.push(UnpackedLibrary { name: shown, file });
        Ok(())
    }
}

/// Returns why a name in an archive could refer to a path outside of the target folder.
fn path_escape(name: &[u8]) -> Option<&'static str> {
    let mut parts = name.split(|b| matches!(b, b'/' | b'\\'));
    let drive = matches!(name, [letter, b':', ..] if letter.is_ascii_alphabetic());
    match name {
        [] => Some("a file with an empty name"),
        [b'/' | b'\\', ..] => Some("an absolute path"),
        _ if drive => Some("a path with a drive"),
        _ if name.contains(&0) => Some("a name with a NUL byte"),
        _ if parts.any(|p| p == b"..") => Some("a path that leads out of its folder"),
        _ => None,
    }
}

fn tar(data: impl Read, target: &mut UnpackTarget<'_>) -> Result<(), RejectReason> {
    use tar::EntryType;
    let failed = |e: io::Error| if e.kind() == io::ErrorKind::FileTooLarge { too_large() } else { damaged(&e) };
    let mut archive = tar::Archive::new(data);
    for entry in archive.entries().map_err(failed)? {
        let mut entry = entry.map_err(failed)?;
        let sort = match entry.header().entry_type() {
            EntryType::Regular => EntryKind::File,
            EntryType::Directory => EntryKind::Folder,
            // A comment that `git archive` writes first.
            EntryType::XGlobalHeader => continue,
            EntryType::Symlink => EntryKind::Other("a symbolic link"),
            EntryType::Link => EntryKind::Other("a hard link"),
            EntryType::Char | EntryType::Block => EntryKind::Other("a device"),
            EntryType::Fifo => EntryKind::Other("a pipe"),
            EntryType::GNUSparse => EntryKind::Other("a sparse file"),
            _ => EntryKind::Other("of an unknown type"),
        };
        let (name, size) = (entry.path_bytes().into_owned(), entry.size());
        target.unpack_entry(&name, sort, size, &mut entry)?;
    }
    Ok(())
}

fn zip(data: File, target: &mut UnpackTarget<'_>) -> Result<(), RejectReason> {
    let mut archive = zip::ZipArchive::new(data).map_err(|e| damaged(&e))?;
    for i in 0..archive.len() {
        let mut entry = archive.by_index(i).map_err(|e| damaged(&e))?;
        // Archives written on Unix store the file type in these bits; for others they are 0.
        let sort = match entry.unix_mode().unwrap_or(0) & 0o170_000 {
            0 | 0o100_000 if entry.is_dir() => EntryKind::Folder,
            0 | 0o100_000 => EntryKind::File,
            0o040_000 => EntryKind::Folder,
            0o120_000 => EntryKind::Other("a symbolic link"),
            0o020_000 | 0o060_000 => EntryKind::Other("a device"),
            0o010_000 => EntryKind::Other("a pipe"),
            _ => EntryKind::Other("of an unknown type"),
        };
        let (name, size) = (entry.name_raw().to_vec(), entry.size());
        target.unpack_entry(&name, sort, size, &mut entry)?;
    }
    Ok(())
}

/// A reader that fails after `left` bytes, to limit how far a small archive can expand.
struct LimitedReader<R> {
    from: R,
    left: u64,
}

impl<R: Read> Read for LimitedReader<R> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let n = self.from.read(to)?;
        self.left = self.left.checked_sub(n as u64).ok_or(io::ErrorKind::FileTooLarge)?;
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_leading_outside_are_detected() {
        for name in ["/x", "\\x", "..", "../x", "a/../../x", "a\\..\\x", "C:x", "c:\\x", "", "a\0b"] {
            assert!(path_escape(name.as_bytes()).is_some(), "{name:?}");
        }
        for name in ["x", "./x", "a/b", "..x", "a..b/x", "a/...", "build/libtatu_x.so"] {
            assert_eq!(path_escape(name.as_bytes()), None, "{name}");
        }
    }

    #[test]
    fn reader_stops_at_size_limit() {
        let mut some = LimitedReader { from: io::repeat(0), left: 1000 };
        let error = io::copy(&mut some, &mut io::sink()).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::FileTooLarge);
    }
}
