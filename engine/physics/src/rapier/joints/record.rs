//! The engine's records of joints, in addition to the data of their solvers.

use rapier3d::{
    dynamics::{ImpulseJointHandle, MultibodyJointHandle, RigidBodyHandle},
    math::{Pose, Vector},
};
use serde::{Deserialize, Serialize};

use crate::{BodyId, JointDrive, JointId, JointKind, PassiveForces, Wrench};

/// The engine's data about a joint.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(crate) struct JointRecord {
    pub backend: JointBackend,
    pub kind: JointKind,
    pub bodies: (BodyId, BodyId),
    /// The joint's frames on both of rapier's bodies.
    pub frames: (Pose, Pose),
    pub passive: PassiveForces,
    /// Lowest and highest position, rad or m.
    pub limits: Option<(f64, f64)>,
    pub turns: JointTurns,
    /// Whether the joint can be geared to another joint.
    pub geared: bool,
    /// Whether the joint closes a loop: other joints already connect its bodies.
    pub closes_loop: bool,
    pub drive: DriveState,
}

/// How the position of a revolute joint is derived from rapier's angle: see [`super::position`].
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(crate) struct JointTurns {
    /// Position at which rapier's angle is 0, rad.
    pub zero: f64,
    /// A position within half a turn of the current one, rad.
    pub near: f64,
}

/// The drive of a joint, and its state.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(crate) struct DriveState {
    /// The drive that was requested.
    pub requested: JointDrive,
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
    /// Whether the drive has not been passed to the joint's solver yet.
    pub pending: bool,
}

impl DriveState {
    /// Returns the state of a joint that has not been driven.
    pub fn free() -> Self {
        DriveState {
            requested: JointDrive::Free,
            pursuit: 0.0,
            rest: RestState::default(),
            memory: ControllerState::default(),
            speed: 0.0,
            at_limit: false,
            folded: 0.0,
            pending: false,
        }
    }

    pub fn is_free(&self) -> bool {
        self.requested == JointDrive::Free
    }
}

/// The solver's representation of a joint, which also determines the solver.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(crate) enum JointBackend {
    Impulse(ImpulseJointHandle),
    Reduced(ReducedJoint),
    Tree(TreeJoint),
}

/// The data of a joint that a tree solves.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
pub(crate) struct TreeJoint {
    /// Effort of the drive, averaged over the last step, N m or N.
    pub effort: f64,
}

/// Rapier's representation of a joint in reduced form.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(crate) struct ReducedJoint {
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

impl JointRecord {
    pub fn is_in_tree(&self) -> bool {
        matches!(self.backend, JointBackend::Tree(_))
    }
    pub fn reduced(&self) -> Option<&ReducedJoint> {
        if let JointBackend::Reduced(r) = &self.backend { Some(r) } else { None }
    }
    pub fn reduced_mut(&mut self) -> Option<&mut ReducedJoint> {
        if let JointBackend::Reduced(r) = &mut self.backend { Some(r) } else { None }
    }
    /// Returns the impulse joint that contains the constraint of the drive, or `None` if there is no such joint.
    pub fn drive_constraint(&self) -> Option<ImpulseJointHandle> {
        match self.backend {
            JointBackend::Impulse(handle) => Some(handle),
            JointBackend::Reduced(r) => r.motor,
            JointBackend::Tree(_) => None,
        }
    }
}

/// The state of the controller of a position drive.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
pub(crate) struct ControllerState {
    /// Integral of the error, rad s or m s.
    pub sum: f64,
    /// Error in the last step, rad or m; `None` before the first step.
    pub last: Option<f64>,
}

/// Whether a joint that its drive stops is at rest.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
pub(crate) struct RestState {
    /// Position in the last step, rad or m; `None` before the first step.
    pub last: Option<f64>,
    pub at_rest: bool,
}

/// A joint whose load is measured.
#[derive(Serialize, Deserialize)]
pub(crate) struct MeasuredJoint {
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
pub(crate) struct MomentumSum {
    pub momentum: (Vector, Vector),
    pub pushes: (Vector, Vector),
}

impl MeasuredJoint {
    pub fn new(joint: JointId) -> Self {
        MeasuredJoint { joint, bodies: Vec::new(), before: None, wrench: None }
    }
}
