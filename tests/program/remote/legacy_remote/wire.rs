//! A client that writes raw bytes in the format of the protocol. All numbers are little-endian. A message is divided
//! into packets, each with a mark, its size and the number of packets that follow. It consists of a header of 18 bytes
//! and of commands with a header of 26 bytes, an argument and data.

use std::{
    io::{Read, Write},
    net::TcpStream,
    time::Duration,
};

use crate::kit::served_scene::ServedScene;

/// Maximum size of a client's packet without its header, bytes.
const MAX_PACKET_BYTES: usize = 1294;
const BLOCKING: u32 = 1;

/// A client's connection.
pub struct PacketConnection {
    stream: TcpStream,
    /// The number of messages sent so far, which is the id of the last one.
    sent: i32,
}

/// Encodes integers as bytes.
pub fn ints(all: &[i32]) -> Vec<u8> {
    all.iter().flat_map(|i| i.to_le_bytes()).collect()
}
/// Encodes floats as bytes.
pub fn floats(all: &[f32]) -> Vec<u8> {
    all.iter().flat_map(|x| x.to_le_bytes()).collect()
}
/// Decodes the integer at an offset.
pub fn int_at(bytes: &[u8], at: usize) -> i32 {
    i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}
/// Decodes bytes as floats.
pub fn floats_of(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
}
/// Checks that bytes encode the expected floats, within the precision of 32 bits.
#[track_caller]
pub fn near(bytes: &[u8], expected: &[f32]) {
    let found = floats_of(bytes);
    let close = found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5);
    assert!(close && bytes.len() == 4 * expected.len(), "{found:?} instead of {expected:?}");
}

impl PacketConnection {
    /// Connects to a served program.
    pub fn new(served: &ServedScene) -> PacketConnection {
        let stream = served.connect();
        stream.set_nodelay(true).unwrap();
        PacketConnection { stream, sent: 0 }
    }

    /// Sends a message with encoded commands, and returns the answer.
    fn message(&mut self, commands: &[u8]) -> Vec<u8> {
        let (id, clock) = (self.sent, 1000 + self.sent);
        self.sent += 1;
        // The header contains checksum, version, message id and the client's clock. The server ignores the fields that
        // it fills in in its answers.
        let mut message = vec![0, 0, 11];
        message.extend(ints(&[id, clock]));
        message.extend([0xAB; 7]);
        message.extend(commands);
        let n = message.len().div_ceil(MAX_PACKET_BYTES);
        let mut bytes = Vec::new();
        for (i, part) in message.chunks(MAX_PACKET_BYTES).enumerate() {
            for word in [1, part.len() as u16, (n - 1 - i) as u16] {
                bytes.extend(word.to_le_bytes());
            }
            bytes.extend(part);
        }
        self.stream.write_all(&bytes).unwrap();
        let mut answer = Vec::new();
        loop {
            let mut head = [0; 6];
            self.stream.read_exact(&mut head).unwrap();
            assert_eq!(head[..2], [1, 0]);
            let mut part = vec![0; usize::from(u16::from_le_bytes([head[2], head[3]]))];
            self.stream.read_exact(&mut part).unwrap();
            answer.extend(part);
            if head[4..] == [0, 0] {
                break;
            }
        }
        assert_eq!((answer[2], int_at(&answer, 7)), (11, clock), "expected the version and the client's clock");
        assert!(int_at(&answer, 3) <= id && answer.len() >= 18);
        answer
    }

    /// Runs commands without data that arrive in one message, and returns the status of each.
    pub fn together(&mut self, commands: &[(u16, Vec<u8>)]) -> Vec<u8> {
        let all: Vec<u8> = commands.iter().flat_map(|(raw, of)| encoded(BLOCKING, *raw, of, b"")).collect();
        let answer = self.answer(&all);
        let (mut at, mut states) = (18, Vec::new());
        while at < answer.len() {
            states.push(answer[at + 24]);
            at += int_at(&answer, at) as usize;
        }
        states
    }

    /// Sends a command without waiting for an answer to it.
    pub fn send(&mut self, raw: u16, of: &[u8], data: &[u8]) {
        const ONESHOT: u32 = 0;
        self.message(&encoded(ONESHOT, raw, of, data));
    }

