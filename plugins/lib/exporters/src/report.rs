//! What a format cannot hold, each named once with its objects.

use std::collections::BTreeMap;

use tatu_plugin_api::safe::Value;

/// What became of a part of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The file expresses it differently, with the same effect.
    Note,
    /// The file does not hold it, or not exactly.
    Lost,
}

/// The report of an export.
#[derive(Default)]
pub struct ExportReport {
    entries: BTreeMap<(Severity, String), Vec<String>>,
    /// Sentences in the order in which they were first reported.
    order: Vec<(Severity, String)>,
}

impl ExportReport {
    /// Reports what the file expresses differently, with the same effect.
    pub fn note(&mut self, text: impl Into<String>, object: &str) {
        self.add(Severity::Note, text.into(), object);
    }

    /// Reports what the file does not hold, or not exactly.
    pub fn lost(&mut self, text: impl Into<String>, object: &str) {
        self.add(Severity::Lost, text.into(), object);
    }

    fn add(&mut self, severity: Severity, text: String, object: &str) {
        let key = (severity, text);
        if !self.entries.contains_key(&key) {
            self.order.push(key.clone());
        }
        let objects = self.entries.entry(key).or_default();
        // Properties of one object are reported one after the other.
        if !object.is_empty() && objects.last().is_none_or(|last| last != object) {
            objects.push(object.to_owned());
        }
    }

    /// Returns the report as a list of maps with `lost`, `text` and `objects`.
    pub fn value(&self) -> Value {
        let text = |s: &str| Value::text(s);
        let entry = |key: &(Severity, String)| {
            let objects = self.entries.get(key).into_iter().flatten().map(|o| text(o)).collect();
            Value::Map(vec![
                (text("lost"), Value::Bool(key.0 == Severity::Lost)),
                (text("text"), text(&key.1)),
                (text("objects"), Value::List(objects)),
            ])
        };
        Value::List(self.order.iter().map(entry).collect())
    }

    /// Returns the sentences of one severity, with the number of their objects.
    #[cfg(test)]
    fn texts(&self, severity: Severity) -> Vec<(&str, usize)> {
        let of = |key: &&(Severity, String)| key.0 == severity;
        self.order.iter().filter(of).map(|key| (key.1.as_str(), self.entries[key].len())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_sentence_is_reported_once_with_its_objects() {
        let mut report = ExportReport::default();
        report.lost("springs are left out", "/a");
        report.note("capsules are three forms", "/a");
        report.lost("springs are left out", "/b");
        report.lost("springs are left out", "/b");
        assert_eq!(report.texts(Severity::Lost), [("springs are left out", 2)]);
        assert_eq!(report.texts(Severity::Note), [("capsules are three forms", 1)]);
    }
}
