//! A drive in a single step: its possible forces as a function of the velocity.

use crate::drive::ForceBound;

/// A drive at a fixed position, whose force depends only on the velocity.
#[derive(Debug, Clone, Copy)]
pub(crate) enum MotorCurve {
    /// Exerts any force within the bound at the target velocity, and the maximum force towards it at all other
    /// velocities.
    Hold { target: f64, bound: ForceBound },
    /// The force `at - slope v`, limited to the bound.
    Line { at: f64, slope: f64, bound: ForceBound },
}

impl MotorCurve {
    /// No drive.
    pub const OFF: MotorCurve = MotorCurve::Line { at: 0.0, slope: 0.0, bound: ForceBound::NONE };

    /// Returns the minimum and maximum force at a velocity, which differ only at a held target.
    #[inline]
    pub fn range(&self, v: f64) -> (f64, f64) {
        match *self {
            MotorCurve::Hold { target, bound } => {
                let (low, high) = bound.range(v);
                (if v < target { high } else { low }, if v > target { low } else { high })
            }
            MotorCurve::Line { at, slope, bound } => {
                let (low, high) = bound.range(v);
                let force = within(at - slope * v, low, high);
                (force, force)
            }
        }
    }

    /// Writes the velocities, unordered, between which the force is linear, and returns their number, at most 9. The
    /// bound must depend on the velocity.
    pub fn corners(&self, out: &mut [f64]) -> usize {
        let (MotorCurve::Hold { bound, .. } | MotorCurve::Line { bound, .. }) = *self;
        let (full, none) = (bound.full_speed, bound.no_load_speed);
        let ends = [-none, -full, full, none];
        let mut count = 0;
        let mut push = |v: f64| {
            // A full speed of 0 would yield the same corner twice.
            if count < out.len() && v.is_finite() && !out[..count].contains(&v) {
                out[count] = v;
                count += 1;
            }
        };
        ends.iter().for_each(|v| push(*v));
        match *self {
            MotorCurve::Hold { target, .. } => push(target),
            MotorCurve::Line { at, slope, .. } => {
                let fall = bound.force / (none - full);
                // Intersections of the line with the constant and the decreasing parts of the bound.
                for force in [bound.force, -bound.force, 0.0] {
                    push((at - force) / slope);
                }
                push((at - fall * none) / (slope - fall));
                push((at + fall * none) / (slope - fall));
            }
        }
        count
    }
}

/// Returns the value in a range that is nearest to `x`. Unlike `clamp`, it does not panic if an end is NaN because of
/// an overflow.
#[inline(always)]
pub(crate) fn within(x: f64, low: f64, high: f64) -> f64 {
    let x = if x < low { low } else { x };
    if x > high { high } else { x }
}

impl ForceBound {
    /// Returns the minimum and maximum force at a velocity.
    #[inline]
    pub(crate) fn range(&self, v: f64) -> (f64, f64) {
        if self.full_speed == f64::INFINITY {
            return (-self.force, self.force);
        }
        let fall = 1.0 / (self.no_load_speed - self.full_speed);
        let share = |v: f64| ((self.no_load_speed - v) * fall).clamp(0.0, 1.0);
        (-self.force * share(-v), self.force * share(v))
    }
}
