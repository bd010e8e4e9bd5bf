//! [`Engine`] implemented with rapier3d, in f64.
//!
//! - Velocities are solved in sub-steps; collisions are detected once per step.
//! - The restitution of a pair is the product of both bodies' coefficients, as in Bullet; `FrictionRule` determines the
//!   friction.
//! - Bodies with joints never sleep; others sleep once they have rested on something for one second.
//! - Work is shared among the threads of the calling rayon pool: `pool.install(|| engine.advance(5))`. The bits of the
//!   result do not depend on the number of threads.
//!
//! `tuning` defines the parameters of the solver. `state` is the engine's complete state, `records` its data for each
//! body and joint, `shapes` a cache of shapes. `bodies` creates bodies and colliders, `joints` creates joints, `drives`
//! updates their drives, `park` lets parked mechanisms sleep, `reduced` implements
//! joints in reduced coordinates, `gears` couples joints, `load` computes their loads, `collision_filter` decides which
//! bodies collide, `surface_friction` implements anisotropic and rolling friction, `separation` separates bodies that
//! were created overlapping, `narrow` finds contacts of hulls and meshes, `contact_refresh` lets cylinders roll,
//! `report` reads contacts, `velocity` computes velocities, `spin` integrates gyroscopic motion, `mechanisms` solves
//! mechanisms without rapier, `sleep` decides which bodies can sleep, `turns` counts whole turns, `push` applies forces
//! for a single step, and `snapshot` saves and restores the state.

mod bodies;
mod collision_filter;
mod contact_refresh;
mod drives;
mod gears;
mod joints;
mod load;
mod mechanisms;
mod narrow;
mod park;
mod push;
mod records;
mod reduced;
mod report;
mod separation;
mod shapes;
mod sleep;
mod snapshot;
mod spin;
mod state;
mod surface_friction;
#[cfg(test)]
mod tests;
mod tuning;
mod turns;
mod velocity;

use collision_filter::PairFilter;
use nalgebra::{Isometry3, Point3, Vector3};
use rapier3d::{
    dynamics::{IntegrationParameters, SpringCoefficients},
    math::{Pose, Vector},
    pipeline::PhysicsWorld,
};
use records::{ControllerState, JointBackend, JointRecord, MeasuredJoint, RestState, TreeJoint};
use shapes::ShapeCache;
pub use state::Rapier;
use state::{EngineState, is_finite, mark_changed};
pub use tuning::SETTLE_TIME;
use tuning::{CONTACT_SOFTNESS, MAX_CONTACT_FREQUENCY_SHARE, STATIC_CONTACT_SOFTNESS, UNEVEN_MASS_RATIO};

use super::{
    BeforeStepHook, BodyContact, BodyDesc, BodyId, ContactSurface, Engine, EngineSettings, Gear, JointDesc, JointDrive,
    JointForm, JointId, JointKind, JointState, MaterialPair, MotionType, PairRule, Twist, Wrench, convert,
};

impl Rapier {
    /// Creates a world without bodies.
    pub fn new(settings: EngineSettings) -> Self {
        let world =
            PhysicsWorld { integration_parameters: IntegrationParameters::default(), ..PhysicsWorld::default() };
        let mut engine = Self { world, state: EngineState::default(), shapes: ShapeCache::default() };
        narrow::install(&mut engine.world);
        engine.configure(settings);
        engine
    }

    /// Moves kinematic bodies at constant velocity along their paths. They thus push other bodies with the velocity of
    /// their motion. `done` is the fraction of the advance that is complete after this step.
    fn move_kinematic(&mut self, done: f64) {
        for (id, (from, to)) in &self.state.moving {
            let Some(record) = &self.state.bodies[id.0 as usize] else {
                continue;
            };
            let pose = if done < 1.0 {
                Pose {
                    translation: from.translation.lerp(to.translation, done),
                    rotation: from.rotation.slerp(to.rotation, done),
                }
            } else {
                *to
            };
            self.world.bodies[record.handle].set_next_kinematic_position(pose);
        }
    }
}

