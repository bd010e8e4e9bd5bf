//! The physics engine behind a trait. Only values cross this interface (SI units, f64, world frame unless stated
//! otherwise). A different engine could therefore replace `rapier` without changes to scenes, hashes or scripts. The
//! scene's dynamics decide which objects become bodies and joints. Ids are dense, start at 0 and are assigned in order
//! of creation; an engine never reuses the id of a removed body or joint.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "expected values in tests do not affect results"))]

mod closest;
pub(crate) mod convert;
mod rapier;

use nalgebra::{Isometry3, Matrix3, Point3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

pub use closest::closest;
pub use convert::hull;
pub use rapier::{Rapier, SETTLE_TIME};
use tatu_geometry::SolidPart;

/// The id of a body, from 0, in order of creation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct BodyId(pub u32);

/// The id of a joint, from 0, in order of creation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct JointId(pub u32);

/// How a body moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum MotionType {
    /// The body never moves; other bodies collide with it.
    Static,
    /// The body follows the poses set by [`Engine::set_pose`] and pushes dynamic bodies.
    Kinematic,
    /// The body is moved by forces.
    Dynamic,
}

/// Mass properties of a dynamic body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProps {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in the body's frame, m.
    pub com: Point3<f64>,
    /// Inertia about the centre of mass along the body's axes, kg m^2.
    pub inertia: Matrix3<f64>,
}

/// Collision masks as in V-REP: two bodies of the same `tree` collide if their low bytes share a bit, other pairs if
/// their high bytes do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct CollisionMask {
    /// The low byte applies within the tree, the high byte to all other bodies. With a mask of 0, the body does not
    /// collide.
    pub mask: u16,
    /// Id of the tree of objects that the body belongs to, such as a robot.
    pub tree: u32,
}

/// Description of a body to create.
#[derive(Debug, Clone)]
pub struct BodyDesc {
    /// Pose of the body in the world frame.
    pub pose: Isometry3<f64>,
    /// How the body moves.
    pub motion: MotionType,
    /// Mass properties; used for dynamic bodies.
    pub mass: MassProps,
    /// Velocity of the centre of mass, world frame, m/s.
    pub linear_velocity: Vector3<f64>,
    /// Angular velocity, world frame, rad/s.
    pub angular_velocity: Vector3<f64>,
    /// Collision forms, in the body's frame; may be empty.
    pub parts: Vec<SolidPart>,
    /// Coulomb friction coefficient. [`EngineSettings::friction_rule`] combines the coefficients of a pair.
    pub friction: f64,
    /// Coefficient of restitution, from 0 (no bounce) to 1 (a bounce to the same height). The restitution of a pair is
    /// the product of both coefficients, as in Bullet.
    pub restitution: f64,
    /// Mask that determines with which bodies the body collides.
    pub collision_mask: CollisionMask,
    /// Whether continuous collision detection includes collisions with other moving bodies.
    pub bullet: bool,
    /// Linear and angular damping, 1/s.
    pub damping: [f64; 2],
    /// Further contact properties of the body's surface.
    pub surface: ContactSurface,
}

/// Contact properties of a surface besides friction and restitution. By default, none has an effect.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ContactSurface {
    /// Velocity of the surface relative to the body, as of a conveyor belt, in the body's frame, m/s.
    pub velocity: Vector3<f64>,
    /// Axis in the body's frame along which a separate friction coefficient applies, as for rollers and skates.
    pub axis: Option<Vector3<f64>>,
    /// Rotation of that axis about the contact normal, which points out of the body, rad. If the axis is the axle of a
    /// wheel, this is the angle of the rollers on its rim, at any point of contact.
    pub axis_angle: f64,
    /// Friction coefficient of a pair along that axis.
    pub axis_friction: f64,
    /// Torque against rolling per N of normal force, m. The greater value of a pair applies.
    pub rolling_friction: f64,
    /// Torque against spinning about the normal per N of normal force, m. The greater value of a pair applies.
    pub spinning_friction: f64,
    /// Id of the material, as used by [`Engine::set_materials`]; 0 means no material.
    pub material: u32,
}

