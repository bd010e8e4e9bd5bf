//! Parses messages of clients and builds answers. A message consists of a head of 18 bytes and commands. A command
//! consists of a header of 26 bytes, its subject and its data.

use std::io;

use crate::packet::invalid_message;

/// Version of the protocol, which is part of the head of each answer.
const PROTOCOL_VERSION: u8 = 11;
/// Size of the head of a message, bytes.
const HEAD_BYTES: usize = 18;
/// Size of the header of a command, bytes.
const COMMAND_HEADER_BYTES: usize = 26;

/// Modes in which a command is executed.
pub mod mode {
    /// The command is executed once.
    pub const ONESHOT: u32 = 0;
    /// The command is executed once, and the client waits for the answer.
    pub const BLOCKING: u32 = 1;
    /// The command is executed repeatedly (streamed).
    pub const STREAMING: u32 = 2;
    /// The command is sent in parts and executed once.
    pub const ONESHOT_SPLIT: u32 = 3;
    /// The command is sent in parts and executed repeatedly.
    pub const STREAMING_SPLIT: u32 = 4;
    /// Ends the repeated execution of the command with this number and subject.
    pub const DISCONTINUE: u32 = 5;
}

/// The head of a message from a client.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct MessageHead {
    /// The id of the message, which the client chooses.
    pub id: i32,
    /// The time of the client's clock, ms.
    pub time: i32,
}

/// A command, or a part of one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RemoteCommand {
    /// The number of the command in the low 16 bits, and the mode in the bits above.
    pub code: u32,
    /// The subject that the command acts on, such as a handle or a name.
    pub subject: Vec<u8>,
    /// The arguments.
    pub data: Vec<u8>,
    /// Interval between executions of a streamed command, ms.
    pub delay: u16,
    /// The offset of this part in the data of the whole command, and the size of that data, bytes.
    pub part: (usize, usize),
}

impl RemoteCommand {
    /// Returns the number of the command.
    pub fn number(&self) -> u16 {
        self.code as u16
    }
    /// Returns the mode: one of the constants in the module `mode`, if it is valid.
    pub fn mode(&self) -> u32 {
        self.code >> 16 & 7
    }
}

/// Reads an i32 at an offset, which must be in range.
fn i32_at(bytes: &[u8], at: usize) -> i32 {
    let mut four = [0; 4];
    four.copy_from_slice(&bytes[at..at + 4]);
    i32::from_le_bytes(four)
}

/// Reads a u16 at an offset, which must be in range.
fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

/// Parses a message into its head and its commands. Fails if a stated size does not match the message.
pub fn read(bytes: &[u8]) -> io::Result<(MessageHead, Vec<RemoteCommand>)> {
    if bytes.len() < HEAD_BYTES {
        return Err(invalid_message("the message is shorter than its header of 18 bytes"));
    }
    let head = MessageHead { id: i32_at(bytes, 3), time: i32_at(bytes, 7) };
    let (mut commands, mut rest) = (Vec::new(), &bytes[HEAD_BYTES..]);
    while !rest.is_empty() {
        if rest.len() < COMMAND_HEADER_BYTES {
            return Err(invalid_message("a command is shorter than its header of 26 bytes"));
        }
        let (size, full) = (i32_at(rest, 0) as usize, i32_at(rest, 4) as usize);
        let of = usize::from(u16_at(rest, 8));
        if size < COMMAND_HEADER_BYTES + of || size > rest.len() {
            return Err(invalid_message(
                "the size of a command is smaller than its header and subject, or exceeds the message",
            ));
        }
        commands.push(RemoteCommand {
            code: i32_at(rest, 14) as u32,
            subject: rest[COMMAND_HEADER_BYTES..COMMAND_HEADER_BYTES + of].to_vec(),
            data: rest[COMMAND_HEADER_BYTES + of..size].to_vec(),
            delay: u16_at(rest, 18),
            part: (i32_at(rest, 10).max(0) as usize, full.saturating_sub(COMMAND_HEADER_BYTES + of)),
        });
        rest = &rest[size..];
    }
    Ok((head, commands))
}

