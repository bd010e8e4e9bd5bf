//! Adoption of free bodies. A free body that a tree touches becomes a tree itself until the two are apart again, which
//! allows both sides of a contact to be solved together.
//!
//! The decisions depend only on the state of the engine. Free bodies that can be reached from a link through contacts
//! are adopted, and released when they have been out of reach for a while. A mechanism that reaches a body that cannot
//! be adopted, such as a vehicle or a mechanism that rapier solves, is left to rapier like a mechanism in a crowd.

use std::collections::BTreeSet;

use rapier3d::{dynamics::RigidBodyType, geometry::ActiveCollisionTypes, math::Vector};

use super::records::BodyLoad;
use crate::{
    BodyId, MotionType, convert,
    rapier::{collision_filter::IN_TREE_FLAG, records::JointRecord, report, sleep, state::Rapier},
};

/// Time for which an adopted body must be apart from all trees before it is released, s.
const RELEASE_DELAY_S: f64 = 0.1;

/// Maximum number of free bodies that a mechanism adopts, directly or through other free bodies; if it reaches more, it
/// is in a crowd.
pub(super) const MAX_ADOPTED_BODIES: usize = 16;

/// The bodies that a mechanism touches or is about to touch, directly or through free bodies.
pub(super) struct ReachedBodies {
    /// Free bodies; the search ends when there are more than [`MAX_ADOPTED_BODIES`].
    pub free: BTreeSet<BodyId>,
    /// Dynamic bodies that are not part of a tree and cannot be adopted.
    pub foreign: BTreeSet<BodyId>,
}

impl Rapier {
    /// Marks a body as moved by a tree: rapier detects its contacts with all bodies, but does not move it.
    pub(in crate::rapier) fn claim_body(&mut self, body: BodyId) {
        let Some(Some(record)) = self.state.bodies.get_mut(body.0 as usize) else { return };
        if record.motion != MotionType::Dynamic || std::mem::replace(&mut record.in_tree, true) {
            return;
        }
        // Forces that were added for the current advance continue to act.
        let handle = record.handle;
        let moved = &mut self.world.bodies[handle];
        let (force, torque) = (moved.user_force(), moved.user_torque());
        if force != Vector::ZERO || torque != Vector::ZERO {
            let (force, torque) = (convert::vector_back(force), convert::vector_back(torque));
            self.state.loads.insert(body, BodyLoad { force, torque });
            moved.reset_forces(false);
            moved.reset_torques(false);
        }
        self.set_body_type(body, RigidBodyType::KinematicVelocityBased);
    }

    /// Returns a body to rapier, unless it is adopted or a joint of a tree is still attached to it.
    pub(in crate::rapier) fn release_unclaimed_body(&mut self, body: BodyId) {
        let on_it = |r: &JointRecord| r.tree_joint().is_some() && (r.bodies.0 == body || r.bodies.1 == body);
        let held = self.state.joints.iter().flatten().any(on_it);
        if !held && !self.state.adopted.contains_key(&body) {
            self.release_body(body);
        }
    }

    /// Returns a body to rapier unconditionally.
    pub(super) fn release_body(&mut self, body: BodyId) {
        let Some(Some(record)) = self.state.bodies.get_mut(body.0 as usize) else { return };
        if !std::mem::replace(&mut record.in_tree, false) {
            return;
        }
        self.set_body_type(body, RigidBodyType::Dynamic);
        if let (Some(load), Some(handle)) = (self.state.loads.remove(&body), self.record(body).map(|r| r.handle)) {
            let moved = &mut self.world.bodies[handle];
            moved.add_force(convert::vector(&load.force), true);
            moved.add_torque(convert::vector(&load.torque), true);
            self.state.pushed.push(body);
        }
        self.discard_velocity(body);
    }

    /// Returns a body to rapier if it is adopted.
    pub(in crate::rapier) fn release_adopted_body(&mut self, body: BodyId) {
        if self.state.adopted.remove(&body).is_some() {
            self.release_unclaimed_body(body);
            self.state.mechanisms_changed = true;
        }
    }

    fn set_body_type(&mut self, id: BodyId, kind: RigidBodyType) {
        let Some(record) = self.record(id).copied() else { return };
        let tree = kind != RigidBodyType::Dynamic;
        let body = &mut self.world.bodies[record.handle];
        body.set_body_type(kind, true);
        body.user_data = u128::from(id.0) | if tree { IN_TREE_FLAG } else { 0 };
        body.set_soft_ccd_prediction(0.0);
        sleep::set_may_sleep(body, !tree && self.state.sleep && record.joints == 0);
        let types = match tree {
            true => ActiveCollisionTypes::all(),
            false => ActiveCollisionTypes::default(),
        };
        let colliders = &mut self.world.colliders;
        for &collider in self.world.bodies[record.handle].colliders() {
            if let Some(collider) = colliders.get_mut(collider) {
                collider.set_active_collision_types(types);
            }
        }
    }

