//! The state of a coordinate, its limits, and a time of constant jerk.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Position, velocity and acceleration of a coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct State {
    /// In m, rad or what the caller measures.
    pub position: f64,
    /// Its first derivative by time, s.
    pub velocity: f64,
    /// Its second derivative.
    pub acceleration: f64,
}

impl State {
    /// Returns the state of rest at a position.
    pub fn at(position: f64) -> Self {
        State { position, ..State::default() }
    }

    /// Returns the state at a position with a velocity, without acceleration.
    pub fn moving(position: f64, velocity: f64) -> Self {
        State { position, velocity, acceleration: 0.0 }
    }

    /// Returns the state at the end of a time of constant jerk that begins here.
    pub(crate) fn after(self, segment: &Segment) -> State {
        let (t, a, j) = (segment.duration, segment.acceleration, segment.jerk);
        State {
            position: self.position + t * (self.velocity + t * (a / 2.0 + t * j / 6.0)),
            velocity: self.velocity + t * (a + t * j / 2.0),
            acceleration: a + t * j,
        }
    }
}

/// A time of constant jerk.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Segment {
    /// Duration, s; 0 or more.
    pub duration: f64,
    /// Acceleration at the beginning. It differs from that at the end of the segment before only where the jerk is
    /// unlimited.
    pub acceleration: f64,
    /// Derivative of the acceleration.
    pub jerk: f64,
}

/// Smallest limit. Motions within smaller ones would take so long that their squares and cubes exceed all numbers.
const MIN_LIMIT: f64 = 1e-30;

/// Limits of a coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Least and greatest velocity; the first at most 0, the second at least 1e-30.
    pub velocity: [f64; 2],
    /// Least and greatest acceleration; the first at most -1e-30, the second at least 1e-30.
    pub acceleration: [f64; 2],
    /// Greatest jerk, at least 1e-30; infinite if the acceleration may jump.
    pub jerk: f64,
}

impl Limits {
    /// Returns limits that are equal in both directions.
    pub fn symmetric(velocity: f64, acceleration: f64, jerk: f64) -> Self {
        Limits { velocity: [-velocity, velocity], acceleration: [-acceleration, acceleration], jerk }
    }

    pub(crate) fn check(&self) -> Result<(), MotionError> {
        let [least, greatest] = self.velocity;
        if !(greatest.is_finite() && greatest >= MIN_LIMIT && least.is_finite() && least <= 0.0) {
            return Err(MotionError::Velocity(self.velocity));
        }
        let [least, greatest] = self.acceleration;
        if !(greatest.is_finite() && greatest >= MIN_LIMIT && least.is_finite() && least <= -MIN_LIMIT) {
            return Err(MotionError::Acceleration(self.acceleration));
        }
        if self.jerk.is_nan() || self.jerk < MIN_LIMIT {
            return Err(MotionError::Jerk(self.jerk));
        }
        Ok(())
    }
}

/// The reason why there is no motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MotionError {
    /// A limit of velocity has the wrong sign, is 0 where motion is needed, or is not finite.
    Velocity([f64; 2]),
    /// A limit of acceleration has the wrong sign, is 0, or is not finite.
    Acceleration([f64; 2]),
    /// The limit of jerk is not above 0.
    Jerk(f64),
    /// A position, velocity or acceleration at the start or at the target is not finite.
    State,
    /// The velocity at the target is beyond the limits.
    TargetVelocity {
        /// The velocity at the target.
        velocity: f64,
        /// The least and the greatest velocity.
        limits: [f64; 2],
    },
    /// No motion of this family takes exactly the given time, s.
    Duration(f64),
    /// No motion was found: the numbers are so far apart that rounding errors prevail.
    Unsolved,
}

impl fmt::Display for MotionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MotionError::Velocity([least, greatest]) => write!(
                f,
                "the velocity limits {least} and {greatest} are invalid: expected finite numbers, the maximum at least \
                 1e-30 and the minimum at most 0"
            ),
            MotionError::Acceleration([least, greatest]) => write!(
                f,
                "the acceleration limits {least} and {greatest} are invalid: expected finite numbers, the maximum at \
                 least 1e-30 and the minimum at most -1e-30"
            ),
            MotionError::Jerk(jerk) => write!(f, "the jerk limit {jerk} is invalid: expected at least 1e-30"),
            MotionError::State => {
                write!(f, "a position, velocity or acceleration of the start or of the target is not a finite number")
            }
            MotionError::TargetVelocity { velocity, limits: [least, greatest] } => {
                write!(f, "the target velocity {velocity} is outside of the velocity limits {least} to {greatest}")
            }
            MotionError::Duration(t) => write!(f, "no motion within the limits takes exactly {t} s"),
            MotionError::Unsolved => write!(
                f,
                "no motion was found: distances, velocities and limits differ by so many orders of magnitude that \
                 rounding errors prevail"
            ),
        }
    }
}

impl std::error::Error for MotionError {}
