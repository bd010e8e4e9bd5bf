//! Updates of drives before each step, and their transfer to rapier's joints.

use rapier3d::math::Pose;

use super::{
    gears, joints,
    records::JointRecord,
    state::{Rapier, mark_changed},
    tuning,
};
use crate::{BodyId, Engine, JointDrive};

/// Fraction of its limit above which a drive is considered to have reached the limit.
const AT_LIMIT_SHARE: f64 = 0.999;

impl Rapier {
    /// Applies changed drives to rapier's joints.
    pub(super) fn apply_drives(&mut self) {
        let mut changed = std::mem::take(&mut self.state.changed);
        for id in changed.drain(..) {
            let Some(record) = self.state.joints[id.0 as usize].as_mut() else {
                continue;
            };
            record.changed = false;
            let folded = joints::folded_friction(record);
            if folded != record.folded {
                record.folded = folded;
                let own = record.passive.friction - folded;
                let place = gears::coordinate(record.kind).0;
                let link = record.reduced().and_then(|r| self.world.multibody_joints.get_mut(r.handle));
                if let Some((multibody, id)) = link
                    && let Some(row) = multibody.link(id).map(|l| l.assembly_id() + place)
                {
                    multibody.frictions_mut()[row] = own;
                }
            }
            if record.drive != JointDrive::Free
                && let (frames, Some(reduced)) = (record.frames, record.reduced_mut())
            {
                if reduced.motor.is_none() {
                    let (a, b) = (reduced.parent, reduced.child);
                    reduced.motor = Some(self.world.insert_impulse_joint(a, b, joints::motor_only(frames)));
                }
                if !self.state.driven.contains(&id) {
                    self.state.driven.push(id);
                }
            }
            // Bodies with joints are always awake.
            let Some(joint) = record.drive_constraint().and_then(|j| self.world.impulse_joints.get_mut(j, false))
            else {
                continue;
            };
            let was_free = joint.data.motor_axes.is_empty();
            joints::apply_motor(&mut joint.data, record);
            // The number of iterations depends only on masses and frames, so it is updated only when a joint starts to
            // be driven.
            if record.drive == JointDrive::Free || !was_free || record.reduced().is_some() {
                continue;
            }
            let (a, b) = (joint.body1(), joint.body2());
            let carries = self.state.bodies[record.bodies.1.0 as usize].as_ref().is_some_and(|r| r.joints > 1);
            let needed = joints::added_iterations(record.frames, &self.world.bodies[a], &self.world.bodies[b])
                .max(if carries { tuning::CARRIER_ITERATIONS } else { 0 });
            if needed > self.world.bodies[b].additional_pgs_iterations() {
                self.world.bodies[b].set_additional_pgs_iterations(needed);
            }
        }
        self.state.changed = changed;
    }

    /// Updates the velocities of position drives for the next step.
    pub(super) fn update_position_drives(&mut self) {
        let dt = self.world.integration_parameters.dt;
        let mut positioned = std::mem::take(&mut self.state.positioned);
        positioned.retain(|id| {
            let Some(record) = &self.state.joints[id.0 as usize] else {
                return false;
            };
            let JointDrive::Position { max_force, tracking, .. } = record.drive else { return false };
            let integrates = tracking.is_some_and(|t| t.i != 0.0);
            let effort = if integrates { self.joint_state(*id).effort } else { 0.0 };
            let pressed = if effort.abs() >= AT_LIMIT_SHARE * max_force { effort.signum() } else { 0.0 };
            let (frame_a, frame_b) = self.joint_frames(record);
            let (pursuit, memory) =
                joints::controller_velocity(record, record.position(&frame_a, &frame_b), dt, pressed);
            if let Some(record) = self.state.joints[id.0 as usize].as_mut() {
                record.memory = memory;
                if record.pursuit != pursuit {
                    record.pursuit = pursuit;
                    mark_changed(&mut self.state.changed, *id, record);
                }
            }
            true
        });
        self.state.positioned = positioned;
    }

    /// Returns the world poses of a joint's frames on both bodies.
    pub(super) fn joint_frames(&self, record: &JointRecord) -> (Pose, Pose) {
        let pose = |id: BodyId| self.record(id).map_or(Pose::IDENTITY, |r| *self.world.bodies[r.handle].position());
        (pose(record.bodies.0) * record.frames.0, pose(record.bodies.1) * record.frames.1)
    }

    /// Updates the limits of drives whose limit falls with speed: records their speed, and whether they have reached
    /// the limit.
    pub(super) fn weaken_drives(&mut self) {
        for i in 0..self.state.weakening.len() {
            let id = self.state.weakening[i];
            let state = self.joint_state(id);
            let Some(Some(record)) = self.state.joints.get_mut(id.0 as usize) else { continue };
            if record.drive == JointDrive::Free {
                continue;
            }
            let row = record.drive_constraint().and_then(|j| self.world.impulse_joints.get(j));
            let (Some(axis), Some(row)) = (record.kind.free_axis(), row) else { continue };
            let motor = row.data.motors[axis as usize];
            // The joint remains on the torque-speed line until it is faster than its target.
            let beyond = (motor.target_vel - state.velocity) * state.effort > 0.0;
            record.at_limit = match record.at_limit {
                true => joints::target_velocity(record).is_none_or(|w| (w - state.velocity) * state.effort > 0.0),
                false => beyond && state.effort.abs() - record.folded >= AT_LIMIT_SHARE * motor.max_force,
            };
            record.speed = state.velocity;
            mark_changed(&mut self.state.changed, id, record);
        }
    }
}
