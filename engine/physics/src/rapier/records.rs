//! The engine's records of bodies and joints, in addition to rapier's own data.

use std::collections::BTreeMap;

use nalgebra::Isometry3;
use rapier3d::{
    dynamics::{ImpulseJointHandle, MultibodyJointHandle, RigidBodyHandle},
    math::{Pose, Rotation, Vector},
};
use serde::{Deserialize, Serialize};

use crate::{BodyId, CollisionMask, JointDrive, JointId, JointKind, MotionType, PassiveForces, Wrench, convert};

/// The engine's data about a body.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct BodyRecord {
    pub handle: RigidBodyHandle,
    pub motion: MotionType,
    pub respond: CollisionMask,
    /// Centre of mass in the body's frame. It is the origin of rapier's body, because rapier's reduced form rotates a
    /// free root about its origin.
    pub com: Vector,
    /// Number of joints attached to the body.
    pub joints: u32,
    /// Whether the principal moments of inertia differ.
    pub uneven: bool,
    /// Whether a tree moves the body, in which case rapier treats it as kinematic: see [`super::trees`].
    pub in_tree: bool,
}

impl BodyRecord {
    /// Converts a pose in the body's frame to the frame of rapier's body.
    pub fn local_pose(&self, pose: &Isometry3<f64>) -> Pose {
        let mut pose = convert::pose(pose);
        pose.translation -= self.com;
        pose
    }
    /// Returns the pose of rapier's body for a pose of the body.
    pub fn rapier_pose(&self, pose: &Isometry3<f64>) -> Pose {
        convert::pose(pose) * Pose::from_translation(self.com)
    }
    /// Returns the pose of the body for a pose of rapier's body.
    pub fn body_pose(&self, pose: &Pose) -> Pose {
        *pose * Pose::from_translation(-self.com)
    }
}

/// The bodies of one collision tree, without those that collide with nothing.
#[derive(Default, Serialize, Deserialize)]
pub(super) struct CollisionTree {
    pub members: Vec<BodyId>,
    /// Whether the low bytes let some pair collide for which the high bytes alone would not allow it.
    pub wide: bool,
}

/// The engine's data about a joint.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct JointRecord {
    pub held: JointBackend,
    pub kind: JointKind,
    pub bodies: (BodyId, BodyId),
    /// The joint's frames on both of rapier's bodies.
    pub frames: (Pose, Pose),
    pub passive: PassiveForces,
    /// Lowest and highest position, rad or m.
    pub limits: Option<(f64, f64)>,
    /// Position at which rapier's angle of a revolute joint is 0, rad: see [`super::turns`].
    pub zero: f64,
    /// A position within half a turn of the current one, rad.
    pub near: f64,
    /// Whether the joint can be geared to another joint.
    pub geared: bool,
    /// Whether the joint closes a loop: other joints already connect its bodies.
    pub closes_loop: bool,
    /// The drive that was requested.
    pub drive: JointDrive,
    /// Velocity of a position drive in the next step, rad/s or m/s.
    pub pursuit: f64,
    pub rest: RestState,
    /// State of the controller of a position drive.
    pub memory: ControllerState,
    /// Velocity before the step, rad/s or m/s. It is updated only if the limit of the drive depends on speed.
    pub speed: f64,
    /// Whether the drive reached its limit in the last step.
    pub at_limit: bool,
    /// Dry friction that is subtracted from the drive's limit instead of having a separate constraint, N m or N.
    pub folded: f64,
    /// Whether `drive` has not been passed to rapier yet.
    pub changed: bool,
}

/// Rapier's representation of a joint.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) enum JointBackend {
    Impulse(ImpulseJointHandle),
    Reduced(ReducedJoint),
    Tree(TreeJoint),
}

/// The data of a joint that a tree solves.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
pub(super) struct TreeJoint {
    /// Effort of the drive, averaged over the last step, N m or N.
    pub effort: f64,
}

