//! Opens files that a user names, which must be regular and of limited size.

use std::{
    fs::{self, File},
    io::{self, Read},
    path::Path,
};

/// Default size limit of a file, bytes.
pub const MAX_FILE_BYTES: u64 = 256 << 20;
#[doc(hidden)]
#[deprecated(since = "0.2.0", note = "use MAX_FILE_BYTES")]
pub const MOST_BYTES: u64 = MAX_FILE_BYTES;

/// Opens a regular file of at most `most` bytes. No more bytes are read even if the file grows. A pipe or a device is
/// an error, because it may be endless or block when it is opened.
pub fn open_plain(path: &Path, most: u64) -> io::Result<io::Take<File>> {
    check(&fs::metadata(path)?, most)?;
    let file = File::open(path)?;
    // Checked again, because another file may have been moved to this path in the meantime.
    check(&file.metadata()?, most)?;
    Ok(file.take(most))
}

/// Reads a regular file of at most `most` bytes.
pub fn read_plain(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    read_opened(open_plain(path, most)?.into_inner(), most)
}

/// Like [`read_plain`], but for an open file.
pub fn read_opened(file: File, most: u64) -> io::Result<Vec<u8>> {
    let length = check(&file.metadata()?, most)?;
    let mut file = file.take(most);
    let mut bytes = Vec::new();
    let no_room = |_| io::Error::new(io::ErrorKind::OutOfMemory, format!("not enough memory for its {length} bytes"));
    bytes.try_reserve_exact(length as usize).map_err(no_room)?;
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Like [`read_plain`], but returns text; invalid UTF-8 is an error.
pub fn read_plain_text(path: &Path, most: u64) -> io::Result<String> {
    let bytes = read_plain(path, most)?;
    String::from_utf8(bytes).map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e.utf8_error()))
}

/// Checks type and size of a file; returns its size in bytes.
fn check(about: &fs::Metadata, most: u64) -> io::Result<u64> {
    if about.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"));
    }
    if !about.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a plain file"));
    }
    if about.len() > most {
        let text = format!("its size is {} MB, but at most {} MB are allowed", about.len() >> 20, most >> 20);
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, text));
    }
    Ok(about.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_plain_files_within_the_bound_are_read() {
        let own = Path::new(file!()).file_name().unwrap();
        let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/safe/value").join(own);
        let text = read_plain_text(&here, MAX_FILE_BYTES).unwrap();
        assert!(text.starts_with("//! Opens files that a user names"));
        assert_eq!(read_plain(&here, 10).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert_eq!(read_plain(here.parent().unwrap(), 10).unwrap_err().kind(), io::ErrorKind::IsADirectory);
        assert_eq!(read_plain(Path::new("/no/such"), 10).unwrap_err().kind(), io::ErrorKind::NotFound);
        #[cfg(unix)]
        assert_eq!(read_plain(Path::new("/dev/zero"), 10).unwrap_err().kind(), io::ErrorKind::InvalidInput);
    }
}
