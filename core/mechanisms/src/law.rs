//! The force on one velocity as a function of that velocity at the end of a step.
//!
//! Drives, dry and viscous friction, springs and joint limits all give forces that never grow with the velocity. So
//! does their sum: a falling line with corners, some of whose pieces are vertical. A drive that holds a velocity is
//! vertical there, dry friction at 0, a limit where the joint would pass it. Since the mass matrix is positive
//! definite, there is exactly one velocity at which all joints meet their laws.

use crate::motor::{Motor, within};

/// Most corners of a law: 4 of the motor's curve, 10 where a line crosses it, 2 of friction, 2 of limits; and 2 spare.
const CORNERS: usize = 20;
/// A force that no bound reaches.
pub(crate) const HUGE: f64 = 1e300;

/// A corner, and how fast the force falls on the piece that ends in it; infinite if that is vertical.
#[derive(Debug, Clone, Copy)]
struct Corner {
    velocity: f64,
    force: f64,
    slope: f64,
}

/// A law: corners by rising velocity and falling force, with a piece before, between and after them. Piece `i` ends at
/// corner `i`; the last ends nowhere.
#[derive(Debug, Clone)]
pub(crate) struct Law {
    count: usize,
    /// Slope of the last piece.
    last: f64,
    corners: [Corner; CORNERS],
}

/// What a piece asks of its velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Piece {
    /// To be this, whatever the force.
    Held(f64),
    /// To meet the force `at - slope v`.
    Line { at: f64, slope: f64 },
}

impl Law {
    /// Returns the force 0.
    pub const ZERO: Law =
        Law { count: 1, last: 0.0, corners: [Corner { velocity: 0.0, force: 0.0, slope: 0.0 }; CORNERS] };

