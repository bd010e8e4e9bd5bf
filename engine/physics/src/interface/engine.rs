//! The trait of an engine, and its settings.

use nalgebra::{Isometry3, Point3, Vector3};
use serde::{Deserialize, Serialize};

use super::{
    bodies::{BodyDesc, BodyWrench, Twist},
    contacts::{BodyContact, ContactSurface, FrictionRule, MaterialPair, PairRule},
    ids::{BodyId, JointId},
    joints::{Gear, JointDesc, JointDrive, JointState, Wrench},
};

/// A function that is called before each physics step and supplies the forces that act in that step only. Its arguments
/// are the engine, the index of the step within the advance, and an empty list to fill.
pub type BeforeStepHook<'a> = dyn FnMut(&dyn Engine, u32, &mut Vec<BodyWrench>) + 'a;

/// Parameters of the engine, for the whole world.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EngineSettings {
    /// Gravity, m/s^2.
    pub gravity: Vector3<f64>,
    /// Length of a physics step, s, which is also the period of collision detection.
    pub step: f64,
    /// Number of sub-steps per physics step in which velocities are solved; at least 1.
    pub substeps: u32,
    /// Whether bodies that rest on something can sleep until they are touched.
    pub sleep: bool,
    /// The rule that combines the friction of two bodies. Applies to bodies that are added afterwards.
    pub friction_rule: FrictionRule,
    /// Natural frequency (Hz) and damping ratio of contacts; `None` means as stiff as the length of a sub-step permits.
    pub contact_spring: Option<[f64; 2]>,
}

impl Default for EngineSettings {
    /// Returns the settings of a scene that specifies none.
    fn default() -> Self {
        EngineSettings {
            gravity: Vector3::new(0.0, 0.0, -9.81),
            step: 0.005,
            substeps: 4,
            sleep: true,
            friction_rule: FrictionRule::Product,
            contact_spring: None,
        }
    }
}

/// A rigid-body engine.
pub trait Engine: Send + Sync {
    /// Replaces the engine's settings.
    fn configure(&mut self, settings: EngineSettings);
    /// Adds a body and returns its id.
    fn add_body(&mut self, desc: &BodyDesc) -> BodyId;
    /// Removes a body and the joints on it. An unknown id is ignored.
    fn remove_body(&mut self, body: BodyId);
    /// Adds a joint. Returns `None` if a body is unknown or both bodies are the same.
    fn add_joint(&mut self, desc: &JointDesc) -> Option<JointId>;
    /// Removes a joint. An unknown id is ignored.
    fn remove_joint(&mut self, joint: JointId);
    /// Sets the drive of a joint. This is cheap if nothing changes. A drive without force, or with a value that is not
    /// finite, is treated as [`JointDrive::Free`]; only limits may be infinite.
    fn drive(&mut self, joint: JointId, drive: JointDrive);
    /// Replaces all couplings of joints. The coupled joints must have been created with `geared`. A coupling of joints
    /// that are not in the same mechanism is ignored, as is one of joints in impulse form.
    fn set_gears(&mut self, gears: &[Gear]);
    /// Starts measuring the load of a joint, for [`Engine::wrench`].
    fn measure(&mut self, joint: JointId);
    /// Returns the load of a measured joint on the body that carries it: force, and torque about the joint's origin, in
    /// the world frame, averaged over the last step. The load is derived from the change of momentum of all bodies
    /// below the joint and from the forces on them, so it includes loads that a closed loop carries past the joint.
    /// Returns `None` before the first step.
    fn wrench(&self, joint: JointId) -> Option<Wrench>;
    /// Sets the contact properties of a body's surface, from the next step on.
    fn set_surface(&mut self, body: BodyId, surface: ContactSurface);
    /// Replaces the friction and restitution of all pairs of materials, from the next step on.
    fn set_materials(&mut self, pairs: &[MaterialPair]);
    /// Sets the rest position of a joint's spring, rad or m.
    fn set_rest(&mut self, joint: JointId, rest: f64);
    /// Sets the pose of a body. Dynamic bodies keep their velocities. Kinematic bodies move to the pose at constant
    /// velocity during the next [`Engine::advance`] and push bodies in their path; [`Engine::pose`] returns the new
    /// pose immediately.
    fn set_pose(&mut self, body: BodyId, pose: &Isometry3<f64>);
    /// Sets the velocities of a dynamic body.
    fn set_twist(&mut self, body: BodyId, twist: &Twist);
    /// Adds a force (N) and a torque (N m) in the world frame, at the centre of mass, for the next [`Engine::advance`].
    fn push(&mut self, body: BodyId, force: Vector3<f64>, torque: Vector3<f64>);
    /// Advances by a number of physics steps. Forces added beforehand act in all of them. Runs in the rayon pool of the
    /// calling thread (`pool.install`); results do not depend on the number of threads, bit for bit.
    fn advance(&mut self, steps: u32) {
        self.advance_with(steps, None);
    }
    /// Like `advance`, but calls `before`, if given, before each step.
    fn advance_with(&mut self, steps: u32, mut before: Option<&mut BeforeStepHook<'_>>) {
        for step in 0..steps {
            self.advance_part(step, steps, before.as_deref_mut());
        }
    }
    /// Runs the step with index `step`, from 0, of the `steps` steps of an advance. Running all of them in order gives
    /// the same result, bit for bit, as one [`Engine::advance_with`]. Between these calls, all state may be read, and
    /// drives and pairs may be changed.
    fn advance_part(&mut self, step: u32, steps: u32, before: Option<&mut BeforeStepHook<'_>>);
    /// Sets the contact parameters of a pair from the next step on, or removes them if `rule` is `None`.
    fn set_pair(&mut self, a: BodyId, b: BodyId, rule: Option<PairRule>);
    /// Returns the pose of a body in the world frame.
    fn pose(&self, body: BodyId) -> Isometry3<f64>;
    /// Returns the velocities of a body, which are zero for static bodies.
    fn twist(&self, body: BodyId) -> Twist;
    /// Returns the centre of mass of a body, world frame, m.
    fn centre_of_mass(&self, body: BodyId) -> Point3<f64>;
    /// Returns the state of a joint after the last step.
    fn joint_state(&self, joint: JointId) -> JointState;
    /// Collects the contacts after the last step, in order of body ids; `out` is cleared first.
    fn contacts(&self, out: &mut Vec<BodyContact>);
    /// Returns the bodies whose state has become NaN or infinite since the last call; they have been frozen.
    fn quarantined(&mut self) -> Vec<BodyId>;
    /// Returns the complete state as bytes, including shapes, for [`Engine::restore`]. Equal states give equal bytes.
    fn snapshot(&self) -> Vec<u8>;
    /// Restores a state, including bodies, joints, ids and settings; the following steps are equal bit for bit. If it
    /// fails (the bytes are damaged or from another version), nothing changes.
    fn restore(&mut self, bytes: &[u8]) -> Result<(), String>;
}
