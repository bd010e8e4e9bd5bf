//! Joints in reduced coordinates: rapier's multibodies, which compute only the degrees of freedom of each joint.
//!
//! A mechanism on a static body is attached to a separate anchor, a fixed body without shapes, because rapier solves
//! all joints below one root together, at a cost that grows with the cube of their number.

use rapier3d::{dynamics::RigidBodyBuilder, math::Pose};
use serde::{Deserialize, Serialize};

use super::coordinates;
use crate::{
    BodyId, Gear, JointId, JointKind, MotionType,
    rapier::{
        bodies::Bodies,
        joints::{
            impulse::build_joint,
            motor::{apply_motor, folded_friction},
            position::{self, coordinate, free_axis},
            record::{JointBackend, JointRecord, ReducedJoint},
            solver::{JointFormSolver, NewJoint},
            table::Joints,
        },
        motors::motor_only,
    },
};

/// A spring is slow if the square of its oscillation phase per sub-step is below this value, rad^2.
const SLOW_SPRING_PHASE_SQUARED: f64 = 0.1;

/// The solver of joints in reduced form, which is that of rapier.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct ReducedJoints {
    /// Joints with a drive.
    pub driven: Vec<JointId>,
    /// Whether springs must be set again, because a spring was added or the length of a sub-step changed.
    pub springs_changed: bool,
    /// Couplings of joints, as set by `set_gears`.
    pub gears: Vec<Gear>,
    /// Whether there are any screw joints.
    pub screws: bool,
}

impl JointFormSolver for ReducedJoints {
    fn add(&mut self, bodies: &mut Bodies, joints: &Joints, new: &NewJoint<'_>) -> Option<JointBackend> {
        let joint = self.insert(bodies, joints, new)?;
        bodies.prepare_for_joint(new.desc.a, false);
        bodies.prepare_for_joint(new.desc.b, false);
        Some(JointBackend::Reduced(joint))
    }

    fn remove(&mut self, bodies: &mut Bodies, joints: &Joints, record: &JointRecord) {
        let Some(joint) = record.reduced() else { return };
        if let Some(motor) = joint.motor {
            bodies.world.remove_impulse_joint(motor);
        }
        bodies.world.remove_multibody_joint(joint.handle);
        let others = joints.iter().filter_map(JointRecord::reduced);
        if joint.anchored && !others.into_iter().any(|o| o.parent == joint.parent) {
            bodies.world.remove_body(joint.parent);
        }
        // The joint coordinates are recomputed from the bodies, so that these retain their motion.
        bodies.moved.extend([record.bodies.0, record.bodies.1]);
    }

    fn set_drive(&mut self, bodies: &mut Bodies, joint: JointId, record: &mut JointRecord) {
        fold_friction(bodies, record);
        let (is_free, frames) = (record.drive.is_free(), record.frames);
        let Some(reduced) = record.reduced_mut() else { return };
        if !is_free {
            if reduced.motor.is_none() {
                let (a, b) = (reduced.parent, reduced.child);
                reduced.motor = Some(bodies.world.insert_impulse_joint(a, b, motor_only(frames)));
            }
            if !self.driven.contains(&joint) {
                self.driven.push(joint);
            }
        }
        // Bodies with joints are always awake.
        if let Some(motor) = reduced.motor.and_then(|m| bodies.world.impulse_joints.get_mut(m, false)) {
            apply_motor(&mut motor.data, record);
        }
    }

    fn before_step(&mut self, bodies: &mut Bodies, joints: &mut Joints) {
        coordinates::recompute_coordinates(bodies);
        if self.springs_changed {
            self.set_springs(bodies, joints);
        }
    }

    fn after_step(&mut self, bodies: &mut Bodies, joints: &mut Joints) {
        self.record_efforts(bodies, joints);
    }
}

