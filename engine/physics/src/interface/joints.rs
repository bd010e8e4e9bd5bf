//! Joints: their descriptions, their drives, and the values that are read from them.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::ids::{BodyId, JointId};

/// The degrees of freedom of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum JointKind {
    /// Rotation about the z axis of the joint frame.
    Revolute,
    /// Translation along the z axis of the joint frame.
    Prismatic,
    /// Rotation about z with a translation along z of this many metres per radian, like a nut on a thread. A screw is
    /// always solved in reduced form.
    Screw(f64),
    /// Rotation about any axis. The joint has no position and cannot be driven.
    Spherical,
    /// No degree of freedom: the bodies are rigidly connected.
    Fixed,
}

/// Description of a joint to create, between body `a` (parent) and body `b` (child).
#[derive(Debug, Clone)]
pub struct JointDesc {
    /// The body that carries the joint.
    pub a: BodyId,
    /// The body that the joint moves.
    pub b: BodyId,
    /// Pose of the joint frame in body `a`.
    pub frame_in_a: Isometry3<f64>,
    /// Pose of the joint frame in body `b` at position 0.
    pub frame_in_b: Isometry3<f64>,
    /// The joint's degrees of freedom.
    pub kind: JointKind,
    /// Lowest and highest position, rad or m; `None` means no limits.
    pub limits: Option<(f64, f64)>,
    /// Position at creation, rad or m. It is used only for revolute joints with limits, where it determines the number
    /// of whole turns.
    pub position: f64,
    /// How the joint is enforced.
    pub form: JointForm,
    /// Passive forces of the joint.
    pub passive: PassiveForces,
    /// Whether [`Engine::set_gears`](crate::Engine::set_gears) may couple the joint to another one, as follower or
    /// leader.
    pub geared: bool,
}

/// A coupling of two joints of one mechanism: `position = ratio * leader's position + offset`. Forces act in both
/// directions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gear {
    /// The joint that follows.
    pub joint: JointId,
    /// The joint that `joint` follows.
    pub leader: JointId,
    /// Change of the joint's position per unit of the leader's position.
    pub ratio: f64,
    /// Position of the joint when the leader is at 0, rad or m.
    pub offset: f64,
}

/// How a joint is enforced. All joints of a mechanism have the same form, except those that close loops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum JointForm {
    /// Reduced coordinates: only the degrees of freedom of the joint are computed, so its bodies cannot separate. This
    /// form is exact at any load, at a cost that grows with the cube of the number of joints of a mechanism.
    #[default]
    Reduced,
    /// Impulses pull the bodies of the joint together: cheap, but soft under load.
    Impulse,
    /// The links of a tree, solved by `tatu_mechanisms` outside rapier: as exact as [`JointForm::Reduced`], at a cost
    /// that grows with the number of joints times their depth. Not available for screws and loops.
    Tree,
    /// Impulses close a loop between bodies that other joints, of any form, already connect.
    Loop,
}

/// Passive forces of a joint, besides its drive. All are 0 by default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PassiveForces {
    /// Damping, N m s/rad or N s/m.
    pub damping: f64,
    /// Dry friction, N m or N. Not supported in impulse form.
    pub friction: f64,
    /// Inertia of a rotor behind a gearbox, reflected to the joint, kg m^2 or kg. Not supported in impulse form.
    pub armature: f64,
    /// Stiffness of a spring towards `rest`, N m/rad or N/m. Not supported in impulse form.
    pub stiffness: f64,
    /// Rest position of the spring, rad or m.
    pub rest: f64,
    /// Speed at which the drive has no effort left, rad/s or m/s: its limit falls linearly from `max_force` at rest to
    /// 0 at this speed, as for a DC motor. 0 means that the limit does not depend on speed.
    pub no_load_speed: f64,
}

/// Controller of a position drive. The velocity that it commands is
/// `p * error + i * (integral of error) + d * (derivative of error) + velocity`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PositionController {
    /// Proportional gain, 1/s.
    pub p: f64,
    /// Integral gain, 1/s^2.
    pub i: f64,
    /// Derivative gain, dimensionless.
    pub d: f64,
    /// Velocity of the target, rad/s or m/s.
    pub velocity: f64,
}

/// The drive of a joint. Torques are in N m, forces in N, and velocities in rad/s or m/s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum JointDrive {
    /// No drive: the joint is passive.
    Free,
    /// Reaches velocity `target` with at most `max_force`.
    Velocity {
        /// Target velocity, rad/s or m/s.
        target: f64,
        /// Maximum torque, N m, or force, N.
        max_force: f64,
        /// Speed lost per unit of load, rad/s per N m or m/s per N; 0 means no slip.
        slip: f64,
    },
    /// Holds position `target` with at most `max_force`, moving there with at most `max_velocity`.
    Position {
        /// Target position, rad or m.
        target: f64,
        /// Maximum torque, N m, or force, N.
        max_force: f64,
        /// Maximum velocity, rad/s or m/s.
        max_velocity: f64,
        /// Controller; `None` means that the error decays to 1/e of its value in 0.05 s, without overshoot.
        tracking: Option<PositionController>,
    },
    /// Exerts a constant torque, N m, or force, N.
    Force(f64),
}

/// The state of a joint after the last step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointState {
    /// Position, rad or m. For revolute joints, it is in (-pi, pi] without limits, and includes whole turns with
    /// limits.
    pub position: f64,
    /// For a spherical joint: rotation of the frame on body `b` relative to that on body `a`.
    pub rotation: UnitQuaternion<f64>,
    /// Velocity, rad/s or m/s.
    pub velocity: f64,
    /// Torque or force that the drive exerted in the last step, N m or N.
    pub effort: f64,
}

/// A force, and a torque about a point.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Wrench {
    /// Force, N.
    pub force: Vector3<f64>,
    /// Torque, N m.
    pub torque: Vector3<f64>,
}
