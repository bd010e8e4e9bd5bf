//! Pending simulator messages. Each script that reads messages receives its own copy of them.

use std::collections::{BTreeMap, VecDeque};

use serde::{Deserialize, Serialize};
use tatu_plugin_api::abi::tatu_object;

/// Maximum number of queued messages; the oldest ones are dropped.
const MAX_MESSAGES: usize = 64;

/// The most recent messages, and the number of messages that each script has read.
#[derive(Default, Clone, PartialEq, Debug, Serialize, Deserialize)]
pub(crate) struct MessageQueue {
    pub(crate) last: VecDeque<(i64, [i64; 4])>,
    pub(crate) sent: u64,
    pub(crate) taken: BTreeMap<tatu_object, u64>,
    /// Number of external inputs processed so far.
    pub(crate) inputs: u64,
}

impl MessageQueue {
    pub(crate) fn send(&mut self, kind: i64, aux: [i64; 4]) {
        if self.last.len() == MAX_MESSAGES {
            self.last.pop_front();
        }
        self.last.push_back((kind, aux));
        self.sent += 1;
    }
    pub(crate) fn next(&mut self, script: tatu_object) -> Option<(i64, [i64; 4])> {
        let oldest = self.sent - self.last.len() as u64;
        let taken = self.taken.entry(script).or_default();
        *taken = (*taken).max(oldest);
        let message = *self.last.get((*taken - oldest) as usize)?;
        *taken += 1;
        Some(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_script_receives_its_own_copy_of_a_message() {
        let mut m = MessageQueue::default();
        assert_eq!(m.next(1), None);
        m.send(6, [115, 0, 0, 0]);
        for script in [1, 2] {
            assert_eq!(m.next(script), Some((6, [115, 0, 0, 0])));
            assert_eq!(m.next(script), None);
        }
    }

    #[test]
    fn oldest_messages_are_dropped() {
        let mut m = MessageQueue::default();
        for i in 0..100 {
            m.send(6, [i, 0, 0, 0]);
        }
        assert_eq!(m.next(1), Some((6, [36, 0, 0, 0])));
        assert_eq!(std::iter::from_fn(|| m.next(1)).count(), 63);
    }
}
