//! Joints and their drives, as impulse joints whose free axis is z of the joint frame.

use rapier3d::{
    dynamics::{
        GenericJoint, JointAxesMask, JointAxis, JointLimits, JointMotor, MotorModel, RigidBody, SpringCoefficients,
    },
    math::{Pose, Vector},
};

use super::records::{JointRecord, Memory};
use tatu_geometry::wrap_angle;

use crate::{Drive, JointDesc, JointForm, JointKind, Tracking};

/// N m s/rad or N s/m. So stiff that a motor below its limit misses its speed by less than its load divided by this:
/// 1e-6 rad/s at 1000 N m. It is a hard constraint in all but name, and stays well inside f64's range.
pub(super) const MOTOR_DAMPING: f64 = 1e9;

/// A speed that no joint reaches, so that a motor with this target exerts its whole limit, always.
const NEVER_REACHED: f64 = 1e6;

/// Seconds in which a position drive covers most (1 - 1/e) of what is left of its way, once it is so near that it
/// need no longer move at its highest velocity. V-REP's controller has the same: P = 0.1 at 5 ms steps.
const SETTLE_TIME: f64 = 0.05;

/// Stiffness of joints, as natural frequency (Hz) and damping ratio. With rapier's own (1 MHz, 1) a joint makes up
/// for its whole error in each sub-step; at steps of 10 ms a two-wheeled robot then chatters about its caster and
/// drifts by 70 mm in 4 m. From here on (half the frequency, or a third of the damping ratio, do as well) it makes up for
/// some 40 %, the robot stands still, and the sides of a joint stay within 0.5 mm of each other.
const SOFTNESS: (f64, f64) = (400.0, 5.0);

/// Most rounds added for one joint. A weight at the end of a light pole would take hundreds.
const MOST_ITERATIONS: f64 = 60.0;

/// Rounds added for a driven joint that carries other joints: without them a car with steered wheels creeps at 3 mm/s.
pub(super) const CARRIER_ITERATIONS: usize = 6;

impl JointKind {
    pub(super) fn free_axis(self) -> Option<JointAxis> {
        match self {
            JointKind::Revolute | JointKind::Screw(_) => Some(JointAxis::AngZ),
            JointKind::Prismatic => Some(JointAxis::LinZ),
            JointKind::Fixed | JointKind::Spherical => None,
        }
    }
}

/// `zero` is where rapier's angle is 0, rad.
pub(super) fn build(desc: &JointDesc, frames: (Pose, Pose), zero: f64) -> GenericJoint {
    let free = desc.kind.free_axis();
    let freed = match desc.kind {
        JointKind::Spherical => JointAxesMask::ANG_AXES,
        JointKind::Screw(_) => JointAxesMask::ANG_Z | JointAxesMask::LIN_Z,
        _ => free.map_or(JointAxesMask::empty(), JointAxesMask::from),
    };
    let mut joint = GenericJoint::new(JointAxesMask::LOCKED_FIXED_AXES & !freed);
    (joint.local_frame1, joint.local_frame2) = frames;
    // Whether the two collide is for their masks to say.
    joint.contacts_enabled = true;
    if desc.form == JointForm::Impulse {
        joint.softness = SpringCoefficients::new(SOFTNESS.0, SOFTNESS.1);
        // Limits of a locked axis make no row between bodies that are not in reduced form, but keep the joint off rapier's wide path, which exists only from 64
        // joints on and goes through the joints of a robot in another order: its motion would depend on how many others
        // there are.
        joint.limit_axes |= JointAxesMask::LIN_X;
        joint.coupled_axes |= JointAxesMask::LIN_X;
    }
    if let (Some(axis), Some((low, high))) = (free, desc.limits) {
        joint.limit_axes |= axis.into();
        joint.limits[axis as usize] = JointLimits { min: low - zero, max: high - zero, impulse: 0.0 };
    }
    joint
}

/// A joint that leaves everything free, for the row of a drive alone.
pub(super) fn motor_only(frames: (Pose, Pose)) -> GenericJoint {
    let mut joint = GenericJoint::new(JointAxesMask::empty());
    (joint.local_frame1, joint.local_frame2) = frames;
    joint.contacts_enabled = true;
    joint
}

/// The kind of a joint of one degree of freedom.
pub(super) fn kind_of(joint: &GenericJoint) -> JointKind {
    match joint.locked_axes.contains(JointAxesMask::LIN_Z) {
        true => JointKind::Revolute,
        false => JointKind::Prismatic,
    }
}

/// A drive that can do no harm: a number that is none, or no force at all, is no drive.
pub(super) fn sane(drive: Drive) -> Drive {
    let good = match drive {
        Drive::Free => true,
        Drive::Velocity { target, max_force, slip } => target.is_finite() && max_force > 0.0 && slip >= 0.0,
        Drive::Position { target, max_force, max_velocity, tracking } => {
            let sane = |t: Tracking| [t.p, t.i, t.d, t.velocity].iter().all(|x| x.is_finite());
            target.is_finite() && max_force > 0.0 && max_velocity > 0.0 && tracking.is_none_or(sane)
        }
        Drive::Force(force) => force.is_finite() && force != 0.0,
    };
    if good { drive } else { Drive::Free }
}

