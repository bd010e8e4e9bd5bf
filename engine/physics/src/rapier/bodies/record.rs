//! The engine's records of bodies, in addition to rapier's own data.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Vector3};
use rapier3d::{
    dynamics::{RigidBody, RigidBodyHandle},
    math::{Pose, Rotation, Vector},
};
use serde::{Deserialize, Serialize};

use crate::{BodyId, CollisionMask, MotionType, convert};

/// The engine's data about a body.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(crate) struct BodyRecord {
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
    /// Whether a tree moves the body, in which case rapier treats it as kinematic: see [`super::handover`].
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

/// The state of a body before the last step.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(crate) struct PreviousState {
    pub place: Vector,
    pub rotation: Rotation,
    pub linear: Vector,
    pub angular: Vector,
}

/// The forces that act on bodies.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct AppliedForces {
    /// Bodies with forces that are cleared after the next advance.
    pub pushed: Vec<BodyId>,
    /// Forces on bodies of trees that act in all steps of an advance.
    pub loads: BTreeMap<BodyId, BodyLoad>,
    /// Forces on bodies of trees that act in the next step only.
    pub step_loads: Vec<(BodyId, BodyLoad)>,
    /// Forces that rapier's bodies had before those of the current step were added, in the order of these additions.
    #[serde(skip)]
    pub saved: Vec<SavedForces>,
}

/// A force, N, and a torque, N m, on a body of a tree, at its centre of mass.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
pub(crate) struct BodyLoad {
    pub force: Vector3<f64>,
    pub torque: Vector3<f64>,
}

/// The force and torque on a body that act in all steps of the advance.
pub(crate) struct SavedForces {
    pub handle: RigidBodyHandle,
    pub force: Vector,
    pub torque: Vector,
}

impl SavedForces {
    pub fn of(handle: RigidBodyHandle, body: &RigidBody) -> Self {
        SavedForces { handle, force: body.user_force(), torque: body.user_torque() }
    }
}

/// Changes since rapier was last called; see `joints/tree/detect.rs`.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct Backlog {
    /// Whether rapier was not called in the last step, in which case the contacts in its narrow phase are those of an
    /// earlier step.
    pub skipped: bool,
    /// Whether bodies were removed. Rapier retains data about their colliders until it is called.
    pub removed: bool,
}

/// The state that determines the number of sub-steps.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct Substeps {
    /// Number of sub-steps of an ordinary step.
    pub usual: usize,
    /// Remaining time for which sub-steps are halved because a mechanism swings fast, s.
    pub fast_s: f64,
    /// Time for which all mechanisms have been slow, s.
    pub calm_s: f64,
}
