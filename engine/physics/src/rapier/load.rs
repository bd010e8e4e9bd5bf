//! Loads of joints, computed from the momentum of all bodies below the joint, because rapier does not provide the
//! forces in the joints of mechanisms in reduced form. The force that a joint exerts is the rate of change of momentum
//! minus gravity, pushes and contacts.

use rapier3d::{dynamics::RigidBody, geometry::PairContacts, math::Vector};

use super::{records::MomentumSum, report, state::Rapier};
use crate::{BodyId, JointId, Wrench, convert};

impl Rapier {
    /// Records the bodies below each measured joint before a step, with their momentum and the forces applied to them.
    pub(super) fn record_momenta(&mut self) {
        let mut measured = std::mem::take(&mut self.state.measured);
        measured.retain(|m| self.state.joints.get(m.joint.0 as usize).is_some_and(Option::is_some));
        for m in &mut measured {
            if self.state.joints_changed || m.bodies.is_empty() {
                m.bodies = self.bodies_below(m.joint);
            }
            m.before = Some(MomentumSum { momentum: self.momentum(&m.bodies), pushes: self.applied_forces(&m.bodies) });
        }
        self.state.measured = measured;
    }

    /// Computes the load of each measured joint after a step.
    pub(super) fn measure_loads(&mut self) {
        let dt = self.world.integration_parameters.dt;
        let mut measured = std::mem::take(&mut self.state.measured);
        for m in &mut measured {
            let (Some(before), Some(Some(record))) = (m.before, self.state.joints.get(m.joint.0 as usize)) else {
                continue;
            };
            let now = self.momentum(&m.bodies);
            let contacts = self.contact_forces(&m.bodies);
            let force = (now.0 - before.momentum.0) / dt - before.pushes.0 - contacts.0;
            let moment = (now.1 - before.momentum.1) / dt - before.pushes.1 - contacts.1;
            let origin = self.joint_frames(record).0.translation;
            // The joint exerts this force on the bodies below, which exert the opposite force on it.
            m.wrench = Some(Wrench {
                force: -convert::vector_back(force),
                torque: -convert::vector_back(moment - origin.cross(force)),
            });
        }
        self.state.measured = measured;
    }

    fn bodies_below(&self, joint: JointId) -> Vec<BodyId> {
        let Some(Some(first)) = self.state.joints.get(joint.0 as usize) else { return Vec::new() };
        let mut found = vec![first.bodies.1];
        // Joints are not sorted, so this repeats until nothing is added.
        loop {
            let known = found.len();
            for record in self.state.joints.iter().flatten().filter(|r| !r.closes_loop) {
                if found.contains(&record.bodies.0) && !found.contains(&record.bodies.1) {
                    found.push(record.bodies.1);
                }
            }
            if found.len() == known {
                found.sort_unstable();
                return found;
            }
        }
    }

    fn bodies<'a>(&'a self, ids: &'a [BodyId]) -> impl Iterator<Item = &'a RigidBody> {
        ids.iter().filter_map(|id| Some(&self.world.bodies[self.record(*id)?.handle]))
    }

    fn momentum(&self, ids: &[BodyId]) -> (Vector, Vector) {
        self.bodies(ids).fold((Vector::ZERO, Vector::ZERO), |(p, l), body| {
            let push = body.linvel() * body.mass();
            let mass = body.mass_properties();
            let axes = body.position().rotation * mass.local_mprops.principal_inertia_local_frame;
            let spin = axes * (mass.local_mprops.principal_inertia() * (axes.inverse() * body.angvel()));
            (p + push, l + body.center_of_mass().cross(push) + spin)
        })
    }

    fn applied_forces(&self, ids: &[BodyId]) -> (Vector, Vector) {
        self.bodies(ids).fold((Vector::ZERO, Vector::ZERO), |(f, m), body| {
            let (force, torque) = self.tree_load(BodyId(body.user_data as u32));
            let force = force + self.world.gravity * body.mass() * body.gravity_scale() + body.user_force();
            (f + force, m + body.center_of_mass().cross(force) + torque + body.user_torque())
        })
    }

    /// Returns the total force and moment of contacts with bodies that are not below the joint.
    fn contact_forces(&self, ids: &[BodyId]) -> (Vector, Vector) {
        let (mut force, mut moment) = (Vector::ZERO, Vector::ZERO);
        for id in ids {
            // Rapier has no contact forces for bodies that trees move; `touches` contains them.
            let Some(handle) = self.record(*id).filter(|r| !r.in_tree).map(|r| r.handle) else { continue };
            for collider in self.world.bodies[handle].colliders() {
                for pair in self.world.narrow_phase.contact_pairs_with(*collider) {
                    let first = pair.collider1 == *collider;
                    let other = if first { pair.collider2 } else { pair.collider1 };
                    if report::body_of(&self.world, other).is_some_and(|b| ids.contains(&b)) {
                        continue;
                    }
                    let PairContacts::Rigid(rigid) = &pair.contacts else { continue };
                    for manifold in rigid.solver_manifolds() {
                        let Some(face) = report::face(&self.world, pair, manifold).filter(|f| f.force > 0.0) else {
                            continue;
                        };
                        let on_second = manifold.data.normal * face.force + face.friction;
                        let f = if first { -on_second } else { on_second };
                        (force, moment) = (force + f, moment + face.point.cross(f));
                    }
                }
            }
        }
        for touch in &self.state.touches {
            let below = |id: BodyId| ids.contains(&id);
            let own = |id: BodyId| below(id) && self.record(id).is_some_and(|r| r.in_tree);
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
}
