//! Messages cut into packets: the byte order's mark, how many bytes follow, how many packets are still to come.

use std::io::{self, Read, Write};

/// Bytes of a packet that is sent, its head apart.
const PAYLOAD: usize = 30_000;
/// Bytes of a message that is taken: more than of the largest file, so that one that is too large is reported.
pub const MOST: usize = 66 << 20;

/// Why a message was not taken.
pub fn wrong(why: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, why.to_owned())
}

/// Reads a message. Memory grows as packets come.
pub fn read(stream: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut message = Vec::new();
    loop {
        let mut head = [0_u8; 6];
        stream.read_exact(&mut head)?;
        let word = |at: usize| u16::from_le_bytes([head[at], head[at + 1]]);
        match word(0) {
            1 => {}
            0x100 => return Err(wrong("a client of the opposite byte order")),
            _ => return Err(wrong("not a packet of the remote API")),
        }
        let (len, more) = (usize::from(word(2)), word(4));
        if len == 0 || message.len() + len > MOST {
            return Err(wrong(&format!("a packet of {len} bytes; a message has {MOST} at most")));
        }
        let at = message.len();
        message.resize(at + len, 0);
        stream.read_exact(&mut message[at..])?;
        if more == 0 {
            return Ok(message);
        }
    }
}

/// Writes a message.
pub fn write(stream: &mut impl Write, message: &[u8]) -> io::Result<()> {
    let n = message.len().div_ceil(PAYLOAD);
    let mut out = Vec::with_capacity(message.len() + 6 * n);
    for (i, part) in message.chunks(PAYLOAD).enumerate() {
        out.extend_from_slice(&1_u16.to_le_bytes());
        out.extend_from_slice(&(part.len() as u16).to_le_bytes());
        out.extend_from_slice(&((n - 1 - i) as u16).to_le_bytes());
        out.extend_from_slice(part);
    }
    stream.write_all(&out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_messages_are_cut_and_joined() {
        let message: Vec<u8> = (0..70_000_u32).map(|i| i as u8).collect();
        let mut bytes = Vec::new();
        write(&mut bytes, &message).unwrap();
        assert_eq!(bytes.len(), 70_000 + 18);
        assert_eq!(&bytes[..6], &[1, 0, 0x30, 0x75, 2, 0]);
        assert_eq!(read(&mut bytes.as_slice()).unwrap(), message);
    }

    #[test]
    fn nonsense_is_refused() {
        for bytes in [&b"GET / HTTP/1.1"[..], &[1, 0, 0, 0, 0, 0], &[0, 1, 5, 0, 0, 0], &[1, 0, 5, 0, 0, 0, 1]] {
            assert!(read(&mut &*bytes).is_err(), "{bytes:?}");
        }
    }
}
