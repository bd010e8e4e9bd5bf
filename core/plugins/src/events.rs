//! The host's own events, each of which docs/reference/events.md describes.

use tatu_plugin_api::{abi::*, safe::Value};

use crate::ParameterSpec;

/// Events that are expensive to collect; `*` does not include them.
pub const OPT_IN_EVENTS: &[&str] = &["collision", "separation", "contact"];
/// Events that a service receives if it does not list any.
pub const SERVICE_DEFAULTS: &[&str] = &["started", "paused", "resumed", "stopped", "fault"];
/// Subscription to all events except those in `OPT_IN_EVENTS`.
pub const ALL_EVENTS: &str = "*";

/// Returns whether a subscription to `wanted` includes the event `name`.
pub fn covers(wanted: &str, name: &str) -> bool {
    wanted == name || wanted == ALL_EVENTS && !OPT_IN_EVENTS.contains(&name)
}

/// A declared event.
#[derive(Debug, Clone, PartialEq)]
pub struct EventSpec {
    /// Index of the plugin that declares the event; `None` for the host's own events.
    pub plugin: Option<usize>,
    /// Name of the event.
    pub name: String,
    /// Description of when the event is published, in one sentence.
    pub text: String,
    /// Declared fields of the event's payload.
    pub fields: Vec<ParameterSpec>,
}

type FieldRow = (&'static str, u32, u32, Option<&'static str>, &'static str);

const TEXT: u32 = TATU_TEXT;
const M: Option<&str> = Some("m");
const N: Option<&str> = Some("N");

const OBJECT_FIELDS: [FieldRow; 3] = [
    ("object", TATU_I64, 0, None, "its handle"),
    ("path", TEXT, 0, None, "its path in the tree of objects"),
    ("kind", TEXT, 0, None, "its kind"),
];
const FAULT_FIELDS: [FieldRow; 8] = [
    ("code", TEXT, 0, None, "code of the fault: docs/reference/errors.md"),
    ("message", TEXT, 0, None, "what went wrong"),
    ("script", TEXT, 0, None, "name of the script, if a script caused it"),
    ("object", TEXT, 0, None, "path of the object, if known"),
    ("plugin", TEXT, 0, None, "id of the plugin, if known"),
    ("file", TEXT, 0, None, "file of the script, if known"),
    ("line", TATU_I64, 0, None, "line in that file"),
    (
        "traceback",
        TEXT,
        0,
        None,
        "the calls that led there, innermost first, if known: lines of the form FILE:LINE: in FUNCTION",
    ),
];
const CONTACT_FIELDS: [FieldRow; 7] = [
    ("a", TATU_OBJECT, 0, None, "a shape"),
    ("b", TATU_OBJECT, 0, None, "the other shape"),
    ("a_path", TEXT, 0, None, "path of `a`"),
    ("b_path", TEXT, 0, None, "path of `b`"),
    ("point", TATU_F64S, 3, M, "point of contact, world frame"),
    ("normal", TATU_F64S, 3, None, "unit vector from `a` to `b`"),
    ("force", TATU_F64, 0, N, "force along the normal, over the last physics step"),
];

const EVENTS: &[(&str, &str, &[FieldRow])] = &[
    ("started", "A run has begun.", &[]),
    ("paused", "Time has stopped.", &[]),
    ("resumed", "Time continues after a pause.", &[]),
    ("stopped", "A run has ended; the scene is in its state before the run.", &[]),
    ("object_added", "An object was created after the scene was opened.", &OBJECT_FIELDS),
    ("object_removed", "An object was removed.", &OBJECT_FIELDS),
    ("edited", "A person edited the scene, undid or redid an edit, or saved.", {
        const EDIT_FIELDS: [FieldRow; 3] = [
            ("undo", TEXT, 0, None, "label of the edit that would be undone next, if any"),
            ("redo", TEXT, 0, None, "label of the edit that would be redone next, if any"),
            ("unsaved", TATU_BOOL, 0, None, "whether the scene differs from its file"),
        ];
        &EDIT_FIELDS
    }),
    ("collision", "Two shapes have come into contact.", &CONTACT_FIELDS),
    ("contact", "Two shapes are in contact: once per pair and physics stage.", &CONTACT_FIELDS),
    ("separation", "Two shapes are no longer in contact.", {
        const SEPARATION_FIELDS: [FieldRow; 4] =
            [CONTACT_FIELDS[0], CONTACT_FIELDS[1], CONTACT_FIELDS[2], CONTACT_FIELDS[3]];
        &SEPARATION_FIELDS
    }),
    ("fault", "A fault occurred for the first time.", &FAULT_FIELDS),
    ("script_error", "A fault occurred in a script for the first time.", &FAULT_FIELDS),
    ("plugin_failed", "A fault occurred in a plugin for the first time.", &FAULT_FIELDS),
    ("message", "A script, a plugin or the host wrote a line to the log.", {
        const MESSAGE_FIELDS: [FieldRow; 2] =
            [("level", TEXT, 0, None, "error, warning, info, debug or status"), ("text", TEXT, 0, None, "the line")];
        &MESSAGE_FIELDS
    }),
    ("console", "A script printed text on its own console, or cleared it.", {
        const CONSOLE_FIELDS: [FieldRow; 3] = [
            ("title", TEXT, 0, None, "title of the console"),
            ("text", TEXT, 0, None, "the printed text, unchanged"),
            ("clear", TATU_BOOL, 0, None, "whether the console was cleared"),
        ];
        &CONSOLE_FIELDS
    }),
];

/// Returns the host's events.
pub fn host_events() -> Vec<EventSpec> {
    let field = |&(key, kind, count, unit, text): &FieldRow| ParameterSpec {
        key: key.into(),
        kind,
        count,
        flags: 0,
        unit: unit.map(str::to_owned),
        lowest: f64::NEG_INFINITY,
        highest: f64::INFINITY,
        fallback: Value::Nil,
        unreadable_default: false,
        choices: Vec::new(),
        keys: Vec::new(),
        keys_cut: false,
        text: text.into(),
    };
    let event = |(name, text, fields): &(&str, &str, &[FieldRow])| EventSpec {
        plugin: None,
        name: (*name).into(),
        text: (*text).into(),
        fields: fields.iter().map(field).collect(),
    };
    EVENTS.iter().map(event).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_page_has_every_event_and_field() {
        let page = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/events.md");
        let page = std::fs::read_to_string(page).unwrap();
        for event in host_events() {
            let start = format!("| `{}` |", event.name);
            let line = page.lines().find(|l| l.starts_with(&start));
            let line = line.unwrap_or_else(|| panic!("docs/reference/events.md lacks `{}`", event.name));
            for f in &event.fields {
                assert!(line.contains(&format!("`{}`", f.key)), "`{}`: the page lacks `{}`", event.name, f.key);
            }
            assert!(!event.name.contains('.'), "names with a dot belong to plugins");
        }
    }
}
