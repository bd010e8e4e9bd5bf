//! The velocities that drives command.

use tatu_geometry::wrap_angle;

use super::record::{ControllerState, JointRecord};
use crate::{JointDrive, JointKind, PositionController, rapier::tuning::SETTLE_TIME};

/// Returns the drive, or [`JointDrive::Free`] if it has invalid values or no force.
pub(crate) fn sanitized(drive: JointDrive) -> JointDrive {
    let good = match drive {
        JointDrive::Free => true,
        JointDrive::Velocity { target, max_force, slip } => target.is_finite() && max_force > 0.0 && slip >= 0.0,
        JointDrive::Position { target, max_force, max_velocity, tracking } => {
            let sane = |t: PositionController| [t.p, t.i, t.d, t.velocity].iter().all(|x| x.is_finite());
            target.is_finite() && max_force > 0.0 && max_velocity > 0.0 && tracking.is_none_or(sane)
        }
        JointDrive::Force(force) => force.is_finite() && force != 0.0,
    };
    if good { drive } else { JointDrive::Free }
}

/// Returns the target velocity of a drive, or `None` if the drive has no target velocity.
pub(crate) fn target_velocity(record: &JointRecord) -> Option<f64> {
    match record.drive.requested {
        JointDrive::Velocity { target, .. } => Some(target),
        JointDrive::Position { .. } => Some(record.drive.pursuit),
        JointDrive::Free | JointDrive::Force(_) => None,
    }
}

/// Returns the velocity of a position drive at `position` for the next `dt`, s, and the new memory of its controller.
/// `pressed` is the sign of the drive's force if it was at its limit in the last step, otherwise 0.
pub(crate) fn controller_velocity(
    record: &JointRecord,
    position: f64,
    dt: f64,
    pressed: f64,
) -> (f64, ControllerState) {
    let JointDrive::Position { target, max_velocity, tracking, .. } = record.drive.requested else {
        return (0.0, ControllerState::default());
    };
    let mut way = target - position;
    // A joint without limits turns in the direction of the shorter path.
    if record.kind == JointKind::Revolute && record.limits.is_none() {
        way = wrap_angle(way);
    }
    let Some(t) = tracking else {
        return ((way / SETTLE_TIME.max(dt)).clamp(-max_velocity, max_velocity), ControllerState::default());
    };
    let ControllerState { sum, last } = record.drive.memory;
    let next = sum + way * dt;
    let change = last.map_or(0.0, |l| (way - l) / dt);
    let wanted = t.p * way + t.i * next + t.d * change + t.velocity;
    let velocity = wanted.clamp(-max_velocity, max_velocity);
    // The error is not integrated while the velocity or the force is at its limit and the integral would press further,
    // which prevents windup.
    let held = velocity != wanted || pressed * t.i * way > 0.0;
    let sum = if held { sum } else { next };
    (velocity, ControllerState { sum, last: Some(way) })
}
