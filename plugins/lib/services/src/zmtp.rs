//! ZMTP 3 (<https://rfc.zeromq.org/spec/23>) with the security mechanism NULL: the handshake, and frames.
//!
//! This module is shared by the service that answers ZeroMQ clients and the plugin that provides ZeroMQ sockets to
//! scripts. Declared sizes are not trusted: memory is allocated only as bytes arrive.

use std::io::{self, Read, Write};

/// Maximum size of a message, bytes.
pub const MAX_MESSAGE_BYTES: u64 = 64 << 20;
/// Maximum size of a body that is copied in order to be written together with its header, bytes.
pub const SMALL_MESSAGE_BYTES: usize = 64 << 10;

/// Flag of a frame: further frames of the message follow.
pub const FLAG_MORE: u8 = 1;
/// Flag of a frame: the size has eight bytes instead of one.
const FLAG_LONG: u8 = 2;
/// Flag of a frame: it is a command of the protocol.
pub const FLAG_COMMAND: u8 = 4;

/// The properties that a peer has declared in the handshake.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PeerProperties {
    /// The type of its socket, such as `REQ`.
    pub kind: String,
    /// The identity by which other sockets can address the peer; usually empty.
    pub identity: Vec<u8>,
}

/// Builds an error for a message that violates the protocol.
pub fn invalid_message(why: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, why.to_owned())
}

/// Exchanges greetings and READY commands, which declare the socket type `kind` and an identity of at most 255 bytes.
/// Returns the properties of the peer.
///
/// The greeting declares version 3.0, in which subscriptions are messages whose first byte is 1 (subscribe) or 0
/// (cancel).
pub fn greet(stream: &mut (impl Read + Write), kind: &str, identity: &[u8]) -> io::Result<PeerProperties> {
    let mut ours = [0_u8; 64];
    ours[0] = 0xFF;
    ours[8] = 1;
    ours[9] = 0x7F;
    ours[10] = 3;
    ours[12..16].copy_from_slice(b"NULL");
    stream.write_all(&ours)?;
    let mut theirs = [0_u8; 64];
    stream.read_exact(&mut theirs)?;
    if theirs[0] != 0xFF || theirs[9] & 1 == 0 || theirs[10] < 3 || theirs[12..32] != ours[12..32] {
        return Err(invalid_message("expected a greeting of ZMTP 3 with the security mechanism NULL"));
    }
    let mut ready = b"\x05READY".to_vec();
    push_property(&mut ready, "Socket-Type", kind.as_bytes());
    if !identity.is_empty() {
        push_property(&mut ready, "Identity", identity);
    }
    write_frame(stream, FLAG_COMMAND, &ready)?;
    let (flags, body) = read_frame(stream, u64::from(u16::MAX))?;
    let properties = body.strip_prefix(b"\x05READY").filter(|_| flags & FLAG_COMMAND != 0);
    Ok(peer_properties(properties.ok_or_else(|| invalid_message("expected the READY command as the first frame"))?))
}

fn push_property(out: &mut Vec<u8>, name: &str, value: &[u8]) {
    out.push(name.len() as u8);
    out.extend_from_slice(name.as_bytes());
    out.extend_from_slice(&(value.len() as u32).to_be_bytes());
    out.extend_from_slice(value);
}

/// Reads the properties of a READY command. Those after a malformed one are ignored.
fn peer_properties(mut properties: &[u8]) -> PeerProperties {
    let mut peer = PeerProperties { kind: String::new(), identity: Vec::new() };
    while let Some((name, value, rest)) = next_property(properties) {
        if name.eq_ignore_ascii_case(b"Socket-Type") {
            peer.kind = String::from_utf8_lossy(value).into_owned();
        } else if name.eq_ignore_ascii_case(b"Identity") {
            peer.identity = value.to_vec();
        }
        properties = rest;
    }
    peer
}

/// Splits off the first property. Returns its name, its value, and the remaining bytes.
fn next_property(bytes: &[u8]) -> Option<(&[u8], &[u8], &[u8])> {
    let (len, rest) = bytes.split_first()?;
    let (name, rest) = rest.split_at_checked(usize::from(*len))?;
    let (len, rest) = rest.split_first_chunk::<4>()?;
    let (value, rest) = rest.split_at_checked(u32::from_be_bytes(*len) as usize)?;
    Some((name, value, rest))
}

/// Appends the header of a frame, which contains its flags and its size.
pub fn push_header(out: &mut Vec<u8>, flags: u8, len: usize) {
    match u8::try_from(len) {
        Ok(len) => out.extend_from_slice(&[flags, len]),
        Err(_) => {
            out.push(flags | FLAG_LONG);
            out.extend_from_slice(&(len as u64).to_be_bytes());
        }
    }
}

