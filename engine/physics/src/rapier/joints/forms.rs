//! The solvers of all forms of joints.

use serde::{Deserialize, Serialize};

use super::{
    impulse::ImpulseJoints,
    position::near,
    record::{DriveState, JointBackend, JointRecord, JointTurns},
    reduced::ReducedJoints,
    solver::{JointFormSolver, NewJoint},
    table::Joints,
    tree::TreeJoints,
};
use crate::{JointForm, JointId, JointKind, rapier::bodies::Bodies};

/// One solver for each form.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct JointForms {
    pub trees: TreeJoints,
    pub reduced: ReducedJoints,
    pub impulse: ImpulseJoints,
}

impl JointForms {
    fn solver(&mut self, backend: &JointBackend) -> &mut dyn JointFormSolver {
        match backend {
            JointBackend::Tree(_) => &mut self.trees,
            JointBackend::Reduced(_) => &mut self.reduced,
            JointBackend::Impulse(_) => &mut self.impulse,
        }
    }

    /// Returns all solvers, in the order in which they prepare a step and complete it.
    fn all(&mut self) -> [&mut dyn JointFormSolver; 3] {
        [&mut self.trees, &mut self.reduced, &mut self.impulse]
    }

    /// Adds a joint in the form that its description requests. If that form cannot contain the joint, the joint closes
    /// a loop, and is added in impulse form. Returns `None` if a body is unknown.
    pub fn add(&mut self, bodies: &mut Bodies, joints: &mut Joints, new: &NewJoint<'_>) -> Option<JointId> {
        let desc = new.desc;
        let crowd = self.trees.crowd_of(desc);
        let reduced = crowd.is_some() || matches!(desc.kind, JointKind::Screw(_));
        let form = if reduced { JointForm::Reduced } else { desc.form };
        let backend = match form {
            JointForm::Reduced => self.reduced.add(bodies, joints, new),
            JointForm::Tree => self.trees.add(bodies, joints, new),
            JointForm::Impulse | JointForm::Loop => None,
        };
        let backend = backend.or_else(|| self.impulse.add(bodies, joints, new))?;
        let id = joints.insert(JointRecord {
            backend,
            kind: desc.kind,
            bodies: (desc.a, desc.b),
            frames: new.frames,
            passive: desc.passive,
            limits: desc.limits,
            turns: JointTurns { zero: new.zero, near: near(desc, new.zero) },
            geared: desc.geared,
            closes_loop: desc.form == JointForm::Loop,
            drive: DriveState::free(),
        });
        match (backend, crowd) {
            // In impulse form, a motor implements damping.
            (JointBackend::Impulse(_), _) if desc.passive.damping > 0.0 => joints.mark_pending(id),
            (JointBackend::Reduced(_), Some(crowd)) => self.trees.grow_crowd(crowd, id, desc.b),
            _ => {}
        }
        Some(id)
    }

    /// Removes a joint. An unknown id is ignored.
    pub fn remove(&mut self, bodies: &mut Bodies, joints: &mut Joints, joint: JointId) {
        let Some(record) = joints.take(joint) else { return };
        self.solver(&record.backend).remove(bodies, joints, &record);
        bodies.free_from_joint(record.bodies.0);
        bodies.free_from_joint(record.bodies.1);
    }

    /// Passes drives that have changed to the solvers of their joints.
    pub fn pass_drives(&mut self, bodies: &mut Bodies, joints: &mut Joints) {
        let mut pending = std::mem::take(&mut joints.pending);
        for id in pending.drain(..) {
            let Some(record) = joints.get_mut(id) else { continue };
            record.drive.pending = false;
            self.solver(&record.backend).set_drive(bodies, id, record);
        }
        joints.pending = pending;
    }

    /// Calls each solver before a step, to apply changes that were made from outside.
    pub fn before_step(&mut self, bodies: &mut Bodies, joints: &mut Joints) {
        self.all().into_iter().for_each(|form| form.before_step(bodies, joints));
    }

    /// Calls each solver to complete a step, after rapier has moved its own bodies.
    pub fn after_step(&mut self, bodies: &mut Bodies, joints: &mut Joints) {
        self.all().into_iter().for_each(|form| form.after_step(bodies, joints));
    }

    /// Sets the rest position of a joint's spring, rad or m.
    pub fn set_rest(&mut self, bodies: &mut Bodies, joints: &mut Joints, joint: JointId, rest: f64) {
        if let Some(record) = joints.get_mut(joint)
            && rest.is_finite()
            && record.passive.rest != rest
        {
            record.passive.rest = rest;
            self.reduced.set_rest(bodies, record);
        }
    }
}
