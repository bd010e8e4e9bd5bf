//! Determines the type of a file: follows links one by one, and recognizes formats by their first bytes.

use std::{
    fs::{self, File, Metadata},
    io::{ErrorKind, Read},
    path::{Path, PathBuf},
};

use super::{names, reason::RejectReason};

/// Maximum number of links that the system follows.
const MAX_LINKS: usize = 40;
/// Number of bytes read to distinguish text from other files.
const HEAD_BYTES: u64 = 512;

const BUILD_OR_COPY_HELP: &str = "build or copy it again";

/// Returns the targets of the links at a path, in order, and the reason that they do not refer to a file, if any.
pub fn links(file: &Path) -> (Vec<PathBuf>, Option<RejectReason>) {
    let mut chain: Vec<PathBuf> = Vec::new();
    let mut at = file.to_owned();
    loop {
        match fs::symlink_metadata(&at) {
            Ok(about) if about.is_symlink() => {}
            Ok(_) => return (chain, None),
            Err(e) if e.kind() == ErrorKind::NotFound && !chain.is_empty() => {
                let text = format!("it is a link to {}, which does not exist", at.display());
                let help = "remove the link, or build the file that it refers to";
                return (chain, Some(RejectReason::new("dangling-link", text, help)));
            }
            Err(e) => return (chain, Some(unreadable(file, &e))),
        }
        let Ok(to) = fs::read_link(&at) else { return (chain, None) };
        let to = at.parent().map_or(to.clone(), |folder| folder.join(&to));
        if to == *file || chain.contains(&to) || chain.len() >= MAX_LINKS {
            let text = format!("it is a link that leads back to itself via {}", at.display());
            chain.push(to);
            return (chain, Some(RejectReason::new("link-loop", text, "remove the links, and copy the library there")));
        }
        chain.push(to.clone());
        at = to;
    }
}

/// Returns why a path must not be opened: it is not a file, cannot be read, or is not a library of this system.
pub fn rejection(file: &Path) -> Option<RejectReason> {
    let about = match fs::metadata(file) {
        Ok(about) => about,
        Err(e) => return Some(unreadable(file, &e)),
    };
    if let Some(sort) = other_than_file(&about) {
        let help = match about.is_dir() {
            true => format!("name the library in it, or remove the folder: {} is a library's name", names::name(file)),
            false => "remove it, and copy the library there".to_owned(),
        };
        return Some(RejectReason::new("not-a-file", format!("it is {sort}, not a file"), help));
    }
    let mut bytes = Vec::new();
    match File::open(file).and_then(|f| f.take(HEAD_BYTES).read_to_end(&mut bytes)) {
        Ok(0) => Some(RejectReason::new("empty", "the file is empty", BUILD_OR_COPY_HELP)),
        Ok(_) => format_rejection(&bytes, file),
        Err(e) => Some(unreadable(file, &e)),
    }
}

fn unreadable(file: &Path, e: &std::io::Error) -> RejectReason {
    match e.kind() {
        ErrorKind::NotFound => RejectReason::new("no-such-file", "there is no such file", "check the path"),
        ErrorKind::PermissionDenied => {
            let help = format!("make it readable: `chmod a+r {}`; its folders need `a+rx`", file.display());
            RejectReason::new("unreadable", "it cannot be read: permission denied", help)
        }
        _ => RejectReason::new("unreadable", format!("it cannot be read: {e}"), BUILD_OR_COPY_HELP),
    }
}

fn other_than_file(about: &Metadata) -> Option<&'static str> {
    if about.is_dir() {
        return Some("a folder");
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let sort = about.file_type();
        if sort.is_fifo() {
            return Some("a pipe");
        }
        if sort.is_socket() {
            return Some("a socket");
        }
        if sort.is_block_device() || sort.is_char_device() {
            return Some("a device");
        }
    }
    (!about.is_file()).then_some("a special file")
}

