//! A look at a library before the loader maps it: a cut ELF file kills the process with SIGBUS instead of failing.

use std::path::Path;

/// Why a file must not be given to the loader, and what to do.
#[derive(Debug, PartialEq, Eq)]
pub struct Unfit {
    /// What is wrong.
    pub text: String,
    /// What to do.
    pub mend: &'static str,
}

const AGAIN: &str = "build or copy it again";
const REBUILD: &str = "build it for this processor and system";

/// Looks at a file. Formats other than ELF are left to their loaders: these fail in order.
pub fn check(path: &Path) -> Result<(), Unfit> {
    let no = |text: String, mend| Err(Unfit { text, mend });
    let bytes = std::fs::read(path).map_err(|e| Unfit { text: format!("it cannot be read: {e}"), mend: AGAIN })?;
    if bytes.is_empty() {
        return no("the file is empty".into(), AGAIN);
    }
    let elf_system = cfg!(all(unix, not(target_vendor = "apple")));
    if elf_system && !bytes.starts_with(b"\x7fELF") {
        return no("it is no library: it does not begin as an ELF file does".into(), AGAIN);
    }
    if !elf_system || bytes.len() > 5 && bytes[4..6] != [2, 1] {
        return match elf_system && cfg!(all(target_pointer_width = "64", target_endian = "little")) {
            true => no("it is an ELF file of another word size or byte order".into(), REBUILD),
            false => Ok(()),
        };
    }
    // 64-bit little-endian ELF; offsets of the ELF-64 object file format.
    let have = bytes.len() as u64;
    let number = |at: u64, n: u64| -> Option<u64> {
        let part = bytes.get(at as usize..at.checked_add(n)? as usize)?;
        Some(part.iter().rev().fold(0, |x, b| x << 8 | u64::from(*b)))
    };
    let whole = || -> Option<bool> {
        let segments = (number(32, 8)?, number(54, 2)?, number(56, 2)?);
        for i in 0..segments.2 {
            let at = segments.0.checked_add(i * segments.1)?;
            let (offset, length) = (number(at.checked_add(8)?, 8)?, number(at.checked_add(32)?, 8)?);
            if offset.checked_add(length)? > have {
                return Some(false);
            }
        }
        // The loader does not need the table of sections, which stands at the end: without it the end is lost.
        let (sections, size, count) = (number(40, 8)?, number(58, 2)?, number(60, 2)?);
        Some(sections == 0 || sections.checked_add(size * count)? <= have)
    };
    let machine = number(18, 2);
    let ours = match std::env::consts::ARCH {
        "x86_64" => Some(62),
        "aarch64" => Some(183),
        "riscv64" => Some(243),
        _ => None,
    };
    match (machine, ours) {
        (Some(m), Some(ours)) if m != ours => {
            no(format!("it is built for another processor (ELF machine {m}, this one is {ours})"), REBUILD)
        }
        _ if whole() == Some(true) => Ok(()),
        _ => no(format!("the file is cut off: it has only {have} bytes of what its headers tell"), AGAIN),
    }
}

#[cfg(all(test, target_os = "linux", target_pointer_width = "64"))]
mod tests {
    use super::*;

    #[test]
    fn a_program_passes_and_its_beginning_does_not() {
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
