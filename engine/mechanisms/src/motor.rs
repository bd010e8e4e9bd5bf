//! A drive in a single step: its possible forces as a function of the velocity.

use crate::drive::ForceBound;

/// The force of a drive that holds a velocity without a force limit; it is finite so that the corners of its law are.
pub(crate) const UNLIMITED_FORCE: f64 = 1e300;

/// Maximum number of velocities between which the force of a motor is linear.
const MAX_MOTOR_CORNERS: usize = 9;

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

    /// Returns whether the force is 0 at every velocity.
    #[inline]
    pub fn is_off(&self) -> bool {
        matches!(self, MotorCurve::Line { at: 0.0, slope: 0.0, .. })
    }

    /// Returns the minimum and maximum force at a velocity, both finite.
    pub fn range_at(&self, v: f64) -> (f64, f64) {
        let (low, high) = self.range(v);
        (within(low, -UNLIMITED_FORCE, UNLIMITED_FORCE), within(high, -UNLIMITED_FORCE, UNLIMITED_FORCE))
    }

    /// Returns the slope of a line without a bound; the force of all other motors is constant beyond their corners.
    pub fn unbounded_slope(&self) -> f64 {
        match *self {
            MotorCurve::Line { slope, bound, .. } if bound.force == f64::INFINITY => slope,
            _ => 0.0,
        }
    }

    /// Returns the lowest of the velocities between which the force is linear that is greater than `after`.
    pub fn next_corner(&self, after: f64) -> Option<f64> {
        let mut corners = [0.0; MAX_MOTOR_CORNERS];
        let count = self.corners(&mut corners);
        corners[..count].iter().copied().filter(|v| *v > after).reduce(f64::min)
    }

    /// Writes the velocities, unordered, between which the force is linear, and returns their number.
    fn corners(&self, out: &mut [f64; MAX_MOTOR_CORNERS]) -> usize {
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
