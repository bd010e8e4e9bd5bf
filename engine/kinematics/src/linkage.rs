//! Frames and joints, and their poses.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// The id of a frame or joint of a [`Linkage`]. Ids are never reused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct FrameId(pub u32);

/// The type of a joint: how it moves the frames that are attached to it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum JointType {
    /// Rotation about z; position in rad. [`Joint::lead`] adds a translation along z.
    Revolute,
    /// Translation along z; position in m.
    Prismatic,
    /// Any rotation, given by [`Joint::rotation`].
    Spherical,
}

/// The role of a joint in inverse kinematics.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum JointRole {
    /// The solver moves the joint.
    Moved,
    /// The joint remains at its position.
    Fixed,
    /// The position of the joint is `factor` times that of another joint, plus `offset`.
    Dependent {
        /// The joint that this joint follows.
        master: FrameId,
        /// Ratio of the positions.
        factor: f64,
        /// Position of this joint when the other joint is at 0, rad or m.
        offset: f64,
    },
}

/// A joint and its position.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// The type of the joint.
    pub kind: JointType,
    /// Position of a revolute or prismatic joint, rad or m. It is ignored for a dependent joint.
    pub position: f64,
    /// Rotation of a spherical joint.
    pub rotation: UnitQuaternion<f64>,
    /// Minimum and maximum of the position; `None` for a joint without limits.
    pub limits: Option<[f64; 2]>,
    /// Weight of the joint in a step: joints with smaller weights move less than others. Default 1.
    pub weight: f64,
    /// Maximum change of the position in an iteration, rad or m.
    pub max_step: f64,
    /// Translation of a revolute joint along z per radian, m/rad, which makes it a screw. Default 0.
    pub lead: f64,
    /// The role of the joint in inverse kinematics.
    pub role: JointRole,
}

impl Joint {
    /// Returns a joint at position 0 that the solver moves, without limits.
    pub fn new(kind: JointType) -> Self {
        Joint {
            kind,
            position: 0.0,
            rotation: UnitQuaternion::identity(),
            limits: None,
            weight: 1.0,
            max_step: f64::INFINITY,
            lead: 0.0,
            role: JointRole::Moved,
        }
    }

    /// Returns the number of degrees of freedom of the joint.
    pub fn freedoms(&self) -> usize {
        if self.kind == JointType::Spherical { 3 } else { 1 }
    }
}

/// A frame, and its joint if it has one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Frame {
    parent: Option<FrameId>,
    /// Pose relative to the moved frame of the parent, excluding the motion of the frame's own joint.
    pose: Isometry3<f64>,
    joint: Option<Joint>,
}

/// Frames and joints, each attached to an earlier one or to the world. Poses are computed on demand.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Linkage {
    /// `None` for a removed frame.
    frames: Vec<Option<Frame>>,
}

/// Maximum length of a chain of dependent joints; a longer chain is treated as a cycle.
const MAX_DEPENDENCIES: usize = 64;

impl Linkage {
    /// Adds a frame at a pose relative to its parent, or to the world.
    ///
    /// If the parent does not exist, the frame is attached to the world.
    pub fn add_frame(&mut self, parent: Option<FrameId>, pose: Isometry3<f64>) -> FrameId {
        self.frames.push(Some(Frame { parent: parent.filter(|p| self.contains(*p)), pose, joint: None }));
        FrameId(self.frames.len() as u32 - 1)
    }

    /// Adds a joint at a pose relative to its parent, or to the world. Frames that are attached to the joint move with
    /// it.
    pub fn add_joint(&mut self, parent: Option<FrameId>, pose: Isometry3<f64>, kind: JointType) -> FrameId {
        let id = self.add_frame(parent, pose);
        if let Some(frame) = self.frame_mut(id) {
            frame.joint = Some(Joint::new(kind));
        }
        id
    }

    /// Removes a frame. Frames attached to it are attached to its parent, and keep their poses in the world.
    pub fn remove(&mut self, id: FrameId) {
        let above = self.parent(id);
        let children: Vec<FrameId> = self.ids().filter(|c| self.parent(*c) == Some(id)).collect();
        for child in children {
            let pose = self.pose(child);
            self.set_parent(child, above);
            self.set_pose(child, &pose);
        }
        if let Some(frame) = self.frames.get_mut(id.0 as usize) {
            *frame = None;
        }
    }

    /// Returns whether a frame exists.
    pub fn contains(&self, id: FrameId) -> bool {
        self.frame(id).is_some()
    }

