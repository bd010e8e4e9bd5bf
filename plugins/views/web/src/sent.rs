//! Remembers what a client has received last, so that data are sent again only when they have changed.

use std::{
    collections::BTreeMap,
    hash::{DefaultHasher, Hash, Hasher},
};

use tatu_services_common::outbox::OutgoingMessage;

/// The subject of a message that is repeated when its content changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    Image,
    Depth,
    Graph,
    Details,
    Overlays,
}

/// Digests of the messages that a client has received last, by their subject and the handle of their object.
#[derive(Default)]
pub struct SentMessages(BTreeMap<(Subject, u32), u64>);

impl SentMessages {
    /// Returns whether a message differs from the last one with this subject and object, and remembers it.
    pub fn is_new(&mut self, subject: Subject, object: u32, message: &OutgoingMessage) -> bool {
        let mut hasher = DefaultHasher::new();
        match message {
            OutgoingMessage::Text(text) => text.as_str().hash(&mut hasher),
            OutgoingMessage::Binary(bytes) => bytes.hash(&mut hasher),
        }
        let digest = hasher.finish();
        self.0.insert((subject, object), digest) != Some(digest)
    }

    /// Forgets the messages with this subject, so that the next ones are sent.
    pub fn forget(&mut self, subject: Subject) {
        self.0.retain(|(of, _), _| *of != subject);
    }

    /// Forgets all messages.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_new_messages_are_sent() {
        let mut sent = SentMessages::default();
        let message = |text: &'static str| OutgoingMessage::Text(text.into());
        assert!(sent.is_new(Subject::Graph, 1, &message("a")));
        assert!(!sent.is_new(Subject::Graph, 1, &message("a")));
        assert!(sent.is_new(Subject::Graph, 2, &message("a")) && sent.is_new(Subject::Details, 1, &message("a")));
        assert!(sent.is_new(Subject::Graph, 1, &message("b")));
        sent.forget(Subject::Graph);
        assert!(sent.is_new(Subject::Graph, 1, &message("b")) && !sent.is_new(Subject::Details, 1, &message("a")));
    }
}
