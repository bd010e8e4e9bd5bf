//! What deserves mention although the file could be expanded.

use crate::error::Origin;

/// Maximum number of different messages of a file.
const MAX_MESSAGES: usize = 100;

/// Notes of one kind, with places as offsets.
#[derive(Debug)]
pub(crate) struct RawNote {
    kind: String,
    pub message: String,
    pub count: usize,
    pub first: Option<Origin>,
}

/// All notes, in the order of their first cases.
#[derive(Debug, Default)]
pub(crate) struct Notes {
    pub list: Vec<RawNote>,
}

impl Notes {
    /// Records a case of a kind; the message is that of the first one.
    pub fn add(&mut self, kind: &str, message: &str, origin: Option<Origin>) {
        if let Some(note) = self.list.iter_mut().find(|note| note.kind == kind) {
            note.count += 1;
        } else if self.list.len() < MAX_MESSAGES {
            self.list.push(RawNote { kind: kind.to_owned(), message: message.to_owned(), count: 1, first: origin });
        }
    }
}
