//! The queue of messages to a client. A slow client only affects itself: of replaceable messages only the newest is
//! queued, and a client for which too many other messages accumulate is disconnected.

use std::{
    collections::VecDeque,
    sync::{Mutex, MutexGuard, PoisonError},
};

pub use tungstenite::{Bytes, Utf8Bytes};

/// Maximum size of the messages queued for a client, bytes.
const MOST: usize = 128 << 20;

/// A message. Clones share its content, because many clients may receive the same message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Message {
    /// JSON.
    Text(Utf8Bytes),
    /// Binary data.
    Binary(Bytes),
}

impl Message {
    fn len(&self) -> usize {
        match self {
            Message::Text(t) => t.len(),
            Message::Binary(b) => b.len(),
        }
    }
}

#[derive(Default)]
struct State {
    queue: VecDeque<Message>,
    bytes: usize,
    frame: Option<Message>,
    cut: bool,
}

/// The queue of messages to a client.
#[derive(Default)]
pub struct Outbox(Mutex<State>);

impl Outbox {
    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
    /// Queues a message that must be delivered, after all others.
    pub fn send(&self, message: Message) {
        let mut s = self.state();
        s.bytes += message.len();
        if s.bytes > MOST {
            s.cut = true;
            s.queue.clear();
        } else {
            s.queue.push_back(message);
        }
    }
    /// Returns whether the last frame has been taken, so that a new one may be queued.
    pub fn wants_frame(&self) -> bool {
        let s = self.state();
        s.frame.is_none() && s.queue.len() < 64
    }
    /// Returns whether messages that must be delivered are queued.
    pub fn waits(&self) -> bool {
        !self.state().queue.is_empty()
    }
    /// Returns the size of the queued messages that must be delivered, in bytes.
    pub fn bytes(&self) -> usize {
        self.state().bytes
    }
    /// Sets the frame to be sent after all messages now queued; it replaces an older one.
    pub fn frame(&self, message: Message) {
        self.state().frame = Some(message);
    }
    /// Removes and returns the next message.
    pub fn next(&self) -> Option<Message> {
        let mut s = self.state();
        match s.queue.pop_front() {
            Some(message) => {
                s.bytes -= message.len();
                Some(message)
            }
            None => s.frame.take(),
        }
    }
    /// Disconnects the client.
    pub fn cut(&self) {
        self.state().cut = true;
    }
    /// Returns whether the client must be disconnected.
    pub fn is_cut(&self) -> bool {
        self.state().cut
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_come_last_and_who_does_not_read_is_cut_off() {
        let out = Outbox::default();
        out.frame(Message::Binary(vec![1].into()));
        assert!(!out.wants_frame());
        out.send(Message::Text("first".into()));
        assert_eq!(out.next(), Some(Message::Text("first".into())));
        assert_eq!(out.next(), Some(Message::Binary(vec![1].into())));
        assert!(out.wants_frame() && out.next().is_none());
        for _ in 0..5 {
            out.send(Message::Binary(vec![0; 30 << 20].into()));
        }
        assert!(out.is_cut() && out.next().is_none());
    }
}
