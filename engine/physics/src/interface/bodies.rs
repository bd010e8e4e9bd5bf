//! Bodies: their descriptions, and the values that are read from them.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use serde::{Deserialize, Serialize};
use tatu_geometry::SolidPart;

use super::{contacts::ContactSurface, ids::BodyId};

/// How a body moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum MotionType {
    /// The body never moves; other bodies collide with it.
    Static,
    /// The body follows the poses set by [`Engine::set_pose`](crate::Engine::set_pose) and pushes dynamic bodies.
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
    /// Coulomb friction coefficient. [`EngineSettings::friction_rule`](crate::EngineSettings::friction_rule) combines
    /// the coefficients of a pair.
    pub friction: f64,
    /// Coefficient of restitution, from 0 (no bounce) to 1 (a bounce to the same height). The restitution of a pair is
    /// the product of both coefficients, as in Bullet.
    pub restitution: f64,
    /// Mask that determines with which bodies the body collides.
    pub collision_mask: CollisionMask,
    /// Whether continuous collision detection includes collisions with other moving bodies.
    pub bullet: bool,
    /// Whether a dynamic body sleeps until something wakes it, even if nothing supports it. A joint wakes it.
    pub asleep: bool,
    /// Linear and angular damping, 1/s.
    pub damping: [f64; 2],
    /// Further contact properties of the body's surface.
    pub surface: ContactSurface,
}

impl BodyDesc {
    /// Describes a dynamic body at rest, which collides with all others, with a friction coefficient of 1, without
    /// restitution and damping.
    pub fn dynamic(pose: Isometry3<f64>, mass: MassProps, parts: Vec<SolidPart>) -> Self {
        BodyDesc {
            pose,
            motion: MotionType::Dynamic,
            mass,
            linear_velocity: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
            parts,
            friction: 1.0,
            restitution: 0.0,
            collision_mask: CollisionMask { mask: 0xffff, tree: 0 },
            bullet: false,
            asleep: false,
            damping: [0.0; 2],
            surface: ContactSurface::default(),
        }
    }

    /// Describes a static body, which collides with all others, with a friction coefficient of 1, without restitution.
    pub fn fixed(pose: Isometry3<f64>, parts: Vec<SolidPart>) -> Self {
        let mass = MassProps { mass: 0.0, com: Point3::origin(), inertia: Matrix3::zeros() };
        BodyDesc { motion: MotionType::Static, ..BodyDesc::dynamic(pose, mass, parts) }
    }
}

/// Velocity of a body in the world frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Twist {
    /// Velocity of the centre of mass, m/s.
    pub linear: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub angular: Vector3<f64>,
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
