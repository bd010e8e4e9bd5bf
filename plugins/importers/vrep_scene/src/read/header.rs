//! The header of a file, which is never compressed.

use super::{cursor::Cursor, cursor::ReadError, cursor::ReadResult};

/// The first bytes of every file.
pub const MAGIC: &[u8; 4] = b"VREP";
/// The last serialization with a short header.
const LAST_SHORT_HEADER: i32 = 12;
/// Offset of the payload, in files with a short header and in all others, in bytes.
const PAYLOAD_OFFSET: [usize; 2] = [17, 1021];
/// The oldest supported serialization.
const MIN_SERIALIZATION: i32 = 15;
/// The newest supported serialization.
const MAX_SERIALIZATION: i32 = 30;
/// Maximum size of the unpacked data, in bytes.
pub const MAX_UNPACKED: usize = 1 << 30;

/// The content of the header.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FileHeader {
    /// Version of the file format, from `MIN_SERIALIZATION` to `MAX_SERIALIZATION`.
    pub serialization: i32,
    /// The oldest serialization whose readers can read the file.
    pub readable_from: i32,
    /// Whether the payload is Huffman-coded.
    pub packed: bool,
    /// Size of the unpacked payload, in bytes.
    pub unpacked: usize,
    /// Version of the program that wrote the file: 30400 is 3.4.0, 41000 is 4.10.0.
    pub program: u32,
    /// Revision of the program that wrote the file.
    pub revision: u8,
    /// 1 for a scene, 2 for a model, 0 in files before 3.6.1.
    pub file_type: u8,
    /// Offset of the payload, in bytes.
    pub payload: usize,
}

impl FileHeader {
    /// Reads and checks the header.
    pub fn read(file: &[u8]) -> ReadResult<FileHeader> {
        let mut c = Cursor::new(file);
        if c.take(4).ok() != Some(MAGIC) {
            return Err(ReadError::new(0, "expected a V-REP scene or model, which begins with `VREP`").within("header"));
        }
        Self::fields(&mut c).map_err(|e| e.within("header"))
    }

    fn fields(c: &mut Cursor<'_>) -> ReadResult<FileHeader> {
        let mut h = FileHeader { serialization: c.i32()?, ..Default::default() };
        if !(MIN_SERIALIZATION..=MAX_SERIALIZATION).contains(&h.serialization) {
            let text = format!(
                "serialization {} is not supported; expected {MIN_SERIALIZATION} to {MAX_SERIALIZATION}",
                h.serialization
            );
            return Err(ReadError::new(4, text));
        }
        h.readable_from = c.i32()?;
        h.packed = match c.u8()? {
            0 => false,
            1 => true,
            n => {
                return Err(ReadError::new(
                    12,
                    format!("packing method {n} is not supported; expected 0 (none) or 1 (Huffman)"),
                ));
            }
        };
        h.unpacked = c.count()?;
        h.payload = PAYLOAD_OFFSET[usize::from(h.serialization > LAST_SHORT_HEADER)];
        if h.serialization > LAST_SHORT_HEADER {
            c.i32()?;
            h.program = c.u16()?.into();
            c.i32()?;
            h.revision = c.u8()?;
            h.file_type = c.u8()?;
        }
        let rest = c.remaining().saturating_add(c.at());
        if rest < h.payload {
            return Err(
                c.error(format!("the file is truncated: its header declares {} bytes, found {rest}", h.payload))
            );
        }
        // An unpacked byte is encoded in at least one bit, so a larger declared size is invalid.
        let most = if h.packed { (rest - h.payload).saturating_mul(8) } else { rest - h.payload };
        if h.unpacked > most || h.unpacked > MAX_UNPACKED {
            let text = format!(
                "the header declares {} unpacked bytes, but at most {} are possible",
                h.unpacked,
                most.min(MAX_UNPACKED)
            );
            return Err(ReadError::new(13, text));
        }
        Ok(h)
    }

    /// Returns the version of the program in its usual spelling, such as "3.4.0".
    pub fn version(&self) -> String {
        format!("{}.{}.{}", self.program / 10_000, self.program / 100 % 100, self.program % 100)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(edit: impl Fn(&mut Vec<u8>)) -> ReadResult<FileHeader> {
        let mut bytes = vec![0; 1200];
        bytes[..29].copy_from_slice(&[
            0x56, 0x52, 0x45, 0x50, 25, 0, 0, 0, 24, 0, 0, 0, 1, 0x18, 1, 0, 0, 0, 0, 0, 0, 0x28, 0xA0, 1, 0x10, 0, 0,
            0, 2,
        ]);
        edit(&mut bytes);
        FileHeader::read(&bytes)
    }

    #[test]
    fn header_of_the_worked_example_is_read() {
        let h = file(|_| {}).unwrap();
        assert_eq!((h.serialization, h.unpacked, h.file_type, h.packed), (25, 280, 2, true));
        assert_eq!(h.version(), "4.10.0");
    }

    #[test]
    fn invalid_header_is_refused() {
        let why = |edit: fn(&mut Vec<u8>)| file(edit).unwrap_err().what;
        assert!(why(|b| b[0] = 0).contains("`VREP`"));
        assert!(why(|b| b[4] = 3).contains("serialization 3"));
        assert!(why(|b| b[12] = 7).contains("method 7"));
        assert!(why(|b| b[13..17].copy_from_slice(&0x7FFF_FFFF_i32.to_le_bytes())).contains("at most 1432"));
        assert!(why(|b| b[16] = 0x80).contains("expected a length"));
        assert!(why(|b| b.truncate(20)).contains("more bytes, found"));
    }
}
