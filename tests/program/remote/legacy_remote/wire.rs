//! A client of raw bytes. Messages are written here by the layout of the protocol, all numbers little endian: packets of a
//! mark, a size and how many follow; a head of 18 bytes; commands of 26 bytes, what they are of, and what they hold.

use std::{
    io::{Read, Write},
    net::TcpStream,
    time::Duration,
};

use crate::kit::served::Served;

/// Bytes of a packet of a client, its head apart.
const PACKET: usize = 1294;
const BLOCKING: u32 = 1;

/// A connection.
pub struct Wire {
    stream: TcpStream,
    /// Messages that were sent.
    sent: i32,
}

/// Integers as bytes.
pub fn ints(all: &[i32]) -> Vec<u8> {
    all.iter().flat_map(|i| i.to_le_bytes()).collect()
}
/// Numbers as bytes.
pub fn floats(all: &[f32]) -> Vec<u8> {
    all.iter().flat_map(|x| x.to_le_bytes()).collect()
}
/// The integer that begins there.
pub fn int_at(bytes: &[u8], at: usize) -> i32 {
    i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}
/// The numbers that bytes are.
pub fn floats_of(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
}
/// Numbers, to within what 32 bits hold.
#[track_caller]
pub fn near(bytes: &[u8], expected: &[f32]) {
    let found = floats_of(bytes);
    let close = found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5);
    assert!(close && bytes.len() == 4 * expected.len(), "{found:?} instead of {expected:?}");
}

impl Wire {
    /// A connection to a program.
    pub fn new(served: &Served) -> Wire {
        let stream = served.connect();
        stream.set_nodelay(true).unwrap();
        Wire { stream, sent: 0 }
    }

    /// Sends a message of commands, and reads the one that answers it.
    fn message(&mut self, commands: &[u8]) -> Vec<u8> {
        let (id, clock) = (self.sent, 1000 + self.sent);
        self.sent += 1;
        // The check, the version, the message, the client's clock; what the server fills is anything.
        let mut message = vec![0, 0, 11];
        message.extend(ints(&[id, clock]));
        message.extend([0xAB; 7]);
        message.extend(commands);
        let n = message.len().div_ceil(PACKET);
        let mut bytes = Vec::new();
        for (i, part) in message.chunks(PACKET).enumerate() {
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
        assert_eq!((answer[2], int_at(&answer, 7)), (11, clock), "the version, and the client's clock again");
        assert!(int_at(&answer, 3) <= id && answer.len() >= 18);
        answer
    }

    /// Does a command in a mode; the status of its answer, and what that holds.
    fn ask(&mut self, mode: u32, raw: u16, of: &[u8], data: &[u8]) -> (u8, Vec<u8>) {
        let code = (mode << 16 | u32::from(raw)) as i32;
        let size = (26 + of.len() + data.len()) as i32;
        let mut command = ints(&[size, size]);
        command.extend((of.len() as u16).to_le_bytes());
        command.extend(ints(&[0, code]));
        // Of the delay there is none; the rest is anything, but for the status.
        command.extend([0, 0, 0xAB, 0xAB, 0xAB, 0xAB, 0, 0xAB]);
        command.extend([of, data].concat());
        let mut answer = self.message(&command);
        let id = self.sent - 1;
        for _ in 0..30_000 {
            if answer.len() > 18 {
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
            // A head alone: nothing was done yet.
            assert_eq!(int_at(&answer, 3), -1);
            answer = self.message(&[]);
        }
        assert_eq!(int_at(&answer, 3), id, "the answered message");
        let found = &answer[18..];
        assert_eq!((int_at(found, 0), int_at(found, 4)), (found.len() as i32, found.len() as i32));
        assert_eq!(usize::from(u16::from_le_bytes([found[8], found[9]])), of.len());
        assert_eq!((int_at(found, 10), int_at(found, 14)), (0, code), "the code again");
        assert_eq!(&found[26..26 + of.len()], of, "what it is of again");
        (found[24], found[26 + of.len()..].to_vec())
    }

    /// Does a command that succeeds; what it gives.
    #[track_caller]
    pub fn good(&mut self, raw: u16, of: &[u8], data: &[u8]) -> Vec<u8> {
        let (status, answer) = self.ask(BLOCKING, raw, of, data);
        if status != 0 {
            panic!("{raw:#06x}: status {status}, {}", self.why());
        }
        answer
    }
    /// Does one that gives nothing.
    #[track_caller]
    pub fn done(&mut self, raw: u16, of: &[u8], data: &[u8]) {
        assert_eq!(self.good(raw, of, data), b"", "{raw:#06x}");
    }
    /// Does one that fails; why.
    #[track_caller]
    pub fn bad(&mut self, raw: u16, of: &[u8], data: &[u8]) -> String {
        self.bad_in(BLOCKING, raw, of, data)
    }
    /// The same in a mode.
    #[track_caller]
    pub fn bad_in(&mut self, mode: u32, raw: u16, of: &[u8], data: &[u8]) -> String {
        let (status, answer) = self.ask(mode, raw, of, data);
        assert_eq!((status & 1, answer.len()), (1, 0), "{raw:#06x} is done");
        let why = self.why();
        assert!(why.starts_with(&format!("{raw:#06x}: ")), "{why}");
        why
    }
    /// What went wrong since this was asked last: one thing.
    #[track_caller]
    fn why(&mut self) -> String {
        let (status, answer) = self.ask(BLOCKING, 4, b"", b"");
        assert_eq!((status, int_at(&answer, 0)), (0, 1), "one error is told");
        assert_eq!(answer.last(), Some(&0));
        String::from_utf8(answer[4..answer.len() - 1].to_vec()).unwrap()
    }
    /// The object of a name.
    pub fn handle(&mut self, name: &str) -> i32 {
        int_at(&self.good(0x3001, &zero(name), b""), 0)
    }
}

fn zero(text: &str) -> Vec<u8> {
    [text.as_bytes(), &[0]].concat()
}
