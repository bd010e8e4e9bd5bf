//! The mapping between objects and the engine's bodies and joints: creates bodies and joints, advances the engine, and
//! copies its state back.
//!
//! - this module: advancing the engine; `state`: the engine, and the mapping;
//! - `body_sync`: creates bodies and joints from objects; `mass`: their mass and surface; `loops`: loops closed by
//!   linked dummies; `follow`: joints that follow others; `notices`: warnings about the scene;
//! - `targets`: drives of joints, and smooth position targets; `force_sensors`: measurements of force sensors;
//! - `pose_writeback`: copies the poses of bodies and the states of joints back to the objects.

mod body_sync;
mod follow;
mod force_sensors;
mod loops;
mod mass;
mod notices;
mod pose_writeback;
mod state;
mod targets;

use tatu_physics::{BeforeStepHook, BodyWrench, Engine, EngineSettings, Gear, JointDrive, MotionType, PairRule};

pub(crate) use follow::geared;
pub(crate) use loops::links;
pub use mass::mass_props;
pub use state::Dynamics;

use crate::{
    object::{Joint, Shape},
    tree::Scene,
};

/// Functions called before and after each engine step of an advance.
#[derive(Default)]
pub struct StepHooks<'a> {
    /// Called before each step; adds the pushes that act in the step.
    pub before: Option<&'a mut BeforeStepHook<'a>>,
    /// Called after each step, with the engine and the index of the step in the advance.
    pub after: Option<&'a mut AfterStep<'a>>,
}

/// A function called after each engine step, with the engine and the index of the step in the advance.
pub type AfterStep<'a> = dyn FnMut(&dyn Engine, u32) + 'a;

/// Speed above which a body is reported, m/s; hardly any part of a robot moves faster.
const STRAY_SPEED_M_S: f64 = 100.0;
/// Distance from its start beyond which a body is reported, m; hardly any part of a robot travels farther.
const STRAY_DISTANCE_M: f64 = 1000.0;

impl Dynamics {
    /// Marks that the drive of a joint or the surface of a shape has changed. The change is passed to the engine before
    /// the next step.
    pub fn mark_drive_changed(&mut self, slot: u32) {
        self.drives.push(slot);
    }

    /// Marks that the pose of an object was set from outside the engine. The bodies of the object and of its
    /// descendants are moved before the next step.
    pub fn mark_moved(&mut self, slot: u32) {
        // A script can set the same joint hundreds of times in a row.
        if self.moved.last() != Some(&slot) {
            self.moved.push(slot);
        }
    }

    fn apply_changes(&mut self, scene: &Scene) {
        for slot in std::mem::take(&mut self.moved) {
            for s in scene.subtree(slot) {
                let Some(o) = scene.get(s) else { continue };
                if let Some(id) = o.shape().and_then(|s| s.body.0) {
                    self.engine.set_pose(id, &scene.world(s));
                }
            }
        }
        self.apply_gears(scene);
        self.move_anchors(scene);
        for (id, slot) in &self.kinematic {
            if scene.get(*slot).is_some() {
                self.engine.set_pose(*id, &scene.world(*slot));
            }
        }
    }

    /// Passes all changes since the last step to the engine, which then agrees with the scene.
    pub fn prepare(&mut self, scene: &mut Scene) {
        self.update_bodies(scene);
        follow::update(scene, &self.couplings.followers, &mut self.drives);
        self.apply_changes(scene);
    }

    /// Passes all gears to the engine; cheap if nothing has changed.
    fn apply_gears(&mut self, scene: &Scene) {
        let gears = self.couplings.geared.iter().filter_map(|(slot, leader)| {
            let joint = scene.get(*slot)?.joint()?;
            let leader = scene.get(*leader)?.joint()?.id?;
            Some(Gear { joint: joint.id?, leader, ratio: joint.follow.factor, offset: joint.follow.offset })
        });
        let gears: Vec<Gear> = gears.collect();
        self.engine.set_gears(&gears);
    }

    /// Returns the number of engine steps of equal length that make up `dt` (s), none longer than the scene's physics
    /// step.
    pub fn engine_steps(&self, dt: f64) -> u32 {
        if dt > 0.0 { (dt / self.settings.step - 1e-9).ceil().max(1.0) as u32 } else { 0 }
    }