impl Rapier {
    /// Returns the friction that the rule or the materials of a pair specify, or `None` if neither is set.
    fn specified_friction(&self, a: BodyId, b: BodyId) -> Option<f64> {
        let rule = self.state.pairs.get(&(a.min(b), a.max(b))).and_then(|r| r.friction);
        let material = |id| self.state.surfaces.get(&id).map_or(0, |s| s.material);
        rule.or_else(|| {
            collision_filter::material_pair(&self.state.materials, material(a), material(b)).map(|p| p.friction)
        })
    }
}

impl Engine for Rapier {
    fn configure(&mut self, settings: EngineSettings) {
        let gravity = convert::vector(&settings.gravity);
        if gravity != self.world.gravity {
            self.world.gravity = gravity;
            self.world.wake_up_all(true);
        }
        self.world.integration_parameters.dt = settings.step;
        self.state.substeps = settings.substeps.max(1) as usize;
        self.state.springs_changed = true;
        self.world.integration_parameters.num_solver_iterations = self.state.substeps;
        // Contacts that are too stiff for the sub-step make stacks rock.
        let rate = 1.0 / self.substep();
        let spring = |usual: (f64, f64), share| {
            let (frequency, damping) = settings.contact_spring.map_or(usual, |[f, d]| (f, d));
            SpringCoefficients::new(frequency.min(share * rate), damping)
        };
        self.world.integration_parameters.contact_softness = spring(CONTACT_SOFTNESS, MAX_CONTACT_FREQUENCY_SHARE);
        self.world.integration_parameters.static_contact_softness =
            spring(STATIC_CONTACT_SOFTNESS, 2.0 * MAX_CONTACT_FREQUENCY_SHARE);
        self.state.friction_rule = settings.friction_rule;
        if self.state.sleep != settings.sleep {
            self.state.sleep = settings.sleep;
            self.set_sleep();
        }
    }

    fn add_body(&mut self, desc: &BodyDesc) -> BodyId {
        self.insert_body(desc)
    }

    fn remove_body(&mut self, body: BodyId) {
        self.delete_body(body);
    }

    fn add_joint(&mut self, desc: &JointDesc) -> Option<JointId> {
        let (a, b) = (*self.record(desc.a)?, *self.record(desc.b)?);
        if a.handle == b.handle {
            return None;
        }
        self.release_adopted_body(desc.a);
        self.release_adopted_body(desc.b);
        let zero = turns::zero(desc);
        let frame_a = a.local_pose(&desc.frame_in_a);
        let frames = (turns::turned(frame_a, zero), b.local_pose(&desc.frame_in_b));
        let (mass_a, mass_b) = (self.world.bodies[a.handle].mass(), self.world.bodies[b.handle].mass());
        let crowd = self.crowd_of(desc);
        let reduced = crowd.is_some() || matches!(desc.kind, JointKind::Screw(_));
        let form = if reduced { JointForm::Reduced } else { desc.form };
        let reduced = match form {
            JointForm::Reduced => self.add_reduced(desc, joints::build_joint(desc, frames, zero)),
            JointForm::Tree | JointForm::Impulse | JointForm::Loop => None,
        };
        let tree = form == JointForm::Tree && self.may_join_tree(desc);
        let uneven = reduced.is_none() && !tree && mass_a.max(mass_b) > UNEVEN_MASS_RATIO * mass_a.min(mass_b);
        self.prepare_for_joint(desc.a, uneven);
        self.prepare_for_joint(desc.b, uneven);
        let held = reduced.map_or_else(
            || {
                if tree {
                    return JointBackend::Tree(TreeJoint::default());
                }
                // If the joint was to be in reduced form or in a tree but cannot be, it closes a loop.
                let form = if desc.form == JointForm::Impulse { JointForm::Impulse } else { JointForm::Loop };
                let desc = JointDesc { form, ..desc.clone() };
                JointBackend::Impulse(self.world.insert_impulse_joint(
                    a.handle,
                    b.handle,
                    joints::build_joint(&desc, frames, zero),
                ))
            },
            JointBackend::Reduced,
        );
        let id = JointId(self.state.joints.len() as u32);
        let mut record = JointRecord {
            held,
            kind: desc.kind,
            bodies: (desc.a, desc.b),
            frames,
            passive: desc.passive,
            limits: desc.limits,
            zero,
            near: turns::near(desc, zero),
            geared: desc.geared,
            closes_loop: desc.form == JointForm::Loop,
            drive: JointDrive::Free,
            pursuit: 0.0,
            rest: RestState::default(),
            memory: ControllerState::default(),
            speed: 0.0,
            at_limit: false,
            folded: 0.0,
            changed: false,
        };
        self.state.joints_changed = true;
        if tree {
            self.state.mechanisms_changed = true;
            self.claim_body(desc.a);
            self.claim_body(desc.b);
        }
        if turns::is_wide(&record) {
            self.state.winding.push(id);
        }
        if desc.passive.no_load_speed > 0.0 {
            self.state.weakening.push(id);
        }
        if reduced.is_none() && !tree && desc.passive.damping > 0.0 {
            mark_changed(&mut self.state.changed, id, &mut record);
        }
        self.state.joints.push(Some(record));
        if let Some(crowd) = crowd {
            self.grow_crowd(crowd, id, desc.b);
        }
        Some(id)
    }

