//! From one velocity to another in minimum time.

use crate::state::{Limits, Segment, State};

/// Returns the fastest change from the velocity and acceleration of `start` to the velocity `to` without acceleration.
/// The acceleration rises or falls to its limit, remains there, and returns to 0.
///
/// With an unlimited jerk the acceleration at the start has no effect.
pub(crate) fn change_velocity(start: State, to: f64, limits: &Limits) -> [Segment; 3] {
    let change = to - start.velocity;
    let jerk = limits.jerk;
    if jerk.is_infinite() {
        let acceleration = limits.acceleration[usize::from(change >= 0.0)];
        let hold = Segment { duration: change / acceleration, acceleration, jerk: 0.0 };
        return [Segment::default(), hold, Segment::default()];
    }
    // The change while the acceleration goes straight to 0 decides about the direction.
    let a = start.acceleration;
    let up = change >= a * a.abs() / (2.0 * jerk);
    // Below, everything is mirrored so that the greatest acceleration is positive.
    let sign = if up { 1.0 } else { -1.0 };
    let (change, a) = (sign * change, sign * a);
    let limit = if up { limits.acceleration[1] } else { -limits.acceleration[0] };
    let (peak, hold) = if a > limit {
        (limit, (change - a * a / (2.0 * jerk)) / limit)
    } else {
        // The change of a motion that reaches the limit and leaves it at once.
        let least = (2.0 * limit * limit - a * a) / (2.0 * jerk);
        if change >= least {
            (limit, (change - least) / limit)
        } else {
            ((jerk * change + a * a / 2.0).max(0.0).sqrt().max(a), 0.0)
        }
    };
    let first_jerk = if peak >= a { jerk } else { -jerk };
    [
        Segment { duration: (peak - a) / first_jerk, acceleration: sign * a, jerk: sign * first_jerk },
        Segment { duration: hold.max(0.0), acceleration: sign * peak, jerk: 0.0 },
        Segment { duration: peak / jerk, acceleration: sign * peak, jerk: -sign * jerk },
    ]
}

/// Returns the state after some segments.
pub(crate) fn after(start: State, segments: &[Segment]) -> State {
    segments.iter().fold(start, |state, segment| state.after(segment))
}

/// Returns the duration of some segments, s.
pub(crate) fn duration(segments: &[Segment]) -> f64 {
    segments.iter().map(|s| s.duration).sum()
}
