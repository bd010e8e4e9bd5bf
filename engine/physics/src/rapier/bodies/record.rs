//! What the engine records about each body, in addition to rapier's own data.

use nalgebra::Isometry3;
use rapier3d::{
    dynamics::RigidBodyHandle,
    math::{Pose, Rotation, Vector},
};
use serde::{Deserialize, Serialize};

use crate::{CollisionMask, MotionType, convert};

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
