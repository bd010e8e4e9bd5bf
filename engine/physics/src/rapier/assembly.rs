//! Changes that concern bodies, contacts and joints together: bodies and joints that are added, removed and moved.

use nalgebra::Isometry3;

use super::{
    bodies::ShapeCache,
    joints::{NewJoint, turned, zero},
    state::EngineState,
};
use crate::{BodyDesc, BodyId, JointDesc, JointId, MotionType};

impl EngineState {
    pub fn add_body(&mut self, shapes: &mut ShapeCache, desc: &BodyDesc) -> BodyId {
        let id = self.bodies.insert(desc);
        self.contacts.add_body(&mut self.bodies, shapes, id, desc);
        self.bodies.finish_insertion(id, desc);
        id
    }

    pub fn remove_body(&mut self, body: BodyId) {
        if self.bodies.record(body).is_none() {
            return;
        }
        for joint in self.joints.on(body) {
            self.remove_joint(joint);
        }
        let trees = &mut self.forms.trees;
        trees.release_adopted_body(&mut self.bodies, &self.joints, body);
        trees.discard_contacts(&self.bodies, body);
        self.contacts.remove_body(&mut self.bodies, body);
        self.bodies.remove(body);
    }

    pub fn set_pose(&mut self, body: BodyId, pose: &Isometry3<f64>) {
        let Some(pose) = self.bodies.set_pose(body, pose) else { return };
        if self.bodies.record(body).is_some_and(|r| r.motion == MotionType::Static && r.joints > 0) {
            self.forms.trees.schedule_rebuild(body);
            self.forms.reduced.move_anchors(&mut self.bodies, &self.joints, body, &pose);
        }
    }

    pub fn add_joint(&mut self, desc: &JointDesc) -> Option<JointId> {
        let (a, b) = (*self.bodies.record(desc.a)?, *self.bodies.record(desc.b)?);
        if a.handle == b.handle {
            return None;
        }
        let EngineState { bodies, joints, forms, .. } = self;
        forms.trees.release_adopted_body(bodies, joints, desc.a);
        forms.trees.release_adopted_body(bodies, joints, desc.b);
        let zero = zero(desc);
        let frames = (turned(a.local_pose(&desc.frame_in_a), zero), b.local_pose(&desc.frame_in_b));
        forms.add(bodies, joints, &NewJoint { desc, frames, zero })
    }

    pub fn remove_joint(&mut self, joint: JointId) {
        self.forms.remove(&mut self.bodies, &mut self.joints, joint);
    }
}
