//! Efforts of drives in reduced form. A drive is a constraint between the two links. Rapier iterates over the
//! constraints once in each sub-step, so an arm of many joints would sag. The effort of a drive in one step, up to half
//! of its limit, is therefore applied as a force in the next, and the constraint has to find only the difference.

use rapier3d::math::Vector;

use super::solver::ReducedJoints;
use crate::{
    JointDrive, JointKind,
    rapier::{
        bodies::{Bodies, SavedForces},
        joints::{position::free_axis, table::Joints},
    },
};

/// Maximum fraction of a drive's limit that is applied as a force. With one half, the total never exceeds the limit,
/// and the constraint, whose own limit is the same in both directions, can always cancel the force.
const MAX_CARRIED_SHARE: f64 = 0.5;

impl ReducedJoints {
    /// Applies the efforts that drives carry over from the last step as forces. [`Bodies::restore_forces`] must be
    /// called after the step.
    pub fn add_carried_effort(&self, bodies: &mut Bodies, joints: &Joints) {
        for id in &self.driven {
            let Some(record) = joints.get(*id) else { continue };
            let (Some(joint), Some(limit)) = (record.reduced(), effort_limit(record.drive.requested)) else { continue };
            if let Some(motor) = joint.motor.and_then(|m| bodies.world.impulse_joints.get_mut(m, false))
                && let Some(axis) = free_axis(record.kind)
            {
                let motor = &mut motor.data.motors[axis as usize];
                motor.max_force = (limit - joint.carried.abs()).min(f64::MAX);
            }
            if joint.carried == 0.0 {
                continue;
            }
            let saved = &mut bodies.forces.saved;
            let bodies = &mut bodies.world.bodies;
            let frame = *bodies[joint.child].position() * record.frames.1;
            let axis = (bodies[joint.parent].position().rotation * record.frames.0.rotation) * Vector::Z;
            for (handle, sign) in [(joint.child, 1.0), (joint.parent, -1.0)] {
                let body = &mut bodies[handle];
                if !body.is_dynamic() {
                    continue;
                }
                saved.push(SavedForces::of(handle, body));
                match record.kind {
                    JointKind::Prismatic => {
                        body.add_force_at_point(axis * (sign * joint.carried), frame.translation, false);
                    }
                    _ => body.add_torque(axis * (sign * joint.carried), false),
                }
            }
        }
    }

    /// Records the efforts of drives in this step.
    pub(super) fn record_efforts(&mut self, bodies: &Bodies, joints: &mut Joints) {
        let substep = bodies.substep();
        self.driven.retain(|id| {
            let Some(record) = joints.get_mut(*id) else { return false };
            let (axis, drive, no_load) = (free_axis(record.kind), record.drive.requested, record.passive.no_load_speed);
            let Some(joint) = record.reduced_mut() else { return false };
            let (Some(axis), true) = (axis, drive != JointDrive::Free) else {
                (joint.carried, joint.effort) = (0.0, 0.0);
                return false;
            };
            let Some(motor) = joint.motor.and_then(|m| bodies.world.impulse_joints.get(m)) else { return true };
            // Rapier's impulses have the opposite sign: they slow the second body down.
            joint.effort = joint.carried - motor.data.motors[axis as usize].impulse / substep;
            let weakening = no_load > 0.0;
            joint.carried = match effort_limit(drive) {
                Some(limit) if joint.effort.is_finite() && !weakening => {
                    let most = MAX_CARRIED_SHARE * limit.min(f64::MAX);
                    joint.effort.clamp(-most, most)
                }
                _ => 0.0,
            };
            true
        });
    }
}

/// Returns the limit of a drive whose effort results from the load, or `None` for other drives.
fn effort_limit(drive: JointDrive) -> Option<f64> {
    match drive {
        JointDrive::Velocity { max_force, slip: 0.0, .. } => Some(max_force),
        JointDrive::Position { max_force, .. } => Some(max_force),
        _ => None,
    }
}
