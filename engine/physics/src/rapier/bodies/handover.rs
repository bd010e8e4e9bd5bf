//! Bodies that pass from rapier to a tree and back. A tree moves its bodies itself; rapier treats them as kinematic,
//! and only detects their contacts.

use rapier3d::{dynamics::RigidBodyType, geometry::ActiveCollisionTypes, math::Vector};

use super::{record::BodyLoad, sleep, table::Bodies};
use crate::{BodyId, MotionType, convert};

/// Flag in the user data of bodies that trees move.
pub(crate) const IN_TREE_FLAG: u128 = 1 << 64;

impl Bodies {
    /// Marks a body as moved by a tree: rapier detects its contacts with all bodies, but does not move it.
    pub fn give_to_tree(&mut self, body: BodyId) {
        let Some(record) = self.record_mut(body) else { return };
        if record.motion != MotionType::Dynamic || std::mem::replace(&mut record.in_tree, true) {
            return;
        }
        // Forces that were added for the current advance continue to act.
        let handle = record.handle;
        let moved = &mut self.world.bodies[handle];
        let (force, torque) = (moved.user_force(), moved.user_torque());
        if force != Vector::ZERO || torque != Vector::ZERO {
            let (force, torque) = (convert::vector_back(force), convert::vector_back(torque));
            self.forces.loads.insert(body, BodyLoad { force, torque });
            moved.reset_forces(false);
            moved.reset_torques(false);
        }
        self.set_body_type(body, RigidBodyType::KinematicVelocityBased);
    }

    /// Returns a body to rapier.
    pub fn return_to_rapier(&mut self, body: BodyId) {
        let Some(record) = self.record_mut(body) else { return };
        if !std::mem::replace(&mut record.in_tree, false) {
            return;
        }
        self.set_body_type(body, RigidBodyType::Dynamic);
        if let (Some(load), Some(handle)) = (self.forces.loads.remove(&body), self.record(body).map(|r| r.handle)) {
            let moved = &mut self.world.bodies[handle];
            moved.add_force(convert::vector(&load.force), true);
            moved.add_torque(convert::vector(&load.torque), true);
            self.forces.pushed.push(body);
        }
        self.discard_velocity(body);
    }

    fn set_body_type(&mut self, id: BodyId, kind: RigidBodyType) {
        let Some(record) = self.record(id).copied() else { return };
        let tree = kind != RigidBodyType::Dynamic;
        let body = &mut self.world.bodies[record.handle];
        body.set_body_type(kind, true);
        body.user_data = u128::from(id.0) | if tree { IN_TREE_FLAG } else { 0 };
        body.set_soft_ccd_prediction(0.0);
        sleep::set_may_sleep(body, !tree && self.sleep && record.joints == 0);
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
}
