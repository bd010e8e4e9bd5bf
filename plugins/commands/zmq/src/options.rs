//! Options of sockets.

use crate::errors::Errno;

/// Numbers of the options that have an effect, with their names in scripts.
pub const ROUTING_ID: i64 = 5;
pub const SUBSCRIBE: i64 = 6;
pub const UNSUBSCRIBE: i64 = 7;
pub const RCVMORE: i64 = 13;
pub const EVENTS: i64 = 15;
pub const TYPE: i64 = 16;
const LINGER: i64 = 17;
const RECONNECT_IVL: i64 = 18;
pub const MAXMSGSIZE: i64 = 22;
const SNDHWM: i64 = 23;
const RCVHWM: i64 = 24;
const RCVTIMEO: i64 = 27;
const SNDTIMEO: i64 = 28;
pub const LAST_ENDPOINT: i64 = 32;
const ROUTER_MANDATORY: i64 = 33;
const IMMEDIATE: i64 = 39;
const REQ_RELAXED: i64 = 53;
const CONFLATE: i64 = 54;

/// Names and numbers of all options, except those for security, which is not supported.
pub const NAMES: &[(&str, i64)] = &[
    ("AFFINITY", 4),
    ("ROUTING_ID", ROUTING_ID),
    ("IDENTITY", ROUTING_ID),
    ("SUBSCRIBE", SUBSCRIBE),
    ("UNSUBSCRIBE", UNSUBSCRIBE),
    ("RATE", 8),
    ("RECOVERY_IVL", 9),
    ("SNDBUF", 11),
    ("RCVBUF", 12),
    ("RCVMORE", RCVMORE),
    ("FD", 14),
    ("EVENTS", EVENTS),
    ("TYPE", TYPE),
    ("LINGER", LINGER),
    ("RECONNECT_IVL", RECONNECT_IVL),
    ("BACKLOG", 19),
    ("RECONNECT_IVL_MAX", 21),
    ("MAXMSGSIZE", MAXMSGSIZE),
    ("SNDHWM", SNDHWM),
    ("RCVHWM", RCVHWM),
    ("MULTICAST_HOPS", 25),
    ("RCVTIMEO", RCVTIMEO),
    ("SNDTIMEO", SNDTIMEO),
    ("LAST_ENDPOINT", LAST_ENDPOINT),
    ("ROUTER_MANDATORY", ROUTER_MANDATORY),
    ("TCP_KEEPALIVE", 34),
    ("TCP_KEEPALIVE_CNT", 35),
    ("TCP_KEEPALIVE_IDLE", 36),
    ("TCP_KEEPALIVE_INTVL", 37),
    ("IMMEDIATE", IMMEDIATE),
    ("XPUB_VERBOSE", 40),
    ("ROUTER_RAW", 41),
    ("IPV6", 42),
    ("MECHANISM", 43),
    ("PROBE_ROUTER", 51),
    ("REQ_CORRELATE", 52),
    ("REQ_RELAXED", REQ_RELAXED),
    ("CONFLATE", CONFLATE),
    ("ROUTER_HANDOVER", 56),
    ("TOS", 57),
    ("CONNECT_ROUTING_ID", 61),
    ("HANDSHAKE_IVL", 66),
    ("XPUB_NODROP", 69),
    ("HEARTBEAT_IVL", 75),
    ("HEARTBEAT_TTL", 76),
    ("HEARTBEAT_TIMEOUT", 77),
    ("CONNECT_TIMEOUT", 79),
];

/// Options that are accepted and have no effect, because all peers are on this machine.
const IGNORED: &[i64] = &[4, 8, 9, 11, 12, 19, 21, 25, 34, 35, 36, 37, 57, 66, 75, 76, 77, 79];

/// Maximum length of a queue, in messages. It also applies if a script sets no limit (0).
const MAX_QUEUE: i64 = 10_000;

/// The options of a socket. Times are in ms; a negative timeout means no limit.
#[derive(Debug, Clone)]
pub struct Options {
    pub linger: i64,
    pub reconnect_interval: i64,
    pub max_message: i64,
    send_queue: i64,
    receive_queue: i64,
    pub receive_timeout: i64,
    pub send_timeout: i64,
    pub router_mandatory: i64,
    pub immediate: i64,
    pub relaxed: i64,
    pub conflate: i64,
    pub identity: Vec<u8>,
}