impl ContactSurface {
    /// Returns whether the surface has friction that depends on direction, or resists rolling or spinning.
    pub fn is_special(&self) -> bool {
        self.axis.is_some() || self.rolling_friction > 0.0 || self.spinning_friction > 0.0
    }
}

/// Friction and restitution of a pair of materials; they override those of the bodies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MaterialPair {
    /// Ids of the two materials, in any order.
    pub materials: (u32, u32),
    /// Coulomb friction coefficient.
    pub friction: f64,
    /// Restitution, 0 to 1; `None` means that it is computed from the bodies.
    pub restitution: Option<f64>,
}

/// The rule that combines the friction of two bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum FrictionRule {
    /// Product: the rule of Bullet, and thus of V-REP.
    #[default]
    Product,
    /// Arithmetic mean.
    Mean,
    /// Minimum.
    Least,
    /// Maximum: MuJoCo's rule.
    Greatest,
}

impl FrictionRule {
    /// Returns the friction of a pair.
    pub fn of(self, a: f64, b: f64) -> f64 {
        match self {
            FrictionRule::Product => a * b,
            FrictionRule::Mean => (a + b) / 2.0,
            FrictionRule::Least => a.min(b),
            FrictionRule::Greatest => a.max(b),
        }
    }
}

/// The degrees of freedom of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum JointKind {
    /// Rotation about the z axis of the joint frame.
    Revolute,
    /// Translation along the z axis of the joint frame.
    Prismatic,
    /// Rotation about z with a translation along z of this many metres per radian, like a nut on a thread. A screw is
    /// always solved in reduced form.
    Screw(f64),
    /// Rotation about any axis. The joint has no position and cannot be driven.
    Spherical,
    /// No degree of freedom: the bodies are rigidly connected.
    Fixed,
}

/// Description of a joint to create, between body `a` (parent) and body `b` (child).
#[derive(Debug, Clone)]
pub struct JointDesc {
    /// The body that carries the joint.
    pub a: BodyId,
    /// The body that the joint moves.
    pub b: BodyId,
    /// Pose of the joint frame in body `a`.
    pub frame_in_a: Isometry3<f64>,
    /// Pose of the joint frame in body `b` at position 0.
    pub frame_in_b: Isometry3<f64>,
    /// The joint's degrees of freedom.
    pub kind: JointKind,
    /// Lowest and highest position, rad or m; `None` means no limits.
    pub limits: Option<(f64, f64)>,
    /// Position at creation, rad or m. It is used only for revolute joints with limits, where it determines the number
    /// of whole turns.
    pub position: f64,
    /// How the joint is enforced.
    pub form: JointForm,
    /// Passive forces of the joint.
    pub passive: PassiveForces,
    /// Whether [`Engine::set_gears`] may couple the joint to another one, as follower or leader.
    pub geared: bool,
}

/// A coupling of two joints of one mechanism: `position = ratio * leader's position + offset`. Forces act in both
/// directions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gear {
    /// The joint that follows.
    pub joint: JointId,
    /// The joint that `joint` follows.
    pub leader: JointId,
    /// Change of the joint's position per unit of the leader's position.
    pub ratio: f64,
    /// Position of the joint when the leader is at 0, rad or m.
    pub offset: f64,
}

/// How a joint is enforced. All joints of a mechanism have the same form, except those that close loops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum JointForm {
    /// Reduced coordinates: only the degrees of freedom of the joint are computed, so its bodies cannot separate. This
    /// form is exact at any load, at a cost that grows with the cube of the number of joints of a mechanism.
    #[default]
    Reduced,
    /// Impulses pull the bodies of the joint together: cheap, but soft under load.
    Impulse,
    /// The links of a tree, solved by `tatu_mechanisms` outside rapier: as exact as [`JointForm::Reduced`], at a cost
    /// that grows with the number of joints times their depth. Not available for screws, gears and loops.
    Tree,
    /// Impulses close a loop between bodies that other joints, of any form, already connect.
    Loop,
}

