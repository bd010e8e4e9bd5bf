//! The interface that the solvers of the three forms of joints implement.

use rapier3d::math::Pose;

use super::{
    record::{JointBackend, JointRecord},
    table::Joints,
};
use crate::{JointDesc, JointId, rapier::bodies::Bodies};

/// A joint that is to be added.
pub(crate) struct NewJoint<'a> {
    pub desc: &'a JointDesc,
    /// The joint's frames on both of rapier's bodies.
    pub frames: (Pose, Pose),
    /// Position at which rapier's angle is 0, rad.
    pub zero: f64,
}

/// The solver of the joints of one form. It contains the data of these joints that is not in their records.
///
/// The state of a joint is not read from the solver: positions and velocities follow from the bodies in every form, and
/// a joint's record contains its effort.
pub(crate) trait JointFormSolver {
    /// Adds a joint and prepares its bodies. Returns `None` and changes nothing if this form cannot contain the joint.
    fn add(&mut self, bodies: &mut Bodies, joints: &Joints, new: &NewJoint<'_>) -> Option<JointBackend>;

    /// Removes a joint. Its record is no longer in the table.
    fn remove(&mut self, bodies: &mut Bodies, joints: &Joints, record: &JointRecord);

    /// Applies the drive of a joint.
    fn set_drive(&mut self, bodies: &mut Bodies, joint: JointId, record: &mut JointRecord);

    /// Applies, before a step, changes that were made from outside: to joints, and to the poses and velocities of
    /// bodies.
    fn before_step(&mut self, _bodies: &mut Bodies, _joints: &mut Joints) {}

    /// Moves the joints that rapier does not move, and records efforts, after rapier has moved its own bodies.
    fn after_step(&mut self, _bodies: &mut Bodies, _joints: &mut Joints) {}
}