    /// Returns the ids of all frames and joints, in order of creation.
    pub fn ids(&self) -> impl Iterator<Item = FrameId> + '_ {
        self.frames.iter().enumerate().filter(|(_, f)| f.is_some()).map(|(i, _)| FrameId(i as u32))
    }

    fn frame(&self, id: FrameId) -> Option<&Frame> {
        self.frames.get(id.0 as usize)?.as_ref()
    }
    fn frame_mut(&mut self, id: FrameId) -> Option<&mut Frame> {
        self.frames.get_mut(id.0 as usize)?.as_mut()
    }

    /// Returns the parent of a frame; `None` for the world.
    pub fn parent(&self, id: FrameId) -> Option<FrameId> {
        self.frame(id)?.parent
    }

    /// Attaches a frame to another one, or to the world, without changing its pose relative to the parent. Returns
    /// `false`, and changes nothing, if this would create a cycle or the parent does not exist.
    pub fn set_parent(&mut self, id: FrameId, parent: Option<FrameId>) -> bool {
        if parent.is_some_and(|p| !self.contains(p) || self.above(p).any(|a| a == id)) {
            return false;
        }
        if let Some(frame) = self.frame_mut(id) {
            frame.parent = parent;
        }
        true
    }

    /// Returns a frame and all frames to which it is attached, starting with itself.
    pub fn above(&self, id: FrameId) -> impl Iterator<Item = FrameId> + '_ {
        std::iter::successors(Some(id), |id| self.parent(*id))
    }

    /// Returns the joint with this id.
    pub fn joint(&self, id: FrameId) -> Option<&Joint> {
        self.frame(id)?.joint.as_ref()
    }
    /// Returns the joint with this id, for changes. All values must be finite; otherwise, poses and solutions are
    /// invalid.
    pub fn joint_mut(&mut self, id: FrameId) -> Option<&mut Joint> {
        self.frame_mut(id)?.joint.as_mut()
    }

    /// Returns the position of a joint, rad or m, including that of a dependent joint; 0 for a frame without a joint.
    pub fn position(&self, id: FrameId) -> f64 {
        self.position_within(id, MAX_DEPENDENCIES)
    }
    fn position_within(&self, id: FrameId, depth: usize) -> f64 {
        match self.joint(id).map(|j| (j.role, j.position)) {
            Some((JointRole::Dependent { master, factor, offset }, _)) if depth > 0 => {
                factor * self.position_within(master, depth - 1) + offset
            }
            Some((_, position)) => position,
            None => 0.0,
        }
    }

    /// Sets the position of a revolute or prismatic joint, rad or m.
    pub fn set_position(&mut self, id: FrameId, position: f64) {
        if let Some(joint) = self.joint_mut(id) {
            joint.position = position;
        }
    }

    /// Returns the joint that determines the position of a joint, and the ratio of their positions. Unless the joint is
    /// dependent, these are the joint itself and 1. Returns `None` if the solver moves neither.
    pub(crate) fn mover(&self, id: FrameId) -> Option<(FrameId, f64)> {
        let (mut id, mut ratio) = (id, 1.0);
        for _ in 0..=MAX_DEPENDENCIES {
            match self.joint(id)?.role {
                JointRole::Moved => return Some((id, ratio)),
                JointRole::Fixed => return None,
                JointRole::Dependent { master, factor, .. } => {
                    ratio *= factor;
                    id = master;
                }
            }
        }
        None
    }

    /// Returns the transform that the joint of a frame adds to its pose: the identity without a joint.
    pub fn motion(&self, id: FrameId) -> Isometry3<f64> {
        let Some(joint) = self.joint(id) else { return Isometry3::identity() };
        let q = self.position(id);
        match joint.kind {
            JointType::Revolute => {
                let (sine, cosine) = libm::sincos(0.5 * q);
                let turned = UnitQuaternion::new_unchecked(Quaternion::new(cosine, 0.0, 0.0, sine));
                Isometry3::from_parts(Translation3::new(0.0, 0.0, joint.lead * q), turned)
            }
            JointType::Prismatic => Isometry3::translation(0.0, 0.0, q),
            JointType::Spherical => Isometry3::from_parts(Translation3::identity(), joint.rotation),
        }
    }

    /// Returns the pose of a frame in the world, m, excluding the motion of its own joint. Complexity: the depth of the
    /// frame.
    pub fn pose(&self, id: FrameId) -> Isometry3<f64> {
        let mut pose = self.frame(id).map_or_else(Isometry3::identity, |f| f.pose);
        let mut at = self.parent(id);
        while let Some(parent) = at {
            let own = self.frame(parent).map_or_else(Isometry3::identity, |f| f.pose);
            pose = own * self.motion(parent) * pose;
            at = self.parent(parent);
        }
        pose
    }

    /// Returns the pose of a frame relative to the moved frame of its parent.
    pub fn local_pose(&self, id: FrameId) -> Isometry3<f64> {
        self.frame(id).map_or_else(Isometry3::identity, |f| f.pose)
    }

    /// Returns the pose, in the world, to which the poses of attached frames are relative: the pose of the frame,
    /// displaced by its joint.
    pub fn moved_pose(&self, id: FrameId) -> Isometry3<f64> {
        self.pose(id) * self.motion(id)
    }

    /// Moves a frame to a pose in the world, with all frames attached to it.
    pub fn set_pose(&mut self, id: FrameId, pose: &Isometry3<f64>) {
        let above = self.parent(id).map_or_else(Isometry3::identity, |p| self.moved_pose(p));
        self.set_local_pose(id, above.inverse() * pose);
    }

    /// Moves a frame to a pose relative to the moved frame of its parent.
    pub fn set_local_pose(&mut self, id: FrameId, pose: Isometry3<f64>) {
        if let Some(frame) = self.frame_mut(id) {
            frame.pose = pose;
        }
    }

    /// Returns the axis of a joint in the world, and a point on it.
    pub(crate) fn axis(&self, id: FrameId) -> (Vector3<f64>, Vector3<f64>) {
        let pose = self.pose(id);
        (pose.rotation * Vector3::z(), pose.translation.vector)
    }
}

