//! One drive at one instant: the forces that it can give at a velocity.

use crate::drive::Bound;

/// A drive with its position put in.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Motor {
    /// Any force of its bound at the target, all of it elsewhere.
    Hold { target: f64, bound: Bound },
    /// The force `at - slope v`, within its bound.
    Line { at: f64, slope: f64, bound: Bound },
}

impl Motor {
    /// No drive.
    pub const OFF: Motor = Motor::Line { at: 0.0, slope: 0.0, bound: Bound::NONE };

    /// Returns the least and the greatest force that it can give at a velocity; they differ at a held target only.
    #[inline]
    pub fn range(&self, v: f64) -> (f64, f64) {
        match *self {
            Motor::Hold { target, bound } => {
                let (low, high) = bound.range(v);
                (if v < target { high } else { low }, if v > target { low } else { high })
            }
            Motor::Line { at, slope, bound } => {
                let (low, high) = bound.range(v);
                let force = within(at - slope * v, low, high);
                (force, force)
            }
        }
    }

    /// Writes the velocities, in no order, between which its force is a line, and returns how many there are: 14 at
    /// most. Its bound must depend on the velocity.
    pub fn corners(&self, out: &mut [f64]) -> usize {
        let (Motor::Hold { bound, .. } | Motor::Line { bound, .. }) = *self;
        let (full, none) = (bound.full_speed, bound.no_load_speed);
        let ends = [-none, -full, full, none];
        let mut count = 0;
        let mut push = |v: f64| {
            // a speed of 0 gives the same end twice
            if count < out.len() && v.is_finite() && !out[..count].contains(&v) {
                out[count] = v;
                count += 1;
            }
        };
        ends.iter().for_each(|v| push(*v));
        match *self {
            Motor::Hold { target, .. } => push(target),
            Motor::Line { at, slope, .. } => {
                let fall = bound.force / (none - full);
                // where it crosses a flat part, and where a falling one
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

/// Returns the nearest number of a range. Unlike `clamp`, it does not panic where overflow made an end not a number.
#[inline(always)]
pub(crate) fn within(x: f64, low: f64, high: f64) -> f64 {
    let x = if x < low { low } else { x };
    if x > high { high } else { x }
}

impl Bound {
    /// Returns the least and the greatest force at a velocity.
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