impl Default for Options {
    /// Returns the defaults of libzmq.
    fn default() -> Self {
        Options {
            linger: -1,
            reconnect_interval: 100,
            max_message: -1,
            send_queue: 1000,
            receive_queue: 1000,
            receive_timeout: -1,
            send_timeout: -1,
            router_mandatory: 0,
            immediate: 0,
            relaxed: 0,
            conflate: 0,
            identity: Vec::new(),
        }
    }
}

impl Options {
    /// Returns the maximum number of messages in the queue of outgoing messages to a peer.
    pub fn send_limit(&self) -> usize {
        Self::limit(self.send_queue)
    }
    /// Returns the maximum number of messages in the queue of incoming messages from a peer.
    pub fn receive_limit(&self) -> usize {
        Self::limit(self.receive_queue)
    }
    fn limit(set: i64) -> usize {
        usize::try_from(if set == 0 { MAX_QUEUE } else { set.clamp(1, MAX_QUEUE) }).unwrap_or(1)
    }
    fn number(&mut self, option: i64) -> Option<&mut i64> {
        Some(match option {
            LINGER => &mut self.linger,
            RECONNECT_IVL => &mut self.reconnect_interval,
            MAXMSGSIZE => &mut self.max_message,
            SNDHWM => &mut self.send_queue,
            RCVHWM => &mut self.receive_queue,
            RCVTIMEO => &mut self.receive_timeout,
            SNDTIMEO => &mut self.send_timeout,
            ROUTER_MANDATORY => &mut self.router_mandatory,
            IMMEDIATE => &mut self.immediate,
            REQ_RELAXED => &mut self.relaxed,
            CONFLATE => &mut self.conflate,
            _ => return None,
        })
    }
    /// Returns the value of a numeric option.
    pub fn get(&mut self, option: i64) -> Result<i64, Errno> {
        self.number(option).map(|value| *value).ok_or(Errno::INVALID)
    }
    /// Sets an option. A number is passed as four or eight bytes in little-endian order.
    pub fn set(&mut self, option: i64, value: &[u8]) -> Result<(), Errno> {
        if option == ROUTING_ID {
            // Identities that begin with a zero byte are reserved for those that a router assigns.
            if value.is_empty() || value.len() > 255 || value[0] == 0 {
                return Err(Errno::INVALID);
            }
            self.identity = value.to_vec();
            return Ok(());
        }
        let number = match *value {
            [a, b, c, d] => i64::from(i32::from_le_bytes([a, b, c, d])),
            _ => i64::from_le_bytes(value.try_into().map_err(|_| Errno::INVALID)?),
        };
        let lowest = if matches!(option, LINGER | RECONNECT_IVL | MAXMSGSIZE | RCVTIMEO | SNDTIMEO) { -1 } else { 0 };
        match self.number(option) {
            Some(place) if number >= lowest => *place = number,
            None if IGNORED.contains(&option) => {}
            _ => return Err(Errno::INVALID),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_set_from_bytes_and_bounded() {
        let mut options = Options::default();
        options.set(RCVTIMEO, &250_i32.to_le_bytes()).unwrap();
        options.set(MAXMSGSIZE, &9_i64.to_le_bytes()).unwrap();
        assert_eq!((options.get(RCVTIMEO), options.get(MAXMSGSIZE)), (Ok(250), Ok(9)));
        options.set(SNDHWM, &0_i32.to_le_bytes()).unwrap();
        assert_eq!((options.send_limit(), options.receive_limit()), (10_000, 1000));
        for (option, value) in
            [(RCVTIMEO, &b"abc"[..]), (SNDHWM, &[255; 4]), (ROUTING_ID, b""), (ROUTING_ID, b"\0a"), (46, &[0; 4])]
        {
            assert_eq!(options.set(option, value), Err(Errno::INVALID), "{option}");
        }
        assert_eq!(options.set(75, &[1, 0, 0, 0]), Ok(()), "heartbeats are ignored");
    }
}