    /// Advances the engine by `dt` (s) in steps, then copies poses and joint states back to the scene. Returns the
    /// slots of objects whose bodies the engine has quarantined.
    pub fn advance(&mut self, scene: &mut Scene, dt: f64, mut hooks: StepHooks<'_>) -> Vec<u32> {
        follow::update(scene, &self.couplings.followers, &mut self.drives);
        self.apply_changes(scene);
        let steps = self.engine_steps(dt);
        if steps > 0 {
            self.set_step(dt / f64::from(steps));
            self.update_splines(scene, steps);
            for part in 0..steps {
                self.apply_drives(scene, part, steps);
                self.step_engine(part, steps, hooks.before.as_deref_mut());
                self.sample_force_sensors(scene);
                if let Some(after) = &mut hooks.after {
                    after(&*self.engine, part);
                }
            }
        }
        self.finish_advance(scene)
    }

    /// Runs the engine step with index `part`, from 0, of the steps that make up `dt` (s). The results are bit for bit
    /// those of [`Dynamics::advance`]. Poses that are set between the steps take effect in the first step of the next
    /// advance.
    pub fn advance_part(&mut self, scene: &mut Scene, dt: f64, part: u32, hooks: StepHooks<'_>) -> Vec<u32> {
        let steps = self.engine_steps(dt);
        if part == 0 {
            self.apply_changes(scene);
            self.set_step(dt / f64::from(steps.max(1)));
            self.update_splines(scene, steps);
        }
        if part < steps {
            self.apply_drives(scene, part, steps);
            self.step_engine(part, steps, hooks.before);
            self.sample_force_sensors(scene);
            if let Some(after) = hooks.after {
                after(&*self.engine, part);
            }
        }
        self.finish_advance(scene)
    }

    fn step_engine(&mut self, part: u32, steps: u32, before: Option<&mut BeforeStepHook<'_>>) {
        if self.pushes.is_empty() {
            return self.engine.advance_part(part, steps, before);
        }
        let (mut pushes, mut before) = (std::mem::take(&mut self.pushes), before);
        let mut ask = |engine: &dyn Engine, step, out: &mut Vec<BodyWrench>| {
            out.append(&mut pushes);
            if let Some(before) = before.as_deref_mut() {
                let mut more = Vec::new();
                before(engine, step, &mut more);
                out.append(&mut more);
            }
        };
        self.engine.advance_part(part, steps, Some(&mut ask));
    }

    /// Sets whether scripts are called between the engine steps of an advance, in which case each force that they apply
    /// acts in a single step.
    pub fn set_scripts_between_steps(&mut self, between: bool) {
        self.scripts_between_steps = between;
    }

    /// Sets the length of an engine step, s, which is chosen for an advance to cover exactly the requested time.
    fn set_step(&mut self, step: f64) {
        if (step - self.step).abs() > 1e-12 {
            self.step = step;
            self.engine.configure(EngineSettings { step, ..self.settings });
        }
    }

    fn finish_advance(&mut self, scene: &mut Scene) -> Vec<u32> {
        let lost = self.engine.quarantined();
        self.copy_back(scene);
        self.sum_efforts(scene);
        lost.iter().filter_map(|b| self.object_of(*b)).collect()
    }

    /// Sets the contact parameters of two shapes from the next engine step on; `None` restores the default.
    pub fn set_pair(&mut self, a: &Shape, b: &Shape, rule: Option<PairRule>) {
        if let (Some(a), Some(b)) = (a.body.0, b.body.0) {
            self.engine.set_pair(a, b, rule);
        }
    }

    /// Overrides the drive of a joint for the next engine step.
    pub fn drive(&mut self, joint: &Joint, drive: JointDrive) {
        if let Some(id) = joint.id {
            self.engine.drive(id, drive);
        }
    }

    /// Returns warnings about the scene that have not been returned before.
    pub fn take_notices(&mut self) -> Vec<String> {
        self.notices.take_pending()
    }

    /// Returns the dynamic bodies that are faster than 100 m/s or farther than 1 km from their initial positions, as
    /// slot, speed (m/s) and distance (m). Each body is returned only once.
    pub fn strays(&mut self, scene: &Scene) -> Vec<(u32, f64, f64)> {
        let mut found = Vec::new();
        for b in self.bodies.iter_mut().filter(|b| b.motion == MotionType::Dynamic && !b.stray) {
            let way = (scene.world(b.slot).translation.vector - b.start).norm();
            let speed = self.engine.twist(b.id).linear.norm();
            if way > STRAY_DISTANCE_M || speed > STRAY_SPEED_M_S {
                b.stray = true;
                found.push((b.slot, speed, way));
            }
        }
        found
    }
}