    fn remove_joint(&mut self, joint: JointId) {
        let Some(record) = self.state.joints.get_mut(joint.0 as usize).and_then(Option::take) else {
            return;
        };
        self.state.joints_changed = true;
        self.state.weakening.retain(|j| *j != joint);
        self.state.winding.retain(|j| *j != joint);
        match record.held {
            JointBackend::Impulse(handle) => drop(self.world.remove_impulse_joint(handle)),
            JointBackend::Reduced(reduced) => self.remove_reduced(&record, reduced),
            JointBackend::Tree(_) => {
                self.state.mechanisms_changed = true;
                self.release_unclaimed_body(record.bodies.0);
                self.release_unclaimed_body(record.bodies.1);
            }
        }
        self.free_from_joint(record.bodies.0);
        self.free_from_joint(record.bodies.1);
    }

    fn drive(&mut self, joint: JointId, drive: JointDrive) {
        let drive = joints::sanitized(drive);
        let Some(Some(record)) = self.state.joints.get_mut(joint.0 as usize) else {
            return;
        };
        if record.drive == drive {
            return;
        }
        let is_position = |d: JointDrive| matches!(d, JointDrive::Position { .. });
        if is_position(drive) && !is_position(record.drive) && !self.state.positioned.contains(&joint) {
            self.state.positioned.push(joint);
        }
        record.drive = drive;
        record.rest = RestState::default();
        let (stops, body) = (record.stops(), record.bodies.1);
        mark_changed(&mut self.state.changed, joint, record);
        if stops {
            self.watch_stopping_joint(joint);
        }
        self.unpark(body);
    }

    fn set_gears(&mut self, gears: &[Gear]) {
        if self.state.gears != gears {
            self.state.gears = gears.to_vec();
            self.state.joints_changed = true;
        }
    }

    fn measure(&mut self, joint: JointId) {
        if !self.state.measured.iter().any(|m| m.joint == joint) {
            self.state.measured.push(MeasuredJoint::new(joint));
            if let Some(body) = self.state.joints.get(joint.0 as usize).and_then(|r| Some(r.as_ref()?.bodies.1)) {
                self.unpark(body);
            }
        }
    }

    fn wrench(&self, joint: JointId) -> Option<Wrench> {
        self.state.measured.iter().find(|m| m.joint == joint)?.wrench
    }

    fn set_surface(&mut self, body: BodyId, surface: ContactSurface) {
        if self.record(body).is_none() || !bodies::is_valid_surface(&surface) {
            return;
        }
        if surface == ContactSurface::default() {
            self.state.surfaces.remove(&body);
        } else if self.state.surfaces.insert(body, surface) != Some(surface) {
            self.enable_pair_hooks(body);
            // Bodies that rest on a belt must wake when it starts.
            let handle = self.record(body).map(|r| r.handle);
            handle.into_iter().for_each(|h| self.wake_touching(h));
        }
    }

