//! A motion of several coordinates that a script or a waiting thread advances.

use serde::{Deserialize, Serialize};
use tatu_trajectories::{Limits, MotionError, State, Synchronization, Trajectory};

use crate::kit::{Fail, Result};

/// Positions, velocities and accelerations of all coordinates.
pub(crate) type MotionState = [Vec<f64>; 3];

/// Limits as scripts state them: a list for each kind, with an element for each coordinate. An element that is missing,
/// not finite or not positive does not limit.
#[derive(Default)]
pub(crate) struct LimitLists {
    pub(crate) velocity: Vec<f64>,
    pub(crate) acceleration: Vec<f64>,
    pub(crate) jerk: Vec<f64>,
    /// Limits towards lower positions, as negative numbers; empty if they equal those above.
    pub(crate) min_velocity: Vec<f64>,
    pub(crate) min_acceleration: Vec<f64>,
}

/// Velocity or acceleration of a coordinate that no list limits.
const UNLIMITED: f64 = 1e9;

impl LimitLists {
    pub(crate) fn symmetric(velocity: Vec<f64>, acceleration: Vec<f64>, jerk: Vec<f64>) -> Self {
        LimitLists { velocity, acceleration, jerk, ..LimitLists::default() }
    }

    fn of(&self, k: usize) -> Limits {
        let positive = |list: &[f64]| list.get(k).copied().filter(|x| x.is_finite() && *x > 0.0);
        let both = |greatest: &[f64], least: &[f64]| {
            let greatest = positive(greatest).unwrap_or(UNLIMITED).min(UNLIMITED);
            [least.get(k).copied().filter(|x| x.is_finite() && *x < 0.0).unwrap_or(-greatest), greatest]
        };
        Limits {
            velocity: both(&self.velocity, &self.min_velocity),
            acceleration: both(&self.acceleration, &self.min_acceleration),
            jerk: positive(&self.jerk).unwrap_or(f64::INFINITY),
        }
    }
}

/// Returns states from lists of positions, velocities and accelerations; missing elements are 0.
pub(crate) fn states(count: usize, lists: [&[f64]; 3]) -> Vec<State> {
    let of = |list: &[f64], k: usize| list.get(k).copied().unwrap_or(0.0);
    let state = |k| State { position: of(lists[0], k), velocity: of(lists[1], k), acceleration: of(lists[2], k) };
    (0..count).map(state).collect()
}

/// Interprets the flags of scripts; `default` applies to -1 and nil.
pub(crate) fn synchronization(flags: i64, default: Synchronization) -> Synchronization {
    match flags {
        ..0 => default,
        _ => match flags & 3 {
            1 => Synchronization::Time,
            3 => Synchronization::None,
            _ => Synchronization::Phase,
        },
    }
}

/// A motion and the time since its start.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct MotionProfile {
    trajectory: Trajectory,
    /// s.
    time: f64,
}

/// Arrival times that differ by less, s, are equal.
const TIME_TOLERANCE: f64 = 1e-9;

impl MotionProfile {
    /// Computes the motion to positions.
    pub(crate) fn to(
        starts: &[State],
        targets: &[State],
        limits: &LimitLists,
        synchronization: Synchronization,
    ) -> Result<MotionProfile> {
        let limits: Vec<Limits> = (0..starts.len()).map(|k| limits.of(k)).collect();
        let trajectory = Trajectory::to_positions(starts, targets, &limits, synchronization).map_err(refused)?;
        Ok(MotionProfile { trajectory, time: 0.0 })
    }

    /// Computes the motion to velocities, which last.
    pub(crate) fn to_velocities(
        starts: &[State],
        velocities: &[f64],
        limits: &LimitLists,
        synchronization: Synchronization,
    ) -> Result<MotionProfile> {
        let limits: Vec<Limits> = (0..starts.len()).map(|k| limits.of(k)).collect();
        let trajectory = Trajectory::to_velocities(starts, velocities, &limits, synchronization).map_err(refused)?;
        Ok(MotionProfile { trajectory, time: 0.0 })
    }

    /// Advances the motion by `dt`, s. Returns whether the target has been reached.
    pub(crate) fn advance(&mut self, dt: f64) -> bool {
        self.time += dt;
        self.has_arrived()
    }

