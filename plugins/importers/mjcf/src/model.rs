//! The contents of a file: bodies with their joints and geoms, and what acts on them.

use std::{collections::BTreeSet, rc::Rc};

use nalgebra::{Isometry3, Vector3};
use tatu_importers_common::{DecodedImage, Mass};

use crate::{mesh::MeshAsset, xml::Place};

/// A model; the first body is the world.
#[derive(Default)]
pub struct Model {
    pub name: String,
    pub bodies: Vec<Body>,
    pub actuators: Vec<Actuator>,
    pub tendons: Vec<Tendon>,
    pub equalities: Vec<Equality>,
    pub sensors: Vec<Sensor>,
    pub keyframes: Vec<Keyframe>,
    /// Names of geoms in contact pairs.
    pub paired_geoms: BTreeSet<String>,
    /// Names of pairs of bodies that must not collide.
    pub exclusions: Vec<[String; 2]>,
    pub gravity: Option<[f64; 3]>,
    pub timestep: Option<f64>,
}

/// A body. Its parts are in its frame.
pub struct Body {
    /// The name; unnamed ones are called after their number.
    pub name: String,
    /// Index of the parent; the world is its own.
    pub parent: usize,
    /// Pose in the parent, with all joints at their reference.
    pub pose: Isometry3<f64>,
    pub joints: Vec<Joint>,
    /// Whether the body moves freely.
    pub is_free: bool,
    /// Damping of a free body's six motions, N s/m and N m s/rad.
    pub damping: f64,
    /// Whether the body is moved from outside only.
    pub is_mocap: bool,
    pub geoms: Vec<Geom>,
    pub sites: Vec<Site>,
    pub cameras: Vec<Camera>,
    pub lights: Vec<Light>,
    /// The mass, if `<inertial>` states it.
    pub inertial: Option<Mass>,
    /// The mass of the body: that of `inertial`, or of its geoms.
    pub mass: Mass,
    pub place: Place,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointKind {
    Hinge,
    Slide,
    Ball,
}

/// A joint between a body and its parent; positions count from `reference` in the pose of the file.
#[derive(Debug, Clone)]
pub struct Joint {
    pub name: String,
    pub kind: JointKind,
    pub at: Vector3<f64>,
    pub axis: Vector3<f64>,
    pub range: Option<[f64; 2]>,
    pub reference: f64,
    pub rest: f64,
    pub stiffness: f64,
    pub damping: f64,
    pub armature: f64,
    pub friction: f64,
    /// Bound of the sum of all actuators on the joint.
    pub max_force: Option<f64>,
    /// Time constant and damping ratio that replace stiffness and damping.
    pub spring_damper: Option<[f64; 2]>,
    pub place: Place,
}

/// The form of a geom, with half extents.
#[derive(Clone)]
pub enum GeomForm {
    Plane([f64; 2]),
    Ellipsoid([f64; 3]),
    Capsule {
        radius: f64,
        half: f64,
    },
    Cylinder {
        radius: f64,
        half: f64,
    },
    Box([f64; 3]),
    Mesh(Rc<MeshAsset>),
    /// A height field, whose asset has triangles.
    Heights(Rc<MeshAsset>),
}

/// A geom.
#[derive(Clone)]
pub struct Geom {
    pub name: String,
    pub form: GeomForm,
    pub pose: Isometry3<f64>,
    pub contype: u32,
    pub conaffinity: u32,
    pub condim: i64,
    pub group: i64,
    pub friction: [f64; 3],
    pub mass: Mass,
    pub look: Look,
}

impl Geom {
    /// Returns whether the geom collides with anything.
    pub fn collides(&self) -> bool {
        self.contype | self.conaffinity != 0
    }
    /// Returns whether viewers show the geom unless told otherwise.
    pub fn is_shown(&self) -> bool {
        self.group < 3 && self.look.rgba[3] > 0.0
    }
}

/// Colour and image of a surface.
#[derive(Clone)]
pub struct Look {
    pub rgba: [f64; 4],
    pub texture: Option<Rc<Picture>>,
    /// Whether neither the geom nor its material sets a colour, so that those of a mesh file apply.
    pub is_default: bool,
}

impl Look {
    /// Returns the colour of a surface on which the image cannot be drawn.
    pub fn flat_color(&self) -> [f64; 3] {
        let mean = self.texture.as_ref().map_or([1.0; 3], |t| t.mean);
        [0, 1, 2].map(|i| (self.rgba[i] * mean[i]).clamp(0.0, 1.0))
    }
}

/// An image that is repeated on a surface.
pub struct Picture {
    /// The image; `None` for textures that have only a colour here.
    pub image: Option<Rc<DecodedImage>>,
    /// Mean colour.
    pub mean: [f64; 3],
    /// Repetitions per surface, or per metre.
    pub repeat: [f64; 2],
    pub per_metre: bool,
}

pub struct Site {
    pub name: String,
    pub pose: Isometry3<f64>,
    /// Half extents of the region, for sensors of touch.
    pub size: [f64; 3],
}

pub struct Camera {
    pub name: String,
    pub pose: Isometry3<f64>,
    /// Vertical angle of view, rad.
    pub angle: f64,
}

pub struct Light {
    pub name: String,
    /// Pose whose z axis is the direction.
    pub pose: Isometry3<f64>,
    pub directional: bool,
    pub diffuse: [f64; 3],
    /// Half the angle of the cone, rad.
    pub cutoff: f64,
}

/// What an actuator acts on.
#[derive(Debug, Clone, PartialEq)]
pub enum Transmission {
    Joint(String),
    Tendon(String),
}

/// An actuator: force = gain * control + bias, with a bias that is linear in length and velocity.
#[derive(Debug, Clone)]
pub struct Actuator {
    pub on: Transmission,
    pub gear: f64,
    pub gain: f64,
    pub bias: [f64; 3],
    /// Damping ratio that replaces the gain on velocity.
    pub damping_ratio: Option<f64>,
    pub force_range: Option<[f64; 2]>,
    pub control_range: Option<[f64; 2]>,
    pub place: Place,
}

/// A fixed tendon: a sum of joint positions.
pub struct Tendon {
    pub name: String,
    pub joints: Vec<(String, f64)>,
}

pub enum Equality {
    /// The position of the first joint is a polynomial of that of the second.
    Joints { first: String, second: Option<String>, polynomial: [f64; 5], place: Place },
    /// As `Joints`, for fixed tendons.
    Tendons { first: String, second: Option<String>, polynomial: [f64; 5], place: Place },
    /// Two bodies share a point.
    Connect { bodies: [String; 2], anchor: Vector3<f64>, place: Place },
    /// Two bodies are fixed to each other, in the pose of the file or in the stated pose.
    Weld { bodies: [String; 2], relative: Option<Isometry3<f64>>, place: Place },
    /// As `Connect` or `Weld`, at two sites.
    Sites { sites: [String; 2], rigid: bool, place: Place },
}

pub struct Sensor {
    pub kind: String,
    pub name: String,
    pub site: String,
    pub place: Place,
}

pub struct Keyframe {
    pub name: String,
    pub positions: Option<Vec<f64>>,
    pub controls: Option<Vec<f64>>,
    pub place: Place,
}
