//! The colliders of a detection, and what it found: the next one compares its colliders with them.

use std::sync::Arc;

use rapier3d::{
    dynamics::CoefficientCombineRule,
    geometry::{Aabb, Collider, ColliderHandle, SharedShape},
    math::Pose,
};

use super::records::DetectedFace;
use crate::rapier::contacts::masks::ColliderTag;

/// Everything about a collider on which its contacts depend.
pub(crate) struct PlacedCollider {
    pub handle: ColliderHandle,
    pub index: u32,
    pub tag: ColliderTag,
    pub shape: SharedShape,
    pub pose: Pose,
    pub friction: f64,
    pub friction_rule: CoefficientCombineRule,
    /// Distance up to which contacts are found, m.
    pub ahead: f64,
    /// Whether a tree moves the body.
    pub is_link: bool,
    /// Bounding box, enlarged by `ahead`.
    pub bounds: Aabb,
}

impl PlacedCollider {
    /// Returns whether this is the collider `handle` as it was, of the same form in the same place.
    pub fn is_still(&self, handle: ColliderHandle, collider: &Collider, pose: &Pose, ahead: f64) -> bool {
        self.handle == handle
            && self.pose == *pose
            && self.ahead == ahead
            && Arc::ptr_eq(&self.shape.0, &collider.shared_shape().0)
    }

    /// Returns whether both have the same contacts with the same others.
    fn equals(&self, other: &PlacedCollider) -> bool {
        self.handle == other.handle
            && self.pose == other.pose
            && self.ahead == other.ahead
            && Arc::ptr_eq(&self.shape.0, &other.shape.0)
            && self.tag == other.tag
            && self.friction == other.friction
            && self.friction_rule == other.friction_rule
            && self.is_link == other.is_link
    }
}

/// The colliders and contacts of the last detection.
#[derive(Default)]
pub(crate) struct Detection {
    pub placed: Vec<PlacedCollider>,
    /// The contact faces, sorted by colliders.
    pub faces: Vec<DetectedFace>,
    /// Whether another detection with the same colliders would begin with the same normals.
    pub is_stable: bool,
}

impl Detection {
    /// Returns whether the contacts of these colliders are those that were found last.
    pub fn repeats(&self, placed: &[PlacedCollider]) -> bool {
        self.placed.len() == placed.len() && self.placed.iter().zip(placed).all(|(a, b)| a.equals(b))
    }
}
