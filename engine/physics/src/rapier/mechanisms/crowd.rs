//! Mechanisms in a crowd. Where many free bodies touch each other and a tree, rapier solves all of them better, and
//! where a tree touches a vehicle or a mechanism that rapier solves, only rapier can solve both sides of the contact.
//!
//! Such a mechanism is converted to reduced form, and the bodies that it had adopted are returned to rapier. It is
//! converted back to a tree when it has touched only few bodies, all of them free, for a while. The decisions depend
//! only on the state of the engine, so a restored snapshot continues in the same way.

use std::collections::{BTreeMap, BTreeSet};

use crate::{
    BodyId, JointDesc, JointForm, JointId,
    rapier::{
        joints,
        mechanisms::{
            adopt::{MAX_ADOPTED_BODIES, ReachedBodies},
            records::CrowdedMechanism,
        },
        records::{JointBackend, JointRecord, TreeJoint},
        state::{Rapier, mark_changed},
    },
};

/// Time for which a mechanism must touch only few bodies before it becomes a tree again, s.
const CROWD_EXIT_TIME_S: f64 = 1.0;

impl Rapier {
    /// Converts a mechanism to reduced form.
    pub(super) fn join_crowd(&mut self, index: usize) {
        let Some(mechanism) = self.state.mechanisms.get(index) else { return };
        let joints: Vec<JointId> = mechanism.joints.iter().flatten().copied().collect();
        let bodies = mechanism.bodies.clone();
        for body in &bodies {
            self.release_body(*body);
        }
        for id in &joints {
            let Some(record) = self.joint(*id).copied() else { continue };
            let JointRecord { bodies: (a, b), kind, limits, passive, zero, frames, .. } = record;
            let desc = JointDesc {
                a,
                b,
                // These are unused: rapier's joint is built from the frames of the record.
                frame_in_a: nalgebra::Isometry3::identity(),
                frame_in_b: nalgebra::Isometry3::identity(),
                kind,
                limits,
                position: zero,
                form: JointForm::Reduced,
                passive,
                geared: false,
            };
            let reduced = self.add_reduced(&desc, joints::build_joint(&desc, frames, zero));
            if let (Some(reduced), Some(Some(record))) = (reduced, self.state.joints.get_mut(id.0 as usize)) {
                record.held = JointBackend::Reduced(reduced);
                // The new joint in reduced form includes all of the dry friction.
                record.folded = 0.0;
                mark_changed(&mut self.state.changed, *id, record);
            }
        }
        self.state.moved.extend(&bodies);
        self.state.crowded.push(CrowdedMechanism { joints, bodies, calm_s: 0.0 });
        (self.state.mechanisms_changed, self.state.joints_changed) = (true, true);
    }

    /// Returns the index of the crowd that a new tree joint would be part of, or `None` if there is none.
    pub(in crate::rapier) fn crowd_of(&self, desc: &JointDesc) -> Option<usize> {
        let in_it = |c: &CrowdedMechanism| c.bodies.contains(&desc.a) || c.bodies.contains(&desc.b);
        self.state.crowded.iter().position(in_it).filter(|_| desc.form == JointForm::Tree)
    }

    /// Adds a joint that was created in reduced form to a crowd.
    pub(in crate::rapier) fn grow_crowd(&mut self, crowd: usize, joint: JointId, body: BodyId) {
        let reduced = self.joint(joint).is_some_and(|r| r.reduced().is_some());
        if let Some(crowd) = self.state.crowded.get_mut(crowd).filter(|_| reduced) {
            crowd.joints.push(joint);
            crowd.bodies.push(body);
        }
    }

    /// Converts mechanisms that are no longer in a crowd back to trees. Mechanisms that touch each other are converted
    /// in the same step. `greatest` is the greatest travel per step of the bodies that rapier moves, m.
    pub(super) fn leave_crowds(&mut self, greatest: Option<f64>) {
        let dt = self.world.integration_parameters.dt;
        let mut crowded = std::mem::take(&mut self.state.crowded);
        crowded.retain_mut(|crowd| {
            // Joints may have been removed since the last step.
            crowd.joints.retain(|id| self.joint(*id).is_some_and(|r| r.reduced().is_some()));
            !crowd.joints.is_empty()
        });
        let owners: BTreeMap<BodyId, usize> =
            crowded.iter().enumerate().flat_map(|(i, c)| c.bodies.iter().map(move |b| (*b, i))).collect();
        // For each crowd, the indices of the crowds that it touches.
        let mut touched: Vec<BTreeSet<usize>> = Vec::new();
        for crowd in &mut crowded {
            let ReachedBodies { free, foreign } = self.reached_bodies(&crowd.bodies, greatest);
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
                self.convert_to_tree(&crowd.joints);
            } else {
                self.state.crowded.push(crowd);
            }
        }
    }

    /// Converts joints in reduced form to a tree.
    fn convert_to_tree(&mut self, joints: &[JointId]) {
        for id in joints {
            let Some(Some(record)) = self.state.joints.get_mut(id.0 as usize) else { continue };
            let before = *record;
            record.held = JointBackend::Tree(TreeJoint::default());
            if let Some(reduced) = before.reduced() {
                self.remove_reduced(&before, *reduced);
            }
        }
        let ends = |id: &JointId| self.joint(*id).map(|r| [r.bodies.0, r.bodies.1]);
        let bodies: Vec<BodyId> = joints.iter().filter_map(ends).flatten().collect();
        bodies.into_iter().for_each(|body| self.claim_body(body));
        (self.state.mechanisms_changed, self.state.joints_changed) = (true, true);
    }
}
