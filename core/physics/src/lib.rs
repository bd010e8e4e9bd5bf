//! The physics engine behind one trait.
//!
//! Only values cross this interface (SI units, f64, world frame unless stated otherwise), so that another engine can
//! replace `rapier` without a change in scene, hash or scripts. Which scene objects become bodies and
//! joints is decided by the dynamics rule of the scene, not here. Ids are dense, start at 0 and are given in order
//! of creation; the id of a removed one is never reused by the same engine.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "what tests compare with decides no bits"))]

mod closest;
pub(crate) mod convert;
mod rapier;

use nalgebra::{Isometry3, Matrix3, Point3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

pub use closest::closest;
pub use rapier::Rapier;
use tatu_geometry::Part;

/// The id of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct BodyId(pub u32);

/// The id of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct JointId(pub u32);

/// How a body moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Motion {
    /// Never; others collide with it.
    Static,
    /// As its pose is set from outside; pushes dynamic bodies.
    Kinematic,
    /// By forces.
    Dynamic,
}

/// Mass properties of a dynamic body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProps {
    /// kg.
    pub mass: f64,
    /// Centre of mass, body frame, m.
    pub com: Point3<f64>,
    /// Inertia about the centre of mass along the body's axes, kg m^2.
    pub inertia: Matrix3<f64>,
}

/// Collision masks as in V-REP: two bodies of the same `tree` collide if their low bytes share a bit,
/// others if their high bytes do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Respond {
    /// Low byte: within the tree. High byte: with everything else. 0: collides with nothing.
    pub mask: u16,
    /// Bodies linked into one mechanism share this number.
    pub tree: u32,
}

/// Description of a rigid body to create.
#[derive(Debug, Clone)]
pub struct BodyDesc {
    /// Body to world.
    pub pose: Isometry3<f64>,
    /// How it moves.
    pub motion: Motion,
    /// Mass properties; used for dynamic bodies.
    pub mass: MassProps,
    /// m/s, world, of the centre of mass.
    pub linear_velocity: Vector3<f64>,
    /// rad/s, world.
    pub angular_velocity: Vector3<f64>,
    /// Collision forms, in the body's frame; may be empty.
    pub parts: Vec<Part>,
    /// Coulomb friction coefficient. A pair's friction is the product of both (V-REP's rule with Bullet).
    pub friction: f64,
    /// 0: no bounce, 1: bounces back to the same height. A pair's restitution is the product of both (Bullet's rule).
    pub restitution: f64,
    /// Its collision mask.
    pub respond: Respond,
    /// Continuous collision detection against moving bodies, too.
    pub bullet: bool,
    /// Share of its velocity, and of its angular velocity, that it loses in a second, 1/s.
    pub damping: [f64; 2],
    /// Further properties of its surface.
    pub surface: Surface,
}

/// Contact properties of a surface besides friction and restitution. None by default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Surface {
    /// Velocity of the surface over the body, as of a conveyor's belt: body frame, m/s.
    pub velocity: Vector3<f64>,
    /// Axis, body frame, along which friction has a coefficient of its own, as rollers and skates have.
    pub axis: Option<Vector3<f64>>,
    /// Angle by which that axis is turned about the normal of the contact, which points out of the body, rad. With the
    /// axle of a wheel as the axis it gives the angle of the rollers at its rim, wherever the wheel touches.
    pub axis_angle: f64,
    /// Coefficient of friction along that axis, of the pair.
    pub axis_friction: f64,
    /// Torque against rolling for each N of normal force, m. A pair's is the greater one.
    pub rolling_friction: f64,
    /// Torque against spinning about the normal for each N of normal force, m. A pair's is the greater one.
    pub spinning_friction: f64,
    /// Number of its material for [`Engine::set_materials`]; 0: none.
    pub material: u32,
}

/// Friction and restitution of two materials, which override those of the bodies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MaterialPair {
    /// Their numbers, in any order.
    pub materials: (u32, u32),
    /// Coulomb friction coefficient.
    pub friction: f64,
    /// Restitution, 0 to 1; `None`: from those of the bodies.
    pub restitution: Option<f64>,
}