/// The state of the world, which the head of each answer reports.
#[derive(Debug, Clone, Copy, Default)]
pub struct WorldStatus {
    /// The time since the start of the service, ms.
    pub time: i32,
    /// The number of the scene that is served.
    pub scene: u16,
    /// Bit 0: the simulation is not stopped; bit 1: it is paused.
    pub state: u8,
}

/// Builds the head of an answer, to which answers to commands are appended. `id` is that of the newest message that was
/// executed, or -1 if the answer has no results.
pub fn head(id: i32, client_time: i32, world: WorldStatus) -> Vec<u8> {
    let mut out = vec![0, 0, PROTOCOL_VERSION];
    out.extend_from_slice(&id.to_le_bytes());
    out.extend_from_slice(&client_time.to_le_bytes());
    out.extend_from_slice(&world.time.to_le_bytes());
    out.extend_from_slice(&world.scene.to_le_bytes());
    out.push(world.state);
    out
}

/// Builds the answer to a command with this code and subject. `data` is `None` if the command failed; `time` is the
/// simulation time, ms.
pub fn answer(code: u32, of: &[u8], data: Option<&[u8]>, time: i32) -> Vec<u8> {
    let (data, status) = data.map_or((&[][..], 1), |d| (d, 0));
    let size = (COMMAND_HEADER_BYTES + of.len() + data.len()) as i32;
    let mut out = Vec::with_capacity(size as usize);
    out.extend_from_slice(&size.to_le_bytes());
    out.extend_from_slice(&size.to_le_bytes());
    out.extend_from_slice(&(of.len() as u16).to_le_bytes());
    out.extend_from_slice(&0_i32.to_le_bytes());
    out.extend_from_slice(&code.to_le_bytes());
    out.extend_from_slice(&0_u16.to_le_bytes());
    out.extend_from_slice(&time.to_le_bytes());
    out.extend_from_slice(&[status, 0]);
    out.extend_from_slice(of);
    out.extend_from_slice(data);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(hex: &str) -> Vec<u8> {
        let digits: Vec<u32> = hex.chars().filter_map(|c| c.to_digit(16)).collect();
        digits.chunks(2).map(|d| (d[0] << 4 | d[1]) as u8).collect()
    }

    #[test]
    fn a_message_of_a_real_client_is_read_and_answered() {
        // A recorded exchange: a blocking call for the handle of `Pioneer_p3dx`, answered by 17 at 1234 ms.
        let asked = bytes(
            "00000b01000000942069030000000000000027000000270000000d0000000000013001000000b67f000000d550696f6e6565725f7033647800",
        );
        let (head_of, commands) = read(&asked).unwrap();
        assert_eq!((head_of.id, commands.len()), (1, 1));
        let c = &commands[0];
        assert_eq!(
            (c.number(), c.mode(), c.subject.as_slice(), c.data.len()),
            (0x3001, mode::BLOCKING, &b"Pioneer_p3dx\0"[..], 0)
        );
        let world = WorldStatus { time: 484, scene: 1, state: 5 };
        let mut out = head(1, head_of.time, world);
        out.extend(answer(c.code, &c.subject, Some(&17_i32.to_le_bytes()), 1234));
        let expected = bytes(
            "00000b0100000094206903e40100000100052b0000002b0000000d0000000000013001000000d2040000000050696f6e6565725f703364780011000000",
        );
        assert_eq!(out, expected);
    }

    #[test]
    fn impossible_sizes_are_refused() {
        let good = bytes(
            "00000b03000000 9e206903 00000000 0000 00 1e0000001e0000000400000000000710000000000000000000 0e 00000000",
        );
        assert!(read(&good).is_ok());
        for cut in 0..good.len() {
            assert!(cut == HEAD_BYTES || read(&good[..cut]).is_err(), "{cut}");
        }
        let mut lie = good;
        lie[18] = 0xFF;
        assert!(read(&lie).is_err());
    }
}
