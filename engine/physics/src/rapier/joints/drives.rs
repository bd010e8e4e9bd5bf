//! Drives of joints: requested from outside, and updated before each step.

use super::{
    controller::{controller_velocity, sanitized, target_velocity},
    position::free_axis,
    record::RestState,
    table::Joints,
};
use crate::{JointDrive, JointId, rapier::bodies::Bodies};

/// Fraction of its limit above which a drive is considered to have reached the limit.
const AT_LIMIT_SHARE: f64 = 0.999;

impl Joints {
    /// Requests a drive.
    pub fn set_drive(&mut self, bodies: &mut Bodies, joint: JointId, drive: JointDrive) {
        let drive = sanitized(drive);
        let Some(Some(record)) = self.records.get_mut(joint.0 as usize) else {
            return;
        };
        if record.drive.requested == drive {
            return;
        }
        let is_position = |d: JointDrive| matches!(d, JointDrive::Position { .. });
        if is_position(drive) && !is_position(record.drive.requested) && !self.positioned.contains(&joint) {
            self.positioned.push(joint);
        }
        record.drive.requested = drive;
        record.drive.rest = RestState::default();
        let (stops, body) = (record.stops(), record.bodies.1);
        self.mark_pending(joint);
        if stops {
            self.watch_stopping_joint(joint);
        }
        self.unpark(bodies, body);
    }

    /// Updates the velocities of position drives for the next step.
    pub fn update_position_drives(&mut self, bodies: &Bodies) {
        let dt = bodies.world.integration_parameters.dt;
        let mut positioned = std::mem::take(&mut self.positioned);
        positioned.retain(|id| {
            let Some(record) = self.get(*id) else { return false };
            let JointDrive::Position { max_force, tracking, .. } = record.drive.requested else { return false };
            let integrates = tracking.is_some_and(|t| t.i != 0.0);
            let effort = if integrates { record.state(bodies).effort } else { 0.0 };
            let pressed = if effort.abs() >= AT_LIMIT_SHARE * max_force { effort.signum() } else { 0.0 };
            let (pursuit, memory) = controller_velocity(record, record.current_position(bodies), dt, pressed);
            if let Some(record) = self.get_mut(*id) {
                record.drive.memory = memory;
                if record.drive.pursuit != pursuit {
                    record.drive.pursuit = pursuit;
                    self.mark_pending(*id);
                }
            }
            true
        });
        self.positioned = positioned;
    }

    /// Updates the limits of drives whose limit falls with speed: records their speed, and whether they have reached
    /// the limit.
    pub fn weaken_drives(&mut self, bodies: &Bodies) {
        for i in 0..self.weakening.len() {
            let id = self.weakening[i];
            let Some(record) = self.get_mut(id) else { continue };
            if record.drive.is_free() {
                continue;
            }
            let row = record.drive_constraint().and_then(|j| bodies.world.impulse_joints.get(j));
            let (Some(axis), Some(row)) = (free_axis(record.kind), row) else { continue };
            let (motor, state) = (row.data.motors[axis as usize], record.state(bodies));
            // The joint remains on the torque-speed line until it is faster than its target.
            let beyond = (motor.target_vel - state.velocity) * state.effort > 0.0;
            record.drive.at_limit = match record.drive.at_limit {
                true => target_velocity(record).is_none_or(|w| (w - state.velocity) * state.effort > 0.0),
                false => beyond && state.effort.abs() - record.drive.folded >= AT_LIMIT_SHARE * motor.max_force,
            };
            record.drive.speed = state.velocity;
            self.mark_pending(id);
        }
    }
}