/// The first bytes of formats that are not libraries on any system.
const OTHER_FORMATS: [(&[u8], &str, &str, &str); 7] = [
    (
        b"!<arch>\n",
        "static-library",
        "it is a static library (an `ar` archive), which can only be linked, not loaded",
        "link its objects into a shared library: `cc -shared -o libtatu_NAME.so *.o`",
    ),
    (
        b"\x1f\x8b",
        "archive",
        "it is packed (gzip), not a library",
        "unpack it, or install the archive: `tatu plugin install FILE`",
    ),
    (
        b"PK\x03\x04",
        "archive",
        "it is packed (zip), not a library",
        "unpack it, or install the archive: `tatu plugin install FILE`",
    ),
    (b"BZh", "archive", "it is packed (bzip2), not a library", "unpack it"),
    (b"\xfd7zXZ\0", "archive", "it is packed (xz), not a library", "unpack it"),
    (b"\x28\xb5\x2f\xfd", "archive", "it is packed (zstd), not a library", "unpack it"),
    (b"BC\xc0\xde", "bitcode", "it is LLVM bitcode, not a library", "build without `-emit-llvm` and `-flto`, and link"),
];

/// The first bytes of libraries on each system.
const ELF_MAGIC: &[u8] = b"\x7fELF";
const WINDOWS_MAGIC: &[u8] = b"MZ";
const MAC_MAGICS: [[u8; 4]; 5] = [
    [0xcf, 0xfa, 0xed, 0xfe],
    [0xce, 0xfa, 0xed, 0xfe],
    [0xfe, 0xed, 0xfa, 0xcf],
    [0xfe, 0xed, 0xfa, 0xce],
    [0xca, 0xfe, 0xba, 0xbe],
];

/// Returns why a file that begins with these bytes must not be opened.
fn format_rejection(bytes: &[u8], file: &Path) -> Option<RejectReason> {
    if let Some((_, kind, text, help)) = OTHER_FORMATS.iter().find(|(magic, ..)| bytes.starts_with(magic)) {
        return Some(RejectReason::new(kind, *text, help.replace("FILE", &file.display().to_string())));
    }
    let of = match bytes {
        _ if bytes.starts_with(ELF_MAGIC) => "Linux",
        _ if bytes.starts_with(WINDOWS_MAGIC) => "Windows",
        _ if MAC_MAGICS.iter().any(|magic| bytes.starts_with(magic)) => "macOS",
        _ if is_text(bytes) => {
            let what = if bytes.starts_with(b"#!") { "a script" } else { "a text file" };
            let help = "compile it, and give the resulting library; a controller in Lua is not a plugin, run it by \
                        `tatu run SCENE --script /ROBOT=FILE`";
            return Some(RejectReason::new("text", format!("it is {what}, not a library"), help));
        }
        _ => {
            return Some(RejectReason::new(
                "not-a-library",
                "it is not a library: its first bytes match no known format",
                BUILD_OR_COPY_HELP,
            ));
        }
    };
    let here = if cfg!(windows) {
        "Windows"
    } else if cfg!(target_vendor = "apple") {
        "macOS"
    } else {
        "Linux"
    };
    // Systems that share the ELF format are distinguished by the loader.
    (of != here).then(|| {
        let help = format!("build it on {here}, or get the author's build for {here}");
        RejectReason::new("other-system", format!("it is a library for {of}, but this is {here}"), help)
    })
}

/// Returns whether a file that begins with these bytes is text. The last character may be incomplete.
fn is_text(bytes: &[u8]) -> bool {
    let valid = match std::str::from_utf8(bytes) {
        Ok(text) => text,
        Err(e) if e.error_len().is_none() => std::str::from_utf8(&bytes[..e.valid_up_to()]).unwrap_or_default(),
        Err(_) => return false,
    };
    !valid.is_empty() && valid.chars().all(|c| !c.is_control() || matches!(c, '\n' | '\r' | '\t' | '\x0c'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_recognized_by_their_first_bytes() {
        let kind = |bytes: &[u8]| format_rejection(bytes, Path::new("x.so")).map(|r| r.kind);
        assert_eq!(kind(b"#!/bin/sh\n"), Some("text"));
        assert_eq!(kind("größer".as_bytes()), Some("text"));
        assert_eq!(kind(&"größer".as_bytes()[..3]), Some("text"), "cut within a character");
        assert_eq!(kind(b"!<arch>\nx"), Some("static-library"));
        assert_eq!(kind(b"PK\x03\x04xx"), Some("archive"));
        assert_eq!(kind(b"\0\x01\x02"), Some("not-a-library"));
        #[cfg(target_os = "linux")]
        {
            assert_eq!(kind(b"\x7fELF\x02\x01"), None);
            assert_eq!(kind(b"MZ\x90\0"), Some("other-system"));
            assert_eq!(kind(b"\xcf\xfa\xed\xfe"), Some("other-system"));
        }
    }
}
