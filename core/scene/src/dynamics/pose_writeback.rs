//! Copies the engine's state back to shapes and joints, and to the objects that they carry.

use std::collections::BTreeMap;

use tatu_physics::{JointId, JointState};

use super::state::{Dynamics, PoseSource, PoseUpdate, WritebackList};
use crate::{
    object::{Joint, ObjectVariant},
    tree::Scene,
};

impl Dynamics {
    /// Copies poses and joint states back. Parents precede their children, so each child's parent frame is up to date.
    pub(super) fn copy_back(&mut self, scene: &mut Scene) {
        if self.pose_writeback.visited_version != scene.versions.shape {
            return self.copy_all(scene);
        }
        if self.pose_writeback.listed_version != scene.versions.shape {
            self.list_writeback(scene);
        }
        for PoseUpdate { slot, parent, from } in &self.pose_writeback.list {
            let frame = scene.frame(*parent);
            let world = match from {
                PoseSource::Body(id) => {
                    let world = self.engine.pose(*id);
                    scene.places.local[*slot as usize] = frame.inverse() * world;
                    world
                }
                PoseSource::Joint(id) => {
                    if let Some(ObjectVariant::Joint(joint)) = scene.get_mut(*slot).map(|o| &mut o.data) {
                        joint.copy_engine_state(&self.engine.joint_state(*id));
                    }
                    frame * scene.places.local[*slot as usize]
                }
                PoseSource::Frame => frame * scene.places.local[*slot as usize],
            };
            scene.store_world_pose(*slot, world);
        }
    }

    /// Like `copy_back`, but for every object. Afterwards, the world poses of objects that need not store them, such as
    /// objects without a body, are computed on demand.
    fn copy_all(&mut self, scene: &mut Scene) {
        for record in &self.joints {
            if let Some(ObjectVariant::Joint(joint)) = scene.get_mut(record.tie).map(|o| &mut o.data) {
                joint.copy_engine_state(&self.engine.joint_state(record.id));
            }
        }
        scene.visit(|scene, slot| {
            let frame = scene.parent_frame(slot);
            let body = scene.get(slot).and_then(|o| o.shape()).filter(|s| s.dynamic).and_then(|s| s.body.0);
            let world = match body {
                Some(id) => {
                    let world = self.engine.pose(id);
                    scene.places.local[slot as usize] = frame.inverse() * world;
                    world
                }
                None => frame * scene.places.local[slot as usize],
            };
            scene.store_world_pose(slot, world);
            scene.start_hanging(slot);
        });
        self.pose_writeback = WritebackList::visited_at(scene.versions.shape);
    }

    fn list_writeback(&mut self, scene: &Scene) {
        let list = &mut self.pose_writeback.list;
        list.clear();
        // If an object has several joints in the engine, the last one is used.
        let joints: BTreeMap<u32, JointId> = self.joints.iter().map(|j| (j.tie, j.id)).collect();
        let mut walk: Vec<(u32, u32, bool)> = scene.roots().iter().rev().map(|s| (*s, 0, false)).collect();
        while let Some((slot, parent, moves)) = walk.pop() {
            let Some(o) = scene.get(slot) else { continue };
            let from = match (&o.data, joints.get(&slot)) {
                (ObjectVariant::Shape(s), _) if s.dynamic => s.body.0.map_or(PoseSource::Frame, PoseSource::Body),
                (ObjectVariant::Joint(_), Some(id)) => PoseSource::Joint(*id),
                _ => PoseSource::Frame,
            };
            let moves = moves || !matches!(from, PoseSource::Frame);
            walk.extend(o.children.iter().rev().map(|s| (*s, slot, moves)));
            if moves && !scene.places.links[slot as usize].hangs {
                list.push(PoseUpdate { slot, parent, from });
            }
        }
        self.pose_writeback.listed_version = scene.versions.shape;
    }
}

impl Joint {
    /// Copies the state of the joint's counterpart in the engine.
    fn copy_engine_state(&mut self, state: &JointState) {
        (self.position, self.velocity, self.effort) = (state.position, state.velocity, state.effort);
        self.rotation = state.rotation;
    }
}
