//! A robot as a file describes it: links, and joints between them. Names have not been resolved.

use std::collections::BTreeMap;

use nalgebra::Isometry3;

/// Converts a name to an alias, which must not contain slashes and control characters.
pub fn alias(name: &str) -> String {
    name.replace(|c: char| c == '/' || c.is_control(), "_")
}

/// Links and joints.
#[derive(Debug, Clone)]
pub struct Robot {
    /// The name; empty if the file has none.
    pub name: String,
    /// Pose where the robot is placed.
    pub pose: Isometry3<f64>,
    /// Links, in the order of the file.
    pub links: Vec<Link>,
    /// Joints, in the order of the file.
    pub joints: Vec<Joint>,
    /// How the links are connected.
    pub structure: RobotStructure,
    /// Texts that the robot's object carries as custom data, by tag.
    pub data: BTreeMap<String, String>,
}

/// How links may be connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RobotStructure {
    /// All links form one tree; anything else is an error.
    Tree,
    /// Links need not be connected, and joints may form loops.
    Graph,
    /// No link moves; joints are ignored.
    Static,
}

/// A link: a rigid body with its mass and its geometries.
#[derive(Debug, Clone)]
pub struct Link {
    /// Line of the start tag, counted from 1.
    pub line: u64,
    /// Its name, which differs from those of all others.
    pub name: String,
    /// Pose in the frame of the robot. It counts only for links above which there is no joint.
    pub pose: Isometry3<f64>,
    /// Whether the link cannot move, if there is no joint above it.
    pub is_fixed: bool,
    /// Its mass.
    pub inertial: Inertial,
    /// What is seen.
    pub visuals: Vec<LinkShape>,
    /// What collides.
    pub collisions: Vec<LinkShape>,
    /// Friction coefficient of all collisions that state none.
    pub friction: Option<f64>,
}

/// Mass (kg) and moments of inertia (kg m^2) of a link; zero if the file has none.
#[derive(Debug, Clone, Default)]
pub struct Inertial {
    /// Pose of the centre of mass and of the axes of the moments.
    pub pose: Isometry3<f64>,
    /// Mass, kg.
    pub mass: f64,
    /// The moments `ixx`, `ixy`, `ixz`, `iyy`, `iyz` and `izz`.
    pub inertia: [f64; 6],
}

/// A visual or a collision.
#[derive(Debug, Clone)]
pub struct LinkShape {
    /// Line of the start tag, counted from 1.
    pub line: u64,
    /// Pose of the geometry in the frame of the link.
    pub pose: Isometry3<f64>,
    /// Its form.
    pub geometry: Geometry,
    /// Red, green, blue and opacity of a visual.
    pub color: Option<[f64; 4]>,
    /// Surface of a collision.
    pub surface: Surface,
}

/// How a collision rubs and rebounds.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Surface {
    /// Friction coefficient.
    pub friction: Option<f64>,
    /// A direction in the frame of the link, and the friction coefficient along it if that differs.
    pub axis: Option<([f64; 3], f64)>,
    /// Coefficient of restitution.
    pub restitution: f64,
}

/// A geometry, with lengths in metres.
#[derive(Debug, Clone)]
pub enum Geometry {
    /// A box.
    Box {
        /// Full extents.
        size: [f64; 3],
    },
    /// A cylinder about the z axis.
    Cylinder {
        /// Its radius.
        radius: f64,
        /// Its length.
        length: f64,
    },
    /// A cylinder about the z axis with caps.
    Capsule {
        /// Its radius.
        radius: f64,
        /// Length of the cylindrical part, without the caps.
        length: f64,
    },
    /// A sphere.
    Sphere {
        /// Its radius.
        radius: f64,
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Half the extents.
        radii: [f64; 3],
    },
    /// A plane through the origin, whose normal is the z axis. It has no end where it collides.
    Plane {
        /// Extents of what is seen of it.
        size: [f64; 2],
    },
    /// A mesh file.
    Mesh {
        /// Its path or URI.
        filename: String,
        /// Factors of its extents.
        scale: Option<[f64; 3]>,
    },
}

/// A joint, which connects a child link to a parent link.
#[derive(Debug, Clone)]
pub struct Joint {
    /// Line of the start tag, counted from 1.
    pub line: u64,
    /// Its name, which differs from those of all others.
    pub name: String,
    /// How the joint moves.
    pub kind: JointKind,
    /// Pose of the joint in the frame of the parent link.
    pub pose: Isometry3<f64>,
    /// Pose of the child link in the frame of the joint.
    pub child_pose: Isometry3<f64>,
    /// Name of the link that carries the joint.
    pub parent: String,
    /// Name of the link that the joint moves.
    pub child: String,
    /// Axis in the frame of the joint.
    pub axis: [f64; 3],
    /// Its limits.
    pub limit: JointLimit,
    /// Its friction and spring.
    pub dynamics: Option<JointDynamics>,
    /// The joint that it follows.
    pub mimic: Option<Mimic>,
    /// What its motor does at the start.
    pub motor: MotorKind,
}

/// Types of joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointKind {
    /// Turns about its axis between limits.
    Revolute,
    /// Turns about its axis without limits.
    Continuous,
    /// Slides along its axis.
    Prismatic,
    /// Does not move.
    Fixed,
    /// Turns about any axis.
    Ball,
    /// Moves along its axis by this distance (m) in each full turn.
    Screw(f64),
    /// A type that is not supported, with its name in the file.
    Other(&'static str),
}

impl JointKind {
    /// Returns whether the joint has one degree of freedom, which a motor can move.
    pub fn has_axis(self) -> bool {
        !matches!(self, JointKind::Fixed | JointKind::Ball | JointKind::Other(_))
    }
}

/// The initial mode of a joint's motor, if the settings leave it to the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MotorKind {
    /// Continuous joints have a speed, as wheels need, others a position, as arms need.
    ByType,
    /// There is no motor; a script can switch one on.
    Off,
    /// Holds this speed, rad/s or m/s.
    Velocity(f64),
    /// Holds this position, rad or m.
    Position(f64),
    /// Exerts a constant force of 0 until it is told another one.
    Force,
}

/// Limits of a joint: positions in rad or m, effort in N m or N, velocity in rad/s or m/s. Positions and velocity are zero
/// if the file has none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct JointLimit {
    /// Lowest position.
    pub lower: f64,
    /// Highest position.
    pub upper: f64,
    /// Greater than 0; `None` if the file states no effort, 0, or a negative one, which means "no limit" in Gazebo.
    pub effort: Option<f64>,
    /// Greatest speed.
    pub velocity: f64,
}

/// Friction of a joint: viscous damping, in N m s/rad or N s/m, and Coulomb friction, in N m or N; and its spring.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct JointDynamics {
    /// Viscous damping.
    pub damping: f64,
    /// Coulomb friction.
    pub friction: f64,
    /// Stiffness, N m/rad or N/m, and the position at which the spring is relaxed.
    pub spring: [f64; 2],
}

/// The coupling of a joint to another joint, which it follows.
#[derive(Debug, Clone)]
pub struct Mimic {
    /// Name of the joint that is followed.
    pub joint: String,
    /// Position per position of that joint; default 1.
    pub multiplier: Option<f64>,
    /// Position when that joint is at 0; default 0.
    pub offset: Option<f64>,
}
