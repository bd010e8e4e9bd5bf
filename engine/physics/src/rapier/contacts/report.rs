//! Reports of contacts, with the forces that the solvers found.

use nalgebra::Vector3;
use rapier3d::{
    geometry::{ColliderHandle, ContactManifold, ContactPair, PairContacts},
    math::Vector,
    pipeline::PhysicsWorld,
};
use serde::{Deserialize, Serialize};

use super::masks::body_of;
use crate::{
    BodyContact, BodyId, convert,
    rapier::bodies::{Bodies, IN_TREE_FLAG},
};

/// The effect of one contact face of a tree in the last step.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct TreeContact {
    pub bodies: (BodyId, BodyId),
    /// Point at which the normal force acts, in the world frame, m.
    pub point: Vector3<f64>,
    /// Unit vector from the first body to the second.
    pub normal: Vector3<f64>,
    /// Normal force on the second body, N, averaged over the step.
    pub force: f64,
    /// Friction on the second body, N, averaged over the step.
    pub friction: Vector3<f64>,
}

/// Collects the contacts that rapier solved and those of trees, `touches`, in order of body ids.
pub(crate) fn contacts(bodies: &Bodies, touches: &[TreeContact], out: &mut Vec<BodyContact>) {
    out.clear();
    let world = &bodies.world;
    let solved = (!bodies.backlog.skipped).then(|| world.narrow_phase.contact_pairs());
    for pair in solved.into_iter().flatten().filter(|p| is_solved(world, p)) {
        let PairContacts::Rigid(rigid) = &pair.contacts else {
            continue;
        };
        // A large face has several manifolds, which have the same normal.
        let faces = rigid.solver_manifolds().chunk_by(|a, b| a.data.normal == b.data.normal);
        out.extend(faces.filter_map(|manifolds| contact(world, pair, manifolds)));
    }
    out.extend(touches.iter().map(|t| {
        let (swap, (a, b)) = (t.bodies.0 > t.bodies.1, t.bodies);
        let sign = if swap { -1.0 } else { 1.0 };
        BodyContact {
            bodies: if swap { (b, a) } else { (a, b) },
            point: t.point.into(),
            normal: t.normal * sign,
            force: t.force,
            friction: t.friction * sign,
        }
    }));
    // Rapier's order of pairs depends on earlier steps. This is a total order without allocation; contacts of the same
    // pair of bodies are sorted by position.
    out.sort_unstable_by(|l, r| {
        let place = |c: &BodyContact| [c.point.x, c.point.y, c.point.z, c.force];
        let places = place(l).into_iter().zip(place(r));
        let by_place = places.map(|(a, b)| a.total_cmp(&b)).find(|o| o.is_ne());
        l.bodies.cmp(&r.bodies).then(by_place.unwrap_or(std::cmp::Ordering::Equal))
    });
}

/// Returns whether rapier alone solves a pair, because no tree moves either body.
fn is_solved(world: &PhysicsWorld, pair: &ContactPair) -> bool {
    let body = |c| world.colliders.get(c).and_then(|c| world.bodies.get(c.parent()?));
    let bodies = [pair.collider1, pair.collider2].map(body);
    bodies.iter().flatten().all(|b| b.user_data & IN_TREE_FLAG == 0)
}

/// The effect of one contact manifold in the last step.
pub(crate) struct ContactFace {
    /// Point at which its normal force acts, or its centre if there is no force, m.
    pub point: Vector,
    /// Normal force, N.
    pub force: f64,
    /// Friction on the second body, N.
    pub friction: Vector,
    /// Mean distance of the contact points from `point`, weighted by force, m.
    pub radius: f64,
}

/// Returns the face of a contact manifold, or `None` if the two bodies do not touch.
pub(crate) fn face(world: &PhysicsWorld, pair: &ContactPair, face: &ContactManifold) -> Option<ContactFace> {
    // Normal impulses are sums over the sub-steps; friction impulses are from the last sub-step.
    let step = world.integration_parameters.dt;
    let substep = step / world.integration_parameters.num_solver_iterations as f64;
    let body = |c: ColliderHandle| {
        let handle = world.colliders.get(c)?.parent()?;
        Some((handle, world.bodies.get(handle)?))
    };
    // Rapier finds contacts before it moves the bodies, and reuses them while the bodies move little. The vector from
    // the centre of mass of a dynamic body to the contact remains valid.
    let (a, b) = (body(pair.collider1)?, body(pair.collider2)?);
    let (on_first, arm_of) = if a.1.is_dynamic() { (true, a.1) } else { (false, b.1) };
    let in_mechanism = [a.0, b.0].iter().any(|h| world.multibody_joints.rigid_body_link(*h).is_some());
    let (mut force, mut weights, mut sum, mut friction) = (0.0, 0.0, Vector::ZERO, Vector::ZERO);
    let mut count = 0;
    for point in &face.points {
        // Rapier also keeps points that may touch in the next step.
        if point.data.impulse <= 0.0 && point.dist > 0.0 {
            continue;
        }
        let arm = if on_first { point.data.solver_dp1 } else { point.data.solver_dp2 };
        let weight = point.data.impulse.max(f64::MIN_POSITIVE);
        force += point.data.impulse / step;
        weights += weight;
        sum += (arm_of.center_of_mass() + arm) * weight;
        // Between free bodies, rapier has one friction constraint for four points, and stores it in each of them.
        if in_mechanism || count % 4 == 0 {
            friction -= point.data.warmstart_tangent_world / substep;
        }
        count += 1;
    }
    if weights <= 0.0 {
        return None;
    }
    let centre = sum / weights;
    let spread = face.points.iter().filter(|p| p.data.impulse > 0.0).map(|p| {
        let arm = if on_first { p.data.solver_dp1 } else { p.data.solver_dp2 };
        (arm_of.center_of_mass() + arm - centre).length() * p.data.impulse
    });
    let radius = spread.sum::<f64>() / weights;
    Some(ContactFace { point: centre, force, friction, radius })
}

/// Joins two parts of a face. The radius of the whole is that of the first part, which is spread over the whole face.
fn join_faces(a: ContactFace, b: ContactFace) -> ContactFace {
    let force = a.force + b.force;
    let point = if force > 0.0 { (a.point * a.force + b.point * b.force) / force } else { a.point };
    ContactFace { point, force, friction: a.friction + b.friction, radius: a.radius }
}

/// Returns the contact of the manifolds of one face, or `None` if the two bodies do not touch there.
fn contact(world: &PhysicsWorld, pair: &ContactPair, manifolds: &[ContactManifold]) -> Option<BodyContact> {
    let bodies = [body_of(world, pair.collider1)?, body_of(world, pair.collider2)?];
    let normal = manifolds.first()?.data.normal;
    let parts = manifolds.iter().filter_map(|m| face(world, pair, m));
    let ContactFace { point, force, friction, .. } = parts.reduce(join_faces)?;
    let swap = bodies[0] > bodies[1];
    let side = |v: Vector3<f64>| if swap { -v } else { v };
    Some(BodyContact {
        bodies: if swap { (bodies[1], bodies[0]) } else { (bodies[0], bodies[1]) },
        point: convert::vector_back(point).into(),
        normal: side(convert::vector_back(normal)),
        force,
        friction: side(convert::vector_back(friction)),
    })
}
