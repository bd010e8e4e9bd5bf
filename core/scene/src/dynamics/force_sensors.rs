//! Measurements of force sensors in an engine step.

use super::state::Dynamics;
use crate::{object::ObjectVariant, tree::Scene};

impl Dynamics {
    /// Updates all force sensors after an engine step. A sensor that breaks releases its bodies immediately.
    pub(super) fn sample_force_sensors(&mut self, scene: &mut Scene) {
        for i in 0..self.force_sensors.len() {
            let (id, slot) = self.force_sensors[i];
            let (Some(wrench), Some(((above, _), frame))) = (self.engine.wrench(id), self.bodies_of_joint(id)) else {
                continue;
            };
            let turn = (self.engine.pose(above).rotation * frame.rotation).inverse();
            let (f, t) = (turn * wrench.force, turn * wrench.torque);
            let Some(ObjectVariant::ForceSensor(sensor)) = scene.get_mut(slot).map(|o| &mut o.data) else { continue };
            if !sensor.broken && sensor.add_sample([f.x, f.y, f.z, t.x, t.y, t.z]) {
                sensor.broken = true;
                self.engine.remove_joint(id);
                scene.touch(slot);
            }
        }
    }
}
