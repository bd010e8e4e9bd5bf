//! Contacts, as rapier solved them.

use nalgebra::Vector3;
use rapier3d::{
    geometry::{Collider, ContactManifold, ContactPair, PairContacts},
    pipeline::PhysicsWorld,
};

use super::respond::Tag;
use crate::{BodyId, Contact, convert};

pub(super) fn contacts(world: &PhysicsWorld, out: &mut Vec<Contact>) {
    out.clear();
    // Impulses are summed over the sub-steps.
    let step = world.integration_parameters.dt;
    for pair in world.narrow_phase.contact_pairs() {
        let PairContacts::Rigid(rigid) = &pair.contacts else {
            continue;
        };
        out.extend(rigid.solver_manifolds().iter().filter_map(|m| contact(world, pair, m, step)));
    }
    // The engine's order of pairs depends on the past. A total order without allocation: equal bodies by place.
    out.sort_unstable_by(|l, r| {
        let place = |c: &Contact| [c.point.x, c.point.y, c.point.z, c.force];
        let places = place(l).into_iter().zip(place(r));
        let by_place = places.map(|(a, b)| a.total_cmp(&b)).find(|o| o.is_ne());
        l.bodies.cmp(&r.bodies).then(by_place.unwrap_or(std::cmp::Ordering::Equal))
    });
}

/// One face of contact: where its force acts, or its middle if there is none.
fn contact(world: &PhysicsWorld, pair: &ContactPair, face: &ContactManifold, step: f64) -> Option<Contact> {
    let (first, second) = (&world.colliders[pair.collider1], &world.colliders[pair.collider2]);
    // Rapier finds contacts before it moves the bodies, and keeps them while these move little. What stays right is
    // the arm from the centre of mass of a body that moves.
    let body = |c: &Collider| c.parent().and_then(|b| world.bodies.get(b));
    let (on_first, arm_of) = match (body(first)?, body(second)?) {
        (a, _) if a.is_dynamic() => (true, a),
        (_, b) => (false, b),
    };
    let mut force = 0.0;
    let mut weights = 0.0;
    let mut sum = Vector3::zeros();
    for point in &face.points {
        // Rapier also keeps points that may touch in the next step.
        if point.data.impulse <= 0.0 && point.dist > 0.0 {
            continue;
        }
        let place = arm_of.center_of_mass() + if on_first { point.data.solver_dp1 } else { point.data.solver_dp2 };
        let weight = point.data.impulse.max(f64::MIN_POSITIVE);
        force += point.data.impulse / step;
        weights += weight;
        sum += convert::vector_back(place) * weight;
    }
    if weights == 0.0 {
        return None;
    }
    let bodies = [first, second].map(|c| BodyId(Tag::unpack(c.user_data).body));
    let swap = bodies[0] > bodies[1];
    let normal = convert::vector_back(face.data.normal);
    Some(Contact {
        bodies: if swap { (bodies[1], bodies[0]) } else { (bodies[0], bodies[1]) },
        point: (sum / weights).into(),
        normal: if swap { -normal } else { normal },
        force,
    })
}
