//! What the importer found in a file that its user should know: one report for each kind, with the number of places.

use std::cell::RefCell;

use tatu_plugin_api::{
    abi::{TATU_REPORT_NOTE, TATU_REPORT_WARNING},
    safe::Builder,
};

/// Kinds of findings, in the order in which they are reported: what was left out, replaced, and assumed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum FindingKind {
    /// A file that another one includes.
    Include,
    /// What concerns the whole world.
    World,
    /// A visual.
    Visual,
    /// A collision.
    Collision,
    /// A mesh file.
    Mesh,
    /// A part of a mesh file.
    MeshPart,
    /// A colour or an image.
    Material,
    /// A joint.
    Joint,
    /// A joint that closes a loop.
    Loop,
    /// A joint with two axes.
    TwoAxes,
    /// A coupling of joints.
    Mimic,
    /// A sensor, or a light.
    Sensor,
    /// Noise of a sensor.
    Noise,
    /// A plugin of another simulator.
    Plugin,
    /// A link on which no forces act.
    Gravity,
    /// An undeclared prefix.
    Namespace,
    /// An element or a name that occurs twice.
    Doubled,
    /// Friction that depends on the direction.
    FrictionAxis,
    /// Products of inertia.
    Products,
    /// The axis of a joint.
    Axis,
    /// Limits of a joint.
    Limits,
    /// The greatest speed of a joint.
    Velocity,
    /// A joint whose limits are equal.
    Immovable,
    /// A joint that does not start at 0.
    StartsAtLimit,
    /// A link without mass.
    Mass,
    /// An impossible inertia.
    Inertia,
    /// An inertia that is computed from forms.
    ComputedInertia,
    /// The effort of a motor.
    Effort,
    /// Joints without a motor.
    Motor,
    /// The inertia of a motor.
    Armature,
    /// Links that do not collide with each other.
    SelfCollision,
    /// A wheel that collides as a sphere.
    Wheel,
    /// Elements that the importer does not read.
    Unread,
}

/// Number of findings from which on those of one kind are only counted.
const MAX_FINDINGS: usize = 100;

impl FindingKind {
    /// Returns whether all findings of this kind are reported, rather than the first one and the number of others.
    fn is_listed(self) -> bool {
        use FindingKind::{Gravity, Include, Plugin, Sensor, World};
        matches!(self, Gravity | Include | Plugin | Sensor | World)
    }
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
        // Findings of these kinds are about different things, unless their texts are equal.
        let differs = all.len() < MAX_FINDINGS && kind.is_listed();
        match all.iter_mut().find(|finding| finding.kind == kind && (!differs || finding.text == text)) {
            Some(known) => known.count += 1,
            None => all.push(Finding { kind, severity, line, text, count: 1 }),
        }
    }

    /// Reports all findings. `origin` returns the file and line from which a line comes; the name of the imported file
    /// itself is empty.
    pub fn report<'s>(self, builder: &Builder<'_>, origin: impl Fn(u64) -> (&'s str, u64)) {
        let mut all = self.0.into_inner();
        all.sort_by_key(|finding| finding.kind);
        for finding in all {
            builder.report(finding.severity, None, &finding.sentence(origin(finding.line)));
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