/// How the friction of a pair follows from that of its bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum FrictionRule {
    /// Product: Bullet's rule, and with it V-REP's.
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
    /// The friction of a pair.
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
    /// Rotation about z of the joint frame.
    Revolute,
    /// Translation along z of the joint frame.
    Prismatic,
    /// Rotation about z with so many metres along z for each radian: a nut on a thread. Always in reduced form.
    Screw(f64),
    /// All rotations; it has no position and cannot be driven.
    Spherical,
    /// None: rigid.
    Fixed,
}

/// Description of a joint to create, between body `a` (parent) and body `b` (child).
#[derive(Debug, Clone)]
pub struct JointDesc {
    /// The body that carries the joint.
    pub a: BodyId,
    /// The body that the joint moves.
    pub b: BodyId,
    /// Joint frame to body `a`.
    pub frame_in_a: Isometry3<f64>,
    /// Joint frame at position 0 to body `b`.
    pub frame_in_b: Isometry3<f64>,
    /// Degrees of freedom.
    pub kind: JointKind,
    /// Lowest and highest position, rad or m; none: unlimited.
    pub limits: Option<(f64, f64)>,
    /// Position at creation, rad or m: of a revolute joint with limits, which turn counts; otherwise without effect.
    pub position: f64,
    /// How the joint is enforced.
    pub form: JointForm,
    /// Its passive forces.
    pub passive: Passive,
    /// Whether it is geared to another joint, or another one to it: [`Engine::set_gears`].
    pub geared: bool,
}

/// Two coupled joints of one mechanism: `position = ratio * leader's position + offset`. Each loads the other.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gear {
    /// The joint that follows.
    pub joint: JointId,
    /// The joint that it follows.
    pub leader: JointId,
    /// rad or m for each rad or m of the leader.
    pub ratio: f64,
    /// Position when the leader stands at 0, rad or m.
    pub offset: f64,
}

/// How a joint is enforced. All joints of a mechanism have the same form.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum JointForm {
    /// Reduced coordinates: only its degrees of freedom are computed, so that its bodies cannot separate. Exact at any
    /// load, at a cost that grows with the cube of the number of joints of a mechanism.
    #[default]
    Reduced,
    /// Its bodies are pulled together by impulses: cheap, and soft under load.
    Impulse,
    /// By impulses, closing a loop between bodies that other joints, of either form, connect already.
    Loop,
}

/// Passive forces of a joint, besides its drive. All 0 (none) by default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Passive {
    /// Torque or force against the motion for each rad/s or m/s, N m s/rad or N s/m.
    pub damping: f64,
    /// Dry friction, N m or N. In reduced form only.
    pub friction: f64,
    /// Inertia of a rotor behind a gear, as felt at the joint, kg m^2 or kg. In reduced form only.
    pub armature: f64,
    /// Spring towards `rest`, N m/rad or N/m. In reduced form only.
    pub stiffness: f64,
    /// Position at which the spring is relaxed, rad or m.
    pub rest: f64,
    /// Speed at which the drive has no torque or force left, rad/s or m/s: its limit falls from `max_force` at rest to
    /// 0 there, as that of a direct-current motor does. 0: the limit is the same at any speed.
    pub no_load_speed: f64,
}

/// Controller of a position drive: it moves at `p * error + i * (sum of error) + d * (change of error) + velocity`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Tracking {
    /// Velocity for each rad or m of error, 1/s.
    pub p: f64,
    /// Velocity for each rad s or m s of error, 1/s^2.
    pub i: f64,
    /// Velocity for each rad/s or m/s at which the error changes.
    pub d: f64,
    /// Velocity of the target, rad/s or m/s.
    pub velocity: f64,
}