/// Returns the rotation that a rotation vector, rad, describes.
pub(crate) fn turned(vector: Vector3<f64>) -> UnitQuaternion<f64> {
    let angle = vector.norm();
    if angle < 1e-300 {
        return UnitQuaternion::identity();
    }
    let (sine, cosine) = libm::sincos(0.5 * angle);
    let part = vector * (sine / angle);
    UnitQuaternion::new_normalize(Quaternion::new(cosine, part.x, part.y, part.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependent_joint_follows_its_master() {
        let mut all = Linkage::default();
        let first = all.add_joint(None, Isometry3::identity(), JointType::Prismatic);
        let second = all.add_joint(Some(first), Isometry3::identity(), JointType::Prismatic);
        let tip = all.add_frame(Some(second), Isometry3::identity());
        all.joint_mut(second).unwrap().role = JointRole::Dependent { master: first, factor: 2.0, offset: 0.1 };
        all.set_position(first, 0.5);
        assert_eq!(all.position(second), 1.1);
        assert_eq!(all.pose(tip).translation.z, 1.6);
        assert_eq!(all.mover(second), Some((first, 2.0)));
    }

    #[test]
    fn cyclic_dependencies_leave_joints_at_zero() {
        let mut all = Linkage::default();
        let a = all.add_joint(None, Isometry3::identity(), JointType::Revolute);
        let b = all.add_joint(None, Isometry3::identity(), JointType::Revolute);
        all.joint_mut(a).unwrap().role = JointRole::Dependent { master: b, factor: 1.0, offset: 0.0 };
        all.joint_mut(b).unwrap().role = JointRole::Dependent { master: a, factor: 1.0, offset: 0.0 };
        assert_eq!((all.mover(a), all.position(a)), (None, 0.0));
    }

    #[test]
    fn removing_a_frame_preserves_the_poses_of_its_children() {
        let mut all = Linkage::default();
        let a = all.add_joint(None, Isometry3::translation(1.0, 0.0, 0.0), JointType::Revolute);
        let b = all.add_frame(Some(a), Isometry3::translation(1.0, 0.0, 0.0));
        all.set_position(a, std::f64::consts::FRAC_PI_2);
        all.remove(a);
        let place = all.pose(b).translation.vector;
        assert!(!all.contains(a) && (place - Vector3::new(1.0, 1.0, 0.0)).norm() < 1e-15);
        assert!(!all.set_parent(b, Some(b)));
    }

    #[test]
    fn screw_moves_along_its_axis() {
        let mut all = Linkage::default();
        let screw = all.add_joint(None, Isometry3::identity(), JointType::Revolute);
        all.joint_mut(screw).unwrap().lead = 0.01;
        all.set_position(screw, 3.0);
        assert_eq!(all.moved_pose(screw).translation.z, 0.03);
    }
}
