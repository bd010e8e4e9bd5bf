//! One object: what every kind has, and what its own kind adds.
//!
//! - here: what all have, shapes, joints and devices; `follow`: joints that follow others; `course`: position targets;
//! - `force_sensor`: force sensors; `views`: cameras, lights and paths.

use std::{collections::BTreeMap, sync::Arc};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use tatu_geometry::Mesh;
use tatu_physics::{BodyId, JointId, Passive, Surface};
use tatu_plugin_api::abi::*;

use crate::{drive::Drive, graph::GraphSpec, noise::NoiseSpec};

mod course;
mod follow;
mod force_sensor;
mod views;

pub use course::Course;
pub use follow::Follow;
pub(crate) use follow::is_curve;
pub use force_sensor::{ForceSensor, MOST_SAMPLES};
pub use views::{Camera, LIGHT_FORMS, Light, LightForm, Path};

/// An object of the scene. What a step asks of a device's object comes first, so that it lies in one cache line.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[repr(C)]
pub struct Object {
    /// What its kind adds.
    pub data: Data,
    /// Name among its siblings.
    pub(crate) alias: String,
    /// Number of its unique name: -1 for `alias`, n for `alias#n`.
    pub(crate) suffix: i32,
    /// Slot of the object above; 0: the world.
    pub parent: u32,
    /// Slots of the objects below, in order.
    pub children: Vec<u32>,
    /// Unique for the life of the scene, in order of creation.
    pub uid: u64,
    /// Increases when its counterpart in the engine must be recreated.
    pub version: u64,
    /// Whether pictures show it.
    pub visible: bool,
    /// Layers, one bit each.
    pub layer: u32,
    /// Free data by tag.
    pub notes: BTreeMap<Vec<u8>, Vec<u8>>,
    /// The wheels that drive what it is the base of.
    pub drive: Option<Box<Drive>>,
}

/// What the kinds add.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub enum Data {
    /// A solid.
    Shape(Box<Shape>),
    /// A joint.
    Joint(Box<Joint>),
    /// A frame; the path of the dummy that it is linked to.
    Dummy(Option<Box<str>>),
    /// A sensor.
    Sensor(SensorData),
    /// An actuator.
    Actuator(ActuatorData),
    /// Ties what is below rigidly to what is above.
    ForceSensor(Box<ForceSensor>),
    /// Records numbers over time.
    Graph(Box<GraphSpec>),
    /// A script; belongs to its parent, and is not among its children.
    Script,
    /// From where a view looks.
    Camera(Box<Camera>),
    /// What lights a view.
    Light(Box<Light>),
    /// A way through space.
    Path(Box<Path>),
}

impl Object {
    /// `TATU_KIND_*`
    pub fn kind(&self) -> i32 {
        match self.data {
            Data::Shape(_) => TATU_KIND_SHAPE,
            Data::Joint(_) => TATU_KIND_JOINT,
            Data::Dummy(_) => TATU_KIND_DUMMY,
            Data::Sensor(_) => TATU_KIND_SENSOR,
            Data::Actuator(_) => TATU_KIND_ACTUATOR,
            Data::ForceSensor(_) => TATU_KIND_FORCE_SENSOR,
            Data::Graph(_) => TATU_KIND_GRAPH,
            Data::Script => TATU_KIND_SCRIPT,
            Data::Camera(_) => TATU_KIND_CAMERA,
            Data::Light(_) => TATU_KIND_LIGHT,
            Data::Path(_) => TATU_KIND_PATH,
        }
    }
    /// Its name among its siblings; changed by [`Scene::set_name`](crate::Scene::set_name).
    pub fn alias(&self) -> &str {
        &self.alias
    }
    /// The number of its unique name: -1 for `alias`, n for `alias#n`.
    pub fn suffix(&self) -> i32 {
        self.suffix
    }
    /// Its unique name.
    pub fn name(&self) -> String {
        if self.suffix < 0 { self.alias.clone() } else { format!("{}#{}", self.alias, self.suffix) }
    }
    /// As a shape.
    pub fn shape(&self) -> Option<&Shape> {
        if let Data::Shape(s) = &self.data { Some(s) } else { None }
    }
    /// As a joint.
    pub fn joint(&self) -> Option<&Joint> {
        if let Data::Joint(j) = &self.data { Some(j) } else { None }
    }
}

/// The form of a shape or part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "named after what they are")]
pub enum Primitive {
    Box,
    Sphere,
    Cylinder,
    Capsule,
    Plane,
    Mesh,
    Compound,
}

/// Their names, in the order of [`Primitive`].
pub const PRIMITIVES: &[&str] = &["box", "sphere", "cylinder", "capsule", "plane", "mesh", "compound"];

