//! Motors of rapier's joints, as the drives of joints in impulse and reduced form require.

use rapier3d::dynamics::{GenericJoint, JointAxesMask, JointMotor};

use super::{
    controller::target_velocity,
    position::free_axis,
    record::{DriveState, JointRecord},
};
use crate::{
    JointDrive,
    rapier::{
        motors::velocity_motor,
        tuning::{MOTOR_DAMPING, UNREACHABLE_SPEED},
    },
};

/// Sets the motor of rapier's joint from its record.
pub(crate) fn apply_motor(joint: &mut GenericJoint, record: &JointRecord) {
    let Some(axis) = free_axis(record.kind) else {
        return;
    };
    let DriveState { requested, pursuit, folded, .. } = record.drive;
    let motor = |target: f64, max_force: f64| velocity_motor(target, (max_force - folded).min(f64::MAX));
    let motor = match requested {
        // Passive damping is a motor with target velocity 0 and this damping.
        JointDrive::Free if record.reduced().is_none() && record.passive.damping > 0.0 => {
            JointMotor { damping: record.passive.damping, ..motor(0.0, f64::MAX) }
        }
        JointDrive::Free => {
            joint.motor_axes &= !JointAxesMask::from(axis);
            joint.motors[axis as usize] = JointMotor::default();
            return;
        }
        JointDrive::Velocity { target, max_force, slip } if slip > 1.0 / MOTOR_DAMPING => {
            JointMotor { damping: 1.0 / slip, ..motor(target, max_force) }
        }
        JointDrive::Velocity { target, max_force, .. } => motor(target, max_force),
        // The same force acts on both bodies along the axis, which is updated in each sub-step.
        JointDrive::Force(force) => motor(UNREACHABLE_SPEED.copysign(force), force.abs()),
        // Rapier's own spring is not used, because its speed would depend on the number of sub-steps.
        JointDrive::Position { max_force, .. } => motor(pursuit, max_force),
    };
    let motor = match record.passive.no_load_speed > 0.0 {
        true => weakened_motor(motor, record),
        false => motor,
    };
    joint.motor_axes |= axis.into();
    joint.motors[axis as usize] = motor;
}

/// Returns a motor whose limit falls with its speed. Once the motor has reached the limit, it follows its torque-speed
/// line, as a motor with finite damping does, and settles at the speed at which its torque equals the load.
fn weakened_motor(motor: JointMotor, record: &JointRecord) -> JointMotor {
    let (no_load, speed) = (record.passive.no_load_speed, record.drive.speed);
    let wanted = target_velocity(record).unwrap_or(motor.target_vel);
    let direction = 1.0f64.copysign(wanted - speed);
    // A braking motor keeps its full limit.
    if direction * speed < 0.0 {
        return motor;
    }
    if record.drive.at_limit {
        let damping = motor.max_force / no_load;
        return JointMotor { target_vel: direction * no_load, damping, ..motor };
    }
    JointMotor {
        // Without this limit, a light load could exceed the no-load speed within a sub-step.
        target_vel: motor.target_vel.clamp(-no_load, no_load),
        max_force: motor.max_force * (1.0 - direction * speed / no_load).max(0.0),
        ..motor
    }
}

/// Returns the dry friction that a drive absorbs into its own limit. Rapier solves the constraint of a drive before
/// that of the friction, once in each sub-step, so a light wheel would lag behind its motor by friction * sub-step /
/// inertia.
pub(crate) fn folded_friction(record: &JointRecord) -> f64 {
    let limit = match record.drive.requested {
        JointDrive::Velocity { max_force, slip: 0.0, .. } | JointDrive::Position { max_force, .. } => max_force,
        _ => return 0.0,
    };
    if limit > record.passive.friction && !record.drive.at_limit { record.passive.friction } else { 0.0 }
}
