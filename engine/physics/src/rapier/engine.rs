//! [`Engine`] implemented with rapier3d, in f64.

use nalgebra::{Isometry3, Point3, Vector3};

use super::{
    bodies::ShapeCache,
    contacts::{faces, report},
    state::{EngineState, snapshot},
};
use crate::{
    BeforeStepHook, BodyContact, BodyDesc, BodyId, ContactSurface, Engine, EngineSettings, Gear, JointDesc, JointDrive,
    JointId, JointState, MaterialPair, PairRule, Twist, Wrench,
};

/// A world of rigid bodies, simulated by rapier3d.
///
/// ```
/// use tatu_physics::{Engine, EngineSettings, Rapier};
///
/// let mut engine = Rapier::new(EngineSettings { step: 0.01, ..EngineSettings::default() });
/// engine.advance(5);
/// ```
pub struct Rapier {
    pub(super) state: EngineState,
    pub(super) shapes: ShapeCache,
}

impl Rapier {
    /// Creates a world without bodies.
    pub fn new(settings: EngineSettings) -> Self {
        let mut engine = Self { state: EngineState::new(), shapes: ShapeCache::default() };
        faces::install(&mut engine.state.bodies.world);
        engine.configure(settings);
        engine
    }
}

impl Engine for Rapier {
    fn configure(&mut self, settings: EngineSettings) {
        self.state.bodies.configure(&settings);
        self.state.contacts.friction_rule = settings.friction_rule;
        self.state.forms.reduced.springs_changed = true;
    }

    fn add_body(&mut self, desc: &BodyDesc) -> BodyId {
        self.state.add_body(&mut self.shapes, desc)
    }

    fn remove_body(&mut self, body: BodyId) {
        self.state.remove_body(body);
    }

    fn add_joint(&mut self, desc: &JointDesc) -> Option<JointId> {
        self.state.add_joint(desc)
    }

    fn remove_joint(&mut self, joint: JointId) {
        self.state.remove_joint(joint);
    }

    fn drive(&mut self, joint: JointId, drive: JointDrive) {
        self.state.joints.set_drive(&mut self.state.bodies, joint, drive);
    }

    fn set_gears(&mut self, gears: &[Gear]) {
        self.state.forms.reduced.set_gears(&mut self.state.joints, gears);
        self.state.forms.trees.set_gears(gears);
    }

    fn measure(&mut self, joint: JointId) {
        self.state.joints.measure(&mut self.state.bodies, joint);
    }

    fn wrench(&self, joint: JointId) -> Option<Wrench> {
        self.state.joints.measured.iter().find(|m| m.joint == joint)?.wrench
    }

    fn set_surface(&mut self, body: BodyId, surface: ContactSurface) {
        self.state.contacts.set_surface(&mut self.state.bodies, body, surface);
    }

    fn set_materials(&mut self, pairs: &[MaterialPair]) {
        self.state.contacts.materials = pairs.to_vec();
    }

    fn set_rest(&mut self, joint: JointId, rest: f64) {
        let EngineState { bodies, joints, forms, .. } = &mut self.state;
        forms.set_rest(bodies, joints, joint, rest);
    }

    fn set_pose(&mut self, body: BodyId, pose: &Isometry3<f64>) {
        self.state.set_pose(body, pose);
    }

    fn set_twist(&mut self, body: BodyId, twist: &Twist) {
        self.state.bodies.set_twist(body, twist);
    }

    fn push(&mut self, body: BodyId, force: Vector3<f64>, torque: Vector3<f64>) {
        self.state.bodies.push(body, force, torque);
    }

    fn advance_part(&mut self, step: u32, steps: u32, before: Option<&mut BeforeStepHook<'_>>) {
        self.run_step(step, steps, before);
    }

    fn set_pair(&mut self, a: BodyId, b: BodyId, rule: Option<PairRule>) {
        self.state.contacts.set_pair(&mut self.state.bodies, a, b, rule);
    }

    fn pose(&self, body: BodyId) -> Isometry3<f64> {
        self.state.bodies.pose(body)
    }

    fn twist(&self, body: BodyId) -> Twist {
        self.state.bodies.twist(body)
    }

    fn centre_of_mass(&self, body: BodyId) -> Point3<f64> {
        self.state.bodies.centre_of_mass(body)
    }

    fn joint_state(&self, joint: JointId) -> JointState {
        self.state.joints.get(joint).map_or_else(JointState::default, |r| r.state(&self.state.bodies))
    }

    fn contacts(&self, out: &mut Vec<BodyContact>) {
        report::contacts(&self.state.bodies, &self.state.forms.trees.touches, out);
    }

    fn quarantined(&mut self) -> Vec<BodyId> {
        std::mem::take(&mut self.state.bodies.frozen)
    }

    fn snapshot(&self) -> Vec<u8> {
        snapshot::write(&self.state)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        let mut state = snapshot::read(bytes)?;
        state.bodies.world.set_thread_pool(self.state.bodies.world.thread_pool());
        faces::install(&mut state.bodies.world);
        self.state = state;
        Ok(())
    }
}
