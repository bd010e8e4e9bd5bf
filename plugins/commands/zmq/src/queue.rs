//! Queues of messages. All queues of a world share a limit on the memory that they use.

use std::{
    collections::VecDeque,
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
};

/// The parts of a message.
pub type Message = Vec<Vec<u8>>;

/// Maximum total size of all queued messages of a world, bytes.
const MAX_QUEUED_BYTES: usize = 256 << 20;
/// Memory that a part occupies in addition to its data, bytes; an estimate.
const PART_BYTES: usize = 64;

/// Total size of all queued messages of a world, bytes.
pub type QueuedBytes = Arc<AtomicUsize>;

fn size(message: &Message) -> usize {
    message.iter().map(|part| part.len() + PART_BYTES).sum()
}

/// A queue of messages, whose size counts towards the total of its world.
pub struct Queue {
    messages: VecDeque<Message>,
    total: QueuedBytes,
}

impl Queue {
    /// Creates an empty queue.
    pub fn new(total: &QueuedBytes) -> Self {
        Queue { messages: VecDeque::new(), total: total.clone() }
    }
    /// Returns whether the queue contains fewer than `most` messages and the total size of all queues is below its
    /// limit.
    pub fn has_room(&self, most: usize) -> bool {
        self.messages.len() < most && self.total.load(Ordering::Acquire) < MAX_QUEUED_BYTES
    }
    /// Appends a message.
    pub fn push(&mut self, message: Message) {
        self.total.fetch_add(size(&message), Ordering::AcqRel);
        self.messages.push_back(message);
    }
    /// Removes and returns the oldest message, or returns `None` if the queue is empty.
    pub fn pop(&mut self) -> Option<Message> {
        let message = self.messages.pop_front()?;
        self.total.fetch_sub(size(&message), Ordering::AcqRel);
        Some(message)
    }
    /// Removes all messages.
    pub fn clear(&mut self) {
        while self.pop().is_some() {}
    }
    /// Returns whether the queue is empty.
    pub fn is_empty(&self) -> bool {
        self.messages.is_empty()
    }
}

impl Drop for Queue {
    fn drop(&mut self) {
        self.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queues_share_a_limit_and_release_their_memory() {
        let total = QueuedBytes::default();
        let (mut a, b) = (Queue::new(&total), Queue::new(&total));
        a.push(vec![vec![0; MAX_QUEUED_BYTES]]);
        assert!(!b.has_room(1));
        drop(a);
        assert!(b.has_room(1) && !b.has_room(0));
        assert_eq!(total.load(Ordering::Acquire), 0);
    }
}
