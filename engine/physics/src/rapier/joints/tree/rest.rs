//! Trees at rest. The result of a step depends only on the state and on what acts, so a step that changes nothing need
//! not be computed again while the same acts.
//!
//! An island that hardly moves is brought to rest first: rounding would otherwise keep it moving by less than the size
//! of an atom per second. From then on, each step compares what acts with what acted in the step that changed nothing.
//! There is therefore no list of what wakes a tree: every cause appears among the arguments of the step. Nor is
//! anything stored in snapshots, since a step that is computed has the same result as one that is not.
//!
//! Forces still change while nothing moves: drives that hold against each other, such as those of the legs of a standing
//! robot, approach a common distribution of its weight. The island rests when they have reached it.

use nalgebra::Vector3;
use tatu_mechanisms::ContactPoint;

use super::{
    records::{Mechanism, RestRecord},
    step::MechanismIsland,
};

/// Maximum speed before and after a step of an island that is brought to rest, rad/s or m/s. A body that accelerates by
/// more than 2e-8 m/s² exceeds it in a step.
const MAX_REST_SPEED: f64 = 1e-10;
/// Maximum change of a force in a step in which an island comes to rest, as a fraction of the greatest one. Rounding
/// changes the forces of contacts by a tenth of this from step to step.
const MAX_FORCE_CHANGE: f64 = 1e-6;

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
        let first = self.mechanisms.first().and_then(|m| m.built.as_ref()?.rest.as_ref());
        self.calm && first.is_some_and(|rest| rest.contacts == self.contacts) && self.mechanisms.iter().all(same)
    }

    /// Returns whether the island is slow enough to be brought to rest.
    pub(super) fn is_nearly_at_rest(&self) -> bool {
        // While a gap closes, bodies move although positions and velocities do not change.
        let closed = |m: &Mechanism| m.gears.iter().flatten().all(|gear| gear.gap == 0.0);
        self.calm && self.mechanisms.iter().all(|m| slow(&m.v) && closed(m))
    }

    /// Returns what a step of the island begins with.
    pub(super) fn rest_start(&self) -> RestStart {
        RestStart {
            carried: self.mechanisms.iter().map(|m| m.carried.clone()).collect(),
            contacts: self.contacts.clone(),
        }
    }

    /// Brings the island to rest after a step that began with the given forces, if it is still slow: stops it, and if it
    /// did not move before either, and its forces no longer change, restores everything.
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
        let steady = rested && self.has_steady_forces(&start, dt);
        for (mechanism, carried) in self.mechanisms.iter_mut().zip(&start.carried) {
            let Some(built) = &mut mechanism.built else { continue };
            built.state.v.fill(0.0);
            if rested {
                built.state.q.copy_from_slice(&mechanism.q);
            }
            if steady {
                built.efforts.copy_from_slice(carried);
                mechanism.carried.copy_from_slice(carried);
            }
        }
        if !steady {
            return;
        }
        for (contact, before) in self.contacts.iter_mut().zip(&start.contacts) {
            contact.impulse = before.impulse;
        }
        self.repeat_impulses();
        let mut contacts = Some(start.contacts);
        for mechanism in &mut self.mechanisms {
            let Some(built) = &mut mechanism.built else { continue };
            built.rest = Some(Box::new(RestRecord {
                members: self.members.clone(),
                q: mechanism.q.clone(),
                carried: mechanism.carried.clone(),
                contacts: contacts.take().unwrap_or_default(),
                drives: built.drives.clone(),
                gravity,
                dt,
            }));
        }
    }

    /// Reports the impulses of the contacts of an island at rest, which are those of the last step.
    pub(super) fn repeat_impulses(&mut self) {
        self.totals = self.contacts.iter().map(|contact| contact.impulse).collect();
    }

    /// Returns whether no force has changed in a step of length `dt`, s, by more than a small part of the greatest.
    fn has_steady_forces(&self, start: &RestStart, dt: f64) -> bool {
        let efforts = self.mechanisms.iter().zip(&start.carried).flat_map(|(m, before)| before.iter().zip(&m.carried));
        let impulses = start.contacts.iter().zip(&self.contacts);
        let impulses = impulses.flat_map(|(a, b)| a.impulse.iter().zip(b.impulse.iter()));
        let (mut change, mut greatest) = (0.0f64, 0.0f64);
        for (before, after) in efforts.map(|(a, b)| (*a, *b)).chain(impulses.map(|(a, b)| (a / dt, b / dt))) {
            change = change.max((after - before).abs());
            greatest = greatest.max(before.abs());
        }
        change <= MAX_FORCE_CHANGE * greatest
    }
}

/// What a step of an island that is nearly at rest began with.
pub(super) struct RestStart {
    carried: Vec<Vec<f64>>,
    contacts: Vec<ContactPoint>,
}

fn slow(v: &[f64]) -> bool {
    v.iter().all(|v| v.abs() <= MAX_REST_SPEED)
}
