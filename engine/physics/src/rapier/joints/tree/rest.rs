//! Trees at rest. The result of a step depends only on the state and on what acts, so a step that changes nothing need
//! not be computed again while the same acts.
//!
//! An island that hardly moves is brought to rest first: rounding would otherwise keep it moving by less than the size
//! of an atom per second. From then on, each step compares what acts with what acted in the step that changed nothing.
//! There is therefore no list of what wakes a tree: every cause appears among the arguments of the step. Nor is
//! anything stored in snapshots, since a step that is computed has the same result as one that is not.
//!
//! Trees with contacts do not rest: the internal forces of a standing robot still change while it moves by less than a
//! millionth of a metre, and would stay as they are when it is stopped.

use nalgebra::Vector3;

use super::{
    records::{Mechanism, RestRecord},
    step::MechanismIsland,
};

/// Maximum speed before and after a step of an island that is brought to rest, rad/s or m/s. A body that accelerates by
/// more than 2e-8 m/s² exceeds it in a step.
const MAX_REST_SPEED: f64 = 1e-10;

impl MechanismIsland {
    /// Returns whether a step would change nothing, because the last one did not, and the same acts.
    pub(super) fn repeats(&self, gravity: Vector3<f64>, dt: f64) -> bool {
        let same = |m: &Mechanism| {
            let Some(built) = &m.built else { return false };
            let Some(rest) = &built.rest else { return false };
            rest.members == self.members
                && rest.gravity == gravity
                && rest.dt == dt
                && m.v.iter().all(|v| *v == 0.0)
                && rest.q == m.q
                && rest.carried == m.carried
                && rest.drives == built.drives
        };
        self.calm && self.contacts.is_empty() && self.mechanisms.iter().all(same)
    }

    /// Returns whether the island is slow enough to be brought to rest.
    pub(super) fn is_nearly_at_rest(&self) -> bool {
        // While a gap closes, bodies move although positions and velocities do not change.
        let closed = |m: &Mechanism| m.gears.iter().flatten().all(|gear| gear.gap == 0.0);
        self.calm && self.contacts.is_empty() && self.mechanisms.iter().all(|m| slow(&m.v) && closed(m))
    }

    /// Returns what a step of the island begins with.
    pub(super) fn rest_start(&self) -> RestStart {
        RestStart { carried: self.mechanisms.iter().map(|m| m.carried.clone()).collect() }
    }

    /// Brings the island to rest after a step that began with the given efforts of drives, if it is still slow: stops it,
    /// and if it was at rest before, restores everything.
    pub(super) fn settle(&mut self, start: RestStart, gravity: Vector3<f64>, dt: f64) {
        // Overlaps and excesses of limits are corrected without velocity.
        let stays = |before: &[f64], after: &[f64]| {
            before.iter().zip(after).all(|(before, after)| (before - after).abs() <= MAX_REST_SPEED * dt)
        };
        let still_slow =
            |m: &Mechanism| m.built.as_ref().is_some_and(|built| slow(&built.state.v) && stays(&m.q, &built.state.q));
        if !self.mechanisms.iter().all(still_slow) {
            return;
        }
        let rested = self.mechanisms.iter().all(|m| m.v.iter().all(|v| *v == 0.0));
        for (mechanism, carried) in self.mechanisms.iter_mut().zip(start.carried) {
            let Some(built) = &mut mechanism.built else { continue };
            built.state.v.fill(0.0);
            if !rested {
                continue;
            }
            built.state.q.copy_from_slice(&mechanism.q);
            built.efforts.copy_from_slice(&carried);
            mechanism.carried = carried;
        }
        if !rested {
            return;
        }
        for mechanism in &mut self.mechanisms {
            let Some(built) = &mut mechanism.built else { continue };
            built.rest = Some(Box::new(RestRecord {
                members: self.members.clone(),
                q: mechanism.q.clone(),
                carried: mechanism.carried.clone(),
                drives: built.drives.clone(),
                gravity,
                dt,
            }));
        }
    }
}

/// What a step of an island that is nearly at rest began with.
pub(super) struct RestStart {
    carried: Vec<Vec<f64>>,
}

fn slow(v: &[f64]) -> bool {
    v.iter().all(|v| v.abs() <= MAX_REST_SPEED)
}
