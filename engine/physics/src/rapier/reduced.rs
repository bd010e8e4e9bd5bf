//! Joints in reduced coordinates: rapier's multibodies, which compute only the degrees of freedom of each joint.
//!
//! - A mechanism on a static body is attached to a separate anchor, a fixed body without shapes, because rapier solves
//!   all joints below one root together, at a cost that grows with the cube of their number.
//! - A drive is a constraint between the two links. Rapier iterates over the constraints once in each sub-step, so an
//!   arm of many joints would sag. The effort of a drive in one step, up to half of its limit, is therefore applied as
//!   a force in the next ([`ReducedJoint::carried`]), and the constraint has to find only the difference.
//! - Rapier stores positions and velocities of joints, not of bodies. After the pose or velocity of a body is set from
//!   outside, they are recomputed from the bodies before the next step ([`Rapier::recompute_coordinates`]).

use rapier3d::{
    dynamics::{GenericJoint, Multibody, MultibodyIndex, RigidBodyBuilder, RigidBodySet},
    math::{Pose, Vector},
};
use tatu_geometry::wrap_angle;

use super::{
    gears, joints,
    push::SavedForces,
    records::{JointRecord, ReducedJoint},
    state::Rapier,
    tuning::{HALVED_SUBSTEPS_TIME_S, MAX_SUBSTEP_MOTION, REST_SPEED_SHARE, REST_TIME_S},
    turns,
};
use crate::{JointDesc, JointDrive, JointKind, MotionType};

/// Maximum fraction of a drive's limit that is applied as a force. With one half, the total never exceeds the limit,
/// and the constraint, whose own limit is the same in both directions, can always cancel the force.
const MAX_CARRIED_SHARE: f64 = 0.5;

/// A spring is slow if the square of its oscillation phase per sub-step is below this value, rad^2.
const SLOW_SPRING_PHASE_SQUARED: f64 = 0.1;

impl Rapier {
    /// Adds a joint in reduced form. Returns `None` if it would close a loop, which rapier does not support in this
    /// form.
    pub(super) fn add_reduced(&mut self, desc: &JointDesc, data: GenericJoint) -> Option<ReducedJoint> {
        let (a, b) = (*self.record(desc.a)?, *self.record(desc.b)?);
        let anchored = a.motion == MotionType::Static;
        // Joints that are geared to each other must be in the same mechanism.
        let shared = self.state.joints.iter().flatten().find_map(|r| {
            let other = r.reduced()?;
            (desc.geared && r.geared && other.anchored && r.bodies.0 == desc.a).then_some(other.parent)
        });
        let parent = match (anchored, shared) {
            (true, Some(anchor)) => anchor,
            (true, None) => {
                let pose = *self.world.bodies[a.handle].position();
                self.world.insert_body(RigidBodyBuilder::fixed().pose(pose))
            }
            (false, _) => a.handle,
        };
        let Some(handle) = self.world.insert_multibody_joint(parent, b.handle, data) else {
            if anchored && shared.is_none() {
                self.world.remove_body(parent);
            }
            return None;
        };
        if let Some((multibody, id)) = self.world.multibody_joints.get_mut(handle)
            && let Some(link) = multibody.link(id)
        {
            let (first, count) = (link.assembly_id(), link.joint().ndofs());
            let own = match desc.kind {
                JointKind::Spherical => first..first + count,
                kind => first + gears::coordinate(kind).0..(first + count).max(first + gears::coordinate(kind).0),
            };
            for i in own {
                multibody.damping_mut()[i] = desc.passive.damping.max(0.0);
                multibody.frictions_mut()[i] = desc.passive.friction.max(0.0);
                multibody.armature_mut()[i] = desc.passive.armature.max(0.0);
            }
            let axis = desc.kind.free_axis().filter(|_| desc.passive.stiffness > 0.0);
            if let (Some(axis), Some(link)) = (axis, multibody.link_mut(id)) {
                link.joint.set_spring(axis as usize, desc.passive.stiffness, desc.passive.rest - turns::zero(desc));
            }
        }
        self.state.moved.push(desc.b);
        self.state.springs_changed |= desc.passive.stiffness > 0.0;
        Some(ReducedJoint { handle, parent, child: b.handle, anchored, motor: None, carried: 0.0, effort: 0.0 })
    }

    pub(super) fn remove_reduced(&mut self, record: &JointRecord, joint: ReducedJoint) {
        if let Some(motor) = joint.motor {
            self.world.remove_impulse_joint(motor);
        }
        self.world.remove_multibody_joint(joint.handle);
        let others = self.state.joints.iter().flatten().filter_map(JointRecord::reduced);
        if joint.anchored && !others.into_iter().any(|o| o.parent == joint.parent) {
            self.world.remove_body(joint.parent);
        }
        // The bodies that were attached keep their motion.
        self.state.moved.extend([record.bodies.0, record.bodies.1]);
    }

