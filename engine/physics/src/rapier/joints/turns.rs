//! Whole turns of revolute joints whose limits are more than a turn apart.

use std::f64::consts::PI;

use rapier3d::dynamics::JointAxis;

use super::{position, record::JointBackend, table::Joints};
use crate::rapier::bodies::Bodies;

impl Joints {
    /// Counts the whole turns of joints whose limits are more than a turn apart, before a step.
    pub fn count_turns(&mut self, bodies: &mut Bodies) {
        for i in 0..self.winding.len() {
            let Some(record) = self.get(self.winding[i]) else { continue };
            let (frame_a, frame_b) = record.world_frames(bodies);
            let position = record.position(&frame_a, &frame_b);
            let angle = position::position(record.kind, &frame_a, &frame_b);
            let (backend, limits) = (record.backend, record.limits);
            if let Some(record) = self.get_mut(self.winding[i]) {
                record.turns.near = position;
            }
            // Coordinates in reduced form already include whole turns.
            let (JointBackend::Impulse(handle), Some((low, high))) = (backend, limits) else { continue };
            let Some(joint) = bodies.world.impulse_joints.get_mut(handle, false) else { continue };
            let turns = position - angle;
            let limits = &mut joint.data.limits[JointAxis::AngZ as usize];
            (limits.min, limits.max) = ((low - turns).clamp(-PI, PI), (high - turns).clamp(-PI, PI));
        }
    }
}
