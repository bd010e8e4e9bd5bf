//! Positions of joints.
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
use tatu_geometry::wrap_angle;

use super::record::JointRecord;
use crate::{JointDesc, JointKind, rapier::bodies::Bodies};

/// Indices of rapier's coordinates along and about the axis of a joint.
pub(crate) const ALONG_AXIS: usize = 2;
pub(crate) const ABOUT_AXIS: usize = 5;

/// Returns rapier's axis of the degree of freedom that a drive moves.
pub(crate) fn free_axis(kind: JointKind) -> Option<JointAxis> {
    match kind {
        JointKind::Revolute | JointKind::Screw(_) => Some(JointAxis::AngZ),
        JointKind::Prismatic => Some(JointAxis::LinZ),
        JointKind::Fixed | JointKind::Spherical => None,
    }
}

/// Returns the index of the driven degree of freedom of a joint, and that of its coordinate. The first degree of
/// freedom of a screw is its translation, and the second one, which is driven, its rotation.
pub(crate) fn coordinate(kind: JointKind) -> (usize, usize) {
    match kind {
        JointKind::Screw(_) => (1, ABOUT_AXIS),
        JointKind::Prismatic => (0, ALONG_AXIS),
        _ => (0, ABOUT_AXIS),
    }
}

/// Returns the position of a joint, as rapier measures it, from the world poses of its frames on both bodies.
pub(crate) fn position(kind: JointKind, frame_a: &Pose, frame_b: &Pose) -> f64 {
    match kind {
        JointKind::Revolute | JointKind::Screw(_) => {
            let q = frame_a.rotation.inverse() * frame_b.rotation;
            // nalgebra's `atan2` gives the same result on every system; the standard library's does not.
            wrap_angle(2.0 * nalgebra::RealField::atan2(q.z, q.w))
        }
        JointKind::Prismatic => (frame_b.translation - frame_a.translation).dot(frame_a.rotation * Vector::Z),
        JointKind::Fixed | JointKind::Spherical => 0.0,
    }
}

/// Returns the position at which rapier's angle is 0, rad. It is 0 if rapier's range suffices.
pub(crate) fn zero(desc: &JointDesc) -> f64 {
    match (desc.kind, desc.limits) {
        (JointKind::Revolute, Some((low, high))) if low < -PI || high > PI => match high - low > TAU {
            true => (desc.position / TAU).round() * TAU,
            false => 0.5 * (low + high),
        },
        _ => 0.0,
    }
}

/// Returns the frame of a joint on the body that carries it, rotated by `zero`, rad.
pub(crate) fn turned(frame: Pose, zero: f64) -> Pose {
    if zero == 0.0 { frame } else { frame * Pose::from_rotation(Rotation::from_axis_angle(Vector::Z, zero)) }
}

/// Returns a position within half a turn of the joint's position at creation, rad.
pub(crate) fn near(desc: &JointDesc, zero: f64) -> f64 {
    if desc.limits.is_some() && desc.position.is_finite() { desc.position } else { zero }
}

impl JointRecord {
    /// Returns whether the limits of a revolute joint are more than a turn apart.
    pub fn is_wide(&self) -> bool {
        self.kind == JointKind::Revolute && self.limits.is_some_and(|(low, high)| high - low > TAU)
    }

    /// Returns the world poses of the joint's frames on both bodies.
    pub fn world_frames(&self, bodies: &Bodies) -> (Pose, Pose) {
        (bodies.position(self.bodies.0) * self.frames.0, bodies.position(self.bodies.1) * self.frames.1)
    }

    /// Returns the position of the joint, rad or m, from the world poses of its frames on both bodies.
    pub fn position(&self, frame_a: &Pose, frame_b: &Pose) -> f64 {
        let (angle, zero) = (position(self.kind, frame_a, frame_b), self.turns.zero);
        if self.is_wide() {
            return zero + angle + ((self.turns.near - zero - angle) / TAU).round() * TAU;
        }
        // Do not add 0, which could change the bits of the angle.
        if zero == 0.0 { angle } else { zero + angle }
    }

    /// Returns the current position of the joint, rad or m.
    pub fn current_position(&self, bodies: &Bodies) -> f64 {
        let (frame_a, frame_b) = self.world_frames(bodies);
        self.position(&frame_a, &frame_b)
    }
}
