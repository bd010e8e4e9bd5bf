//! The force on one velocity as a function of that velocity at the end of a step.
//!
//! The forces of drives, dry and viscous friction, springs and joint limits never increase with the velocity. Their
//! sum, the law, is therefore a non-increasing piecewise linear curve, some of whose pieces are vertical. The law of a
//! drive that holds a velocity is vertical at this velocity, that of dry friction at 0, and that of a limit at the
//! velocity at which the joint would pass it. Since the mass matrix is positive definite, there is exactly one set of
//! velocities at which all joints satisfy their laws.

use crate::motor::{MotorCurve, within};

/// Maximum number of corners of a law. At most 13 are needed: 9 of a motor (see [`MotorCurve::corners`]), 2 of
/// friction, and 2 of limits.
const MAX_CORNERS: usize = 20;
/// The force of a drive that holds a velocity without a force limit; it is finite so that the corners of its law are.
pub(crate) const UNLIMITED_FORCE: f64 = 1e300;

/// A corner, and the slope at which the force decreases on the piece that ends at the corner; infinite if the piece is
/// vertical.
#[derive(Debug, Clone, Copy)]
struct LawCorner {
    velocity: f64,
    force: f64,
    slope: f64,
}

/// A law: corners in the order of their velocities, with forces that never increase, and pieces before, between and
/// after them. Piece `i` ends at corner `i`; the last piece is unbounded.
#[derive(Debug, Clone)]
pub(crate) struct ForceLaw {
    count: usize,
    /// Slope at which the force decreases on the last piece.
    last: f64,
    corners: [LawCorner; MAX_CORNERS],
}

/// The condition that a piece imposes on its velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum LawPiece {
    /// The velocity has this value, regardless of the force.
    Held(f64),
    /// The force is `at - slope v`.
    Line { at: f64, slope: f64 },
}

impl ForceLaw {
    /// The law of zero force.
    pub const ZERO: ForceLaw =
        ForceLaw { count: 1, last: 0.0, corners: [LawCorner { velocity: 0.0, force: 0.0, slope: 0.0 }; MAX_CORNERS] };

    /// Sets this to the law of a motor.
    #[inline]
    pub fn set_motor(&mut self, motor: &MotorCurve) {
        self.count = 0;
        match *motor {
            MotorCurve::Hold { target, bound } if bound.full_speed == f64::INFINITY => {
                let force = bound.force.min(UNLIMITED_FORCE);
                self.push(target, force, 0.0);
                self.push(target, -force, f64::INFINITY);
                self.last = 0.0;
            }
            MotorCurve::Line { at, slope, bound } if bound.full_speed == f64::INFINITY => {
                let force = bound.force;
                if slope > 0.0 && force < UNLIMITED_FORCE {
                    self.push((at - force) / slope, force, 0.0);
                    self.push((at + force) / slope, -force, slope);
                    self.last = 0.0;
                } else {
                    self.set_line(within(at, -force, force), slope);
                }
            }
            _ => self.set_curve(motor),
        }
    }

    /// Sets this to the force `at - slope v`.
    #[inline]
    pub fn set_line(&mut self, at: f64, slope: f64) {
        self.count = 0;
        self.push(0.0, at, slope);
        self.last = slope;
    }

    /// Sets this to the law of a motor whose bound depends on the velocity.
    fn set_curve(&mut self, motor: &MotorCurve) {
        let mut at = [0.0; MAX_CORNERS];
        let count = motor.corners(&mut at);
        let at = &mut at[..count];
        at.sort_unstable_by(f64::total_cmp);
        for (i, &v) in at.iter().enumerate() {
            let (low, high) = motor.range(v);
            let slope = if i == 0 {
                0.0
            } else {
                // The slope since the last corner must not be negative, even by rounding.
                ((self.corners[self.count - 1].force - high) / (v - self.corners[self.count - 1].velocity)).max(0.0)
            };
            self.push(v, high, if slope.is_finite() { slope } else { f64::INFINITY });
            if low < high {
                self.push(v, low, f64::INFINITY);
            }
        }
        // Outside its range of speeds, the force of a motor is constant: its maximum or 0.
        self.last = 0.0;
    }

    /// Adds the force `at - slope v`.
    #[inline]
    pub fn add_line(&mut self, at: f64, slope: f64) {
        for corner in &mut self.corners[..self.count] {
            corner.force += at - slope * corner.velocity;
            corner.slope += slope;
        }
        self.last += slope;
    }

    /// Adds dry friction, which opposes the motion with the force `most`, and holds the joint at rest with up to that
    /// force.
    pub fn add_friction(&mut self, most: f64) {
        let before = self.count_before(|v| v < 0.0);
        let after = self.count_before(|v| v <= 0.0);
        // A vertical piece at velocity 0 is extended; without one, it is inserted.
        let missing = 2usize.saturating_sub(after - before);
        if self.count + missing > MAX_CORNERS {
            return;
        }
        if missing == 2 {
            let (force, slope) = (self.line(before, 0.0), self.slope(before));
            self.insert(before, 0.0, force, slope);
            self.insert(before + 1, 0.0, force, f64::INFINITY);
        } else if missing == 1 {
            self.insert(before + 1, 0.0, self.corners[before].force, f64::INFINITY);
        }
        for corner in &mut self.corners[..=before] {
            corner.force += most;
        }
        for corner in &mut self.corners[after + missing - 1..self.count] {
            corner.force -= most;
        }
    }