/// Passive forces of a joint, besides its drive. All are 0 by default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PassiveForces {
    /// Damping, N m s/rad or N s/m.
    pub damping: f64,
    /// Dry friction, N m or N. Not supported in impulse form.
    pub friction: f64,
    /// Inertia of a rotor behind a gearbox, reflected to the joint, kg m^2 or kg. Not supported in impulse form.
    pub armature: f64,
    /// Stiffness of a spring towards `rest`, N m/rad or N/m. Not supported in impulse form.
    pub stiffness: f64,
    /// Rest position of the spring, rad or m.
    pub rest: f64,
    /// Speed at which the drive has no effort left, rad/s or m/s: its limit falls linearly from `max_force` at rest to
    /// 0 at this speed, as for a DC motor. 0 means that the limit does not depend on speed.
    pub no_load_speed: f64,
}

/// Controller of a position drive. The velocity that it commands is
/// `p * error + i * (integral of error) + d * (derivative of error) + velocity`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PositionController {
    /// Proportional gain, 1/s.
    pub p: f64,
    /// Integral gain, 1/s^2.
    pub i: f64,
    /// Derivative gain, dimensionless.
    pub d: f64,
    /// Velocity of the target, rad/s or m/s.
    pub velocity: f64,
}

/// The drive of a joint. Torques are in N m, forces in N, and velocities in rad/s or m/s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum JointDrive {
    /// No drive: the joint is passive.
    Free,
    /// Reaches velocity `target` with at most `max_force`.
    Velocity {
        /// Target velocity, rad/s or m/s.
        target: f64,
        /// Maximum torque, N m, or force, N.
        max_force: f64,
        /// Speed lost per unit of load, rad/s per N m or m/s per N; 0 means no slip.
        slip: f64,
    },
    /// Holds position `target` with at most `max_force`, moving there with at most `max_velocity`.
    Position {
        /// Target position, rad or m.
        target: f64,
        /// Maximum torque, N m, or force, N.
        max_force: f64,
        /// Maximum velocity, rad/s or m/s.
        max_velocity: f64,
        /// Controller; `None` means that the error decays to 1/e of its value in 0.05 s, without overshoot.
        tracking: Option<PositionController>,
    },
    /// Exerts a constant torque, N m, or force, N.
    Force(f64),
}

/// Velocity of a body in the world frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Twist {
    /// Velocity of the centre of mass, m/s.
    pub linear: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub angular: Vector3<f64>,
}

/// The state of a joint after the last step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointState {
    /// Position, rad or m. For revolute joints, it is in (-pi, pi] without limits, and includes whole turns with
    /// limits.
    pub position: f64,
    /// For a spherical joint: rotation of the frame on body `b` relative to that on body `a`.
    pub rotation: UnitQuaternion<f64>,
    /// Velocity, rad/s or m/s.
    pub velocity: f64,
    /// Torque or force that the drive exerted in the last step, N m or N.
    pub effort: f64,
}

/// A contact of two bodies on one face. Bodies with several parts or with corners can have several contacts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BodyContact {
    /// The bodies, lower id first.
    pub bodies: (BodyId, BodyId),
    /// Point of contact in the world frame, m.
    pub point: Point3<f64>,
    /// Unit vector from the first body to the second.
    pub normal: Vector3<f64>,
    /// Normal force on the second body, N, averaged over the last step.
    pub force: f64,
    /// Friction on the second body, world frame, N, averaged over the last step.
    pub friction: Vector3<f64>,
}

/// A force, and a torque about a point.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Wrench {
    /// Force, N.
    pub force: Vector3<f64>,
    /// Torque, N m.
    pub torque: Vector3<f64>,
}

/// Contact parameters of a pair of bodies, which override those of the bodies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PairRule {
    /// Whether the two bodies collide.
    pub responds: bool,
    /// Coulomb friction coefficient; `None` means that of the materials or bodies.
    pub friction: Option<f64>,
    /// Restitution; `None` means that of the materials or bodies.
    pub restitution: Option<f64>,
}

/// A force and a torque on a body in the world frame, at its centre of mass.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BodyWrench {
    /// The body on which the force and the torque act.
    pub body: BodyId,
    /// Force, N.
    pub force: Vector3<f64>,
    /// Torque, N m.
    pub torque: Vector3<f64>,
}

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
    /// that are not in the same mechanism in reduced form is ignored.
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