    /// Adopts the free bodies that trees touch, releases those that they no longer touch, and leaves trees in a crowd
    /// to rapier.
    pub(in crate::rapier) fn update_adoptions(&mut self) {
        if self.state.mechanisms.is_empty() && self.state.crowded.is_empty() {
            return;
        }
        self.set_contact_prediction();
        let greatest = self.greatest_travel();
        if greatest.is_none() && self.state.adopted.is_empty() {
            return;
        }
        let dt = self.world.integration_parameters.dt;
        let (mut reached, mut crowds) = (BTreeSet::new(), Vec::new());
        for (i, mechanism) in self.state.mechanisms.iter().enumerate() {
            if mechanism.frozen || self.state.adopted.contains_key(&mechanism.root) {
                continue;
            }
            let ReachedBodies { free, foreign } = self.reached_bodies(&mechanism.bodies, greatest);
            if free.len() > MAX_ADOPTED_BODIES || !foreign.is_empty() {
                crowds.push((i, free));
            } else {
                reached.extend(free);
            }
        }
        for (i, found) in crowds {
            for body in found {
                reached.remove(&body);
                self.release_adopted_body(body);
            }
            self.join_crowd(i);
        }
        for body in &reached {
            if self.state.adopted.insert(*body, 0.0).is_none() {
                self.claim_body(*body);
                self.state.mechanisms_changed = true;
            }
        }
        let mut apart = Vec::new();
        for (body, time) in self.state.adopted.iter_mut().filter(|(body, _)| !reached.contains(body)) {
            *time += dt;
            if *time >= RELEASE_DELAY_S {
                apart.push(*body);
            }
        }
        for body in apart {
            self.release_adopted_body(body);
        }
        self.leave_crowds(greatest);
    }

    /// Returns the bodies that touch the given ones or are about to, directly or through free bodies. `greatest` is the
    /// greatest travel per step of the bodies that rapier moves, m, or `None` if there are no such bodies.
    pub(super) fn reached_bodies(&self, bodies: &[BodyId], greatest: Option<f64>) -> ReachedBodies {
        let mut open = bodies.to_vec();
        let mut reach = ReachedBodies { free: BTreeSet::new(), foreign: BTreeSet::new() };
        let mut next = 0;
        while next < open.len() && reach.free.len() <= MAX_ADOPTED_BODIES {
            let mut near = self.touching(open[next]);
            near.extend(greatest.into_iter().flat_map(|greatest| self.approaching(open[next], greatest)));
            for other in near {
                if self.may_be_adopted(other) {
                    if reach.free.insert(other) {
                        open.push(other);
                    }
                } else if self.is_foreign(other) && !bodies.contains(&other) {
                    reach.foreign.insert(other);
                }
            }
            next += 1;
        }
        reach
    }

    /// Returns the bodies that have an active contact with a body.
    fn touching(&self, body: BodyId) -> BTreeSet<BodyId> {
        let Some(record) = self.record(body) else { return BTreeSet::new() };
        let colliders = self.world.bodies[record.handle].colliders();
        let pairs = colliders.iter().flat_map(|c| self.world.narrow_phase.contact_pairs_with(*c));
        pairs
            .filter(|p| p.has_any_active_contact())
            .flat_map(|p| [p.collider1, p.collider2])
            .filter_map(|c| report::body_of(&self.world, c))
            .filter(|other| *other != body)
            .collect()
    }

    /// Returns whether rapier moves a body.
    fn is_foreign(&self, body: BodyId) -> bool {
        let Some(record) = self.record(body) else { return false };
        record.motion == MotionType::Dynamic && !record.in_tree && self.world.bodies[record.handle].is_enabled()
    }

    fn may_be_adopted(&self, body: BodyId) -> bool {
        let Some(record) = self.record(body) else { return false };
        let mass = &self.world.bodies[record.handle].mass_properties().local_mprops;
        let moments = mass.principal_inertia();
        // A tree requires that every free body has mass and inertia.
        record.motion == MotionType::Dynamic
            && record.joints == 0
            && mass.mass() > 0.0
            && moments.x.min(moments.y).min(moments.z) > 0.0
            && self.world.bodies[record.handle].is_enabled()
            && !self.state.surfaces.get(&body).is_some_and(|s| s.is_special())
    }
}
