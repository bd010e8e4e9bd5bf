//! Splits messages into packets, and joins packets into messages. The head of a packet consists of a byte order mark,
//! the size of its payload in bytes, and the number of packets that follow.

use std::io::{self, Read, Write};

/// Maximum payload of a packet that is sent, bytes.
const MAX_PAYLOAD_BYTES: usize = 30_000;
/// Maximum size of a received message, bytes. It is larger than the maximum size of a file, so that a file that is too
/// large results in an error instead of a closed connection.
pub const MAX_MESSAGE_BYTES: usize = 66 << 20;

/// Builds the error for an invalid message.
pub fn invalid_message(why: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, why.to_owned())
}

/// Reads a message. The sizes in packet heads are checked, and memory is allocated only as packets arrive.
pub fn read(stream: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut message = Vec::new();
    loop {
        let mut head = [0_u8; 6];
        stream.read_exact(&mut head)?;
        let word = |at: usize| u16::from_le_bytes([head[at], head[at + 1]]);
        match word(0) {
            1 => {}
            0x100 => return Err(invalid_message("the client uses big-endian byte order, which is not supported")),
            _ => return Err(invalid_message("expected a packet of the legacy remote API")),
        }
        let (len, more) = (usize::from(word(2)), word(4));
        if len == 0 || message.len() + len > MAX_MESSAGE_BYTES {
            return Err(invalid_message(&format!(
                "a packet has {len} bytes: expected at least 1, and at most {MAX_MESSAGE_BYTES} for all packets of a message"
            )));
        }
        let at = message.len();
        message.resize(at + len, 0);
        stream.read_exact(&mut message[at..])?;
        if more == 0 {
            return Ok(message);
        }
    }
}

/// Writes a message, split into packets.
pub fn write(stream: &mut impl Write, message: &[u8]) -> io::Result<()> {
    let n = message.len().div_ceil(MAX_PAYLOAD_BYTES);
    let mut out = Vec::with_capacity(message.len() + 6 * n);
    for (i, part) in message.chunks(MAX_PAYLOAD_BYTES).enumerate() {
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
    fn large_messages_are_split_and_joined() {
        let message: Vec<u8> = (0..70_000_u32).map(|i| i as u8).collect();
        let mut bytes = Vec::new();
        write(&mut bytes, &message).unwrap();
        assert_eq!(bytes.len(), 70_000 + 18);
        assert_eq!(&bytes[..6], &[1, 0, 0x30, 0x75, 2, 0]);
        assert_eq!(read(&mut bytes.as_slice()).unwrap(), message);
    }

    #[test]
    fn invalid_packets_are_refused() {
        for bytes in [&b"GET / HTTP/1.1"[..], &[1, 0, 0, 0, 0, 0], &[0, 1, 5, 0, 0, 0], &[1, 0, 5, 0, 0, 0, 1]] {
            assert!(read(&mut &*bytes).is_err(), "{bytes:?}");
        }
    }
}
