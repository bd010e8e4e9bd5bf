//! Collects what the importer changed or omitted: one message for each kind, with the number of elements.

use std::collections::BTreeMap;

use tatu_plugin_api::{
    abi::{TATU_REPORT_NOTE, TATU_REPORT_WARNING},
    safe::{Builder, Value},
};

use crate::xml::Place;

/// Maximum number of different messages.
const MAX_MESSAGES: usize = 200;

/// Messages in the order in which they first occurred.
#[derive(Default)]
pub struct ImportReport {
    lines: Vec<(u32, String, usize, Option<Place>)>,
    index: BTreeMap<(u32, String), usize>,
}

impl ImportReport {
    /// Adds a note: the scene behaves as the file describes, or differs in its looks.
    pub fn note(&mut self, place: &Place, text: impl Into<String>) {
        self.add(TATU_REPORT_NOTE, Some(place), text.into());
    }
    /// Adds a warning: the scene behaves differently from what the file describes.
    pub fn warn(&mut self, place: &Place, text: impl Into<String>) {
        self.add(TATU_REPORT_WARNING, Some(place), text.into());
    }
    /// Adds a note about the file as a whole.
    pub fn note_file(&mut self, text: impl Into<String>) {
        self.add(TATU_REPORT_NOTE, None, text.into());
    }
    /// Adds a warning about the file as a whole.
    pub fn warn_file(&mut self, text: impl Into<String>) {
        self.add(TATU_REPORT_WARNING, None, text.into());
    }

    fn add(&mut self, severity: u32, place: Option<&Place>, text: String) {
        let next = self.lines.len();
        let (text, place) = match next >= MAX_MESSAGES && !self.index.contains_key(&(severity, text.clone())) {
            true => ("other elements and attributes are omitted".to_owned(), None),
            false => (text, place),
        };
        let at = *self.index.entry((severity, text.clone())).or_insert(next);
        match self.lines.get_mut(at) {
            Some(line) => line.2 += 1,
            None => self.lines.push((severity, text, 1, place.cloned())),
        }
    }

    fn texts(&self) -> impl Iterator<Item = (u32, String)> {
        self.lines.iter().map(|(severity, text, count, place)| {
            let text = match (count, place) {
                (_, None) => text.clone(),
                (1, Some(place)) => format!("{text} ({place})"),
                (n, Some(place)) => format!("{text} ({n} times, first in {place})"),
            };
            (*severity, text)
        })
    }

    /// Prints all messages.
    pub fn print(&self, builder: &Builder<'_>) {
        self.texts().for_each(|(severity, text)| builder.report(severity, None, &text));
    }

    /// Returns all messages, for the description of the file.
    pub fn value(&self) -> Value {
        Value::List(self.texts().map(|(_, text)| Value::text(text)).collect())
    }
}
