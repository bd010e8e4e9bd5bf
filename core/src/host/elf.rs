//! A look at a library before the loader maps it: a cut ELF file kills the process with SIGBUS instead of failing.

use std::path::Path;

/// Why a file must not be given to the loader. Files of other formats are left to it: they fail in order.
pub fn check(path: &Path) -> Result<(), String> {
    let bytes = std::fs::read(path).map_err(|e| e.to_string())?;
    if bytes.is_empty() {
        return Err("the file is empty".into());
    }
    // 64-bit little-endian ELF; offsets of the ELF-64 object file format.
    if !bytes.starts_with(b"\x7fELF\x02\x01") {
        return Ok(());
    }
    let cut = || format!("the file is cut off: it has only {} bytes of what its headers tell", bytes.len());
    let number = |at: usize, n: usize| -> Option<u64> {
        let part = bytes.get(at..at.checked_add(n)?)?;
        Some(part.iter().rev().fold(0, |x, b| x << 8 | u64::from(*b)))
    };
    let machine = number(18, 2).ok_or_else(cut)?;
    let ours = match std::env::consts::ARCH {
        "x86_64" => Some(62),
        "aarch64" => Some(183),
        "riscv64" => Some(243),
        _ => None,
    };
    if ours.is_some_and(|m| m != machine) {
        return Err(format!("it is built for another processor (ELF machine {machine}); build it for this one"));
    }
    let (Some(table), Some(size), Some(count)) = (number(32, 8), number(54, 2), number(56, 2)) else {
        return Err(cut());
    };
    for i in 0..count {
        let at = table.saturating_add(i * size) as usize;
        let (Some(offset), Some(length)) = (number(at.saturating_add(8), 8), number(at.saturating_add(32), 8)) else {
            return Err(cut());
        };
        if offset.saturating_add(length) > bytes.len() as u64 {
            return Err(cut());
        }
    }
    Ok(())
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn a_program_passes_and_its_beginning_does_not() {
        let whole = std::env::current_exe().unwrap();
        assert_eq!(check(&whole), Ok(()));
        let bytes = std::fs::read(&whole).unwrap();
        let file = std::env::temp_dir().join(format!("tatu_elf_{}", std::process::id()));
        for n in [0, 5, 30, 4096, 1 << 16] {
            std::fs::write(&file, &bytes[..n]).unwrap();
            let passes = check(&file).is_ok();
            // Too short to be known as ELF at all: the loader refuses it in order.
            assert_eq!(passes, n == 5, "{n} bytes");
        }
        std::fs::remove_file(&file).unwrap();
    }
}
