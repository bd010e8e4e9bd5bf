//! Pushes that act in a single engine step.

use rapier3d::{
    dynamics::{RigidBody, RigidBodyHandle},
    math::Vector,
};

use super::{
    state::{Rapier, finite},
    trees::records::Load,
};
use crate::{Motion, Push, convert};

/// The force and torque on a body that act in all steps of the advance, saved before those of a single step are added.
pub(super) struct Before {
    handle: RigidBodyHandle,
    force: Vector,
    torque: Vector,
}

impl Before {
    pub(super) fn of(handle: RigidBodyHandle, body: &RigidBody) -> Self {
        Before { handle, force: body.user_force(), torque: body.user_torque() }
    }
}

impl Rapier {
    /// Adds forces and torques for one step. The result must be passed to [`Rapier::take_back`] after the step.
    pub(super) fn push_for_a_step(&mut self, pushes: &[Push]) -> Vec<Before> {
        let mut old = Vec::with_capacity(pushes.len());
        for push in pushes {
            let Some((handle, Motion::Dynamic)) = self.record(push.body).map(|r| (r.handle, r.motion)) else {
                continue;
            };
            if !finite(&push.force) || !finite(&push.torque) {
                self.freeze(push.body);
                continue;
            }
            if self.record(push.body).is_some_and(|r| r.in_tree) {
                self.tables.step_loads.push((push.body, Load { force: push.force, torque: push.torque }));
                continue;
            }
            let body = &mut self.world.bodies[handle];
            old.push(Before::of(handle, body));
            body.add_force(convert::vector(&push.force), true);
            body.add_torque(convert::vector(&push.torque), true);
        }
        old
    }

    /// Restores the previous forces, in reverse order because a body may have been pushed more than once.
    pub(super) fn take_back(&mut self, old: Vec<Before>) {
        for before in old.into_iter().rev() {
            let Some(body) = self.world.bodies.get_mut(before.handle) else { continue };
            body.reset_forces(false);
            body.reset_torques(false);
            body.add_force(before.force, false);
            body.add_torque(before.torque, false);
        }
    }
}
