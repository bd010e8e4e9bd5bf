//! The motion of one coordinate.
//!
//! A motion to a position changes the velocity to a cruising velocity, cruises, and changes it to the target's. The
//! distance without cruising depends on the cruising velocity alone, so the fastest motion either cruises at a limit,
//! or has a cruising velocity at which the distance is right and which is found by bisection. Among several, the fastest
//! is taken. If the acceleration at the start is not 0, a motion whose acceleration never crosses 0 can be faster by a
//! fraction of the time that the acceleration needs to vanish; it is not sought. The family of motions is that of
//! R. Haschke, E. Weitnauer and H. Ritter, "On-Line Planning of Time-Optimal, Jerk-Limited Trajectories" (2008).

use serde::{Deserialize, Serialize};

use crate::{
    state::{Limits, MotionError, Segment, State},
    velocity::{after, change_velocity, duration},
};

/// The motion of one coordinate: at most seven segments of constant jerk.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    start: State,
    /// The state that is reached, without rounding errors.
    target: State,
    segments: [Segment; 7],
}

impl Profile {
    /// Returns the fastest motion to a position and velocity; the acceleration at the target is 0.
    ///
    /// # Errors
    ///
    /// Limits that are not as [`Limits`] says, states that are not finite, a target velocity beyond the limits.
    pub fn to_position(start: State, target: State, limits: &Limits) -> Result<Profile, MotionError> {
        let motion = Motion::new(start, target, limits)?;
        motion.fastest_first().first().copied().ok_or(MotionError::Unsolved)
    }

    /// Returns the motion to a position and velocity that takes `t` seconds, by cruising more slowly.
    ///
    /// # Errors
    ///
    /// As [`Profile::to_position`], and [`MotionError::Duration`] if no motion takes so long or so little time. If the
    /// velocities at start and target are not 0, some durations above the minimum may be impossible.
    pub fn to_position_in(start: State, target: State, limits: &Limits, t: f64) -> Result<Profile, MotionError> {
        let motion = Motion::new(start, target, limits)?;
        let extremal = motion.fastest_first().into_iter().find(|p| (p.duration() - t).abs() <= TIME_TOLERANCE);
        extremal.or_else(|| motion.lasting(t)).ok_or(MotionError::Duration(t))
    }

    /// Returns the fastest change to a velocity, which lasts from then on.
    ///
    /// # Errors
    ///
    /// As [`Profile::to_position`]; the limits of velocity have no effect.
    pub fn to_velocity(start: State, velocity: f64, limits: &Limits) -> Result<Profile, MotionError> {
        check_states(start, State::moving(0.0, velocity))?;
        Limits { velocity: [-1.0, 1.0], ..*limits }.check()?;
        let [a, b, c] = change_velocity(start, velocity, limits);
        let segments = [a, b, c, Segment::default(), Segment::default(), Segment::default(), Segment::default()];
        let end = after(start, &segments);
        Ok(Profile { start, target: State::moving(end.position, velocity), segments })
    }

    /// Returns the change to a velocity that takes `t` seconds, with a smaller acceleration.
    ///
    /// # Errors
    ///
    /// As [`Profile::to_velocity`], and [`MotionError::Duration`] if `t` is below the minimum.
    pub fn to_velocity_in(start: State, velocity: f64, limits: &Limits, t: f64) -> Result<Profile, MotionError> {
        let fastest = Profile::to_velocity(start, velocity, limits)?;
        if t <= fastest.duration() {
            return if fastest.duration() - t <= TIME_TOLERANCE { Ok(fastest) } else { Err(MotionError::Duration(t)) };
        }
        let slower = |factor: f64| Limits { acceleration: limits.acceleration.map(|a| a * factor), ..*limits };
        let excess = |factor: f64| {
            Profile::to_velocity(start, velocity, &slower(factor)).map_or(f64::INFINITY, |p| p.duration()) - t
        };
        let factor = bisect(SMALLEST_FACTOR, 1.0, excess).ok_or(MotionError::Duration(t))?;
        Profile::to_velocity(start, velocity, &slower(factor))
    }

    /// Returns the duration, s.
    pub fn duration(&self) -> f64 {
        duration(&self.segments)
    }

