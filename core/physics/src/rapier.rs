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
//! joints in reduced coordinates, `gears` couples joints, `load` computes their loads, `respond` decides which bodies
//! collide, `grip` implements anisotropic and rolling friction, `overlap` separates bodies that were created
//! overlapping, `narrow` finds contacts of hulls and meshes, `curved` lets cylinders roll, `report` reads contacts,
//! `velocity` computes velocities, `spin` integrates gyroscopic motion, `trees` solves mechanisms without rapier,
//! `sleep` decides which bodies can sleep, `turns` counts whole turns, `push` applies forces for a single step, and
//! `snapshot` saves and restores the state.

mod bodies;
mod curved;
mod drives;
mod gears;
mod grip;
mod joints;
mod load;
mod narrow;
mod overlap;
mod park;
mod push;
mod records;
mod reduced;
mod report;
mod respond;
mod shapes;
mod sleep;
mod snapshot;
mod spin;
mod state;
#[cfg(test)]
mod tests;
mod trees;
mod tuning;
mod turns;
mod velocity;

use nalgebra::{Isometry3, Point3, Vector3};
use rapier3d::{
    dynamics::{IntegrationParameters, SpringCoefficients},
    math::{Pose, Vector},
    pipeline::PhysicsWorld,
};
use records::{Held, JointRecord, Measured, Memory, Rest, Tied};
use respond::PairFilter;
use shapes::ShapeCache;
pub use state::Rapier;
use state::{Tables, finite, mark};
pub use tuning::SETTLE_TIME;
use tuning::{CONTACT_SHARE, CONTACT_SOFTNESS, STATIC_CONTACT_SOFTNESS, UNEVEN};

use super::{
    BeforeStep, BodyDesc, BodyId, Contact, Drive, Engine, EngineSettings, Gear, JointDesc, JointForm, JointId,
    JointKind, JointState, MaterialPair, Motion, PairRule, Surface, Twist, Wrench, convert,
};

impl Rapier {
    /// Creates a world without bodies.
    pub fn new(settings: EngineSettings) -> Self {
        let world =
            PhysicsWorld { integration_parameters: IntegrationParameters::default(), ..PhysicsWorld::default() };
        let mut engine = Self { world, tables: Tables::default(), shapes: ShapeCache::default() };
        narrow::install(&mut engine.world);
        engine.configure(settings);
        engine
    }