impl JointRecord {
    pub fn tree_joint(&self) -> Option<&TreeJoint> {
        if let JointBackend::Tree(t) = &self.held { Some(t) } else { None }
    }
    pub fn tree_joint_mut(&mut self) -> Option<&mut TreeJoint> {
        if let JointBackend::Tree(t) = &mut self.held { Some(t) } else { None }
    }
    pub fn reduced(&self) -> Option<&ReducedJoint> {
        if let JointBackend::Reduced(r) = &self.held { Some(r) } else { None }
    }
    pub fn reduced_mut(&mut self) -> Option<&mut ReducedJoint> {
        if let JointBackend::Reduced(r) = &mut self.held { Some(r) } else { None }
    }
    /// Returns the impulse joint that contains the constraint of the drive, or `None` if there is no such joint.
    pub fn drive_constraint(&self) -> Option<ImpulseJointHandle> {
        match self.held {
            JointBackend::Impulse(handle) => Some(handle),
            JointBackend::Reduced(r) => r.motor,
            JointBackend::Tree(_) => None,
        }
    }
}

/// The state of the controller of a position drive.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
pub(super) struct ControllerState {
    /// Integral of the error, rad s or m s.
    pub sum: f64,
    /// Error in the last step, rad or m; `None` before the first step.
    pub last: Option<f64>,
}

/// Whether a joint that its drive stops is at rest.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
pub(super) struct RestState {
    /// Position in the last step, rad or m; `None` before the first step.
    pub last: Option<f64>,
    pub at_rest: bool,
}

/// Rapier's representation of a joint in reduced form.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct ReducedJoint {
    pub handle: MultibodyJointHandle,
    /// The body that carries the joint, or the anchor that represents it.
    pub parent: RigidBodyHandle,
    pub child: RigidBodyHandle,
    pub anchored: bool,
    /// The constraint of the drive; `None` until the joint is first driven.
    pub motor: Option<ImpulseJointHandle>,
    /// Effort of the drive that is applied as a force in the next step, N m or N.
    pub carried: f64,
    /// Effort of the drive in the last step, N m or N.
    pub effort: f64,
}

/// Friction constraints, by pair of bodies, lower id first.
pub(super) type FrictionConstraints = BTreeMap<(BodyId, BodyId), FrictionConstraint>;

/// The friction constraints of a pair.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct FrictionConstraint {
    pub handle: ImpulseJointHandle,
    /// Whether the pair touched in the last step.
    pub used: bool,
}

/// A joint whose load is measured.
#[derive(Serialize, Deserialize)]
pub(super) struct MeasuredJoint {
    pub joint: JointId,
    /// All bodies below the joint, in ascending order of ids.
    pub bodies: Vec<BodyId>,
    /// Momentum of these bodies before the step, and the forces applied to them; `None` before the first step.
    pub before: Option<MomentumSum>,
    /// Load in the last step; `None` before the first step.
    pub wrench: Option<Wrench>,
}

/// Momentum (N s) and applied forces (N), each with its moment about the world's origin (N m s, N m).
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct MomentumSum {
    pub momentum: (Vector, Vector),
    pub pushes: (Vector, Vector),
}

impl MeasuredJoint {
    pub fn new(joint: JointId) -> Self {
        MeasuredJoint { joint, bodies: Vec::new(), before: None, wrench: None }
    }
}

/// The state of a body before the last step.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct PreviousState {
    pub place: Vector,
    pub rotation: Rotation,
    pub linear: Vector,
    pub angular: Vector,
}

/// Pairs that overlapped when they were created, lower id first.
pub(super) type PairSeparations = BTreeMap<(BodyId, BodyId), PairSeparation>;

/// The state of a pair that is being separated.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct PairSeparation {
    /// Part of the overlap depth that is not corrected, m.
    pub fit: f64,
    /// Whether the two bodies belong to the same mechanism.
    pub held: bool,
    /// Depth when separation was last checked, m, and the time since then, s.
    pub asked: (f64, f64),
}

impl PairSeparation {
    /// Returns the distance reported to the solver, with an overlap of at most `deepest`.
    pub fn reported_distance(&self, distance: f64, deepest: f64) -> f64 {
        if distance < 0.0 { (distance + self.fit).min(0.0).max(-deepest) } else { distance }
    }
}