/// The drive of a joint. Torques N m or forces N; velocities rad/s or m/s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Drive {
    /// None: the joint is passive.
    Free,
    /// Reach `target` with at most `max_force`.
    Velocity {
        /// Target velocity.
        target: f64,
        /// Limit of torque or force.
        max_force: f64,
        /// Speed lost per N m or N of load; 0: none.
        slip: f64,
    },
    /// Hold `target` with at most `max_force`, approaching with at most `max_velocity`.
    Position {
        /// Target position, rad or m.
        target: f64,
        /// Limit of torque or force.
        max_force: f64,
        /// Limit of the velocity.
        max_velocity: f64,
        /// Its controller; none: the error decays by 1/e in 0.05 s, without overshoot.
        tracking: Option<Tracking>,
    },
    /// Constant torque or force.
    Force(f64),
}

/// Velocity of a body: m/s of its centre of mass, and rad/s, both in the world frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Twist {
    /// m/s.
    pub linear: Vector3<f64>,
    /// rad/s.
    pub angular: Vector3<f64>,
}

/// Position (rad or m), velocity, and the torque or force that the drive exerted in the last step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointState {
    /// rad or m; revolute joints without limits in (-pi, pi], those with limits as many turns as they have made.
    pub position: f64,
    /// Of a spherical joint: the frame on body `b` in that on body `a`.
    pub rotation: UnitQuaternion<f64>,
    /// rad/s or m/s.
    pub velocity: f64,
    /// N m or N.
    pub effort: f64,
}

/// Two bodies that touch on one face. Forms of several parts, or with corners, can touch on more than one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// The bodies, lower id first.
    pub bodies: (BodyId, BodyId),
    /// Where, world, m.
    pub point: Point3<f64>,
    /// Unit vector from the first body to the second.
    pub normal: Vector3<f64>,
    /// Normal force on the second body, N, averaged over the last step.
    pub force: f64,
    /// Friction on the second body, world, N, averaged over the last step.
    pub friction: Vector3<f64>,
}

/// A force and the torque about a point.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Wrench {
    /// N.
    pub force: Vector3<f64>,
    /// N m.
    pub torque: Vector3<f64>,
}

/// Contact parameters of a pair of bodies, which override their own.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PairRule {
    /// Whether they collide at all.
    pub responds: bool,
    /// Friction of the pair.
    pub friction: Option<f64>,
    /// Restitution of the pair.
    pub restitution: Option<f64>,
}

/// A force and a torque on a body, world frame, at its centre of mass.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Push {
    /// The body.
    pub body: BodyId,
    /// N.
    pub force: Vector3<f64>,
    /// N m.
    pub torque: Vector3<f64>,
}

/// Called before each physics step for the forces that act in that step alone: it gets the engine, the number
/// of the step within the advance from 0, and an empty list.
pub type BeforeStep<'a> = dyn FnMut(&dyn Engine, u32, &mut Vec<Push>) + 'a;

/// Parameters of the engine, for the whole world.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EngineSettings {
    /// m/s^2.
    pub gravity: Vector3<f64>,
    /// Length of one physics step, s: the period of collision detection.
    pub step: f64,
    /// Sub-steps per physics step, in which velocities are solved; at least 1.
    pub substeps: u32,
    /// Whether bodies that rest on something may sleep until they are touched.
    pub sleep: bool,
    /// How the friction of a pair is combined. For bodies that are added from then on.
    pub friction_rule: FrictionRule,
    /// Natural frequency (Hz) and damping ratio of contacts; `None`: as stiff as the sub-step can carry.
    pub contact_spring: Option<[f64; 2]>,
}

