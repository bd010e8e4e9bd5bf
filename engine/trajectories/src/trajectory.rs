//! The motion of several coordinates.

use serde::{Deserialize, Serialize};

use crate::{
    profile::Profile,
    state::{Limits, MotionError, State},
};

/// How coordinates depend on each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Synchronization {
    /// All arrive at the same time.
    #[default]
    Time,
    /// All move on a straight line, if their states at start and target and their limits allow it, else as `Time`.
    Phase,
    /// Each moves as fast as it can.
    None,
}

/// The motion of several coordinates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trajectory {
    profiles: Vec<Profile>,
}

impl Trajectory {
    /// Returns the fastest motion to positions and velocities. The slices have one element for each coordinate; those
    /// beyond the shortest slice are ignored.
    ///
    /// # Errors
    ///
    /// As [`Profile::to_position`]; [`MotionError::Duration`] if coordinates with velocities at their start or target
    /// cannot arrive together.
    pub fn to_positions(
        starts: &[State],
        targets: &[State],
        limits: &[Limits],
        synchronization: Synchronization,
    ) -> Result<Trajectory, MotionError> {
        let coordinates =
            || starts.iter().zip(targets).zip(limits).map(|((start, target), limits)| (start, target, limits));
        let found = coordinates()
            .map(|(start, target, limits)| {
                let found = Profile::extremal(*start, *target, limits)?;
                if found.is_empty() { Err(MotionError::Unsolved) } else { Ok(found) }
            })
            .collect::<Result<Vec<_>, _>>()?;
        let fastest: Vec<Profile> = found.iter().filter_map(|found| found.first().copied()).collect();
        if synchronization == Synchronization::None {
            return Ok(Trajectory { profiles: fastest });
        }
        if synchronization == Synchronization::Phase {
            let way = |k: usize| targets[k].position - starts[k].position;
            if let Some(profiles) = on_a_line(&fastest, starts, targets, limits, way) {
                return Ok(Trajectory { profiles });
            }
        }
        let longest = fastest.iter().map(Profile::duration).fold(0.0, f64::max);
        // If a duration is impossible for a coordinate, the next possible one is that of a slower extremal motion.
        let mut durations: Vec<f64> = found.iter().flatten().map(Profile::duration).filter(|t| *t >= longest).collect();
        durations.sort_by(f64::total_cmp);
        let together = |t: f64| -> Option<Vec<Profile>> {
            coordinates()
                .map(|(start, target, limits)| Profile::to_position_in(*start, *target, limits, t).ok())
                .collect()
        };
        match durations.into_iter().find_map(together) {
            Some(profiles) => Ok(Trajectory { profiles }),
            None if fastest.is_empty() => Ok(Trajectory { profiles: Vec::new() }),
            None => Err(MotionError::Duration(longest)),
        }
    }

    /// Returns the fastest motion to velocities, which last from then on. The slices are as in
    /// [`Trajectory::to_positions`].
    ///
    /// # Errors
    ///
    /// As [`Profile::to_velocity`].
    pub fn to_velocities(
        starts: &[State],
        velocities: &[f64],
        limits: &[Limits],
        synchronization: Synchronization,
    ) -> Result<Trajectory, MotionError> {
        let coordinates = || starts.iter().zip(velocities).zip(limits);
        let fastest = coordinates()
            .map(|((start, velocity), limits)| Profile::to_velocity(*start, *velocity, limits))
            .collect::<Result<Vec<_>, _>>()?;
        if synchronization == Synchronization::None {
            return Ok(Trajectory { profiles: fastest });
        }
        if synchronization == Synchronization::Phase {
            let targets: Vec<State> = fastest.iter().map(|p| p.at(p.duration())).collect();
            let change = |k: usize| velocities[k] - starts[k].velocity;
            if let Some(profiles) = on_a_line(&fastest, starts, &targets, limits, change) {
                return Ok(Trajectory { profiles });
            }
        }
        let longest = fastest.iter().map(Profile::duration).fold(0.0, f64::max);
        let profiles = coordinates()
            .map(|((start, velocity), limits)| Profile::to_velocity_in(*start, *velocity, limits, longest))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Trajectory { profiles })
    }

    /// Returns the time at which the last coordinate arrives, s.
    pub fn duration(&self) -> f64 {
        self.profiles.iter().map(Profile::duration).fold(0.0, f64::max)
    }

    /// Returns the motion of each coordinate.
    pub fn profiles(&self) -> &[Profile] {
        &self.profiles
    }

    /// Returns the state of each coordinate at a time, s.
    pub fn at(&self, t: f64) -> impl Iterator<Item = State> {
        self.profiles.iter().map(move |profile| profile.at(t))
    }
}

/// Share by which proportions of states may differ for a motion on a straight line.
const PROPORTION_TOLERANCE: f64 = 1e-9;

/// Returns the motions of all coordinates in proportion to `amount`, which is what each has to cover, with the shape of
/// the slowest one. Returns `None` if their states are not in this proportion, or their limits are exceeded.
fn on_a_line(
    fastest: &[Profile],
    starts: &[State],
    targets: &[State],
    limits: &[Limits],
    amount: impl Fn(usize) -> f64,
) -> Option<Vec<Profile>> {
    let slowest =
        (0..fastest.len()).reduce(|a, b| if fastest[b].duration() > fastest[a].duration() { b } else { a })?;
    let whole = amount(slowest);
    if whole == 0.0 {
        // Nothing moves, or the slowest coordinate returns to where it is.
        return fastest.iter().all(|p| p.duration() == 0.0).then(|| fastest.to_vec());
    }
    let (reference, target) = (starts[slowest], targets[slowest]);
    let scales = [reference.velocity, reference.acceleration, target.velocity].map(f64::abs);
    (0..fastest.len())
        .map(|k| {
            let factor = amount(k) / whole;
            let equal = |own: f64, whole: f64, scale: f64| {
                (own - factor * whole).abs() <= PROPORTION_TOLERANCE * scale.max(1.0)
            };
            let proportional = equal(starts[k].velocity, reference.velocity, scales[0])
                && equal(starts[k].acceleration, reference.acceleration, scales[1])
                && equal(targets[k].velocity, target.velocity, scales[2]);
            if !proportional {
                return None;
            }
            if k == slowest {
                Some(fastest[k])
            } else {
                fastest[slowest].scaled(factor, starts[k], targets[k], &limits[k])
            }
        })
        .collect()
}
