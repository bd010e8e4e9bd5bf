//! What the importer found in a file that its user should know: one report for each kind, with the number of places.

use std::cell::RefCell;

use tatu_plugin_api::{
    abi::{TATU_REPORT_NOTE, TATU_REPORT_WARNING},
    safe::Builder,
};

use crate::source::SourceText;

/// Kinds of findings, in the order in which they are reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum FindingKind {
    /// An element of the file was left out.
    Visual,
    Collision,
    Mesh,
    MeshPart,
    Material,
    Joint,
    Mimic,
    /// A value of the file was replaced.
    Namespace,
    Doubled,
    Products,
    Axis,
    Limits,
    Velocity,
    Immovable,
    StartsAtLimit,
    Mass,
    Inertia,
    /// A value that the file does not state was assumed.
    Effort,
    Armature,
    Wheel,
    /// Elements that the importer does not read.
    Unread,
}

/// The findings of one kind.
#[derive(Debug)]
struct Finding {
    kind: FindingKind,
    severity: u32,
    /// Line of the first place; 0 if it has none.
    line: u64,
    text: String,
    count: usize,
}

/// Collects findings. The first of each kind is reported with its text, the others by their number.
#[derive(Debug, Default)]
pub struct Findings(RefCell<Vec<Finding>>);

impl Findings {
    /// Adds a warning: the robot differs from what the file describes.
    pub fn warn(&self, kind: FindingKind, line: u64, text: String) {
        self.add(kind, TATU_REPORT_WARNING, line, text);
    }

    /// Adds a note: the file leaves something open, and this was assumed.
    pub fn note(&self, kind: FindingKind, line: u64, text: String) {
        self.add(kind, TATU_REPORT_NOTE, line, text);
    }

    fn add(&self, kind: FindingKind, severity: u32, line: u64, text: String) {
        let mut all = self.0.borrow_mut();
        match all.iter_mut().find(|finding| finding.kind == kind) {
            Some(known) => known.count += 1,
            None => all.push(Finding { kind, severity, line, text, count: 1 }),
        }
    }

    /// Reports all findings, with the places in the source.
    pub fn report(self, builder: &Builder<'_>, source: &SourceText<'_>) {
        let mut all = self.0.into_inner();
        all.sort_by_key(|finding| finding.kind);
        for finding in all {
            builder.report(finding.severity, None, &finding.sentence(source.origin(finding.line)));
        }
    }
}

impl Finding {
    /// Returns the report; `origin` is the file and line of the first place.
    fn sentence(&self, (file, line): (&str, u64)) -> String {
        let place = match (file, line) {
            (_, 0) => String::new(),
            ("", line) => format!("line {line}: "),
            (file, line) => format!("{file}:{line}: "),
        };
        let others = match self.count {
            1 => String::new(),
            2 => " (and in one more place)".to_owned(),
            n => format!(" (and in {} more places)", n - 1),
        };
        format!("{place}{}{others}", self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_is_one_sentence() {
        let findings = Findings::default();
        (7..10).for_each(|line| findings.warn(FindingKind::Joint, line, format!("axis {line}")));
        findings.note(FindingKind::Effort, 0, "effort".into());
        let all = findings.0.into_inner();
        let sentences: Vec<_> = all.iter().map(|f| f.sentence(("", f.line))).collect();
        assert_eq!(sentences, ["line 7: axis 7 (and in 2 more places)", "effort"]);
    }
}
