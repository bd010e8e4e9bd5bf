//! Checks of a library before the loader maps it, because a truncated ELF file would kill the process with SIGBUS.

use std::{
    fs::File,
    io::{Read, Seek, SeekFrom},
    path::Path,
};

/// The reason why a file must not be passed to the loader, and a hint.
#[derive(Debug, PartialEq, Eq)]
pub struct LibraryFlaw {
    /// Why the file is rejected.
    pub text: String,
    /// Hint that suggests what to do about it.
    pub help: &'static str,
}

const BUILD_OR_COPY_HELP: &str = "build or copy it again";
const REBUILD_HELP: &str = "build it for this processor and system";

/// Size of the header of an ELF file, bytes.
const HEADER: usize = 64;

/// Checks the headers of an ELF file. On systems with ELF libraries, other files are refused; on other systems, the
/// loader checks the format.
pub fn check(path: &Path) -> Result<(), LibraryFlaw> {
    let no = |text: String, help| Err(LibraryFlaw { text, help });
    let unread = |e: std::io::Error| LibraryFlaw { text: format!("it cannot be read: {e}"), help: BUILD_OR_COPY_HELP };
    // Opening a pipe would block until a process writes to it.
    let about = std::fs::metadata(path).map_err(unread)?;
    if !about.is_file() {
        let what = if about.is_dir() { "a folder" } else { "a pipe, socket or device" };
        return no(format!("it is {what}, not a file"), "remove it, and copy the library there");
    }
    let mut file = File::open(path).map_err(unread)?;
    let have = file.metadata().map_err(unread)?.len();
    let mut header = Vec::with_capacity(HEADER);
    file.by_ref().take(HEADER as u64).read_to_end(&mut header).map_err(unread)?;
    if header.is_empty() {
        return no("the file is empty".into(), BUILD_OR_COPY_HELP);
    }
    let elf_system = cfg!(all(unix, not(target_vendor = "apple")));
    if elf_system && !header.starts_with(b"\x7fELF") {
        return no("it is not a library: it has no ELF header".into(), BUILD_OR_COPY_HELP);
    }
    if !elf_system || header.len() > 5 && header[4..6] != [2, 1] {
        return match elf_system && cfg!(all(target_pointer_width = "64", target_endian = "little")) {
            true => no("it is an ELF file with a different word size or byte order".into(), REBUILD_HELP),
            false => Ok(()),
        };
    }
    let machine = number(&header, 18, 2);
    let ours = match std::env::consts::ARCH {
        "x86_64" => Some(62),
        "aarch64" => Some(183),
        "riscv64" => Some(243),
        _ => None,
    };
    match (machine, ours) {
        (Some(m), Some(ours)) if m != ours => {
            no(format!("it is built for a different processor (ELF machine {m}, this one is {ours})"), REBUILD_HELP)
        }
        _ if is_complete(&mut file, &header, have) == Some(true) => Ok(()),
        _ => {
            no(format!("the file is truncated: it has {have} bytes, fewer than its headers state"), BUILD_OR_COPY_HELP)
        }
    }
}

/// Returns whether a file of `have` bytes contains everything that its headers declare, or `None` if the headers are
/// truncated. Offsets are those of 64-bit little-endian ELF.
fn is_complete(file: &mut File, header: &[u8], have: u64) -> Option<bool> {
    let (first, size, count) = (number(header, 32, 8)?, number(header, 54, 2)?, number(header, 56, 2)?);
    if first.checked_add(size * count)? > have {
        return Some(false);
    }
    file.seek(SeekFrom::Start(first)).ok()?;
    let mut segments = vec![0; (size * count) as usize];
    file.read_exact(&mut segments).ok()?;
    for i in 0..count {
        let at = i * size;
        let (offset, length) = (number(&segments, at + 8, 8)?, number(&segments, at + 32, 8)?);
        if offset.checked_add(length)? > have {
            return Some(false);
        }
    }
    // The loader does not need the section table, but a file without it is truncated, because the table is at its end.
    let (sections, size, count) = (number(header, 40, 8)?, number(header, 58, 2)?, number(header, 60, 2)?);
    Some(sections == 0 || sections.checked_add(size * count)? <= have)
}

/// Returns the little-endian number of `n` bytes at an offset, or `None` if the bytes end before it does.
fn number(bytes: &[u8], at: u64, n: usize) -> Option<u64> {
    let part = bytes.get(at as usize..)?.get(..n)?;
    Some(part.iter().rev().fold(0, |x, b| x << 8 | u64::from(*b)))
}

#[cfg(all(test, target_os = "linux", target_pointer_width = "64"))]
mod tests {
    use super::*;

    #[test]
    fn complete_elf_file_is_accepted_and_truncated_one_refused() {
        let whole = std::env::current_exe().unwrap();
        assert_eq!(check(&whole), Ok(()));
        let bytes = std::fs::read(&whole).unwrap();
        let file = std::env::temp_dir().join(format!("tatu_elf_{}", std::process::id()));
        for n in [0, 1, 5, 6, 30, 64, 4096, 1 << 16, bytes.len() / 2, bytes.len() - 1] {
            std::fs::write(&file, &bytes[..n]).unwrap();
            assert!(check(&file).is_err(), "{n} bytes");
        }
        std::fs::remove_file(&file).unwrap();
    }
}
