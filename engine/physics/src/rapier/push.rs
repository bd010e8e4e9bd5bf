//! Pushes that act in a single engine step.

use rapier3d::{
    dynamics::{RigidBody, RigidBodyHandle},
    math::Vector,
};

use super::{
    mechanisms::records::BodyLoad,
    state::{Rapier, is_finite},
};
use crate::{BodyWrench, MotionType, convert};

/// The force and torque on a body that act in all steps of the advance, saved before those of a single step are added.
pub(super) struct SavedForces {
    handle: RigidBodyHandle,
    force: Vector,
    torque: Vector,
}

impl SavedForces {
    pub(super) fn of(handle: RigidBodyHandle, body: &RigidBody) -> Self {
        SavedForces { handle, force: body.user_force(), torque: body.user_torque() }
    }
}

impl Rapier {
    /// Adds forces and torques for one step. The result must be passed to [`Rapier::restore_forces`] after the step.
    pub(super) fn push_for_step(&mut self, pushes: &[BodyWrench]) -> Vec<SavedForces> {
        let mut old = Vec::with_capacity(pushes.len());
        for push in pushes {
            let Some((handle, MotionType::Dynamic)) = self.record(push.body).map(|r| (r.handle, r.motion)) else {
                continue;
            };
            if !is_finite(&push.force) || !is_finite(&push.torque) {
                self.freeze(push.body);
                continue;
            }
            if self.record(push.body).is_some_and(|r| r.in_tree) {
                self.state.step_loads.push((push.body, BodyLoad { force: push.force, torque: push.torque }));
                continue;
            }
            let body = &mut self.world.bodies[handle];
            old.push(SavedForces::of(handle, body));
            body.add_force(convert::vector(&push.force), true);
            body.add_torque(convert::vector(&push.torque), true);
        }
        old
    }

    /// Restores the previous forces, in reverse order because a body may have been pushed more than once.
    pub(super) fn restore_forces(&mut self, old: Vec<SavedForces>) {
        for before in old.into_iter().rev() {
            let Some(body) = self.world.bodies.get_mut(before.handle) else { continue };
            body.reset_forces(false);
            body.reset_torques(false);
            body.add_force(before.force, false);
            body.add_torque(before.torque, false);
        }
    }
}