    /// Restricts the velocity to a range, at whose ends the law becomes vertical.
    pub fn restrict(&mut self, low: f64, high: f64) {
        if low >= high {
            self.count = 0;
            self.push(low, 0.0, f64::INFINITY);
            self.last = f64::INFINITY;
            return;
        }
        if low > f64::NEG_INFINITY {
            let gone = self.count_before(|v| v <= low);
            let force = self.line(gone, low);
            if gone == 0 {
                self.insert(0, low, force, f64::INFINITY);
            } else {
                let shift = gone - 1;
                self.corners.copy_within(shift..self.count, 0);
                self.count -= shift;
                (self.corners[0].velocity, self.corners[0].force) = (low, force);
            }
            self.corners[0].slope = f64::INFINITY;
        }
        if high < f64::INFINITY {
            let kept = self.count_before(|v| v < high);
            let force = self.line(kept, high);
            if kept < MAX_CORNERS {
                let slope = self.slope(kept);
                self.corners[kept] = LawCorner { velocity: high, force, slope };
                self.count = kept + 1;
            }
            self.last = f64::INFINITY;
        }
    }

    /// Returns the condition of a piece.
    #[inline]
    pub fn piece(&self, piece: usize) -> LawPiece {
        let (corner, slope) = (piece.saturating_sub(1), self.slope(piece));
        if slope == f64::INFINITY {
            LawPiece::Held(self.corners[corner].velocity)
        } else {
            LawPiece::Line { at: self.corners[corner].force + slope * self.corners[corner].velocity, slope }
        }
    }

    /// Returns the velocity on a piece that is nearest to `v`.
    #[inline]
    pub fn clamp_to_piece(&self, piece: usize, v: f64) -> f64 {
        let mut out = v;
        if piece < self.count && out > self.corners[piece].velocity {
            out = self.corners[piece].velocity;
        }
        if piece > 0 && out < self.corners[piece - 1].velocity {
            out = self.corners[piece - 1].velocity;
        }
        out
    }

    /// Returns the piece next to the given one, on the side on which a solution is, or `None` if the velocity and force
    /// of the solution are on the given piece, within the tolerances (of the velocity, then of the force).
    #[inline]
    pub fn adjacent_piece(&self, piece: usize, v: f64, force: f64, tolerance: (f64, f64)) -> Option<usize> {
        let slope = self.slope(piece);
        let held = slope == f64::INFINITY;
        // On a steep piece, a small error of velocity is a large error of force; limit it to 1000 times the tolerance.
        let slack = tolerance.0.min(1e3 * tolerance.1 / slope + 1e-15 * v.abs());
        if piece < self.count {
            let beyond = if held {
                force < self.corners[piece].force - tolerance.1
            } else {
                v > self.corners[piece].velocity + slack
            };
            if beyond {
                return Some(piece + 1);
            }
        }
        if piece > 0 {
            let beyond = if held {
                force > self.corners[piece - 1].force + tolerance.1
            } else {
                v < self.corners[piece - 1].velocity - slack
            };
            if beyond {
                return Some(piece - 1);
            }
        }
        None
    }

    /// Returns a first guess of the piece: that on which an isolated mass would be at the end of a step.
    ///
    /// `inertia` is mass divided by step duration, and `pull` is `inertia` times the old velocity minus the bias force.
    /// At the new velocity `v`, the law's force equals `inertia v - pull`.
    #[inline]
    pub fn guess(&self, inertia: f64, pull: f64) -> usize {
        let ahead = |i: &usize| inertia * self.corners[*i].velocity - pull < self.corners[*i].force;
        (0..self.count).take_while(ahead).count()
    }

    /// Returns the minimum and maximum velocity that the law allows.
    #[inline]
    pub fn velocity_range(&self) -> (f64, f64) {
        let low = if self.slope(0) == f64::INFINITY { self.corners[0].velocity } else { f64::NEG_INFINITY };
        let end = self.count;
        let high = if self.slope(end) == f64::INFINITY { self.corners[end - 1].velocity } else { f64::INFINITY };
        (low, high)
    }

    /// Returns the force at `v` on a piece or its extension; for a vertical piece, that of its corner.
    #[inline]
    fn line(&self, piece: usize, v: f64) -> f64 {
        match self.piece(piece) {
            LawPiece::Held(_) => self.corners[piece.saturating_sub(1)].force,
            LawPiece::Line { at, slope } => at - slope * v,
        }
    }

    /// Returns the slope at which the force decreases on a piece.
    #[inline(always)]
    fn slope(&self, piece: usize) -> f64 {
        if piece < self.count { self.corners[piece].slope } else { self.last }
    }

    /// Returns the number of corners before the first one whose velocity does not match.
    fn count_before(&self, matches: impl Fn(f64) -> bool) -> usize {
        self.corners[..self.count].iter().take_while(|c| matches(c.velocity)).count()
    }

    /// Appends a corner after a piece with this slope.
    #[inline]
    fn push(&mut self, velocity: f64, force: f64, slope: f64) {
        if self.count < MAX_CORNERS {
            let i = self.count;
            self.corners[i] = LawCorner { velocity, force, slope };
            self.count += 1;
        }
    }

    /// Inserts a corner at index `i`, which splits a piece; `slope` is that of the part before the corner.
    fn insert(&mut self, i: usize, velocity: f64, force: f64, slope: f64) {
        if self.count < MAX_CORNERS {
            self.corners.copy_within(i..self.count, i + 1);
            self.corners[i] = LawCorner { velocity, force, slope };
            self.count += 1;
        }
    }
}
