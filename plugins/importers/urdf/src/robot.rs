//! The content of a URDF file. Numbers have been parsed but not checked, and names have not been resolved.

use std::collections::BTreeMap;

/// Converts a name to an alias, which must not contain slashes.
pub fn alias(name: &str) -> String {
    name.replace('/', "_")
}

/// The element `<robot>`.
#[derive(Debug, Clone)]
pub struct Robot {
    /// The name; empty if the file has none.
    pub name: String,
    /// Links, in the order of the file.
    pub links: Vec<Link>,
    /// Joints, in the order of the file.
    pub joints: Vec<Joint>,
    /// Materials to which visuals refer by name.
    pub materials: Vec<Material>,
    /// What `<gazebo>` elements state about links, by the names of these.
    pub gazebo: BTreeMap<String, GazeboLink>,
    /// The names of all other children of `<robot>`, which are ignored, and their numbers of occurrences.
    pub others: BTreeMap<String, usize>,
}

/// What a `<gazebo>` element states about a link.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GazeboLink {
    /// Friction coefficient: the mean of `mu1` and `mu2`.
    pub friction: Option<f64>,
    /// Name of a material of Gazebo, such as `Gazebo/Orange`.
    pub material: Option<String>,
}

/// A link: a rigid body with its mass and its geometries.
#[derive(Debug, Clone)]
pub struct Link {
    /// Line of the start tag, counted from 1.
    pub line: u64,
    pub name: String,
    pub inertial: Inertial,
    pub visuals: Vec<LinkShape>,
    pub collisions: Vec<LinkShape>,
}

/// Mass (kg) and moments of inertia (kg m^2) of a link; zero if the file has none.
#[derive(Debug, Clone, Default)]
pub struct Inertial {
    pub origin: UrdfPose,
    pub mass: f64,
    /// The moments `ixx`, `ixy`, `ixz`, `iyy`, `iyz` and `izz`.
    pub inertia: [f64; 6],
}

/// A visual or a collision. Collisions have no material.
#[derive(Debug, Clone)]
pub struct LinkShape {
    /// Line of the start tag, counted from 1.
    pub line: u64,
    pub origin: UrdfPose,
    pub geometry: Geometry,
    pub material: Option<Material>,
}

/// Position (m) and angles (rad): roll, pitch and yaw about the fixed axes x, y and z.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct UrdfPose {
    pub xyz: [f64; 3],
    pub rpy: [f64; 3],
}

/// A geometry, with lengths in metres.
#[derive(Debug, Clone)]
pub enum Geometry {
    Box { size: [f64; 3] },
    Cylinder { radius: f64, length: f64 },
    Capsule { radius: f64, length: f64 },
    Sphere { radius: f64 },
    Mesh { filename: String, scale: Option<[f64; 3]> },
}

/// A material. Without a colour, it refers to the robot's material with the same name.
#[derive(Debug, Clone)]
pub struct Material {
    pub name: String,
    /// Red, green, blue and opacity.
    pub color: Option<[f64; 4]>,
}

/// A joint, which connects a child link to a parent link.
#[derive(Debug, Clone)]
pub struct Joint {
    /// Line of the start tag, counted from 1.
    pub line: u64,
    pub name: String,
    pub kind: UrdfJointKind,
    pub origin: UrdfPose,
    /// Names of the links that the joint connects.
    pub parent: String,
    pub child: String,
    pub axis: [f64; 3],
    pub limit: JointLimit,
    pub dynamics: Option<JointDynamics>,
    pub mimic: Option<Mimic>,
}

/// Types of joints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UrdfJointKind {
    Revolute,
    Continuous,
    Prismatic,
    Fixed,
    /// A type that is not supported, with its name in the file.
    Other(&'static str),
}

/// Limits of a joint: positions in rad or m, effort in N m or N, velocity in rad/s or m/s. Positions and velocity are zero
/// if the file has none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct JointLimit {
    pub lower: f64,
    pub upper: f64,
    /// Greater than 0; `None` if the file states no effort, 0, or a negative one, which means "no limit" in Gazebo.
    pub effort: Option<f64>,
    pub velocity: f64,
}

/// Friction of a joint: viscous damping, in N m s/rad or N s/m, and Coulomb friction, in N m or N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointDynamics {
    pub damping: f64,
    pub friction: f64,
}

/// The coupling of a joint to another joint, which it follows.
#[derive(Debug, Clone)]
pub struct Mimic {
    pub joint: String,
    pub multiplier: Option<f64>,
    pub offset: Option<f64>,
}
