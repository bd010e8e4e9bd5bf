//! What waits to be sent to a client. A slow client costs nobody but itself: of what is replaced by something newer only
//! the last is kept, and who lets too much else pile up is cut off.

use std::{
    collections::VecDeque,
    sync::{Mutex, MutexGuard, PoisonError},
};

pub use tungstenite::{Bytes, Utf8Bytes};

/// Bytes that may wait for a client.
const MOST: usize = 128 << 20;

/// A message. A clone shares what it holds: many clients may get the same.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Message {
    /// JSON
    Text(Utf8Bytes),
    /// Numbers.
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

/// The queue of a client.
#[derive(Default)]
pub struct Outbox(Mutex<State>);

impl Outbox {
    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
    /// Something that must arrive, after all before it.
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
    /// Whether the last frame has been taken: another one is welcome.
    pub fn wants_frame(&self) -> bool {
        let s = self.state();
        s.frame.is_none() && s.queue.len() < 64
    }
    /// Whether something waits that must arrive.
    pub fn waits(&self) -> bool {
        !self.state().queue.is_empty()
    }
    /// Bytes that wait and must arrive.
    pub fn bytes(&self) -> usize {
        self.state().bytes
    }
    /// A frame: sent after all that waits now.
    pub fn frame(&self, message: Message) {
        self.state().frame = Some(message);
    }
    /// The next message.
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
    /// Cuts the client off.
    pub fn cut(&self) {
        self.state().cut = true;
    }
    /// Whether it is to be cut off.
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