    /// Moves kinematic bodies at constant velocity along their paths. They thus push other bodies with the velocity of
    /// their motion. `done` is the fraction of the advance that is complete after this step.
    fn move_kinematic(&mut self, done: f64) {
        for (id, (from, to)) in &self.tables.moving {
            let Some(record) = &self.tables.bodies[id.0 as usize] else {
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
    fn met(&self, a: BodyId, b: BodyId) -> Option<f64> {
        let rule = self.tables.pairs.get(&(a.min(b), a.max(b))).and_then(|r| r.friction);
        let material = |id| self.tables.surfaces.get(&id).map_or(0, |s| s.material);
        rule.or_else(|| respond::of_materials(&self.tables.materials, material(a), material(b)).map(|p| p.friction))
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
        self.tables.substeps = settings.substeps.max(1) as usize;
        self.tables.springs_changed = true;
        self.world.integration_parameters.num_solver_iterations = self.tables.substeps;
        // Contacts that are too stiff for the sub-step make stacks rock.
        let rate = 1.0 / self.substep();
        let spring = |usual: (f64, f64), share| {
            let (frequency, damping) = settings.contact_spring.map_or(usual, |[f, d]| (f, d));
            SpringCoefficients::new(frequency.min(share * rate), damping)
        };
        self.world.integration_parameters.contact_softness = spring(CONTACT_SOFTNESS, CONTACT_SHARE);
        self.world.integration_parameters.static_contact_softness =
            spring(STATIC_CONTACT_SOFTNESS, 2.0 * CONTACT_SHARE);
        self.tables.friction_rule = settings.friction_rule;
        if self.tables.sleep != settings.sleep {
            self.tables.sleep = settings.sleep;
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
        self.give_back(desc.a);
        self.give_back(desc.b);
        let zero = turns::zero(desc);
        let frame_a = a.local_pose(&desc.frame_in_a);
        let frames = (turns::turned(frame_a, zero), b.local_pose(&desc.frame_in_b));
        let (mass_a, mass_b) = (self.world.bodies[a.handle].mass(), self.world.bodies[b.handle].mass());
        let crowd = self.crowd_of(desc);
        let reduced = crowd.is_some() || matches!(desc.kind, JointKind::Screw(_));
        let form = if reduced { JointForm::Reduced } else { desc.form };
        let reduced = match form {
            JointForm::Reduced => self.add_reduced(desc, joints::build(desc, frames, zero)),
            JointForm::Tree | JointForm::Impulse | JointForm::Loop => None,
        };
        let tree = form == JointForm::Tree && self.may_join_tree(desc);
        let uneven = reduced.is_none() && !tree && mass_a.max(mass_b) > UNEVEN * mass_a.min(mass_b);
        self.prepare_for_joint(desc.a, uneven);
        self.prepare_for_joint(desc.b, uneven);
        let held = reduced.map_or_else(
            || {
                if tree {
                    return Held::Tree(Tied::default());
                }
                // If the joint was to be in reduced form or in a tree but cannot be, it closes a loop.
                let form = if desc.form == JointForm::Impulse { JointForm::Impulse } else { JointForm::Loop };
                let desc = JointDesc { form, ..desc.clone() };
                Held::Impulse(self.world.insert_impulse_joint(a.handle, b.handle, joints::build(&desc, frames, zero)))
            },
            Held::Reduced,
        );
        let id = JointId(self.tables.joints.len() as u32);
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
            drive: Drive::Free,
            pursuit: 0.0,
            rest: Rest::default(),
            memory: Memory::default(),
            speed: 0.0,
            at_limit: false,
            folded: 0.0,
            changed: false,
        };
        self.tables.joints_changed = true;
        if tree {
            self.tables.mechanisms_changed = true;
            self.take_body(desc.a);
            self.take_body(desc.b);
        }
        if turns::is_wide(&record) {
            self.tables.winding.push(id);
        }
        if desc.passive.no_load_speed > 0.0 {
            self.tables.weakening.push(id);
        }
        if reduced.is_none() && !tree && desc.passive.damping > 0.0 {
            mark(&mut self.tables.changed, id, &mut record);
        }
        self.tables.joints.push(Some(record));
        if let Some(crowd) = crowd {
            self.grow_crowd(crowd, id, desc.b);
        }
        Some(id)
    }

    fn remove_joint(&mut self, joint: JointId) {
        let Some(record) = self.tables.joints.get_mut(joint.0 as usize).and_then(Option::take) else {
            return;
        };
        self.tables.joints_changed = true;
        self.tables.weakening.retain(|j| *j != joint);
        self.tables.winding.retain(|j| *j != joint);
        match record.held {
            Held::Impulse(handle) => drop(self.world.remove_impulse_joint(handle)),
            Held::Reduced(reduced) => self.remove_reduced(&record, reduced),
            Held::Tree(_) => {
                self.tables.mechanisms_changed = true;
                self.return_body(record.bodies.0);
                self.return_body(record.bodies.1);
            }
        }
        self.free_from_joint(record.bodies.0);
        self.free_from_joint(record.bodies.1);
    }

    fn drive(&mut self, joint: JointId, drive: Drive) {
        let drive = joints::sane(drive);
        let Some(Some(record)) = self.tables.joints.get_mut(joint.0 as usize) else {
            return;
        };
        if record.drive == drive {
            return;
        }
        let is_position = |d: Drive| matches!(d, Drive::Position { .. });
        if is_position(drive) && !is_position(record.drive) && !self.tables.positioned.contains(&joint) {
            self.tables.positioned.push(joint);
        }
        record.drive = drive;
        record.rest = Rest::default();
        let (stops, body) = (record.stops(), record.bodies.1);
        mark(&mut self.tables.changed, joint, record);
        if stops {
            self.watch_stop(joint);
        }
        self.unpark(body);
    }

    fn set_gears(&mut self, gears: &[Gear]) {
        if self.tables.gears != gears {
            self.tables.gears = gears.to_vec();
            self.tables.joints_changed = true;
        }
    }

    fn measure(&mut self, joint: JointId) {
        if !self.tables.measured.iter().any(|m| m.joint == joint) {
            self.tables.measured.push(Measured::new(joint));
            if let Some(body) = self.tables.joints.get(joint.0 as usize).and_then(|r| Some(r.as_ref()?.bodies.1)) {
                self.unpark(body);
            }
        }
    }

    fn wrench(&self, joint: JointId) -> Option<Wrench> {
        self.tables.measured.iter().find(|m| m.joint == joint)?.wrench
    }

    fn set_surface(&mut self, body: BodyId, surface: Surface) {
        if self.record(body).is_none() || !bodies::sound_surface(&surface) {
            return;
        }
        if surface == Surface::default() {
            self.tables.surfaces.remove(&body);
        } else if self.tables.surfaces.insert(body, surface) != Some(surface) {
            self.watch_pairs(body);
            // Bodies that rest on a belt must wake when it starts.
            let handle = self.record(body).map(|r| r.handle);
            handle.into_iter().for_each(|h| self.wake_touching(h));
        }
    }

    fn set_materials(&mut self, pairs: &[MaterialPair]) {
        self.tables.materials = pairs.to_vec();
    }

    fn set_rest(&mut self, joint: JointId, rest: f64) {
        if let Some(Some(record)) = self.tables.joints.get_mut(joint.0 as usize)
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
        self.place(body, pose);
    }

    fn set_twist(&mut self, body: BodyId, twist: &Twist) {
        let Some((handle, Motion::Dynamic)) = self.record(body).map(|r| (r.handle, r.motion)) else {
            return;
        };
        if !finite(&twist.linear) || !finite(&twist.angular) {
            return self.freeze(body);
        }
        let moved = &mut self.world.bodies[handle];
        moved.set_linvel(convert::vector(&twist.linear), true);
        moved.set_angvel(convert::vector(&twist.angular), true);
        self.tables.moved.push(body);
        self.forget_velocity(body);
    }

    fn push(&mut self, body: BodyId, force: Vector3<f64>, torque: Vector3<f64>) {
        let Some((handle, Motion::Dynamic)) = self.record(body).map(|r| (r.handle, r.motion)) else {
            return;
        };
        if !finite(&force) || !finite(&torque) {
            return self.freeze(body);
        }
        if self.record(body).is_some_and(|r| r.in_tree) {
            let sum = self.tables.loads.entry(body).or_default();
            (sum.force, sum.torque) = (sum.force + force, sum.torque + torque);
            return;
        }
        let pushed = &mut self.world.bodies[handle];
        pushed.add_force(convert::vector(&force), true);
        pushed.add_torque(convert::vector(&torque), true);
        self.tables.pushed.push(body);
    }

    fn advance_part(&mut self, part: u32, parts: u32, before: Option<&mut BeforeStep<'_>>) {
        self.move_kinematic(f64::from(part + 1) / f64::from(parts));
        self.adopt();
        self.arrange_trees();
        self.find_coordinates();
        if self.tables.springs_changed {
            self.set_springs();
        }
        self.count_turns();
        self.update_positions();
        self.park();
        self.weaken_drives();
        self.apply_drives();
        let old = match before {
            Some(ask) => {
                let mut pushes = Vec::new();
                ask(&*self, part, &mut pushes);
                self.push_for_a_step(&pushes)
            }
            None => Vec::new(),
        };
        let carried = self.carry_drives();
        let spun = self.spin(0.5);
        self.see_velocities();
        self.choose_substeps();
        self.find_overlaps();
        self.weigh();
        self.couple();
        self.grip();
        let deepest = self.parting_depths();
        let Tables { pairs, surfaces, materials, partings, .. } = &self.tables;
        let (gravity, step, substep) = (self.world.gravity, self.world.integration_parameters.dt, self.substep());
        let filter = PairFilter { pairs, surfaces, materials, partings, deepest, gravity, step, substep };
        self.world.step_with_events(&filter, &());
        self.follow_overlaps();
        self.step_trees();
        self.measure_loads();
        self.spin_on(spun);
        self.take_back(carried);
        self.take_back(old);
        self.note_drives();
        self.collect_frozen();
        if part + 1 < parts {
            return;
        }
        self.keep_awake();
        self.tables.loads.clear();
        self.tables.moving.clear();
        let mut pushed = std::mem::take(&mut self.tables.pushed);
        for id in pushed.drain(..) {
            let Some(handle) = self.record(id).map(|r| r.handle) else {
                continue;
            };
            let body = &mut self.world.bodies[handle];
            body.reset_forces(false);
            body.reset_torques(false);
        }
        self.tables.pushed = pushed;
    }

    fn set_pair(&mut self, a: BodyId, b: BodyId, rule: Option<PairRule>) {
        let pair = (a.min(b), a.max(b));
        match rule {
            None => drop(self.tables.pairs.remove(&pair)),
            Some(rule) => {
                self.tables.pairs.insert(pair, rule);
                // The filter must be enabled for bodies with a rule.
                for body in [a, b] {
                    self.watch_pairs(body);
                }
            }
        }
    }

    fn pose(&self, body: BodyId) -> Isometry3<f64> {
        let Some(record) = self.record(body) else {
            return Isometry3::identity();
        };
        // The pose of a kinematic body is the one that was set, even if the engine has not moved the body there yet.
        let ahead = self.tables.moving.get(&body);
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
        let Some(Some(record)) = self.tables.joints.get(joint.0 as usize) else {
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
            (Drive::Free, _) => 0.0,
            (_, Held::Reduced(reduced)) if velocity != 0.0 => reduced.effort + record.folded.copysign(velocity),
            (_, Held::Reduced(reduced)) => reduced.effort,
            (_, Held::Tree(tied)) => tied.effort,
            // Rapier's impulses have the opposite sign: they slow the second body down.
            (_, Held::Impulse(handle)) => {
                let joint = self.world.impulse_joints.get(*handle);
                -joint.map_or(0.0, |j| j.data.motors[axis as usize].impulse) / self.substep()
            }
        };
        let position = record.position(&frame_a, &frame_b);
        JointState { position, velocity, effort, ..JointState::default() }
    }

    fn contacts(&self, out: &mut Vec<Contact>) {
        report::contacts(&self.world, &self.tables.touches, out);
    }

    fn quarantined(&mut self) -> Vec<BodyId> {
        std::mem::take(&mut self.tables.frozen)
    }

    fn snapshot(&self) -> Vec<u8> {
        snapshot::write(&self.world, &self.tables)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (mut world, tables) = snapshot::read(bytes)?;
        world.set_thread_pool(self.world.thread_pool());
        narrow::install(&mut world);
        (self.world, self.tables) = (world, tables);
        Ok(())
    }
}
