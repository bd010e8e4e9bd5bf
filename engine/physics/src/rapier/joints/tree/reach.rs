//! The bodies that a mechanism touches or is about to touch.

use std::collections::BTreeSet;

use super::approach;
use crate::{
    BodyId, MotionType,
    rapier::{
        bodies::Bodies,
        contacts::{Contacts, masks},
    },
};

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

/// Returns the bodies that touch the given ones or are about to, directly or through free bodies. `greatest` is the
/// greatest travel per step of the bodies that rapier moves, m, or `None` if there are no such bodies.
pub(super) fn reached_bodies(
    bodies: &Bodies,
    contacts: &Contacts,
    members: &[BodyId],
    greatest: Option<f64>,
) -> ReachedBodies {
    let mut open = members.to_vec();
    let mut reach = ReachedBodies { free: BTreeSet::new(), foreign: BTreeSet::new() };
    let mut next = 0;
    while next < open.len() && reach.free.len() <= MAX_ADOPTED_BODIES {
        let mut near = touching(bodies, open[next]);
        near.extend(greatest.into_iter().flat_map(|greatest| approach::approaching(bodies, open[next], greatest)));
        for other in near {
            if may_be_adopted(bodies, contacts, other) {
                if reach.free.insert(other) {
                    open.push(other);
                }
            } else if is_foreign(bodies, other) && !members.contains(&other) {
                reach.foreign.insert(other);
            }
        }
        next += 1;
    }
    reach
}

/// Returns the bodies that have an active contact with a body; none if rapier has not found the contacts of the last step.
fn touching(bodies: &Bodies, body: BodyId) -> BTreeSet<BodyId> {
    let Some(record) = bodies.record(body).filter(|_| !bodies.backlog.skipped) else { return BTreeSet::new() };
    let colliders = bodies.world.bodies[record.handle].colliders();
    let pairs = colliders.iter().flat_map(|c| bodies.world.narrow_phase.contact_pairs_with(*c));
    pairs
        .filter(|p| p.has_any_active_contact())
        .flat_map(|p| [p.collider1, p.collider2])
        .filter_map(|c| masks::body_of(&bodies.world, c))
        .filter(|other| *other != body)
        .collect()
}

/// Returns whether rapier moves a body.
fn is_foreign(bodies: &Bodies, body: BodyId) -> bool {
    let Some(record) = bodies.record(body) else { return false };
    record.motion == MotionType::Dynamic && !record.in_tree && bodies.world.bodies[record.handle].is_enabled()
}

fn may_be_adopted(bodies: &Bodies, contacts: &Contacts, body: BodyId) -> bool {
    let Some(record) = bodies.record(body) else { return false };
    let mass = &bodies.world.bodies[record.handle].mass_properties().local_mprops;
    let moments = mass.principal_inertia();
    // A tree requires that every free body has mass and inertia.
    record.motion == MotionType::Dynamic
        && record.joints == 0
        && mass.mass() > 0.0
        && moments.x.min(moments.y).min(moments.z) > 0.0
        && bodies.world.bodies[record.handle].is_enabled()
        && !contacts.surfaces.get(&body).is_some_and(|s| s.is_special())
}