    /// Subtracts from each joint's damping what rapier's implicit spring adds to it, `stiffness * sub-step`, if the
    /// spring is slow enough for the sub-steps to remain stable without it.
    pub(super) fn set_springs(&mut self) {
        self.state.springs_changed = false;
        let h = self.world.integration_parameters.dt / self.state.substeps as f64;
        for record in self.state.joints.iter().flatten() {
            let (Some(reduced), Some(_)) = (record.reduced(), record.kind.free_axis()) else { continue };
            let (stiffness, damping) = (record.passive.stiffness, record.passive.damping);
            if stiffness <= 0.0 {
                continue;
            }
            let Some((multibody, id)) = self.world.multibody_joints.get_mut(reduced.handle) else { continue };
            let mobility = multibody.dof_inverse_inertia(&self.world.bodies);
            let place = gears::coordinate(record.kind).0;
            let Some(row) = multibody.link(id).map(|l| l.assembly_id() + place) else { continue };
            let slow = mobility.get(row).is_some_and(|m| stiffness * m * h * h < SLOW_SPRING_PHASE_SQUARED);
            multibody.damping_mut()[row] = if slow { damping - stiffness * h } else { damping };
        }
    }

    /// Moves the anchors along with the static body that they represent.
    pub(super) fn move_anchors(&mut self, body: crate::BodyId, pose: &Pose) {
        for record in self.state.joints.iter().flatten() {
            if let (true, Some(reduced)) = (record.bodies.0 == body, record.reduced().filter(|r| r.anchored)) {
                self.world.bodies[reduced.parent].set_position(*pose, true);
            }
        }
    }

    /// Recomputes positions and velocities of joints in all mechanisms with a body that was moved or attached from
    /// outside.
    pub(super) fn recompute_coordinates(&mut self) {
        if self.state.moved.is_empty() {
            return;
        }
        let mut found: Vec<MultibodyIndex> = Vec::new();
        for id in std::mem::take(&mut self.state.moved) {
            let Some(handle) = self.record(id).map(|r| r.handle) else { continue };
            let Some(link) = self.world.multibody_joints.rigid_body_link(handle) else { continue };
            if !found.contains(&link.multibody) {
                found.push(link.multibody);
            }
        }
        let (bodies, joints) = (&mut self.world.bodies, &mut self.world.multibody_joints);
        for index in found {
            if let Some(multibody) = joints.get_multibody_mut(index) {
                recompute_multibody(multibody, bodies);
            }
        }
    }

    /// Doubles the number of sub-steps while a mechanism swings so fast that it would gain or lose energy: a double
    /// pendulum that falls from horizontal keeps its energy to 2 % instead of 10 %. The number remains doubled for a
    /// while or until the mechanism has come to rest, because each change of the sub-step also costs energy: a pendulum
    /// with changes in each swing would lose 10 % in 100 s.
    pub(super) fn choose_substeps(&mut self) {
        let (usual, dt) = (self.state.substeps, self.world.integration_parameters.dt);
        let fastest = MAX_SUBSTEP_MOTION * usual as f64 / dt;
        self.state.fast_s = (self.state.fast_s - dt).max(0.0);
        let speeds = self.world.multibody_joints.multibodies().map(|m| m.generalized_velocity().amax());
        let most = speeds.fold(0.0, f64::max);
        if most > fastest {
            self.state.fast_s = HALVED_SUBSTEPS_TIME_S;
        }
        self.state.calm_s = if most < REST_SPEED_SHARE * fastest { self.state.calm_s + dt } else { 0.0 };
        if self.state.calm_s > REST_TIME_S {
            self.state.fast_s = 0.0;
        }
        let fast = self.state.fast_s > 0.0;
        self.world.integration_parameters.num_solver_iterations = if fast { 2 * usual } else { usual };
    }

    /// Applies the efforts that drives carry over from the last step ([`ReducedJoint::carried`]) as forces. The result
    /// must be passed to [`Rapier::restore_forces`] after the step.
    pub(super) fn add_carried_effort(&mut self) -> Vec<SavedForces> {
        let mut old = Vec::new();
        for id in &self.state.driven {
            let Some(Some(record)) = self.state.joints.get(id.0 as usize) else { continue };
            let (Some(joint), Some(limit)) = (record.reduced(), effort_limit(record.drive)) else { continue };
            if let Some(motor) = joint.motor.and_then(|m| self.world.impulse_joints.get_mut(m, false))
                && let Some(axis) = record.kind.free_axis()
            {
                let motor = &mut motor.data.motors[axis as usize];
                motor.max_force = (limit - joint.carried.abs()).min(f64::MAX);
            }
            if joint.carried == 0.0 {
                continue;
            }
            let bodies = &mut self.world.bodies;
            let frame = *bodies[joint.child].position() * record.frames.1;
            let axis = (bodies[joint.parent].position().rotation * record.frames.0.rotation) * Vector::Z;
            for (handle, sign) in [(joint.child, 1.0), (joint.parent, -1.0)] {
                let body = &mut bodies[handle];
                if !body.is_dynamic() {
                    continue;
                }
                old.push(SavedForces::of(handle, body));
                match record.kind {
                    JointKind::Prismatic => {
                        body.add_force_at_point(axis * (sign * joint.carried), frame.translation, false);
                    }
                    _ => body.add_torque(axis * (sign * joint.carried), false),
                }
            }
        }
        old
    }

