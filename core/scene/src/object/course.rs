//! The way of a position target between scene steps.

use serde::{Deserialize, Serialize};

/// The way of a position target.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Course {
    /// The targets of the last three scene steps, rad or m, the newest one last.
    pub points: [f64; 3],
    /// Whether a target came between physics steps.
    pub direct: bool,
}

impl Course {
    pub(crate) fn at(target: f64) -> Self {
        Course { points: [target; 3], direct: false }
    }

    /// With the next scene step.
    pub(crate) fn next(self, target: f64) -> Self {
        let [_, a, b] = self.points;
        if self.direct { Course::at(target) } else { Course { points: [a, b, target], direct: false } }
    }

    /// Whether it is not yet where it leads to.
    pub fn under_way(&self) -> bool {
        let [a, b, c] = self.points;
        a != b || b != c
    }

    /// The target when a share of the scene step has passed.
    pub(crate) fn target(&self, share: f64) -> f64 {
        let [a, b, c] = self.points;
        let rest = 1.0 - share;
        b + 0.5 * (rest * rest * (a - b) + share * share * (c - b))
    }
}
