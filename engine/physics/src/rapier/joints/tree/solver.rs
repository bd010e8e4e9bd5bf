//! Joints in trees, added and removed like those of other forms.

use super::table::TreeJoints;
use crate::{
    BodyId, JointDesc, JointId,
    rapier::{
        bodies::Bodies,
        joints::{
            record::{JointBackend, JointRecord, TreeJoint},
            solver::{JointFormSolver, NewJoint},
            table::Joints,
        },
    },
};

impl JointFormSolver for TreeJoints {
    fn add(&mut self, bodies: &mut Bodies, joints: &Joints, new: &NewJoint<'_>) -> Option<JointBackend> {
        let JointDesc { a, b, .. } = *new.desc;
        if !may_join(bodies, joints, a, b) {
            return None;
        }
        bodies.prepare_for_joint(a, false);
        bodies.prepare_for_joint(b, false);
        self.changed = true;
        bodies.give_to_tree(a);
        bodies.give_to_tree(b);
        Some(JointBackend::Tree(TreeJoint::default()))
    }

    fn remove(&mut self, bodies: &mut Bodies, joints: &Joints, record: &JointRecord) {
        self.changed = true;
        self.release_unclaimed_body(bodies, joints, record.bodies.0);
        self.release_unclaimed_body(bodies, joints, record.bodies.1);
    }

    /// Drives are read before each step.
    fn set_drive(&mut self, _: &mut Bodies, _: JointId, _: &mut JointRecord) {}

    fn before_step(&mut self, bodies: &mut Bodies, joints: &mut Joints) {
        self.arrange(bodies, joints);
    }

    fn after_step(&mut self, bodies: &mut Bodies, joints: &mut Joints) {
        self.step(bodies, joints);
    }
}

/// Returns whether a joint from `a` to `b` can be part of a tree: its child body is dynamic and has no other parent,
/// and the joint does not close a loop.
fn may_join(bodies: &Bodies, joints: &Joints, a: BodyId, b: BodyId) -> bool {
    let above =
        |body: BodyId| joints.iter().filter(|r| r.is_in_tree()).find(|r| r.bodies.1 == body).map(|r| r.bodies.0);
    let mut at = Some(a);
    while let Some(body) = at.filter(|body| *body != b) {
        at = above(body);
    }
    bodies.is_dynamic(b) && above(b).is_none() && at.is_none()
}
