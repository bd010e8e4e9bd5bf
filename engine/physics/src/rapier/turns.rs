//! Revolute joints with limits beyond half a turn.
//!
//! Rapier computes the angle of a joint from the rotation between its bodies, from -pi to pi, and compares it with the
//! limits. A joint with limits of 47 and 313 degrees could therefore be outside its limits at 180 degrees. To prevent
//! this, the angle is measured from the middle between the limits. If the limits are more than a turn apart, whole
//! turns are counted, and the limits that are passed to rapier are shifted accordingly.

use std::f64::consts::{PI, TAU};

use rapier3d::{
    dynamics::JointAxis,
    math::{Pose, Rotation, Vector},
};

use super::{
    joints,
    records::{JointBackend, JointRecord},
    state::Rapier,
};
use crate::{JointDesc, JointKind};

/// Returns the position at which rapier's angle is 0, rad. It is 0 if rapier's range suffices.
pub(super) fn zero(desc: &JointDesc) -> f64 {
    match (desc.kind, desc.limits) {
        (JointKind::Revolute, Some((low, high))) if low < -PI || high > PI => match high - low > TAU {
            true => (desc.position / TAU).round() * TAU,
            false => 0.5 * (low + high),
        },
        _ => 0.0,
    }
}

/// Returns the frame of a joint on the body that carries it, rotated by `zero`, rad.
pub(super) fn turned(frame: Pose, zero: f64) -> Pose {
    if zero == 0.0 { frame } else { frame * Pose::from_rotation(Rotation::from_axis_angle(Vector::Z, zero)) }
}

/// Returns a position within half a turn of the joint's position at creation, rad.
pub(super) fn near(desc: &JointDesc, zero: f64) -> f64 {
    if desc.limits.is_some() && desc.position.is_finite() { desc.position } else { zero }
}

/// Returns whether the limits of a revolute joint are more than a turn apart.
pub(super) fn is_wide(record: &JointRecord) -> bool {
    record.kind == JointKind::Revolute && record.limits.is_some_and(|(low, high)| high - low > TAU)
}

impl JointRecord {
    /// Returns the position of the joint, rad or m, from the world poses of its frames on both bodies.
    pub(super) fn position(&self, frame_a: &Pose, frame_b: &Pose) -> f64 {
        let angle = joints::position(self.kind, frame_a, frame_b);
        if is_wide(self) {
            return self.zero + angle + ((self.near - self.zero - angle) / TAU).round() * TAU;
        }
        // Do not add 0, which could change the bits of the angle.
        if self.zero == 0.0 { angle } else { self.zero + angle }
    }
}

impl Rapier {
    /// Counts the whole turns of joints whose limits are more than a turn apart, before a step.
    pub(super) fn count_turns(&mut self) {
        for i in 0..self.state.winding.len() {
            let id = self.state.winding[i];
            let Some(Some(record)) = self.state.joints.get(id.0 as usize) else { continue };
            let (frame_a, frame_b) = self.joint_frames(record);
            let position = record.position(&frame_a, &frame_b);
            let angle = joints::position(record.kind, &frame_a, &frame_b);
            let (held, limits) = (record.held, record.limits);
            if let Some(Some(record)) = self.state.joints.get_mut(id.0 as usize) {
                record.near = position;
            }
            // Coordinates in reduced form already include whole turns.
            let (JointBackend::Impulse(handle), Some((low, high))) = (held, limits) else { continue };
            let Some(joint) = self.world.impulse_joints.get_mut(handle, false) else { continue };
            let turns = position - angle;
            let limits = &mut joint.data.limits[JointAxis::AngZ as usize];
            (limits.min, limits.max) = ((low - turns).clamp(-PI, PI), (high - turns).clamp(-PI, PI));
        }
    }
}