    fn set_materials(&mut self, pairs: &[MaterialPair]) {
        self.state.materials = pairs.to_vec();
    }

    fn set_rest(&mut self, joint: JointId, rest: f64) {
        if let Some(Some(record)) = self.state.joints.get_mut(joint.0 as usize)
            && rest.is_finite()
            && record.passive.rest != rest
        {
            record.passive.rest = rest;
            let (axis, stiffness, zero) = (record.kind.free_axis(), record.passive.stiffness, record.zero);
            let link = record.reduced().and_then(|r| self.world.multibody_joints.get_mut(r.handle));
            if let (Some(axis), Some(link)) = (axis, link.and_then(|(m, id)| m.link_mut(id))) {
                link.joint.set_spring(axis as usize, stiffness, rest - zero);
            }
        }
    }

    fn set_pose(&mut self, body: BodyId, pose: &Isometry3<f64>) {
        self.set_body_pose(body, pose);
    }

    fn set_twist(&mut self, body: BodyId, twist: &Twist) {
        let Some((handle, MotionType::Dynamic)) = self.record(body).map(|r| (r.handle, r.motion)) else {
            return;
        };
        if !is_finite(&twist.linear) || !is_finite(&twist.angular) {
            return self.freeze(body);
        }
        let moved = &mut self.world.bodies[handle];
        moved.set_linvel(convert::vector(&twist.linear), true);
        moved.set_angvel(convert::vector(&twist.angular), true);
        self.state.moved.push(body);
        self.discard_velocity(body);
    }

    fn push(&mut self, body: BodyId, force: Vector3<f64>, torque: Vector3<f64>) {
        let Some((handle, MotionType::Dynamic)) = self.record(body).map(|r| (r.handle, r.motion)) else {
            return;
        };
        if !is_finite(&force) || !is_finite(&torque) {
            return self.freeze(body);
        }
        if self.record(body).is_some_and(|r| r.in_tree) {
            let sum = self.state.loads.entry(body).or_default();
            (sum.force, sum.torque) = (sum.force + force, sum.torque + torque);
            return;
        }
        let pushed = &mut self.world.bodies[handle];
        pushed.add_force(convert::vector(&force), true);
        pushed.add_torque(convert::vector(&torque), true);
        self.state.pushed.push(body);
    }

    fn advance_part(&mut self, part: u32, parts: u32, before: Option<&mut BeforeStepHook<'_>>) {
        self.move_kinematic(f64::from(part + 1) / f64::from(parts));
        self.update_adoptions();
        self.arrange_trees();
        self.recompute_coordinates();
        if self.state.springs_changed {
            self.set_springs();
        }
        self.count_turns();
        self.update_position_drives();
        self.park();
        self.weaken_drives();
        self.apply_drives();
        let old = match before {
            Some(ask) => {
                let mut pushes = Vec::new();
                ask(&*self, part, &mut pushes);
                self.push_for_step(&pushes)
            }
            None => Vec::new(),
        };
        let carried = self.add_carried_effort();
        let spun = self.advance_spin(0.5);
        self.record_velocities();
        self.choose_substeps();
        self.find_overlaps();
        self.record_momenta();
        self.update_gears();
        self.update_surface_friction();
        let deepest = self.separation_depths();
        let EngineState { pairs, surfaces, materials, partings, .. } = &self.state;
        let (gravity, step, substep) = (self.world.gravity, self.world.integration_parameters.dt, self.substep());
        let filter = PairFilter {
            pairs,
            surfaces,
            materials,
            separations: partings,
            max_depths: deepest,
            gravity,
            step,
            substep,
        };
        self.world.step_with_events(&filter, &());
        self.update_separations();
        self.step_trees();
        self.measure_loads();
        self.finish_spin(spun);
        self.restore_forces(carried);
        self.restore_forces(old);
        self.record_drive_efforts();
        self.collect_frozen();
        if part + 1 < parts {
            return;
        }
        self.keep_floating_bodies_awake();
        self.state.loads.clear();
        self.state.moving.clear();
        let mut pushed = std::mem::take(&mut self.state.pushed);
        for id in pushed.drain(..) {
            let Some(handle) = self.record(id).map(|r| r.handle) else {
                continue;
            };
            let body = &mut self.world.bodies[handle];
            body.reset_forces(false);
            body.reset_torques(false);
        }
        self.state.pushed = pushed;
    }

