//! Revolute joints whose limits lie beyond half a turn.
//!
//! Rapier takes the angle of a joint from the rotation between its bodies, from -pi to pi, and measures limits by it. A
//! joint that may stand from 47 to 313 degrees would be outside its limits at 180. So the angle is counted from the
//! middle between the limits. If these are more than a turn apart, turns are counted, and the limits that are in reach
//! are moved along with them.

use std::f64::consts::{PI, TAU};

use rapier3d::{
    dynamics::JointAxis,
    math::{Pose, Rotation, Vector},
};

use super::{
    joints,
    records::{Held, JointRecord},
    state::Rapier,
};
use crate::{JointDesc, JointKind};

/// Where rapier's angle is 0, rad: 0 wherever its own range will do.
pub(super) fn zero(desc: &JointDesc) -> f64 {
    match (desc.kind, desc.limits) {
        (JointKind::Revolute, Some((low, high))) if low < -PI || high > PI => match high - low > TAU {
            true => (desc.position / TAU).round() * TAU,
            false => 0.5 * (low + high),
        },
        _ => 0.0,
    }
}

/// The frame of a joint on the body that carries it, turned by so much.
pub(super) fn turned(frame: Pose, zero: f64) -> Pose {
    if zero == 0.0 { frame } else { frame * Pose::from_rotation(Rotation::from_axis_angle(Vector::Z, zero)) }
}

/// A position within half a turn of that at creation, where it can be known.
pub(super) fn near(desc: &JointDesc, zero: f64) -> f64 {
    if desc.limits.is_some() && desc.position.is_finite() { desc.position } else { zero }
}

/// Whether it may turn more than once.
pub(super) fn is_wide(record: &JointRecord) -> bool {
    record.kind == JointKind::Revolute && record.limits.is_some_and(|(low, high)| high - low > TAU)
}

impl JointRecord {
    /// Position, rad or m, of the joint with its frames on both bodies in the world.
    pub(super) fn position(&self, frame_a: &Pose, frame_b: &Pose) -> f64 {
        let angle = joints::position(self.kind, frame_a, frame_b);
        if is_wide(self) {
            return self.zero + angle + ((self.near - self.zero - angle) / TAU).round() * TAU;
        }
        // An angle stays the one it is, bit for bit.
        if self.zero == 0.0 { angle } else { self.zero + angle }
    }
}

impl Rapier {
    /// Counts the turns of joints that may turn more than once, before a step.
    pub(super) fn count_turns(&mut self) {
        for i in 0..self.tables.winding.len() {
            let id = self.tables.winding[i];
            let Some(Some(record)) = self.tables.joints.get(id.0 as usize) else { continue };
            let (frame_a, frame_b) = self.joint_frames(record);
            let position = record.position(&frame_a, &frame_b);
            let angle = joints::position(record.kind, &frame_a, &frame_b);
            let (held, limits) = (record.held, record.limits);
            if let Some(Some(record)) = self.tables.joints.get_mut(id.0 as usize) {
                record.near = position;
            }
            // Coordinates of the reduced form count turns by themselves.
            let (Held::Impulse(handle), Some((low, high))) = (held, limits) else { continue };
            let Some(joint) = self.world.impulse_joints.get_mut(handle, false) else { continue };
            let turns = position - angle;
            let limits = &mut joint.data.limits[JointAxis::AngZ as usize];
            (limits.min, limits.max) = ((low - turns).clamp(-PI, PI), (high - turns).clamp(-PI, PI));
        }
    }
}
