//! The queue of messages to a client. A slow client affects only itself: of frames, which replace each other, only the
//! newest is queued, and a client with too many other queued messages is disconnected.

use std::{
    collections::VecDeque,
    sync::{Mutex, MutexGuard, PoisonError},
};

pub use tungstenite::{Bytes, Utf8Bytes};

/// Maximum total size of the messages queued for a client, without the frame, bytes.
const MAX_QUEUED_BYTES: usize = 128 << 20;

/// A message. Clones share its content, because many clients may receive the same message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum OutgoingMessage {
    /// A text message, which contains JSON.
    Text(Utf8Bytes),
    /// A binary message.
    Binary(Bytes),
}

impl OutgoingMessage {
    fn len(&self) -> usize {
        match self {
            OutgoingMessage::Text(t) => t.len(),
            OutgoingMessage::Binary(b) => b.len(),
        }
    }
}

#[derive(Default)]
struct OutboxState {
    queue: VecDeque<OutgoingMessage>,
    /// Total size of `queue`, bytes.
    bytes: usize,
    /// The newest frame that has not been sent.
    frame: Option<OutgoingMessage>,
    /// Whether the client must be disconnected.
    must_disconnect: bool,
}

/// The queue of messages to a client.
#[derive(Default)]
pub struct Outbox(Mutex<OutboxState>);

impl Outbox {
    fn state(&self) -> MutexGuard<'_, OutboxState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
    /// Queues a message after all others. If the queue becomes too large, discards the queue and marks the client to be
    /// disconnected instead.
    pub fn send(&self, message: OutgoingMessage) {
        let mut s = self.state();
        s.bytes += message.len();
        if s.bytes > MAX_QUEUED_BYTES {
            s.must_disconnect = true;
            s.queue.clear();
        } else {
            s.queue.push_back(message);
        }
    }
    /// Returns whether a new frame should be built: the last one has been taken, and few other messages are queued.
    pub fn wants_frame(&self) -> bool {
        let s = self.state();
        s.frame.is_none() && s.queue.len() < 64
    }
    /// Returns whether messages other than a frame are queued.
    pub fn has_queued(&self) -> bool {
        !self.state().queue.is_empty()
    }
    /// Returns the total size of the queued messages without the frame, in bytes.
    pub fn bytes(&self) -> usize {
        self.state().bytes
    }
    /// Sets the frame, which is sent when no other messages are queued. It replaces an older frame that was not sent.
    pub fn set_frame(&self, message: OutgoingMessage) {
        self.state().frame = Some(message);
    }
    /// Removes and returns the next message: a queued one, otherwise the frame.
    pub fn next(&self) -> Option<OutgoingMessage> {
        let mut s = self.state();
        match s.queue.pop_front() {
            Some(message) => {
                s.bytes -= message.len();
                Some(message)
            }
            None => s.frame.take(),
        }
    }
    /// Marks the client to be disconnected.
    pub fn disconnect(&self) {
        self.state().must_disconnect = true;
    }
    /// Returns whether the client must be disconnected.
    pub fn must_disconnect(&self) -> bool {
        self.state().must_disconnect
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_sent_last_and_slow_client_is_disconnected() {
        let out = Outbox::default();
        out.set_frame(OutgoingMessage::Binary(vec![1].into()));
        assert!(!out.wants_frame());
        out.send(OutgoingMessage::Text("first".into()));
        assert_eq!(out.next(), Some(OutgoingMessage::Text("first".into())));
        assert_eq!(out.next(), Some(OutgoingMessage::Binary(vec![1].into())));
        assert!(out.wants_frame() && out.next().is_none());
        for _ in 0..5 {
            out.send(OutgoingMessage::Binary(vec![0; 30 << 20].into()));
        }
        assert!(out.must_disconnect() && out.next().is_none());
    }
}
