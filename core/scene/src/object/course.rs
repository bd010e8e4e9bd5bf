//! Smooth trajectories of position targets between scene steps.

use serde::{Deserialize, Serialize};

/// The trajectory of a position target, a uniform quadratic B-spline.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TargetSpline {
    /// Control points: the targets of the last three scene steps, rad or m, newest last.
    pub points: [f64; 3],
    /// Whether a target was set between physics steps; it is then applied directly, and the trajectory is not smooth.
    pub direct: bool,
}

impl TargetSpline {
    pub(crate) fn at(target: f64) -> Self {
        TargetSpline { points: [target; 3], direct: false }
    }

    /// Returns the trajectory for the next scene step, whose newest control point is `target`.
    pub(crate) fn next(self, target: f64) -> Self {
        let [_, a, b] = self.points;
        if self.direct { TargetSpline::at(target) } else { TargetSpline { points: [a, b, target], direct: false } }
    }

    /// Returns whether the target is still moving.
    pub fn is_moving(&self) -> bool {
        let [a, b, c] = self.points;
        a != b || b != c
    }

    /// Returns the target after a fraction of the scene step, 0 to 1.
    pub(crate) fn target(&self, share: f64) -> f64 {
        let [a, b, c] = self.points;
        let rest = 1.0 - share;
        b + 0.5 * (rest * rest * (a - b) + share * share * (c - b))
    }

    /// Returns the rate of the target after a fraction of the scene step, 0 to 1, per scene step.
    pub(crate) fn rate(&self, share: f64) -> f64 {
        let [a, b, c] = self.points;
        (1.0 - share) * (b - a) + share * (c - b)
    }
}
