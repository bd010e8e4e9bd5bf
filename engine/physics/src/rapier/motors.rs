//! Motors of rapier's joints.

use rapier3d::{
    dynamics::{GenericJoint, JointAxesMask, JointMotor, MotorModel},
    math::Pose,
};

use super::tuning::MOTOR_DAMPING;

/// Returns a motor that reaches a velocity, rad/s or m/s, with at most a force, N m or N.
pub(crate) fn velocity_motor(target_vel: f64, max_force: f64) -> JointMotor {
    JointMotor { target_vel, damping: MOTOR_DAMPING, max_force, model: MotorModel::ForceBased, ..JointMotor::default() }
}

/// Returns a joint that leaves all axes free, to carry motors only.
pub(crate) fn motor_only(frames: (Pose, Pose)) -> GenericJoint {
    let mut joint = GenericJoint::new(JointAxesMask::empty());
    (joint.local_frame1, joint.local_frame2) = frames;
    joint.contacts_enabled = true;
    joint
}