    /// Records the efforts of drives in this step.
    pub(super) fn record_drive_efforts(&mut self) {
        let substep = self.substep();
        let world = &self.world;
        let joints = &mut self.state.joints;
        self.state.driven.retain(|id| {
            let Some(Some(record)) = joints.get_mut(id.0 as usize) else { return false };
            let (axis, drive, no_load) = (record.kind.free_axis(), record.drive, record.passive.no_load_speed);
            let Some(joint) = record.reduced_mut() else { return false };
            let (Some(axis), true) = (axis, drive != JointDrive::Free) else {
                (joint.carried, joint.effort) = (0.0, 0.0);
                return false;
            };
            let Some(motor) = joint.motor.and_then(|m| world.impulse_joints.get(m)) else { return true };
            // Rapier's impulses have the opposite sign: they slow the second body down.
            joint.effort = joint.carried - motor.data.motors[axis as usize].impulse / substep;
            let weakening = no_load > 0.0;
            joint.carried = match effort_limit(drive) {
                Some(limit) if joint.effort.is_finite() && !weakening => {
                    let most = MAX_CARRIED_SHARE * limit.min(f64::MAX);
                    joint.effort.clamp(-most, most)
                }
                _ => 0.0,
            };
            true
        });
    }
}

/// Returns the limit of a drive whose effort results from the load, or `None` for other drives.
fn effort_limit(drive: JointDrive) -> Option<f64> {
    match drive {
        JointDrive::Velocity { max_force, slip: 0.0, .. } => Some(max_force),
        JointDrive::Position { max_force, .. } => Some(max_force),
        _ => None,
    }
}

fn recompute_multibody(multibody: &mut Multibody, bodies: &mut RigidBodySet) {
    // This also determines whether the root is dynamic.
    multibody.forward_kinematics(bodies, true);
    let links = multibody.num_links();
    let mut velocities = vec![0.0; multibody.ndofs()];
    for i in 0..links {
        let Some(link) = multibody.link(i) else { continue };
        let (first, count) = (link.assembly_id(), link.joint().ndofs());
        let child = &bodies[link.rigid_body_handle()];
        let Some(parent) = link.parent_id().and_then(|p| multibody.link(p)) else {
            if count == 6 {
                let (v, w) = (child.linvel(), child.angvel());
                velocities[..6].copy_from_slice(&[v.x, v.y, v.z, w.x, w.y, w.z]);
                // Rapier's default damping would slow down a free mechanism.
                multibody.damping_mut().rows_mut(0, 6).fill(0.0);
            }
            continue;
        };
        let parent = &bodies[parent.rigid_body_handle()];
        let data = link.joint().data;
        let (frame_a, frame_b) = (*parent.position() * data.local_frame1, *child.position() * data.local_frame2);
        let mut way = [0.0; 3];
        match count {
            1 => {
                let kind = joints::kind_of(&data);
                let axis = frame_a.rotation * Vector::Z;
                let coordinates = link.joint().coords();
                let now = joints::position(kind, &frame_a, &frame_b);
                (way[0], velocities[first]) = match kind {
                    // The wrapped difference preserves the number of whole turns.
                    JointKind::Revolute => {
                        (wrap_angle(now - coordinates[5]), (child.angvel() - parent.angvel()).dot(axis))
                    }
                    _ => (
                        now - coordinates[2],
                        (child.velocity_at_point(frame_b.translation) - parent.velocity_at_point(frame_b.translation))
                            .dot(axis),
                    ),
                };
            }
            // A screw, with the degrees of freedom translation and rotation.
            2 => {
                let axis = frame_a.rotation * Vector::Z;
                let coordinates = link.joint().coords();
                let angle = joints::position(JointKind::Revolute, &frame_a, &frame_b);
                way[0] = joints::position(JointKind::Prismatic, &frame_a, &frame_b) - coordinates[2];
                way[1] = wrap_angle(angle - coordinates[5]);
                let slide =
                    child.velocity_at_point(frame_b.translation) - parent.velocity_at_point(frame_b.translation);
                velocities[first] = slide.dot(axis);
                velocities[first + 1] = (child.angvel() - parent.angvel()).dot(axis);
            }
            3 => {
                let turn = frame_a.rotation.inverse() * frame_b.rotation * link.joint().joint_rot().inverse();
                way = turn.to_scaled_axis().into();
                let relative = frame_a.rotation.inverse() * (child.angvel() - parent.angvel());
                velocities[first..first + 3].copy_from_slice(&[relative.x, relative.y, relative.z]);
            }
            _ => {}
        }
        if let Some(link) = multibody.link_mut(i).filter(|_| count > 0) {
            link.joint.apply_displacement(&way[..count.min(3)]);
        }
    }
    multibody.generalized_velocity_mut().copy_from_slice(&velocities);
    multibody.forward_kinematics(bodies, false);
    multibody.update_rigid_bodies(bodies, true);
}
