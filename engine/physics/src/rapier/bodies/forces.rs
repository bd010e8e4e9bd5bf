//! Forces that are applied from outside, in all steps of an advance or in a single one.

use nalgebra::Vector3;
use rapier3d::math::Vector;

use super::{
    record::{BodyLoad, SavedForces},
    table::{Bodies, is_finite},
};
use crate::{BodyId, BodyWrench, convert};

impl Bodies {
    /// Adds a force and a torque for the next advance.
    pub fn push(&mut self, body: BodyId, force: Vector3<f64>, torque: Vector3<f64>) {
        let Some(handle) = self.dynamic_handle(body) else { return };
        if !is_finite(&force) || !is_finite(&torque) {
            return self.freeze(body);
        }
        if self.record(body).is_some_and(|r| r.in_tree) {
            let sum = self.forces.loads.entry(body).or_default();
            (sum.force, sum.torque) = (sum.force + force, sum.torque + torque);
            return;
        }
        let pushed = &mut self.world.bodies[handle];
        pushed.add_force(convert::vector(&force), true);
        pushed.add_torque(convert::vector(&torque), true);
        self.forces.pushed.push(body);
    }

    /// Adds forces and torques for one step. [`Bodies::restore_forces`] must be called after the step.
    pub fn push_for_step(&mut self, pushes: &[BodyWrench]) {
        for push in pushes {
            let Some(handle) = self.dynamic_handle(push.body) else { continue };
            if !is_finite(&push.force) || !is_finite(&push.torque) {
                self.freeze(push.body);
                continue;
            }
            if self.record(push.body).is_some_and(|r| r.in_tree) {
                let load = BodyLoad { force: push.force, torque: push.torque };
                self.forces.step_loads.push((push.body, load));
                continue;
            }
            let body = &mut self.world.bodies[handle];
            self.forces.saved.push(SavedForces::of(handle, body));
            body.add_force(convert::vector(&push.force), true);
            body.add_torque(convert::vector(&push.torque), true);
        }
    }

    /// Restores the forces from before the step, in reverse order because forces may have been added to a body more
    /// than once.
    pub fn restore_forces(&mut self) {
        while let Some(before) = self.forces.saved.pop() {
            let Some(body) = self.world.bodies.get_mut(before.handle) else { continue };
            body.reset_forces(false);
            body.reset_torques(false);
            body.add_force(before.force, false);
            body.add_torque(before.torque, false);
        }
    }

    /// Removes the forces that acted in all steps of an advance.
    pub fn clear_forces(&mut self) {
        self.forces.loads.clear();
        let mut pushed = std::mem::take(&mut self.forces.pushed);
        for id in pushed.drain(..) {
            let Some(handle) = self.record(id).map(|r| r.handle) else {
                continue;
            };
            let body = &mut self.world.bodies[handle];
            body.reset_forces(false);
            body.reset_torques(false);
        }
        self.forces.pushed = pushed;
    }

    /// Returns the force on a body of a tree, N, and the torque about its centre of mass, N m, excluding gravity and
    /// contacts.
    pub fn tree_load(&self, body: BodyId) -> (Vector, Vector) {
        let mut load = self.forces.loads.get(&body).copied().unwrap_or_default();
        for (_, more) in self.forces.step_loads.iter().filter(|(b, _)| *b == body) {
            load = BodyLoad { force: load.force + more.force, torque: load.torque + more.torque };
        }
        (convert::vector(&load.force), convert::vector(&load.torque))
    }
}
