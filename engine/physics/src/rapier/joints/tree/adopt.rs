//! Adoption of free bodies. A free body that a tree touches becomes a tree itself until the two are apart again, which
//! allows both sides of a contact to be solved together.
//!
//! The decisions depend only on the state of the engine. Free bodies that can be reached from a link through contacts
//! are adopted, and released when they have been out of reach for a while. A mechanism that reaches a body that cannot
//! be adopted, such as a vehicle or a mechanism that rapier solves, is left to rapier like a mechanism in a crowd.

use std::collections::BTreeSet;

use super::{
    approach,
    reach::{MAX_ADOPTED_BODIES, ReachedBodies, reached_bodies},
    table::TreeJoints,
};
use crate::{
    BodyId,
    rapier::{
        bodies::Bodies,
        contacts::Contacts,
        joints::{record::JointRecord, reduced::ReducedJoints, table::Joints},
    },
};

/// Time for which an adopted body must be apart from all trees before it is released, s.
const RELEASE_DELAY_S: f64 = 0.1;

impl TreeJoints {
    /// Returns a body to rapier, unless it is adopted or a joint of a tree is still attached to it.
    pub(super) fn release_unclaimed_body(&mut self, bodies: &mut Bodies, joints: &Joints, body: BodyId) {
        let on_it = |r: &JointRecord| r.is_in_tree() && (r.bodies.0 == body || r.bodies.1 == body);
        let held = joints.iter().any(on_it);
        if !held && !self.adopted.contains_key(&body) {
            bodies.return_to_rapier(body);
        }
    }

    /// Returns a body to rapier if it is adopted.
    pub fn release_adopted_body(&mut self, bodies: &mut Bodies, joints: &Joints, body: BodyId) {
        if self.adopted.remove(&body).is_some() {
            self.release_unclaimed_body(bodies, joints, body);
            self.changed = true;
        }
    }

    /// Adopts the free bodies that trees touch, releases those that they no longer touch, and leaves trees in a crowd
    /// to rapier.
    pub fn update_adoptions(
        &mut self,
        bodies: &mut Bodies,
        contacts: &Contacts,
        joints: &mut Joints,
        reduced: &mut ReducedJoints,
    ) {
        if self.mechanisms.is_empty() && self.crowded.is_empty() {
            return;
        }
        approach::set_contact_prediction(&self.mechanisms, bodies);
        let greatest = approach::greatest_travel(bodies);
        if greatest.is_none() && self.adopted.is_empty() {
            return;
        }
        let dt = bodies.world.integration_parameters.dt;
        let (mut reached, mut crowds) = (BTreeSet::new(), Vec::new());
        for (i, mechanism) in self.mechanisms.iter().enumerate() {
            if mechanism.frozen || self.adopted.contains_key(&mechanism.root) {
                continue;
            }
            let ReachedBodies { free, foreign } = reached_bodies(bodies, contacts, &mechanism.bodies, greatest);
            if free.len() > MAX_ADOPTED_BODIES || !foreign.is_empty() {
                crowds.push((i, free));
            } else {
                reached.extend(free);
            }
        }
        for (i, found) in crowds {
            for body in found {
                reached.remove(&body);
                self.release_adopted_body(bodies, joints, body);
            }
            self.join_crowd(bodies, joints, reduced, i);
        }
        for body in &reached {
            if self.adopted.insert(*body, 0.0).is_none() {
                bodies.give_to_tree(*body);
                self.changed = true;
            }
        }
        let mut apart = Vec::new();
        for (body, time) in self.adopted.iter_mut().filter(|(body, _)| !reached.contains(body)) {
            *time += dt;
            if *time >= RELEASE_DELAY_S {
                apart.push(*body);
            }
        }
        for body in apart {
            self.release_adopted_body(bodies, joints, body);
        }
        self.leave_crowds(bodies, contacts, joints, reduced, greatest);
    }
}