    /// Returns the state at a time, s. Before the start it is that of the start; after the end the coordinate moves on
    /// at the velocity of the target.
    pub fn at(&self, t: f64) -> State {
        let end = self.duration();
        if t >= end {
            let Self { target, .. } = self;
            return State { position: target.position + target.velocity * (t - end), ..*target };
        }
        let (mut state, mut left) = (self.start, t.max(0.0));
        for segment in &self.segments {
            if left < segment.duration {
                return state.after(&Segment { duration: left, ..*segment });
            }
            state = state.after(segment);
            left -= segment.duration;
        }
        self.target
    }

    /// Returns the segments; some have the duration 0.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Returns the motion of a coordinate from `start` to `target` whose derivatives are `factor` times those of this
    /// one, if it stays within the limits.
    pub(crate) fn scaled(&self, factor: f64, start: State, target: State, limits: &Limits) -> Option<Profile> {
        let segments = self.segments.map(|s| Segment {
            duration: s.duration,
            acceleration: s.acceleration * factor,
            jerk: s.jerk * factor,
        });
        let scaled = Profile { start, target, segments };
        scaled.is_within(limits).then_some(scaled)
    }

    /// Returns whether velocities, accelerations and jerks are within the limits, but for rounding errors. Beyond the
    /// limits of the start's own state is allowed as it is.
    fn is_within(&self, limits: &Limits) -> bool {
        let margin = |[least, greatest]: [f64; 2], own: f64| {
            let slack = LIMIT_TOLERANCE * (greatest - least);
            [least.min(own) - slack, greatest.max(own) + slack]
        };
        let velocity = margin(limits.velocity, self.start.velocity);
        let acceleration = margin(limits.acceleration, self.start.acceleration);
        let inside = |x: f64, [least, greatest]: [f64; 2]| (least..=greatest).contains(&x);
        let mut state = self.start;
        self.segments.iter().all(|segment| {
            // The velocity has an extremum where the acceleration vanishes.
            let zero = -segment.acceleration / segment.jerk;
            let extremum = if zero > 0.0 && zero < segment.duration { zero } else { 0.0 };
            let middle = state.after(&Segment { duration: extremum, ..*segment });
            state = state.after(segment);
            segment.duration <= 0.0
                || segment.jerk.abs() <= limits.jerk * (1.0 + LIMIT_TOLERANCE)
                    && inside(segment.acceleration, acceleration)
                    && inside(state.acceleration, acceleration)
                    && inside(middle.velocity, velocity)
                    && inside(state.velocity, velocity)
        })
    }

    /// Returns the fastest motion and, if velocities at start and target allow it, slower ones that also cruise at no
    /// limit, fastest first. Between them some durations are impossible.
    pub(crate) fn extremal(start: State, target: State, limits: &Limits) -> Result<Vec<Profile>, MotionError> {
        Ok(Motion::new(start, target, limits)?.fastest_first())
    }
}

/// Times that differ by less, s, are equal.
const TIME_TOLERANCE: f64 = 1e-12;

/// Share of a range of velocities or accelerations by which rounding errors may exceed it.
const LIMIT_TOLERANCE: f64 = 1e-9;

/// Smallest share of the limit of acceleration that is tried to prolong a change of velocity.
const SMALLEST_FACTOR: f64 = 1e-9;

/// Parts of each interval of cruising velocities that are searched for solutions.
const INTERVAL_PARTS: usize = 4;

/// Halvings of an interval, which suffice for neighbouring numbers unless the solution is close to 0.
const MAX_BISECTIONS: usize = 120;

fn check_states(start: State, target: State) -> Result<(), MotionError> {
    let numbers = [start.position, start.velocity, start.acceleration, target.position, target.velocity];
    if numbers.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(MotionError::State) }
}

/// A motion to a position that is sought.
struct Motion<'a> {
    start: State,
    target: State,
    limits: &'a Limits,
}

impl<'a> Motion<'a> {
    fn new(start: State, target: State, limits: &'a Limits) -> Result<Self, MotionError> {
        limits.check()?;
        check_states(start, target)?;
        let [least, greatest] = limits.velocity;
        if !(least..=greatest).contains(&target.velocity) {
            return Err(MotionError::TargetVelocity { velocity: target.velocity, limits: limits.velocity });
        }
        Ok(Motion { start, target: State { acceleration: 0.0, ..target }, limits })
    }

