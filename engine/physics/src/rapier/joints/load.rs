//! Loads of joints, computed from the momentum of all bodies below the joint, because rapier does not provide the
//! forces in the joints of mechanisms in reduced form. The force that a joint exerts is the rate of change of momentum
//! minus gravity, pushes and contacts.

use rapier3d::{dynamics::RigidBody, geometry::PairContacts, math::Vector};

use super::{
    record::{MeasuredJoint, MomentumSum},
    table::Joints,
};
use crate::{
    BodyId, JointId, Wrench, convert,
    rapier::{
        bodies::Bodies,
        contacts::{TreeContact, masks, report},
    },
};

impl Joints {
    /// Starts measuring the load of a joint.
    pub fn measure(&mut self, bodies: &mut Bodies, joint: JointId) {
        if !self.measured.iter().any(|m| m.joint == joint) {
            self.measured.push(MeasuredJoint::new(joint));
            if let Some(body) = self.get(joint).map(|r| r.bodies.1) {
                self.unpark(bodies, body);
            }
        }
    }

    /// Records the bodies below each measured joint before a step, with their momentum and the forces applied to them.
    pub fn record_momenta(&mut self, bodies: &Bodies) {
        let mut measured = std::mem::take(&mut self.measured);
        measured.retain(|m| self.get(m.joint).is_some());
        for m in &mut measured {
            if self.structure_changed || m.bodies.is_empty() {
                m.bodies = self.bodies_below(m.joint);
            }
            let (momentum, pushes) = (momentum(bodies, &m.bodies), applied_forces(bodies, &m.bodies));
            m.before = Some(MomentumSum { momentum, pushes });
        }
        self.measured = measured;
    }

    /// Computes the load of each measured joint after a step. `touches` are the contacts of trees.
    pub fn measure_loads(&mut self, bodies: &Bodies, touches: &[TreeContact]) {
        let dt = bodies.world.integration_parameters.dt;
        for m in &mut self.measured {
            let record = self.records.get(m.joint.0 as usize).and_then(Option::as_ref);
            let (Some(before), Some(record)) = (m.before, record) else {
                continue;
            };
            let now = momentum(bodies, &m.bodies);
            let contacts = contact_forces(bodies, touches, &m.bodies);
            let force = (now.0 - before.momentum.0) / dt - before.pushes.0 - contacts.0;
            let moment = (now.1 - before.momentum.1) / dt - before.pushes.1 - contacts.1;
            let origin = record.world_frames(bodies).0.translation;
            // The joint exerts this force on the bodies below, which exert the opposite force on it.
            m.wrench = Some(Wrench {
                force: -convert::vector_back(force),
                torque: -convert::vector_back(moment - origin.cross(force)),
            });
        }
    }
}

fn members<'a>(bodies: &'a Bodies, ids: &'a [BodyId]) -> impl Iterator<Item = &'a RigidBody> {
    ids.iter().filter_map(|id| Some(&bodies.world.bodies[bodies.record(*id)?.handle]))
}

fn momentum(bodies: &Bodies, ids: &[BodyId]) -> (Vector, Vector) {
    members(bodies, ids).fold((Vector::ZERO, Vector::ZERO), |(p, l), body| {
        let push = body.linvel() * body.mass();
        let mass = body.mass_properties();
        let axes = body.position().rotation * mass.local_mprops.principal_inertia_local_frame;
        let spin = axes * (mass.local_mprops.principal_inertia() * (axes.inverse() * body.angvel()));
        (p + push, l + body.center_of_mass().cross(push) + spin)
    })
}

fn applied_forces(bodies: &Bodies, ids: &[BodyId]) -> (Vector, Vector) {
    members(bodies, ids).fold((Vector::ZERO, Vector::ZERO), |(f, m), body| {
        let (force, torque) = bodies.tree_load(BodyId(body.user_data as u32));
        let force = force + bodies.world.gravity * body.mass() * body.gravity_scale() + body.user_force();
        (f + force, m + body.center_of_mass().cross(force) + torque + body.user_torque())
    })
}

/// Returns the total force and moment of contacts with bodies that are not below the joint.
fn contact_forces(bodies: &Bodies, touches: &[TreeContact], ids: &[BodyId]) -> (Vector, Vector) {
    let (mut force, mut moment) = (Vector::ZERO, Vector::ZERO);
    for id in ids {
        // Rapier has no contact forces for bodies that trees move; `touches` contains them.
        let Some(handle) = bodies.record(*id).filter(|r| !r.in_tree).map(|r| r.handle) else { continue };
        for collider in bodies.world.bodies[handle].colliders() {
            for pair in bodies.world.narrow_phase.contact_pairs_with(*collider) {
                let first = pair.collider1 == *collider;
                let other = if first { pair.collider2 } else { pair.collider1 };
                if masks::body_of(&bodies.world, other).is_some_and(|b| ids.contains(&b)) {
                    continue;
                }
                let PairContacts::Rigid(rigid) = &pair.contacts else { continue };
                for manifold in rigid.solver_manifolds() {
                    let Some(face) = report::face(&bodies.world, pair, manifold).filter(|f| f.force > 0.0) else {
                        continue;
                    };
                    let on_second = manifold.data.normal * face.force + face.friction;
                    let f = if first { -on_second } else { on_second };
                    (force, moment) = (force + f, moment + face.point.cross(f));
                }
            }
        }
    }
    for touch in touches {
        let below = |id: BodyId| ids.contains(&id);
        let own = |id: BodyId| below(id) && bodies.record(id).is_some_and(|r| r.in_tree);
        let (first, second) = touch.bodies;
        let sign = match (own(first) && !below(second), own(second) && !below(first)) {
            (true, _) => -1.0,
            (_, true) => 1.0,
            _ => continue,
        };
        let f = convert::vector(&((touch.normal * touch.force + touch.friction) * sign));
        (force, moment) = (force + f, moment + convert::vector(&touch.point).cross(f));
    }
    (force, moment)
}
