//! Joints and their drives, as impulse joints whose free axis is the z axis of the joint frame.

use rapier3d::{
    dynamics::{
        GenericJoint, JointAxesMask, JointAxis, JointLimits, JointMotor, MotorModel, RigidBody, SpringCoefficients,
    },
    math::{Pose, Vector},
};

use super::{
    records::{ControllerState, JointRecord},
    tuning::{JOINT_SOFTNESS, MAX_ADDED_ITERATIONS, MOTOR_DAMPING, SETTLE_TIME, UNREACHABLE_SPEED},
};
use tatu_geometry::wrap_angle;

use crate::{JointDesc, JointDrive, JointForm, JointKind, PositionController};

impl JointKind {
    pub(super) fn free_axis(self) -> Option<JointAxis> {
        match self {
            JointKind::Revolute | JointKind::Screw(_) => Some(JointAxis::AngZ),
            JointKind::Prismatic => Some(JointAxis::LinZ),
            JointKind::Fixed | JointKind::Spherical => None,
        }
    }
}

/// Builds rapier's joint. `zero` is the joint's position at which rapier's angle is 0, rad.
pub(super) fn build_joint(desc: &JointDesc, frames: (Pose, Pose), zero: f64) -> GenericJoint {
    let free = desc.kind.free_axis();
    let freed = match desc.kind {
        JointKind::Spherical => JointAxesMask::ANG_AXES,
        JointKind::Screw(_) => JointAxesMask::ANG_Z | JointAxesMask::LIN_Z,
        _ => free.map_or(JointAxesMask::empty(), JointAxesMask::from),
    };
    let mut joint = GenericJoint::new(JointAxesMask::LOCKED_FIXED_AXES & !freed);
    (joint.local_frame1, joint.local_frame2) = frames;
    // The bodies' masks decide whether they collide.
    joint.contacts_enabled = true;
    if desc.form == JointForm::Impulse {
        joint.softness = SpringCoefficients::new(JOINT_SOFTNESS.0, JOINT_SOFTNESS.1);
        // Limits on a locked axis add no constraint between bodies that are not in reduced form, but keep the joint off
        // rapier's SIMD path. Rapier uses that path only for 64 or more joints, and it solves a robot's joints in a
        // different order, so the motion of a robot would depend on the number of other joints.
        joint.limit_axes |= JointAxesMask::LIN_X;
        joint.coupled_axes |= JointAxesMask::LIN_X;
    }
    if let (Some(axis), Some((low, high))) = (free, desc.limits) {
        joint.limit_axes |= axis.into();
        joint.limits[axis as usize] = JointLimits { min: low - zero, max: high - zero, impulse: 0.0 };
    }
    joint
}

/// Builds a joint that leaves all axes free, to carry the constraint of a drive only.
pub(super) fn motor_only(frames: (Pose, Pose)) -> GenericJoint {
    let mut joint = GenericJoint::new(JointAxesMask::empty());
    (joint.local_frame1, joint.local_frame2) = frames;
    joint.contacts_enabled = true;
    joint
}

/// Returns the kind of a joint with one degree of freedom.
pub(super) fn kind_of(joint: &GenericJoint) -> JointKind {
    match joint.locked_axes.contains(JointAxesMask::LIN_Z) {
        true => JointKind::Revolute,
        false => JointKind::Prismatic,
    }
}

/// Returns the drive, or [`JointDrive::Free`] if it has invalid values or no force.
pub(super) fn sanitized(drive: JointDrive) -> JointDrive {
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

/// Sets the motor of rapier's joint from its record.
pub(super) fn apply_motor(joint: &mut GenericJoint, record: &JointRecord) {
    let Some(axis) = record.kind.free_axis() else {
        return;
    };
    let motor = |target_vel: f64, max_force: f64| JointMotor {
        target_vel,
        damping: MOTOR_DAMPING,
        max_force: (max_force - record.folded).min(f64::MAX),
        model: MotorModel::ForceBased,
        ..JointMotor::default()
    };
    let motor = match record.drive {
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
        JointDrive::Position { max_force, .. } => motor(record.pursuit, max_force),
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
    let (no_load, speed) = (record.passive.no_load_speed, record.speed);
    let wanted = target_velocity(record).unwrap_or(motor.target_vel);
    let direction = 1.0f64.copysign(wanted - speed);
    // A braking motor keeps its full limit.
    if direction * speed < 0.0 {
        return motor;
    }
    if record.at_limit {
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
pub(super) fn folded_friction(record: &JointRecord) -> f64 {
    let limit = match record.drive {
        JointDrive::Velocity { max_force, slip: 0.0, .. } | JointDrive::Position { max_force, .. } => max_force,
        _ => return 0.0,
    };
    if limit > record.passive.friction && !record.at_limit { record.passive.friction } else { 0.0 }
}

/// Returns the target velocity of a drive, or `None` if the drive has no target velocity.
pub(super) fn target_velocity(record: &JointRecord) -> Option<f64> {
    match record.drive {
        JointDrive::Velocity { target, .. } => Some(target),
        JointDrive::Position { .. } => Some(record.pursuit),
        JointDrive::Free | JointDrive::Force(_) => None,
    }
}

/// Returns the number of additional iterations that a driven joint needs in each sub-step.
///
/// Rapier solves the motor and the pivot of a joint one after the other. If the moved body's centre of mass is on the
/// axis, as in a wheel, one iteration is exact. Otherwise each iteration leaves 1 - 1/q of the error, where q is the
/// ratio of the inertia about the axis to that about the centre of mass: 3/4 for a rod held at its end, which would
/// then lag behind gravity by 0.04 rad/s. Six iterations per unit of q above 1 leave less than 0.3 %.
pub(super) fn added_iterations(frames: (Pose, Pose), a: &RigidBody, b: &RigidBody) -> usize {
    let (frame_a, frame_b) = (a.position() * frames.0, b.position() * frames.1);
    let axis = frame_b.rotation * Vector::Z;
    let mobility = |body: &RigidBody, pivot: Vector| {
        if !body.is_dynamic() {
            return (0.0, 0.0);
        }
        let about_com = axis.dot(body.mass_properties().effective_world_inv_inertia * axis);
        let arm = (pivot - body.center_of_mass()).cross(axis);
        let inertia = 1.0 / about_com + body.mass() * arm.length_squared();
        (about_com, 1.0 / inertia)
    };
    let (of_a, of_b) = (mobility(a, frame_a.translation), mobility(b, frame_b.translation));
    let q = (of_a.0 + of_b.0) / (of_a.1 + of_b.1);
    // The ratio is NaN for bodies without inertia. Below 1.01, as for a wheel on a chassis, the first iteration leaves
    // less than 1 %.
    if q.is_nan() || q < 1.01 { 0 } else { (6.0 * (q - 1.0)).ceil().min(MAX_ADDED_ITERATIONS) as usize }
}

/// Returns the velocity of a position drive at `position` for the next `dt`, s, and the new memory of its controller.
/// `pressed` is the sign of the drive's force if it was at its limit in the last step, otherwise 0.
pub(super) fn controller_velocity(
    record: &JointRecord,
    position: f64,
    dt: f64,
    pressed: f64,
) -> (f64, ControllerState) {
    let JointDrive::Position { target, max_velocity, tracking, .. } = record.drive else {
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
    let ControllerState { sum, last } = record.memory;
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

/// Returns the position of a joint, as rapier measures it, from the world poses of its frames on both bodies.
pub(super) fn position(kind: JointKind, frame_a: &Pose, frame_b: &Pose) -> f64 {
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