    /// Sends a message with encoded commands, and returns the answer that contains theirs.
    fn answer(&mut self, commands: &[u8]) -> Vec<u8> {
        let mut answer = self.message(commands);
        let id = self.sent - 1;
        for _ in 0..30_000 {
            if answer.len() > 18 {
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
            // The answer is only a header if the command is not done yet.
            assert_eq!(int_at(&answer, 3), -1);
            answer = self.message(&[]);
        }
        assert_eq!(int_at(&answer, 3), id, "the answer has another message id");
        answer
    }

    /// Runs a command in a mode, and returns the status and the data of its answer.
    fn ask(&mut self, mode: u32, raw: u16, of: &[u8], data: &[u8]) -> (u8, Vec<u8>) {
        let code = (mode << 16 | u32::from(raw)) as i32;
        let answer = self.answer(&encoded(mode, raw, of, data));
        let found = &answer[18..];
        assert_eq!((int_at(found, 0), int_at(found, 4)), (found.len() as i32, found.len() as i32));
        assert_eq!(usize::from(u16::from_le_bytes([found[8], found[9]])), of.len());
        assert_eq!((int_at(found, 10), int_at(found, 14)), (0, code), "expected the code");
        assert_eq!(&found[26..26 + of.len()], of, "expected the argument");
        (found[24], found[26 + of.len()..].to_vec())
    }

    /// Runs a command that must succeed, and returns its result.
    #[track_caller]
    pub fn good(&mut self, raw: u16, of: &[u8], data: &[u8]) -> Vec<u8> {
        let (status, answer) = self.ask(BLOCKING, raw, of, data);
        if status != 0 {
            panic!("{raw:#06x}: status {status}, {}", self.why());
        }
        answer
    }
    /// Runs a command that must succeed without a result.
    #[track_caller]
    pub fn done(&mut self, raw: u16, of: &[u8], data: &[u8]) {
        assert_eq!(self.good(raw, of, data), b"", "{raw:#06x}");
    }
    /// Runs a command that must fail, and returns its error.
    #[track_caller]
    pub fn bad(&mut self, raw: u16, of: &[u8], data: &[u8]) -> String {
        self.bad_in(BLOCKING, raw, of, data)
    }
    /// Like the method without `_in`, in a given mode.
    #[track_caller]
    pub fn bad_in(&mut self, mode: u32, raw: u16, of: &[u8], data: &[u8]) -> String {
        let (status, answer) = self.ask(mode, raw, of, data);
        assert_eq!((status & 1, answer.len()), (1, 0), "{raw:#06x} must fail");
        let why = self.why();
        assert!(why.starts_with(&format!("{raw:#06x}: ")), "{why}");
        why
    }
    /// Returns the last error. There must be exactly one since the previous request.
    #[track_caller]
    fn why(&mut self) -> String {
        let (status, answer) = self.ask(BLOCKING, 4, b"", b"");
        assert_eq!((status, int_at(&answer, 0)), (0, 1), "expected one error");
        assert_eq!(answer.last(), Some(&0));
        String::from_utf8(answer[4..answer.len() - 1].to_vec()).unwrap()
    }
    /// Returns the handle of the object with a name.
    pub fn handle(&mut self, name: &str) -> i32 {
        int_at(&self.good(0x3001, &zero(name), b""), 0)
    }
}

/// Encodes a command.
fn encoded(mode: u32, raw: u16, of: &[u8], data: &[u8]) -> Vec<u8> {
    let code = (mode << 16 | u32::from(raw)) as i32;
    let size = (26 + of.len() + data.len()) as i32;
    let mut command = ints(&[size, size]);
    command.extend((of.len() as u16).to_le_bytes());
    command.extend(ints(&[0, code]));
    // The delay is 0. The remaining fields are ignored, except for the status.
    command.extend([0, 0, 0xAB, 0xAB, 0xAB, 0xAB, 0, 0xAB]);
    command.extend([of, data].concat());
    command
}

/// Encodes a zero-terminated text.
pub fn zero(text: &str) -> Vec<u8> {
    [text.as_bytes(), &[0]].concat()
}