impl ReducedJoints {
    /// Adds a joint without preparing its bodies. Returns `None` if it would close a loop, which rapier does not
    /// support in this form.
    pub fn insert(&mut self, bodies: &mut Bodies, joints: &Joints, new: &NewJoint<'_>) -> Option<ReducedJoint> {
        let desc = new.desc;
        let (a, b) = (*bodies.record(desc.a)?, *bodies.record(desc.b)?);
        let anchored = a.motion == MotionType::Static;
        // Joints that are geared to each other must be in the same mechanism.
        let shared = joints.iter().find_map(|r| {
            let other = r.reduced()?;
            (desc.geared && r.geared && other.anchored && r.bodies.0 == desc.a).then_some(other.parent)
        });
        let parent = match (anchored, shared) {
            (true, Some(anchor)) => anchor,
            (true, None) => {
                let pose = *bodies.world.bodies[a.handle].position();
                bodies.world.insert_body(RigidBodyBuilder::fixed().pose(pose))
            }
            (false, _) => a.handle,
        };
        let Some(handle) = bodies.world.insert_multibody_joint(parent, b.handle, build_joint(new)) else {
            if anchored && shared.is_none() {
                bodies.world.remove_body(parent);
            }
            return None;
        };
        if let Some((multibody, id)) = bodies.world.multibody_joints.get_mut(handle)
            && let Some(link) = multibody.link(id)
        {
            let (first, count) = (link.assembly_id(), link.joint().ndofs());
            let own = match desc.kind {
                JointKind::Spherical => first..first + count,
                kind => first + coordinate(kind).0..(first + count).max(first + coordinate(kind).0),
            };
            for i in own {
                multibody.damping_mut()[i] = desc.passive.damping.max(0.0);
                multibody.frictions_mut()[i] = desc.passive.friction.max(0.0);
                multibody.armature_mut()[i] = desc.passive.armature.max(0.0);
            }
            let axis = free_axis(desc.kind).filter(|_| desc.passive.stiffness > 0.0);
            if let (Some(axis), Some(link)) = (axis, multibody.link_mut(id)) {
                let rest = desc.passive.rest - position::zero(desc);
                link.joint.set_spring(axis as usize, desc.passive.stiffness, rest);
            }
        }
        bodies.moved.push(desc.b);
        self.springs_changed |= desc.passive.stiffness > 0.0;
        Some(ReducedJoint { handle, parent, child: b.handle, anchored, motor: None, carried: 0.0, effort: 0.0 })
    }

    /// Subtracts from each joint's damping what rapier's implicit spring adds to it, `stiffness * sub-step`, if the
    /// spring is slow enough for the sub-steps to remain stable without it.
    fn set_springs(&mut self, bodies: &mut Bodies, joints: &Joints) {
        self.springs_changed = false;
        let h = bodies.usual_substep();
        for record in joints.iter() {
            let (Some(reduced), Some(_)) = (record.reduced(), free_axis(record.kind)) else { continue };
            let (stiffness, damping) = (record.passive.stiffness, record.passive.damping);
            if stiffness <= 0.0 {
                continue;
            }
            let Some((multibody, id)) = bodies.world.multibody_joints.get_mut(reduced.handle) else { continue };
            let mobility = multibody.dof_inverse_inertia(&bodies.world.bodies);
            let place = coordinate(record.kind).0;
            let Some(row) = multibody.link(id).map(|l| l.assembly_id() + place) else { continue };
            let slow = mobility.get(row).is_some_and(|m| stiffness * m * h * h < SLOW_SPRING_PHASE_SQUARED);
            multibody.damping_mut()[row] = if slow { damping - stiffness * h } else { damping };
        }
    }

    /// Sets the rest position of a joint's spring, rad or m, which is also recorded.
    pub fn set_rest(&mut self, bodies: &mut Bodies, record: &JointRecord) {
        let (axis, stiffness) = (free_axis(record.kind), record.passive.stiffness);
        let link = record.reduced().and_then(|r| bodies.world.multibody_joints.get_mut(r.handle));
        if let (Some(axis), Some(link)) = (axis, link.and_then(|(m, id)| m.link_mut(id))) {
            link.joint.set_spring(axis as usize, stiffness, record.passive.rest - record.turns.zero);
        }
    }

    /// Moves the anchors along with the static body that they represent.
    pub fn move_anchors(&self, bodies: &mut Bodies, joints: &Joints, body: BodyId, pose: &Pose) {
        for record in joints.iter() {
            if let (true, Some(reduced)) = (record.bodies.0 == body, record.reduced().filter(|r| r.anchored)) {
                bodies.world.bodies[reduced.parent].set_position(*pose, true);
            }
        }
    }
}

/// Divides the dry friction of a joint between the limit of its drive and the joint's own constraint.
fn fold_friction(bodies: &mut Bodies, record: &mut JointRecord) {
    let folded = folded_friction(record);
    if folded == record.drive.folded {
        return;
    }
    record.drive.folded = folded;
    let own = record.passive.friction - folded;
    let place = coordinate(record.kind).0;
    let link = record.reduced().and_then(|r| bodies.world.multibody_joints.get_mut(r.handle));
    if let Some((multibody, id)) = link
        && let Some(row) = multibody.link(id).map(|l| l.assembly_id() + place)
    {
        multibody.frictions_mut()[row] = own;
    }
}