    /// Makes this the law of a motor.
    #[inline]
    pub fn set_motor(&mut self, motor: &Motor) {
        self.count = 0;
        match *motor {
            Motor::Hold { target, bound } if bound.full_speed == f64::INFINITY => {
                let force = bound.force.min(HUGE);
                self.push(target, force, 0.0);
                self.push(target, -force, f64::INFINITY);
                self.last = 0.0;
            }
            Motor::Line { at, slope, bound } if bound.full_speed == f64::INFINITY => {
                let force = bound.force;
                if slope > 0.0 && force < HUGE {
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

    /// Makes this the force `at - slope v`.
    #[inline]
    pub fn set_line(&mut self, at: f64, slope: f64) {
        self.count = 0;
        self.push(0.0, at, slope);
        self.last = slope;
    }

    /// Makes this the law of a motor whose bound depends on the velocity.
    fn set_curve(&mut self, motor: &Motor) {
        let mut at = [0.0; CORNERS];
        let count = motor.corners(&mut at);
        let at = &mut at[..count];
        at.sort_unstable_by(f64::total_cmp);
        for (i, &v) in at.iter().enumerate() {
            let (low, high) = motor.range(v);
            let slope = if i == 0 {
                0.0
            } else {
                // the piece since the last corner; it can only fall
                ((self.corners[self.count - 1].force - high) / (v - self.corners[self.count - 1].velocity)).max(0.0)
            };
            self.push(v, high, if slope.is_finite() { slope } else { f64::INFINITY });
            if low < high {
                self.push(v, low, f64::INFINITY);
            }
        }
        // beyond its speeds a motor gives all of its force or none
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

    /// Adds dry friction, up to `most` against the motion.
    pub fn add_friction(&mut self, most: f64) {
        let before = self.below(|v| v < 0.0);
        let after = self.below(|v| v <= 0.0);
        // a vertical piece at 0 grows; otherwise one is put in
        let missing = 2usize.saturating_sub(after - before);
        if self.count + missing > CORNERS {
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

    /// Allows no velocity outside of a range: beyond, there is a force as great as it takes.
    pub fn restrict(&mut self, low: f64, high: f64) {
        if low >= high {
            self.count = 0;
            self.push(low, 0.0, f64::INFINITY);
            self.last = f64::INFINITY;
            return;
        }
        if low > f64::NEG_INFINITY {
            let gone = self.below(|v| v <= low);
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
            let kept = self.below(|v| v < high);
            let force = self.line(kept, high);
            if kept < CORNERS {
                let slope = self.slope(kept);
                self.corners[kept] = Corner { velocity: high, force, slope };
                self.count = kept + 1;
            }
            self.last = f64::INFINITY;
        }
    }

    /// Returns what a piece asks.
    #[inline]
    pub fn piece(&self, piece: usize) -> Piece {
        let (corner, slope) = (piece.saturating_sub(1), self.slope(piece));
        if slope == f64::INFINITY {
            Piece::Held(self.corners[corner].velocity)
        } else {
            Piece::Line { at: self.corners[corner].force + slope * self.corners[corner].velocity, slope }
        }
    }

    /// Returns the velocity, moved to the nearest of a piece.
    #[inline]
    pub fn nearest(&self, piece: usize, v: f64) -> f64 {
        let mut out = v;
        if piece < self.count && out > self.corners[piece].velocity {
            out = self.corners[piece].velocity;
        }
        if piece > 0 && out < self.corners[piece - 1].velocity {
            out = self.corners[piece - 1].velocity;
        }
        out
    }

    /// Returns the piece next to the given one that a solution asks for, or none if velocity and force lie on it,
    /// within the tolerances.
    #[inline]
    pub fn better(&self, piece: usize, v: f64, force: f64, tolerance: (f64, f64)) -> Option<usize> {
        let slope = self.slope(piece);
        let held = slope == f64::INFINITY;
        // on a steep piece, little velocity is much force: not more than 1000 times its tolerance
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

    /// Returns the piece on which a mass on its own would end a step: the first guess.
    ///
    /// `pull` is mass over step times velocity less the other forces, so that the mass ends where
    /// `inertia v - pull` is the law's force.
    #[inline]
    pub fn guess(&self, inertia: f64, pull: f64) -> usize {
        let ahead = |i: &usize| inertia * self.corners[*i].velocity - pull < self.corners[*i].force;
        (0..self.count).take_while(ahead).count()
    }

    /// Returns the velocities that the law allows.
    #[inline]
    pub fn domain(&self) -> (f64, f64) {
        let low = if self.slope(0) == f64::INFINITY { self.corners[0].velocity } else { f64::NEG_INFINITY };
        let end = self.count;
        let high = if self.slope(end) == f64::INFINITY { self.corners[end - 1].velocity } else { f64::INFINITY };
        (low, high)
    }

    /// Returns the force on a piece, or on the line that it is part of; at a vertical one, that of its corner.
    #[inline]
    fn line(&self, piece: usize, v: f64) -> f64 {
        match self.piece(piece) {
            Piece::Held(_) => self.corners[piece.saturating_sub(1)].force,
            Piece::Line { at, slope } => at - slope * v,
        }
    }

    /// Returns how fast the force falls on a piece.
    #[inline(always)]
    fn slope(&self, piece: usize) -> f64 {
        if piece < self.count { self.corners[piece].slope } else { self.last }
    }

    /// Returns the number of corners before the first whose velocity does not match.
    fn below(&self, matches: impl Fn(f64) -> bool) -> usize {
        self.corners[..self.count].iter().take_while(|c| matches(c.velocity)).count()
    }

    /// Appends a corner after a piece with this slope.
    #[inline]
    fn push(&mut self, velocity: f64, force: f64, slope: f64) {
        if self.count < CORNERS {
            let i = self.count;
            self.corners[i] = Corner { velocity, force, slope };
            self.count += 1;
        }
    }

    /// Puts a corner in at `i`; the piece that was split goes on behind it, and `slope` is that of the part before.
    fn insert(&mut self, i: usize, velocity: f64, force: f64, slope: f64) {
        if self.count < CORNERS {
            self.corners.copy_within(i..self.count, i + 1);
            self.corners[i] = Corner { velocity, force, slope };
            self.count += 1;
        }
    }
}
