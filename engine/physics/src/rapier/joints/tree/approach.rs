//! Bodies that are about to hit each other.
//!
//! The narrow phase reports a contact one step before it acts only if the bodies are slow. Fast bodies must be found
//! earlier, because rapier solves a contact in the step in which it detects it, and treats a tree as having infinite
//! mass.

use rapier3d::{
    dynamics::RigidBody,
    geometry::{Aabb, BoundingVolume, Collider},
    pipeline::QueryFilter,
};

use super::records::Mechanism;
use crate::{
    BodyId, MotionType,
    rapier::{
        bodies::Bodies,
        contacts::masks::{self, ColliderTag},
    },
};

/// Combined travel of two bodies per step up to which the narrow phase reports their contact one step ahead, m: three
/// quarters of its prediction distance.
const SLOW_TRAVEL: f64 = 1.5e-3;

/// Makes rapier detect contacts of fast links and adopted bodies as far ahead as they move in a step. Otherwise,
/// they would pass through thin bodies: rapier's continuous collision detection stops only bodies that it moves
/// itself.
pub(super) fn set_contact_prediction(mechanisms: &[Mechanism], bodies: &mut Bodies) {
    for link in mechanisms.iter().flat_map(|m| &m.bodies) {
        let Some(handle) = bodies.record(*link).map(|r| r.handle) else { continue };
        let Some(body) = bodies.world.bodies.get(handle) else { continue };
        let travel = body.linvel().length() * bodies.world.integration_parameters.dt;
        let fast = travel > SLOW_TRAVEL && (body.is_ccd_enabled() || travel > depth(bodies, body));
        let ahead = if fast { 2.0 * travel } else { 0.0 };
        if body.soft_ccd_prediction() != ahead {
            bodies.world.bodies[handle].set_soft_ccd_prediction(ahead);
        }
    }
}

/// Returns half the thickness of a body, m.
fn depth(bodies: &Bodies, body: &RigidBody) -> f64 {
    let colliders = body.colliders().iter().filter_map(|c| bodies.world.colliders.get(*c));
    let halves = colliders.map(|c| c.shape().compute_local_aabb().half_extents().min_element());
    halves.fold(f64::INFINITY, f64::min)
}

/// Returns the greatest travel per step of the bodies that rapier moves, m, or `None` if there are no such bodies.
pub(super) fn greatest_travel(bodies: &Bodies) -> Option<f64> {
    let moved = bodies.records.iter().flatten().filter(|r| r.motion == MotionType::Dynamic && !r.in_tree);
    moved.map(|r| travel(bodies, &bodies.world.bodies[r.handle])).reduce(f64::max)
}

/// Returns the bodies moved by rapier whose bounding boxes may reach that of a body within two steps at the current
/// velocities. `greatest` is the greatest travel per step of the bodies that rapier moves, m.
pub(super) fn approaching(bodies: &Bodies, body: BodyId, greatest: f64) -> Vec<BodyId> {
    let mut found = Vec::new();
    let Some(own) = bodies.body(body) else { return found };
    let travel = travel(bodies, own);
    if travel + greatest <= SLOW_TRAVEL {
        return found;
    }
    for collider in own.colliders().iter().filter_map(|c| bodies.world.colliders.get(*c)) {
        let swept = collider.compute_aabb().loosened(2.0 * travel);
        // The boxes of the broad phase date from the beginning of the last step.
        let near = swept.loosened(3.0 * greatest);
        for (handle, other) in bodies.world.intersect_aabb_conservative(near, QueryFilter::only_dynamic()) {
            let Some(id) = masks::body_of(&bodies.world, handle).filter(|id| *id != body) else { continue };
            let [one, two] = [collider, other].map(|c| ColliderTag::unpack(c.user_data).collision_mask);
            let free = bodies.record(id).is_some_and(|r| !r.in_tree);
            if free && masks::masks_collide(one, two) && may_hit(bodies, other, &swept, travel) {
                found.push(id);
            }
        }
    }
    found
}

/// Returns whether a collider may enter the box `swept` within two steps. `other_travel` is the travel per step of the
/// body that sweeps the box, m.
fn may_hit(bodies: &Bodies, collider: &Collider, swept: &Aabb, other_travel: f64) -> bool {
    let Some(body) = collider.parent().and_then(|p| bodies.world.bodies.get(p)) else { return false };
    let own = travel(bodies, body);
    other_travel + own > SLOW_TRAVEL && collider.compute_aabb().loosened(2.0 * own).intersects(swept)
}

/// Returns an upper bound on the distance that any point of a body travels in one step, m.
fn travel(bodies: &Bodies, body: &RigidBody) -> f64 {
    let spin = body.angvel().length();
    let mut speed = body.linvel().length();
    if spin > 0.0 {
        let centre = body.center_of_mass();
        let radius = |c: &Collider| {
            let bounds = c.compute_aabb();
            (bounds.center() - centre).length() + bounds.half_extents().length()
        };
        let colliders = body.colliders().iter().filter_map(|c| bodies.world.colliders.get(*c));
        speed += spin * colliders.map(radius).fold(0.0, f64::max);
    }
    speed * bodies.world.integration_parameters.dt
}