impl Primitive {
    /// By its name in `PRIMITIVES`.
    pub fn parse(name: &str) -> Option<Self> {
        use Primitive::*;
        let all = [Box, Sphere, Cylinder, Capsule, Plane, Mesh, Compound];
        PRIMITIVES.iter().position(|p| *p == name).map(|i| all[i])
    }
    /// Its name.
    pub fn name(self) -> &'static str {
        PRIMITIVES[self as usize]
    }
}

/// One part of a compound.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShapePart {
    /// Its form.
    pub primitive: Primitive,
    /// Full extents.
    pub size: Vector3<f64>,
    /// In the shape's frame.
    pub pose: Isometry3<f64>,
    /// Its color, if not the shape's.
    pub color: Option<[f64; 3]>,
    /// Its friction, if not the shape's.
    pub friction: Option<f64>,
    /// Number of its mesh in the document, from 1, for the form `mesh`; else 0.
    pub mesh_number: u32,
    /// That mesh; left out of snapshots.
    #[serde(skip)]
    pub mesh: Option<Arc<Mesh>>,
    /// Whether its mesh is its own convex hull.
    pub convex: bool,
}

/// Where a shape stands in the engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Body(pub Option<BodyId>);

/// A solid.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[allow(missing_docs, reason = "each is a property row with its sentence")]
pub struct Shape {
    pub primitive: Primitive,
    pub size: Vector3<f64>,
    /// Left out of snapshots, which name the document's mesh instead.
    #[serde(skip)]
    pub mesh: Option<Arc<Mesh>>,
    pub convex: bool,
    pub parts: Vec<ShapePart>,
    pub color: [f64; 3],
    pub mass: Option<f64>,
    pub inertia: Option<[f64; 9]>,
    pub com: Vector3<f64>,
    pub dynamic: bool,
    pub respondable: bool,
    pub mask: u16,
    pub friction: f64,
    pub restitution: f64,
    /// `None`: by its form.
    pub detectable: Option<bool>,
    /// How the joints of the mechanism that begins with it are kept together.
    pub joint_solver: JointSolver,
    /// Continuous collision detection against moving bodies, too.
    pub bullet: bool,
    /// m/s of the centre of mass and rad/s at the start, in the world.
    pub initial_velocity: Vector3<f64>,
    pub initial_angular_velocity: Vector3<f64>,
    /// Share of its velocity, and of its angular velocity, that it loses in a second, 1/s.
    pub damping: [f64; 2],
    /// Its number of the material is known to the engine alone.
    pub surface: Surface,
    pub material: String,
    /// Which beams see it, if it is detectable.
    pub detectable_mask: u16,
    pub collide_as: Option<Primitive>,
    pub collide_size: Vector3<f64>,
    pub body: Body,
}

impl Default for Shape {
    fn default() -> Self {
        Shape {
            primitive: Primitive::Box,
            size: Vector3::repeat(0.1),
            mesh: None,
            convex: false,
            parts: Vec::new(),
            color: [0.7; 3],
            mass: None,
            inertia: None,
            com: Vector3::zeros(),
            dynamic: false,
            respondable: false,
            mask: 0xFFFF,
            friction: 1.0,
            restitution: 0.0,
            detectable: None,
            detectable_mask: u16::MAX,
            joint_solver: JointSolver::Auto,
            bullet: false,
            initial_velocity: Vector3::zeros(),
            initial_angular_velocity: Vector3::zeros(),
            damping: [0.0; 2],
            surface: Surface::default(),
            material: String::new(),
            collide_as: None,
            collide_size: Vector3::zeros(),
            body: Body(None),
        }
    }
}

impl Object {
    /// Whether pictures show it: it is visible, and on one of the layers that are shown.
    pub fn is_visible(&self) -> bool {
        self.visible && self.layer & SHOWN_LAYERS != 0
    }
}

/// The lower eight of the sixteen layers are shown, the others hold what is hidden.
const SHOWN_LAYERS: u32 = 0xFF;

impl Shape {
    /// Whether beams see it: floors that are planes are left out unless a scene asks for them.
    pub fn is_detectable(&self) -> bool {
        self.detectable.unwrap_or(self.primitive != Primitive::Plane)
    }
}

/// The degrees of freedom of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "named after what they are")]
pub enum JointType {
    Revolute,
    Prismatic,
    Spherical,
}

impl JointType {
    /// By its name.
    pub fn parse(name: &str) -> Option<Self> {
        [Self::Revolute, Self::Prismatic, Self::Spherical].into_iter().find(|t| t.name() == name)
    }
    /// As scene files write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Revolute => "revolute",
            Self::Prismatic => "prismatic",
            Self::Spherical => "spherical",
        }
    }
}

