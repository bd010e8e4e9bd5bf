//! Bodies that are about to hit each other.
//!
//! The narrow phase tells of a contact a step before it acts only if the bodies are slow. What is fast must be seen
//! earlier: in the step in which rapier finds a contact, it already solves it, with a tree as something of infinite
//! mass.

use rapier3d::{
    dynamics::RigidBody,
    geometry::{Aabb, BoundingVolume, Collider},
    pipeline::QueryFilter,
};

use crate::{
    BodyId, Motion,
    rapier::{
        report,
        respond::{self, Tag},
        state::Rapier,
    },
};

/// Way of two bodies together in a step up to which the narrow phase finds their contact a step before, m: three
/// quarters of its prediction distance.
const SLOW: f64 = 1.5e-3;

impl Rapier {
    /// Returns the greatest way in a step of the bodies that rapier moves, m; `None` if it moves none.
    pub(super) fn fastest_way(&self) -> Option<f64> {
        let moved = self.tables.bodies.iter().flatten().filter(|r| r.motion == Motion::Dynamic && !r.in_tree);
        moved.map(|r| self.way(&self.world.bodies[r.handle])).reduce(f64::max)
    }

    /// Returns the bodies moved by rapier that may hit a body within two steps, at the velocities that they have;
    /// `fastest` is the greatest way of such a body in a step. Bounding boxes decide.
    pub(super) fn approached(&self, body: BodyId, fastest: f64) -> Vec<BodyId> {
        let mut found = Vec::new();
        let Some(own) = self.record(body).and_then(|r| self.world.bodies.get(r.handle)) else { return found };
        let own_way = self.way(own);
        if own_way + fastest <= SLOW {
            return found;
        }
        for collider in own.colliders().iter().filter_map(|c| self.world.colliders.get(*c)) {
            let place = collider.compute_aabb().loosened(2.0 * own_way);
            // boxes in the tree are those of the beginning of the last step
            for (handle, other) in
                self.world.intersect_aabb_conservative(place.loosened(3.0 * fastest), QueryFilter::only_dynamic())
            {
                let Some(id) = report::body_of(&self.world, handle).filter(|id| *id != body) else { continue };
                let [one, two] = [collider, other].map(|c| Tag::unpack(c.user_data).respond);
                let free = self.record(id).is_some_and(|r| !r.in_tree);
                if free && respond::responds(one, two) && self.may_hit(other, &place, own_way) {
                    found.push(id);
                }
            }
        }
        found
    }

    fn may_hit(&self, other: &Collider, place: &Aabb, own_way: f64) -> bool {
        let Some(body) = other.parent().and_then(|p| self.world.bodies.get(p)) else { return false };
        let way = self.way(body);
        own_way + way > SLOW && other.compute_aabb().loosened(2.0 * way).intersects(place)
    }

    /// Returns a bound of the way of a body's points in a step, m.
    fn way(&self, body: &RigidBody) -> f64 {
        let spin = body.angvel().length();
        let mut speed = body.linvel().length();
        if spin > 0.0 {
            let centre = body.center_of_mass();
            let far = |c: &Collider| {
                let place = c.compute_aabb();
                (place.center() - centre).length() + place.half_extents().length()
            };
            let colliders = body.colliders().iter().filter_map(|c| self.world.colliders.get(*c));
            speed += spin * colliders.map(far).fold(0.0, f64::max);
        }
        speed * self.world.integration_parameters.dt
    }
}