    /// Returns the segments before and after cruising at a velocity, the distance that remains for cruising, and the
    /// duration without it.
    fn cruising_at(&self, velocity: f64) -> ([Segment; 3], [Segment; 3], f64, f64) {
        let first = change_velocity(self.start, velocity, self.limits);
        let second = change_velocity(State::moving(0.0, velocity), self.target.velocity, self.limits);
        // The distance is measured from the start, which keeps it exact for positions far from 0.
        let moved = after(State { position: 0.0, ..self.start }, &first).position
            + after(State::moving(0.0, velocity), &second).position;
        let rest = self.target.position - self.start.position - moved;
        (first, second, rest, duration(&first) + duration(&second))
    }

    fn profile(&self, velocity: f64, cruise: f64) -> Profile {
        let ([a, b, c], [d, e, f], ..) = self.cruising_at(velocity);
        let cruise = Segment { duration: cruise, ..Segment::default() };
        Profile { start: self.start, target: self.target, segments: [a, b, c, cruise, d, e, f] }
    }

    /// Returns all velocities within the limits at which `f` is 0, from the least to the greatest. It is searched in a
    /// few parts between the velocities where it can bend: those known for all motions, and `more`.
    fn roots(&self, more: &[f64], f: impl Fn(f64) -> f64) -> Vec<f64> {
        let [least, greatest] = self.limits.velocity;
        let own = self.start.acceleration;
        let without_jerk = if self.limits.jerk.is_finite() { own * own.abs() / (2.0 * self.limits.jerk) } else { 0.0 };
        let mut bends =
            vec![least, 0.0, self.start.velocity, self.start.velocity + without_jerk, self.target.velocity, greatest];
        bends.extend(more);
        bends.retain(|v| (least..=greatest).contains(v));
        bends.sort_by(f64::total_cmp);
        bends.dedup();
        let mut roots = Vec::new();
        let mut search = |from: f64, to: f64| {
            if let Some(root) = bisect(from, to, &f)
                && roots.last() != Some(&root)
            {
                roots.push(root);
            }
        };
        for ends in bends.windows(2) {
            let part = |k: usize| ends[0] + (ends[1] - ends[0]) * (k as f64 / INTERVAL_PARTS as f64);
            (0..INTERVAL_PARTS).for_each(|k| search(part(k), part(k + 1)));
        }
        roots
    }

    /// Returns the cruising velocities at which the distance is right without cruising.
    fn without_cruising(&self) -> Vec<f64> {
        self.roots(&[], |v| self.cruising_at(v).2)
    }

    fn fastest_first(&self) -> Vec<Profile> {
        let distance = |v: f64| self.cruising_at(v).2;
        let mut found: Vec<Profile> = self.without_cruising().into_iter().map(|v| self.profile(v, 0.0)).collect();
        for limit in self.limits.velocity {
            let cruise = distance(limit) / limit;
            if cruise > 0.0 && cruise.is_finite() {
                found.push(self.profile(limit, cruise));
            }
        }
        found.sort_by(|a, b| a.duration().total_cmp(&b.duration()));
        found
    }

    fn lasting(&self, t: f64) -> Option<Profile> {
        let cruise = |v: f64| t - self.cruising_at(v).3;
        let missing = |v: f64| {
            let (.., rest, duration) = self.cruising_at(v);
            rest - v * (t - duration)
        };
        let roots = self.roots(&self.without_cruising(), missing);
        let v = roots.into_iter().find(|v| cruise(*v) >= -TIME_TOLERANCE)?;
        Some(self.profile(v, cruise(v).max(0.0)))
    }
}

/// Returns a number between `from` and `to` at which `f` is 0, if the signs of `f` there differ or one of them is 0.
fn bisect(mut from: f64, mut to: f64, f: impl Fn(f64) -> f64) -> Option<f64> {
    let (first, last) = (f(from), f(to));
    if first == 0.0 {
        return Some(from);
    }
    if last == 0.0 {
        return Some(to);
    }
    if first.is_nan() || last.is_nan() || (first > 0.0) == (last > 0.0) {
        return None;
    }
    for _ in 0..MAX_BISECTIONS {
        let middle = from + (to - from) / 2.0;
        if middle <= from || middle >= to {
            break;
        }
        let value = f(middle);
        if value == 0.0 {
            return Some(middle);
        }
        if (value > 0.0) == (first > 0.0) { from = middle } else { to = middle }
    }
    // Of two neighbouring numbers the better one.
    Some(if f(from).abs() < f(to).abs() { from } else { to })
}