/// How the joints of a mechanism are kept together; a property of its first shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[allow(missing_docs, reason = "named after what they are")]
pub enum JointSolver {
    #[default]
    Auto,
    Reduced,
    Impulse,
}

impl JointSolver {
    /// By its name; others mean `auto`.
    pub fn parse(name: &str) -> Self {
        [Self::Reduced, Self::Impulse].into_iter().find(|s| s.name() == name).unwrap_or_default()
    }
    /// As scene files write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Reduced => "reduced",
            Self::Impulse => "impulse",
        }
    }
}

/// What a joint's motor does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "named after what they are")]
pub enum Control {
    Free,
    Velocity,
    Position,
    Force,
    Callback,
    Spring,
}

/// A joint; rad and N m, or m and N. What changes in each step lies in one cache line.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[allow(missing_docs, reason = "each is a property row with its sentence")]
#[repr(C, align(64))]
pub struct Joint {
    pub position: f64,
    pub velocity: f64,
    /// Of a spherical joint.
    pub rotation: UnitQuaternion<f64>,
    pub effort: f64,
    pub target_velocity: f64,
    pub max_force: f64,
    pub slip: f64,
    /// In the engine, if it ties two bodies there.
    pub id: Option<JointId>,
    pub kind: JointType,
    pub dynamic: bool,
    pub control: Control,
    pub target_position: f64,
    pub max_velocity: f64,
    pub limits: Option<(f64, f64)>,
    pub follow: Follow,
    /// Of its position controller, P, I and D.
    pub gains: Option<[f64; 3]>,
    /// Metres along its axis for a whole turn, if it is a screw.
    pub lead: f64,
    /// Damping, dry friction, armature and spring.
    pub passive: Passive,
    pub smooth_target: bool,
    /// How the target of position control moves between scene steps; `None`: it has none, or is taken as it comes.
    pub course: Option<Course>,
}

impl Default for Joint {
    fn default() -> Self {
        Joint {
            kind: JointType::Revolute,
            dynamic: true,
            control: Control::Free,
            position: 0.0,
            rotation: UnitQuaternion::identity(),
            velocity: 0.0,
            target_velocity: 0.0,
            target_position: 0.0,
            max_force: 0.0,
            max_velocity: 10.0,
            effort: 0.0,
            limits: None,
            slip: 0.0,
            follow: Follow::default(),
            gains: None,
            lead: 0.0,
            passive: Passive::default(),
            smooth_target: true,
            course: None,
            id: None,
        }
    }
}

impl Joint {
    /// Metres along its axis for each radian; 0 if it is no screw.
    pub fn lead_per_radian(&self) -> f64 {
        if self.kind == JointType::Revolute { self.lead / std::f64::consts::TAU } else { 0.0 }
    }
    /// What its position does to the frame of its children.
    pub fn motion(&self) -> Isometry3<f64> {
        match self.kind {
            JointType::Revolute => Isometry3::from_parts(
                Translation3::new(0.0, 0.0, self.lead_per_radian() * self.position),
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.position),
            ),
            JointType::Prismatic => Isometry3::translation(0.0, 0.0, self.position),
            JointType::Spherical => Isometry3::from_parts(Translation3::identity(), self.rotation),
        }
    }
}

/// A sensor. So laid out that objects stay small.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[repr(C)]
pub struct SensorData {
    /// What is done to its fields after each measure.
    pub noise: Option<Arc<NoiseSpec>>,
    /// Hz; 0: it measures in each step.
    pub rate: f64,
    /// Index of its kind in the registry.
    pub kind: usize,
    /// The preset that was set last.
    pub preset: Box<str>,
    /// Measures only on request.
    pub explicit: bool,
    /// What it sees of the scene; `None`: all.
    pub view: Option<Arc<SensorTargets>>,
}

/// What a sensor sees, by paths seen from itself. Each stands for its object with all below it; of nested ones the nearest
/// above an object decides.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SensorTargets {
    /// What it sees; empty: all.
    pub targets: Vec<String>,
    /// What it does not see.
    pub ignored: Vec<String>,
}

impl SensorData {
    /// One of a kind, as it is by default.
    pub fn new(kind: usize) -> Self {
        SensorData { kind, explicit: false, rate: 0.0, preset: Box::default(), noise: None, view: None }
    }
}

/// An actuator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ActuatorData {
    /// Index of its kind in the registry.
    pub kind: usize,
    /// Its commands, one number for each that its kind declares; live, and reset at stop like everything else.
    pub commands: Vec<f64>,
}
