//! Joints in impulse form: rapier's impulse joints, which pull two bodies together. Loops are closed in this form, too.

use rapier3d::{
    dynamics::{GenericJoint, JointAxesMask, JointLimits, RigidBody, SpringCoefficients},
    math::{Pose, Vector},
};
use serde::{Deserialize, Serialize};

use super::{
    motor::{apply_motor, folded_friction},
    position::free_axis,
    record::{JointBackend, JointRecord},
    solver::{JointFormSolver, NewJoint},
    table::Joints,
};
use crate::{
    JointForm, JointId, JointKind,
    rapier::{
        bodies::Bodies,
        tuning::{CARRIER_ITERATIONS, JOINT_SOFTNESS, MAX_ADDED_ITERATIONS, UNEVEN_MASS_RATIO},
    },
};

/// The solver of joints in impulse form, which is that of rapier.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct ImpulseJoints;

impl JointFormSolver for ImpulseJoints {
    fn add(&mut self, bodies: &mut Bodies, _: &Joints, new: &NewJoint<'_>) -> Option<JointBackend> {
        let (a, b) = (bodies.record(new.desc.a)?.handle, bodies.record(new.desc.b)?.handle);
        let (mass_a, mass_b) = (bodies.world.bodies[a].mass(), bodies.world.bodies[b].mass());
        let uneven = mass_a.max(mass_b) > UNEVEN_MASS_RATIO * mass_a.min(mass_b);
        bodies.prepare_for_joint(new.desc.a, uneven);
        bodies.prepare_for_joint(new.desc.b, uneven);
        Some(JointBackend::Impulse(bodies.world.insert_impulse_joint(a, b, build_joint(new))))
    }

    fn remove(&mut self, bodies: &mut Bodies, _: &Joints, record: &JointRecord) {
        if let JointBackend::Impulse(handle) = record.backend {
            bodies.world.remove_impulse_joint(handle);
        }
    }

    fn set_drive(&mut self, bodies: &mut Bodies, _: JointId, record: &mut JointRecord) {
        let JointBackend::Impulse(handle) = record.backend else { return };
        record.drive.folded = folded_friction(record);
        // Bodies with joints are always awake.
        let Some(joint) = bodies.world.impulse_joints.get_mut(handle, false) else { return };
        let was_free = joint.data.motor_axes.is_empty();
        apply_motor(&mut joint.data, record);
        // The number of iterations depends only on masses and frames, so it is updated only when a joint starts to be
        // driven.
        if record.drive.is_free() || !was_free {
            return;
        }
        let (a, b) = (joint.body1(), joint.body2());
        let carries = bodies.record(record.bodies.1).is_some_and(|r| r.joints > 1);
        let needed = added_iterations(record.frames, &bodies.world.bodies[a], &bodies.world.bodies[b])
            .max(if carries { CARRIER_ITERATIONS } else { 0 });
        if needed > bodies.world.bodies[b].additional_pgs_iterations() {
            bodies.world.bodies[b].set_additional_pgs_iterations(needed);
        }
    }
}

/// Builds rapier's joint.
pub(crate) fn build_joint(new: &NewJoint<'_>) -> GenericJoint {
    let NewJoint { desc, frames, zero } = *new;
    let free = free_axis(desc.kind);
    let freed = match desc.kind {
        JointKind::Spherical => JointAxesMask::ANG_AXES,
        JointKind::Screw(_) => JointAxesMask::ANG_Z | JointAxesMask::LIN_Z,
        _ => free.map_or(JointAxesMask::empty(), JointAxesMask::from),
    };
    let mut joint = GenericJoint::new(JointAxesMask::LOCKED_FIXED_AXES & !freed);
    (joint.local_frame1, joint.local_frame2) = frames;
    // The bodies' masks decide whether they collide.
    joint.contacts_enabled = true;
    if desc.form == JointForm::Impulse {
        joint.softness = SpringCoefficients::new(JOINT_SOFTNESS.0, JOINT_SOFTNESS.1);
        // Limits on a locked axis add no constraint between bodies that are not in reduced form, but exclude the joint
        // from rapier's SIMD path. Rapier uses that path only for 64 or more joints, and it solves a robot's joints in
        // a different order, so the motion of a robot would depend on the number of other joints.
        joint.limit_axes |= JointAxesMask::LIN_X;
        joint.coupled_axes |= JointAxesMask::LIN_X;
    }
    if let (Some(axis), Some((low, high))) = (free, desc.limits) {
        joint.limit_axes |= axis.into();
        joint.limits[axis as usize] = JointLimits { min: low - zero, max: high - zero, impulse: 0.0 };
    }
    joint
}

/// Returns the number of additional iterations that a driven joint needs in each sub-step.
///
/// Rapier solves the motor and the pivot of a joint one after the other. If the moved body's centre of mass is on the
/// axis, as in a wheel, one iteration is exact. Otherwise each iteration leaves 1 - 1/q of the error, where q is the
/// ratio of the inertia about the axis to that about the centre of mass: 3/4 for a rod held at its end, which would
/// then lag behind gravity by 0.04 rad/s. Six iterations per unit of q above 1 leave less than 0.3 %.
fn added_iterations(frames: (Pose, Pose), a: &RigidBody, b: &RigidBody) -> usize {
    let (frame_a, frame_b) = (a.position() * frames.0, b.position() * frames.1);
    let axis = frame_b.rotation * Vector::Z;
    let mobility = |body: &RigidBody, pivot: Vector| {
        if !body.is_dynamic() {
            return (0.0, 0.0);
        }
        let about_com = axis.dot(body.mass_properties().effective_world_inv_inertia * axis);
        let arm = (pivot - body.center_of_mass()).cross(axis);
        let inertia = 1.0 / about_com + body.mass() * arm.length_squared();
        (about_com, 1.0 / inertia)
    };
    let (of_a, of_b) = (mobility(a, frame_a.translation), mobility(b, frame_b.translation));
    let q = (of_a.0 + of_b.0) / (of_a.1 + of_b.1);
    // The ratio is NaN for bodies without inertia. Below 1.01, as for a wheel on a chassis, the first iteration leaves
    // less than 1 %.
    if q.is_nan() || q < 1.01 { 0 } else { (6.0 * (q - 1.0)).ceil().min(MAX_ADDED_ITERATIONS) as usize }
}