    fn set_pair(&mut self, a: BodyId, b: BodyId, rule: Option<PairRule>) {
        let pair = (a.min(b), a.max(b));
        match rule {
            None => drop(self.state.pairs.remove(&pair)),
            Some(rule) => {
                self.state.pairs.insert(pair, rule);
                // The filter must be enabled for bodies with a rule.
                for body in [a, b] {
                    self.enable_pair_hooks(body);
                }
            }
        }
    }

    fn pose(&self, body: BodyId) -> Isometry3<f64> {
        let Some(record) = self.record(body) else {
            return Isometry3::identity();
        };
        // The pose of a kinematic body is the one that was set, even if the engine has not moved the body there yet.
        let ahead = self.state.moving.get(&body);
        convert::pose_back(&record.body_pose(ahead.map_or(self.world.bodies[record.handle].position(), |(_, to)| to)))
    }

    fn twist(&self, body: BodyId) -> Twist {
        let velocity = self.velocity(body);
        Twist { linear: convert::vector_back(velocity.linear), angular: convert::vector_back(velocity.angular) }
    }

    fn centre_of_mass(&self, body: BodyId) -> Point3<f64> {
        self.record(body).map_or(Point3::origin(), |r| {
            Point3::from(convert::vector_back(self.world.bodies[r.handle].center_of_mass()))
        })
    }

    fn joint_state(&self, joint: JointId) -> JointState {
        let Some(Some(record)) = self.state.joints.get(joint.0 as usize) else {
            return JointState::default();
        };
        let (frame_a, frame_b) = self.joint_frames(record);
        let Some(axis) = record.kind.free_axis() else {
            let turn = Pose::from_rotation(frame_a.rotation.inverse() * frame_b.rotation);
            return JointState { rotation: convert::pose_back(&turn).rotation, ..JointState::default() };
        };
        let along = frame_a.rotation * Vector::Z;
        let [a, b] = [record.bodies.0, record.bodies.1].map(|id| self.velocity(id));
        let velocity = match record.kind {
            JointKind::Revolute | JointKind::Screw(_) => (b.angular - a.angular).dot(along),
            // Both velocities are taken at the same point, which cancels a common rotation.
            _ => (b.at(frame_b.translation) - a.at(frame_b.translation)).dot(along),
        };
        let effort = match (record.drive, &record.held) {
            (JointDrive::Free, _) => 0.0,
            (_, JointBackend::Reduced(reduced)) if velocity != 0.0 => reduced.effort + record.folded.copysign(velocity),
            (_, JointBackend::Reduced(reduced)) => reduced.effort,
            (_, JointBackend::Tree(tied)) => tied.effort,
            // Rapier's impulses have the opposite sign: they slow the second body down.
            (_, JointBackend::Impulse(handle)) => {
                let joint = self.world.impulse_joints.get(*handle);
                -joint.map_or(0.0, |j| j.data.motors[axis as usize].impulse) / self.substep()
            }
        };
        let position = record.position(&frame_a, &frame_b);
        JointState { position, velocity, effort, ..JointState::default() }
    }

    fn contacts(&self, out: &mut Vec<BodyContact>) {
        report::contacts(&self.world, &self.state.touches, out);
    }

    fn quarantined(&mut self) -> Vec<BodyId> {
        std::mem::take(&mut self.state.frozen)
    }

    fn snapshot(&self) -> Vec<u8> {
        snapshot::write(&self.world, &self.state)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (mut world, tables) = snapshot::read(bytes)?;
        world.set_thread_pool(self.world.thread_pool());
        narrow::install(&mut world);
        (self.world, self.state) = (world, tables);
        Ok(())
    }
}
