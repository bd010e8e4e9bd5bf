//! Measurements of force sensors in an engine step.

use super::state::Dynamics;
use crate::{object::Data, tree::Scene};

impl Dynamics {
    /// Updates all force sensors after an engine step. A sensor that breaks releases its bodies immediately.
    pub(super) fn sample(&mut self, scene: &mut Scene) {
        for i in 0..self.force_sensors.len() {
            let (id, slot) = self.force_sensors[i];
            let (Some(wrench), Some(((above, _), frame))) = (self.engine.wrench(id), self.tie(id)) else { continue };
            let turn = (self.engine.pose(above).rotation * frame.rotation).inverse();
            let (f, t) = (turn * wrench.force, turn * wrench.torque);
            let Some(Data::ForceSensor(sensor)) = scene.get_mut(slot).map(|o| &mut o.data) else { continue };
            if !sensor.broken && sensor.take([f.x, f.y, f.z, t.x, t.y, t.z]) {
                sensor.broken = true;
                self.engine.remove_joint(id);
                scene.touch(slot);
            }
        }
    }
}