    /// Advances the motion by `dt` (s) in cycles, and ends with the first cycle in which the target is reached.
    pub(crate) fn advance_in_cycles(&mut self, dt: f64, cycle: f64) -> bool {
        let left = self.left();
        if left > TIME_TOLERANCE && left < dt && cycle > 0.0 {
            let cycles = ((left - TIME_TOLERANCE) / cycle).ceil();
            return self.advance((cycles * cycle).min(dt));
        }
        self.advance(dt)
    }

    /// Returns the approximate size in memory, bytes.
    pub(crate) fn size(&self) -> usize {
        size_of_val(self.trajectory.profiles())
    }

    pub(crate) fn has_arrived(&self) -> bool {
        self.left() <= TIME_TOLERANCE
    }

    /// Returns the time until the target is reached, s; negative afterwards.
    pub(crate) fn left(&self) -> f64 {
        let left = self.trajectory.duration() - self.time;
        if left.abs() <= TIME_TOLERANCE { 0.0 } else { left }
    }

    /// Returns the present state, or that at the target after it has been reached.
    pub(crate) fn state(&self) -> MotionState {
        let end = self.trajectory.duration();
        self.state_at(if self.has_arrived() { end } else { self.time })
    }

    /// Returns the present state; after a target velocity has been reached the positions go on.
    pub(crate) fn continued_state(&self) -> MotionState {
        self.state_at(if self.left() == 0.0 { self.trajectory.duration() } else { self.time })
    }

    fn state_at(&self, t: f64) -> MotionState {
        let mut out = MotionState::default();
        for state in self.trajectory.at(t) {
            let of = [state.position, state.velocity, state.acceleration];
            out.iter_mut().zip(of).for_each(|(list, x)| list.push(x));
        }
        out
    }
}

fn refused(e: MotionError) -> Fail {
    Fail::argument(e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn metre() -> MotionProfile {
        let limits = LimitLists::symmetric(vec![0.5], vec![1.0], vec![10.0]);
        MotionProfile::to(&[State::at(0.0)], &[State::at(1.0)], &limits, Synchronization::Time).unwrap()
    }

    #[test]
    fn time_that_is_still_needed_is_known() {
        let mut profile = metre();
        for step in 1..=52 {
            let arrived = profile.advance_in_cycles(0.05, 0.0001);
            assert_eq!(arrived, step == 52);
            assert!((profile.left() - (2.6 - 0.05 * f64::from(step))).abs() < 1e-9);
            if step == 1 {
                let [p, v, a] = profile.state().map(|list| list[0]);
                assert!((p - 0.000_208_333).abs() < 1e-9 && (v - 0.0125).abs() < 1e-9 && (a - 0.5).abs() < 1e-9);
            }
        }
        assert_eq!(profile.state(), [vec![1.0], vec![0.0], vec![0.0]]);
    }

    #[test]
    fn motion_ends_with_the_cycle_in_which_the_target_is_reached() {
        let mut profile = metre();
        assert!(profile.advance_in_cycles(3.0, 0.7));
        assert!((profile.left() + 0.2).abs() < 1e-9, "{}", profile.left());
    }

    #[test]
    fn flags_select_the_synchronization() {
        let of = |flags| synchronization(flags, Synchronization::Time);
        let expected = [Synchronization::Time, Synchronization::Phase, Synchronization::Time, Synchronization::Phase];
        assert_eq!([-1, 0, 1, 2].map(of), expected);
        assert_eq!([3, 256 + 3].map(of), [Synchronization::None; 2]);
    }

    #[test]
    fn missing_limits_do_not_limit() {
        let limits = LimitLists::symmetric(vec![0.0], vec![f64::NAN], vec![]);
        assert_eq!(limits.of(0), Limits::symmetric(UNLIMITED, UNLIMITED, f64::INFINITY));
        let uneven =
            LimitLists { min_velocity: vec![-0.25], ..LimitLists::symmetric(vec![0.5], vec![1.0], vec![10.0]) };
        assert_eq!(uneven.of(0).velocity, [-0.25, 0.5]);
    }
}
