//! The force on one velocity as a function of that velocity at the end of a step.
//!
//! The forces of drives, dry and viscous friction, springs and joint limits never increase with the velocity. Their
//! sum, the law, is therefore a non-increasing piecewise linear curve, some of whose pieces are vertical. The law of a
//! drive that holds a velocity is vertical at this velocity, that of dry friction at 0, and that of a limit at the
//! velocity at which the joint would pass it. Since the mass matrix is positive definite, there is exactly one set of
//! velocities at which all joints satisfy their laws.

use crate::motor::{MotorCurve, UNLIMITED_FORCE, within};

/// Number of corners for which a law of one motor has memory. At most 14 are needed: 10 of a motor (9 velocities, see
/// [`MotorCurve::corners`], and two corners at that of a vertical piece), 2 of friction, and 2 of limits.
const CORNERS: usize = 20;
/// Number of corners that each further motor adds.
const CORNERS_PER_MOTOR: usize = 10;
/// Difference of velocities, relative to 1 plus the velocity, up to which corners of several motors are one corner.
const SAME_VELOCITY: f64 = 1e-12;

/// A corner, and the slope at which the force decreases on the piece that ends at the corner; infinite if the piece is
/// vertical.
#[derive(Debug, Clone, Copy, Default)]
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
    corners: Box<[LawCorner]>,
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
    /// Returns the law of zero force, with memory for the laws of some motors.
    pub fn zero(motors: usize) -> Self {
        let corners = CORNERS + CORNERS_PER_MOTOR * motors.saturating_sub(1);
        ForceLaw { count: 1, last: 0.0, corners: vec![LawCorner::default(); corners].into() }
    }

    /// Sets this to the sum of the laws of motors.
    #[inline]
    pub fn set_motors<'a>(&mut self, motors: impl Iterator<Item = &'a MotorCurve> + Clone) {
        let mut acting = motors.clone().filter(|motor| !motor.is_off());
        match (acting.next(), acting.next()) {
            (None, _) => self.set_line(0.0, 0.0),
            (Some(motor), None) => self.set_motor(motor),
            _ => self.set_curve(motors, SAME_VELOCITY),
        }
    }

    #[inline]
    fn set_motor(&mut self, motor: &MotorCurve) {
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
            _ => self.set_curve(std::iter::once(motor), 0.0),
        }
    }

    /// Sets this to the force `at - slope v`.
    #[inline]
    pub fn set_line(&mut self, at: f64, slope: f64) {
        self.count = 0;
        self.push(0.0, at, slope);
        self.last = slope;
    }

    /// Sets this to the sum of the laws of motors, corner by corner. Corners within `tolerance` of each other, relative
    /// to 1 plus their velocity, become one.
    fn set_curve<'a>(&mut self, motors: impl Iterator<Item = &'a MotorCurve> + Clone, tolerance: f64) {
        self.count = 0;
        // Outside the corners, each force is constant, except that of a line without a bound.
        let outer: f64 = motors.clone().map(MotorCurve::unbounded_slope).sum();
        let mut after = f64::NEG_INFINITY;
        while let Some(v) = motors.clone().filter_map(|motor| motor.next_corner(after)).reduce(f64::min) {
            let ranges = motors.clone().map(|motor| motor.range_at(v));
            let (low, high) = ranges.fold((0.0, 0.0), |sum, (low, high)| (sum.0 + low, sum.1 + high));
            let slope = match self.count.checked_sub(1).map(|last| self.corners[last]) {
                None => outer,
                // The slope since the last corner must not be negative, even by rounding.
                Some(last) => ((last.force - high) / (v - last.velocity)).max(0.0),
            };
            self.push(v, high, if slope.is_finite() { slope } else { f64::INFINITY });
            if low < high {
                self.push(v, low, f64::INFINITY);
            }
            after = v + tolerance * (1.0 + v.abs());
        }
        if self.count == 0 {
            self.set_line(motors.map(|motor| motor.range_at(0.0).0).sum(), outer);
        }
        self.last = outer;
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
        if self.count + missing > self.corners.len() {
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
            if kept < self.corners.len() {
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
        if self.count < self.corners.len() {
            let i = self.count;
            self.corners[i] = LawCorner { velocity, force, slope };
            self.count += 1;
        }
    }

    /// Inserts a corner at index `i`, which splits a piece; `slope` is that of the part before the corner.
    fn insert(&mut self, i: usize, velocity: f64, force: f64, slope: f64) {
        if self.count < self.corners.len() {
            self.corners.copy_within(i..self.count, i + 1);
            self.corners[i] = LawCorner { velocity, force, slope };
            self.count += 1;
        }
    }
}