/// Writes a frame. A small body is written together with its header; a large one, such as an image, is not copied.
pub fn write_frame(stream: &mut impl Write, flags: u8, body: &[u8]) -> io::Result<()> {
    let mut bytes = Vec::new();
    push_header(&mut bytes, flags, body.len());
    write_after(stream, bytes, body)
}

/// Writes the headers in `bytes`, followed by a body.
pub fn write_after(stream: &mut impl Write, mut bytes: Vec<u8>, body: &[u8]) -> io::Result<()> {
    if body.len() <= SMALL_MESSAGE_BYTES {
        bytes.extend_from_slice(body);
        return stream.write_all(&bytes);
    }
    stream.write_all(&bytes)?;
    stream.write_all(body)
}

/// Reads a frame with a body of at most `most` bytes. Returns its flags and its body.
pub fn read_frame(stream: &mut impl Read, most: u64) -> io::Result<(u8, Vec<u8>)> {
    let mut head = [0_u8; 1];
    stream.read_exact(&mut head)?;
    let flags = head[0];
    if flags & !(FLAG_MORE | FLAG_LONG | FLAG_COMMAND) != 0 {
        return Err(invalid_message("a frame has unknown flags"));
    }
    let len = if flags & FLAG_LONG != 0 {
        let mut len = [0_u8; 8];
        stream.read_exact(&mut len)?;
        u64::from_be_bytes(len)
    } else {
        stream.read_exact(&mut head)?;
        u64::from(head[0])
    };
    if len > most {
        return Err(invalid_message(&format!("a frame declares a size of {len} bytes: expected at most {most}")));
    }
    let mut body = Vec::new();
    if stream.take(len).read_to_end(&mut body)? as u64 != len {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok((flags, body))
}

/// Returns the body of the PONG command that answers a command, or `None` if the command is not a PING.
pub fn pong(command: &[u8]) -> io::Result<Option<Vec<u8>>> {
    // The length and name of the command are followed by a time to live of two bytes, and by a context, which must be
    // returned.
    let Some(context) = command.strip_prefix(b"\x04PING").and_then(|rest| rest.get(2..)) else { return Ok(None) };
    if context.len() > 16 {
        return Err(invalid_message("the context of a PING command is too long: expected at most 16 bytes"));
    }
    Ok(Some([b"\x04PONG", context].concat()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn claimed_frame_size_is_not_trusted() {
        let claim = [&[FLAG_LONG][..], &(MAX_MESSAGE_BYTES + 1).to_be_bytes()].concat();
        assert!(
            read_frame(&mut claim.as_slice(), MAX_MESSAGE_BYTES)
                .unwrap_err()
                .to_string()
                .contains("declares a size of")
        );
        let claim = [&[FLAG_LONG][..], &MAX_MESSAGE_BYTES.to_be_bytes(), b"short"].concat();
        assert_eq!(
            read_frame(&mut claim.as_slice(), MAX_MESSAGE_BYTES).unwrap_err().kind(),
            io::ErrorKind::UnexpectedEof
        );
        assert_eq!(read_frame(&mut &b"\x00\x02ab"[..], MAX_MESSAGE_BYTES).unwrap(), (0, b"ab".to_vec()));
        assert!(read_frame(&mut &b"\xF0\x02ab"[..], MAX_MESSAGE_BYTES).is_err());
    }

    #[test]
    fn written_frames_are_read_back() {
        for len in [0, 1, 255, 256, SMALL_MESSAGE_BYTES + 1] {
            let (mut bytes, body) = (Vec::new(), vec![7; len]);
            write_frame(&mut bytes, FLAG_MORE, &body).unwrap();
            let (flags, read) = read_frame(&mut bytes.as_slice(), MAX_MESSAGE_BYTES).unwrap();
            assert_eq!((flags & FLAG_MORE, read), (FLAG_MORE, body));
        }
    }

    #[test]
    fn malformed_properties_end_the_list() {
        let mut bytes = Vec::new();
        push_property(&mut bytes, "Identity", b"me");
        push_property(&mut bytes, "socket-type", b"REQ");
        bytes.extend_from_slice(b"\x05abc");
        assert_eq!(peer_properties(&bytes), PeerProperties { kind: "REQ".into(), identity: b"me".to_vec() });
    }

    #[test]
    fn only_ping_is_answered_with_pong() {
        assert_eq!(pong(b"\x04PING\x00\x0aabc").unwrap().unwrap(), b"\x04PONGabc");
        assert_eq!(pong(b"\x09SUBSCRIBEa").unwrap(), None);
        assert!(pong(&[&b"\x04PING\0\0"[..], &[0; 17]].concat()).is_err());
    }
}