impl Default for EngineSettings {
    /// As a scene without settings has them.
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
    /// Changes gravity or the length of a step.
    fn configure(&mut self, settings: EngineSettings);
    /// Adds a body.
    fn add_body(&mut self, desc: &BodyDesc) -> BodyId;
    /// Removes a body and the joints on it. An unknown id is ignored.
    fn remove_body(&mut self, body: BodyId);
    /// Adds a joint. `None` if a body is unknown or both are the same.
    fn add_joint(&mut self, desc: &JointDesc) -> Option<JointId>;
    /// Removes a joint. An unknown id is ignored.
    fn remove_joint(&mut self, joint: JointId);
    /// Sets the drive of a joint. Cheap if nothing changed. A drive with a number that is not finite, or
    /// without force, counts as [`Drive::Free`]; only a limit may be infinite.
    fn drive(&mut self, joint: JointId, drive: Drive);
    /// Sets the coupled joints, replacing those before. Pairs that are not of one mechanism in reduced form,
    /// created with `geared`, are not coupled.
    fn set_gears(&mut self, gears: &[Gear]);
    /// Measures what a joint carries from now on, for [`Engine::wrench`].
    fn measure(&mut self, joint: JointId);
    /// The load of a measured joint on the body that carries it: force, and torque about the joint's origin;
    /// world frame, averaged over the last step. From the change of momentum of all that hangs below, and the forces on
    /// it; what a closed loop carries past the joint is included. `None` before the first step.
    fn wrench(&self, joint: JointId) -> Option<Wrench>;
    /// Sets the contact properties of a body's surface, from the next step on.
    fn set_surface(&mut self, body: BodyId, surface: Surface);
    /// Sets friction and restitution by pairs of materials, from the next step on.
    fn set_materials(&mut self, pairs: &[MaterialPair]);
    /// Sets the rest position of a joint's spring, rad or m.
    fn set_rest(&mut self, joint: JointId, rest: f64);
    /// Places a body. Dynamic bodies keep their velocities. Kinematic ones move there evenly during the next
    /// [`Engine::advance`] and push what is in their way; [`Engine::pose`] returns the new pose at once.
    fn set_pose(&mut self, body: BodyId, pose: &Isometry3<f64>);
    /// Sets the velocities of a dynamic body.
    fn set_twist(&mut self, body: BodyId, twist: &Twist);
    /// Adds a force (N) and a torque (N m), world frame, at the centre of mass, for the next [`Engine::advance`].
    fn push(&mut self, body: BodyId, force: Vector3<f64>, torque: Vector3<f64>);
    /// Advances by `steps` physics steps of the configured length. Forces added before act in all of them. Runs on the
    /// rayon pool of the calling thread (`pool.install`); results are bitwise independent of the number of threads.
    fn advance(&mut self, steps: u32) {
        self.advance_with(steps, None);
    }
    /// The same; `before`, if any, is called before each step.
    fn advance_with(&mut self, steps: u32, mut before: Option<&mut BeforeStep<'_>>) {
        for step in 0..steps {
            self.advance_part(step, steps, before.as_deref_mut());
        }
    }
    /// One step of an advance of `steps`, counted from 0. All of them, in order, are one [`Engine::advance_with`], with
    /// bitwise equal; between two of them everything may be read, and drives and pairs may be changed.
    fn advance_part(&mut self, step: u32, steps: u32, before: Option<&mut BeforeStep<'_>>);
    /// Sets the contact parameters of a pair from the next step on; `None`: those of its bodies.
    fn set_pair(&mut self, a: BodyId, b: BodyId, rule: Option<PairRule>);
    /// Body to world.
    fn pose(&self, body: BodyId) -> Isometry3<f64>;
    /// Velocities; zero for static bodies.
    fn twist(&self, body: BodyId) -> Twist;
    /// Centre of mass of a body, world.
    fn centre_of_mass(&self, body: BodyId) -> Point3<f64>;
    /// State of a joint after the last step.
    fn joint_state(&self, joint: JointId) -> JointState;
    /// Touching pairs after the last step, in order of body ids; `out` is cleared first.
    fn contacts(&self, out: &mut Vec<Contact>);
    /// Bodies whose state has become not-a-number or infinite since the last call; they have been frozen.
    fn quarantined(&mut self) -> Vec<BodyId>;
    /// The whole state as bytes, forms included, for [`Engine::restore`]. Equal states give equal bytes.
    fn snapshot(&self) -> Vec<u8>;
    /// Restores a state, including bodies, joints, ids and settings; the next steps are then bitwise equal. On
    /// failure (bytes damaged or of another version) nothing changes.
    fn restore(&mut self, bytes: &[u8]) -> Result<(), String>;
}