/// Tells the engine's joint what drives it.
pub(super) fn apply(joint: &mut GenericJoint, record: &JointRecord) {
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
        // The row of a motor that is to stand still, and yields.
        Drive::Free if record.reduced().is_none() && record.passive.damping > 0.0 => {
            JointMotor { damping: record.passive.damping, ..motor(0.0, f64::MAX) }
        }
        // No row at all.
        Drive::Free => {
            joint.motor_axes &= !JointAxesMask::from(axis);
            joint.motors[axis as usize] = JointMotor::default();
            return;
        }
        Drive::Velocity { target, max_force, slip } if slip > 1.0 / MOTOR_DAMPING => {
            JointMotor { damping: 1.0 / slip, ..motor(target, max_force) }
        }
        Drive::Velocity { target, max_force, .. } => motor(target, max_force),
        // The same force on both bodies, along the axis as it is in each sub-step.
        Drive::Force(force) => motor(NEVER_REACHED.copysign(force), force.abs()),
        // Not by rapier's own spring: how fast that is depends on the number of sub-steps.
        Drive::Position { max_force, .. } => motor(record.pursuit, max_force),
    };
    let motor = match record.passive.no_load_speed > 0.0 {
        true => weakened(motor, record),
        false => motor,
    };
    joint.motor_axes |= axis.into();
    joint.motors[axis as usize] = motor;
}

/// A motor whose limit falls with its speed. Where it had reached the limit it follows the line of torque over speed, which
/// a row that gives way by a damping is, so that it settles at the speed at which the line meets the load.
fn weakened(motor: JointMotor, record: &JointRecord) -> JointMotor {
    let (no_load, speed) = (record.passive.no_load_speed, record.speed);
    let wanted = wanted(record).unwrap_or(motor.target_vel);
    let direction = 1.0f64.copysign(wanted - speed);
    // A motor that brakes has its whole limit.
    if direction * speed < 0.0 {
        return motor;
    }
    if record.at_limit {
        let damping = motor.max_force / no_load;
        return JointMotor { target_vel: direction * no_load, damping, ..motor };
    }
    JointMotor { max_force: motor.max_force * (1.0 - direction * speed / no_load).max(0.0), ..motor }
}

/// Dry friction that a drive takes upon itself. Rapier solves the row of a drive before that of the friction, once in each
/// sub-step: a light wheel would lag behind its motor by friction * sub-step / inertia.
pub(super) fn folded(record: &JointRecord) -> f64 {
    let limit = match record.drive {
        Drive::Velocity { max_force, slip: 0.0, .. } | Drive::Position { max_force, .. } => max_force,
        _ => return 0.0,
    };
    if limit > record.passive.friction && !record.at_limit { record.passive.friction } else { 0.0 }
}

/// The velocity that a drive wants; `None`: more than there is.
pub(super) fn wanted(record: &JointRecord) -> Option<f64> {
    match record.drive {
        Drive::Velocity { target, .. } => Some(target),
        Drive::Position { .. } => Some(record.pursuit),
        Drive::Free | Drive::Force(_) => None,
    }
}

/// How often more a driven joint must be gone through in each sub-step.
///
/// Rapier solves the motor and the pivot of a joint one after the other. Where the moved body's centre of mass lies
/// on the axis, as in a wheel, once is exact. Else each round leaves 1 - 1/q of the error, q being the ratio of the
/// inertia about the axis to that about the centre of mass: 3/4 for a rod held at its end, which would then lag
/// behind gravity by 0.04 rad/s. Six rounds for each 1 of q above 1 leave less than 0.3 %.
pub(super) fn iterations(frames: (Pose, Pose), a: &RigidBody, b: &RigidBody) -> usize {
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
    // Not a number for bodies without inertia. Below 1.01 the first round leaves less than 1 %: a wheel on a chassis.
    if q.is_nan() || q < 1.01 { 0 } else { (6.0 * (q - 1.0)).ceil().min(MOST_ITERATIONS) as usize }
}

/// Velocity at which a position drive that stands at `position` moves in the next `dt`, s, and what its controller then
/// remembers.
pub(super) fn pursue(record: &JointRecord, position: f64, dt: f64) -> (f64, Memory) {
    let Drive::Position { target, max_velocity, tracking, .. } = record.drive else {
        return (0.0, Memory::default());
    };
    let mut way = target - position;
    // A joint without limits takes the shorter way round.
    if record.kind == JointKind::Revolute && record.limits.is_none() {
        way = wrap_angle(way);
    }
    let Some(t) = tracking else {
        return ((way / SETTLE_TIME.max(dt)).clamp(-max_velocity, max_velocity), Memory::default());
    };
    let Memory { sum, last } = record.memory;
    let next = sum + way * dt;
    let change = last.map_or(0.0, |l| (way - l) / dt);
    let wanted = t.p * way + t.i * next + t.d * change + t.velocity;
    let velocity = wanted.clamp(-max_velocity, max_velocity);
    // At its highest velocity the error is not summed up: it would have to be made up for later.
    let sum = if velocity == wanted { next } else { sum };
    (velocity, Memory { sum, last: Some(way) })
}

/// Position of a joint whose frames on both bodies stand so in the world, as rapier counts it.
pub(super) fn position(kind: JointKind, frame_a: &Pose, frame_b: &Pose) -> f64 {
    match kind {
        JointKind::Revolute | JointKind::Screw(_) => {
            let q = frame_a.rotation.inverse() * frame_b.rotation;
            // nalgebra's function is the same on every system, the standard library's is not.
            wrap_angle(2.0 * nalgebra::RealField::atan2(q.z, q.w))
        }
        JointKind::Prismatic => (frame_b.translation - frame_a.translation).dot(frame_a.rotation * Vector::Z),
        JointKind::Fixed | JointKind::Spherical => 0.0,
    }
}
