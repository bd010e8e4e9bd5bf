//! Mechanisms in a crowd. Where many free bodies touch each other and a tree, rapier solves all of them better, and
//! where a tree touches a vehicle or a mechanism that rapier solves, only rapier can solve both sides of the contact.
//!
//! Such a mechanism is converted to reduced form, and the bodies that it had adopted are returned to rapier. It is
//! converted back to a tree when it has touched only few bodies, all of them free, for a while. The decisions depend
//! only on the state of the engine, so a restored snapshot continues in the same way.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Isometry3;

use super::{
    reach::{MAX_ADOPTED_BODIES, ReachedBodies, reached_bodies},
    records::CrowdedMechanism,
    table::TreeJoints,
};
use crate::{
    BodyId, JointDesc, JointForm, JointId,
    rapier::{
        bodies::Bodies,
        contacts::Contacts,
        joints::{
            record::{JointBackend, JointRecord, TreeJoint},
            reduced::ReducedJoints,
            solver::{JointFormSolver, NewJoint},
            table::Joints,
        },
    },
};

/// Time for which a mechanism must touch only few bodies before it becomes a tree again, s.
const CROWD_EXIT_TIME_S: f64 = 1.0;

impl TreeJoints {
    /// Converts a mechanism to reduced form.
    pub(super) fn join_crowd(
        &mut self,
        bodies: &mut Bodies,
        joints: &mut Joints,
        reduced: &mut ReducedJoints,
        index: usize,
    ) {
        let Some(mechanism) = self.mechanisms.get(index) else { return };
        let links: Vec<JointId> = mechanism.joints.iter().flatten().copied().collect();
        let members = mechanism.bodies.clone();
        for body in &members {
            bodies.return_to_rapier(*body);
        }
        for id in &links {
            let Some(record) = joints.get(*id).copied() else { continue };
            let desc = reduced_desc(&record);
            let new = NewJoint { desc: &desc, frames: record.frames, zero: record.turns.zero };
            if let (Some(joint), Some(record)) = (reduced.insert(bodies, joints, &new), joints.get_mut(*id)) {
                record.backend = JointBackend::Reduced(joint);
                // The new joint in reduced form includes all of the dry friction.
                record.drive.folded = 0.0;
                joints.mark_pending(*id);
            }
        }
        bodies.moved.extend(&members);
        self.crowded.push(CrowdedMechanism { joints: links, bodies: members, calm_s: 0.0 });
        (self.changed, joints.structure_changed) = (true, true);
    }

    /// Returns the index of the crowd that a new joint would be part of in tree form, or `None` if there is none.
    pub fn crowd_of(&self, desc: &JointDesc) -> Option<usize> {
        let in_it = |c: &CrowdedMechanism| c.bodies.contains(&desc.a) || c.bodies.contains(&desc.b);
        self.crowded.iter().position(in_it).filter(|_| desc.form == JointForm::Tree)
    }

    /// Adds a joint that was created in reduced form, and the body that it moves, to a crowd.
    pub fn grow_crowd(&mut self, crowd: usize, joint: JointId, body: BodyId) {
        if let Some(crowd) = self.crowded.get_mut(crowd) {
            crowd.joints.push(joint);
            crowd.bodies.push(body);
        }
    }

    /// Converts mechanisms that are no longer in a crowd back to trees. Mechanisms that touch each other are converted
    /// in the same step. `greatest` is the greatest travel per step of the bodies that rapier moves, m.
    pub(super) fn leave_crowds(
        &mut self,
        bodies: &mut Bodies,
        contacts: &Contacts,
        joints: &mut Joints,
        reduced: &mut ReducedJoints,
        greatest: Option<f64>,
    ) {
        let dt = bodies.world.integration_parameters.dt;
        let mut crowded = std::mem::take(&mut self.crowded);
        crowded.retain_mut(|crowd| {
            // Joints may have been removed since the last step.
            crowd.joints.retain(|id| joints.get(*id).is_some_and(|r| r.reduced().is_some()));
            !crowd.joints.is_empty()
        });
        let owners: BTreeMap<BodyId, usize> =
            crowded.iter().enumerate().flat_map(|(i, c)| c.bodies.iter().map(move |b| (*b, i))).collect();
        // For each crowd, the indices of the crowds that it touches.
        let mut touched: Vec<BTreeSet<usize>> = Vec::new();
        for crowd in &mut crowded {
            let ReachedBodies { free, foreign } = reached_bodies(bodies, contacts, &crowd.bodies, greatest);
            let calm = free.len() <= MAX_ADOPTED_BODIES / 2 && foreign.iter().all(|body| owners.contains_key(body));
            crowd.calm_s = if calm { crowd.calm_s + dt } else { 0.0 };
            touched.push(foreign.iter().filter_map(|body| owners.get(body).copied()).collect());
        }
        let mut leaves: Vec<bool> = crowded.iter().map(|c| c.calm_s >= CROWD_EXIT_TIME_S).collect();
        while let Some(i) = (0..leaves.len()).find(|i| leaves[*i] && touched[*i].iter().any(|other| !leaves[*other])) {
            leaves[i] = false;
        }
        for (crowd, leaves) in crowded.into_iter().zip(leaves) {
            if leaves {
                convert_to_tree(bodies, joints, reduced, &crowd.joints);
                self.changed = true;
            } else {
                self.crowded.push(crowd);
            }
        }
    }
}

/// Describes a joint of a tree in reduced form.
fn reduced_desc(record: &JointRecord) -> JointDesc {
    JointDesc {
        a: record.bodies.0,
        b: record.bodies.1,
        // These are unused: rapier's joint is built from the frames of the record.
        frame_in_a: Isometry3::identity(),
        frame_in_b: Isometry3::identity(),
        kind: record.kind,
        limits: record.limits,
        position: record.turns.zero,
        form: JointForm::Reduced,
        passive: record.passive,
        geared: record.geared,
    }
}

/// Converts joints in reduced form to a tree.
fn convert_to_tree(bodies: &mut Bodies, joints: &mut Joints, reduced: &mut ReducedJoints, links: &[JointId]) {
    for id in links {
        let Some(record) = joints.get_mut(*id) else { continue };
        let before = *record;
        record.backend = JointBackend::Tree(TreeJoint::default());
        reduced.remove(bodies, joints, &before);
    }
    let ends = |id: &JointId| joints.get(*id).map(|r| [r.bodies.0, r.bodies.1]);
    links.iter().filter_map(ends).flatten().for_each(|body| bodies.give_to_tree(body));
    joints.structure_changed = true;
}
