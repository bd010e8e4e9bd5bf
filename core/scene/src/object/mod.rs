//! Objects: properties common to all objects, and those of each kind.
//!
//! - this module: common properties, shapes, joints and devices; `primitive`: forms by name; `derived`: what is computed
//!   from the form of a shape; `follow`: joints that follow a leader; `course`: position targets;
//! - `force_sensor`: force sensors; `views`: cameras, lights and paths.

use std::{collections::BTreeMap, sync::Arc};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use tatu_geometry::Mesh;
use tatu_physics::{BodyId, JointId, Passive, Surface};
use tatu_plugin_api::abi::*;

use crate::{drive::Drive, graph::GraphSpec, noise::NoiseSpec, texture::ShapeTexture};

mod course;
mod derived;
mod follow;
mod force_sensor;
mod primitive;
mod views;

pub use course::Course;
pub use derived::Derived;
pub(crate) use derived::{Lump, Matter, Solid};
pub use follow::Follow;
pub(crate) use follow::is_curve;
pub use force_sensor::{ForceSensor, MOST_SAMPLES};
pub use primitive::{PRIMITIVES, Primitive};
pub use views::{Camera, LIGHT_FORMS, Light, LightForm, Path};

/// An object of the scene. The data that a step needs for a device is at the start of the struct, where it fits in one
/// cache line.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[repr(C)]
pub struct Object {
    /// Properties specific to the kind of the object.
    pub data: Data,
    /// Name of the object in paths; siblings can share it.
    pub(crate) alias: String,
    /// Suffix of the unique name: -1 for `alias`, n for `alias#n`.
    pub(crate) suffix: i32,
    /// Slot of the parent, or 0 for the world.
    pub parent: u32,
    /// Slots of the children, in order.
    pub children: Vec<u32>,
    /// Identifier that is unique for the lifetime of the scene, ascending in order of creation.
    pub uid: u64,
    /// Version, incremented when the object's counterpart in the engine must be recreated.
    pub version: u64,
    /// Whether pictures show the object, provided that one of its layers is shown.
    pub visible: bool,
    /// Layers that the object belongs to, one bit each.
    pub layer: u32,
    /// Custom data, by tag.
    pub notes: BTreeMap<Vec<u8>, Vec<u8>>,
    /// The wheel drive of the robot, if the object is the base of a wheeled robot.
    pub drive: Option<Box<Drive>>,
}

/// Properties of each kind of object.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub enum Data {
    /// A solid.
    Shape(Box<Shape>),
    /// A joint, which moves its children relative to its parent.
    Joint(Box<Joint>),
    /// A frame, with the path of the dummy that it is linked to, if any.
    Dummy(Option<Box<str>>),
    /// A sensor, whose kind a plugin defines.
    Sensor(SensorData),
    /// An actuator, whose kind a plugin defines.
    Actuator(ActuatorData),
    /// A rigid connection between its parent and its children that measures their load.
    ForceSensor(Box<ForceSensor>),
    /// A graph, which records values over time.
    Graph(Box<GraphSpec>),
    /// A script; it belongs to its parent but is not among its children.
    Script,
    /// A camera, which is the viewpoint of a view or picture.
    Camera(Box<Camera>),
    /// A light source of a view.
    Light(Box<Light>),
    /// A path through space.
    Path(Box<Path>),
}

impl Object {
    /// Returns the object's kind, a `TATU_KIND_*`.
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
    /// Returns the object's name in paths; [`Scene::set_name`](crate::Scene::set_name) changes it.
    pub fn alias(&self) -> &str {
        &self.alias
    }
    /// Returns the suffix of the object's unique name: -1 for `alias`, n for `alias#n`.
    pub fn suffix(&self) -> i32 {
        self.suffix
    }
    /// Returns the object's unique name.
    pub fn name(&self) -> String {
        if self.suffix < 0 { self.alias.clone() } else { format!("{}#{}", self.alias, self.suffix) }
    }
    /// Returns the object as a shape, if it is one.
    pub fn shape(&self) -> Option<&Shape> {
        if let Data::Shape(s) = &self.data { Some(s) } else { None }
    }
    /// Returns the object as a joint, if it is one.
    pub fn joint(&self) -> Option<&Joint> {
        if let Data::Joint(j) = &self.data { Some(j) } else { None }
    }
}

/// A part of a compound.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShapePart {
    /// Form of the part.
    pub primitive: Primitive,
    /// Full extents, m.
    pub size: Vector3<f64>,
    /// Pose in the shape's frame.
    pub pose: Isometry3<f64>,
    /// Red, green and blue, each 0 to 1, if the colour differs from the shape's.
    pub color: Option<[f64; 3]>,
    /// Texture, if it differs from the shape's.
    pub texture: Option<ShapeTexture>,
    /// Friction coefficient, if it differs from the shape's.
    pub friction: Option<f64>,
    /// Number of the part's mesh in the document, from 1; 0 if the part is not a mesh.
    pub mesh_number: u32,
    /// The mesh with this number; not stored in snapshots.
    #[serde(skip)]
    pub mesh: Option<Arc<Mesh>>,
    /// Whether the convex hull of the mesh replaces the mesh.
    pub convex: bool,
}

/// Id of the shape's body in the engine, or `None` if the shape has no body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Body(pub Option<BodyId>);

/// The properties of a shape, which is a solid.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[allow(missing_docs, reason = "`rows.rs` describes each property")]
pub struct Shape {
    pub primitive: Primitive,
    pub size: Vector3<f64>,
    /// The mesh. A snapshot stores only its number in the document.
    #[serde(skip)]
    pub mesh: Option<Arc<Mesh>>,
    pub convex: bool,
    pub parts: Vec<ShapePart>,
    pub color: [f64; 3],
    pub texture: Option<ShapeTexture>,
    pub mass: Option<f64>,
    pub inertia: Option<[f64; 9]>,
    /// Centre of mass in the shape's frame, m; `None`: that of the form at uniform density.
    pub com: Option<Vector3<f64>>,
    pub dynamic: bool,
    pub respondable: bool,
    pub mask: u16,
    pub friction: f64,
    pub restitution: f64,
    /// Whether beams detect the shape; if `None`, this depends on the form.
    pub detectable: Option<bool>,
    /// The solver for the joints of the mechanism whose root is this shape.
    pub joint_solver: JointSolver,
    /// Whether continuous collision detection includes collisions with other moving bodies.
    pub bullet: bool,
    /// Initial velocity of the centre of mass, m/s, and angular velocity, rad/s, in the world frame.
    pub initial_velocity: Vector3<f64>,
    pub initial_angular_velocity: Vector3<f64>,
    /// Damping rates of velocity and angular velocity, 1/s.
    pub damping: [f64; 2],
    /// Velocity of the surface, and its axis, rolling and spinning friction. The number of the material is set only in
    /// the copy that is passed to the engine.
    pub surface: Surface,
    pub material: String,
    /// Bit mask of the kinds of beams that detect the shape, if it is detectable.
    pub detectable_mask: u16,
    pub collide_as: Option<Primitive>,
    pub collide_size: Vector3<f64>,
    pub body: Body,
    /// What was computed from the form; not stored in snapshots.
    #[serde(skip)]
    pub derived: Derived,
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
            texture: None,
            mass: None,
            inertia: None,
            com: None,
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
            derived: Derived::default(),
        }
    }
}

impl Shape {
    /// Returns the textures of the shape and of its parts.
    pub fn textures(&self) -> impl Iterator<Item = &ShapeTexture> {
        self.texture.iter().chain(self.parts.iter().filter_map(|p| p.texture.as_ref()))
    }
    /// Returns mutable references to the textures of the shape and of its parts.
    pub fn textures_mut(&mut self) -> impl Iterator<Item = &mut ShapeTexture> {
        self.texture.iter_mut().chain(self.parts.iter_mut().filter_map(|p| p.texture.as_mut()))
    }
}

impl Object {
    /// Returns whether pictures show the object, that is, whether it is visible and on a layer that is shown.
    pub fn is_visible(&self) -> bool {
        self.visible && self.layer & SHOWN_LAYERS != 0
    }
}

/// Bit mask of the layers that are shown: the lower eight of sixteen.
const SHOWN_LAYERS: u32 = 0xFF;

impl Shape {
    /// Returns whether beams detect the shape. Planes, which are mostly floors, are not detected unless the scene
    /// requests it.
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
    /// Returns the type with a name, as used in scene files.
    pub fn parse(name: &str) -> Option<Self> {
        [Self::Revolute, Self::Prismatic, Self::Spherical].into_iter().find(|t| t.name() == name)
    }
    /// Returns the type's name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Revolute => "revolute",
            Self::Prismatic => "prismatic",
            Self::Spherical => "spherical",
        }
    }
}

/// The solver for the joints of a mechanism, a property of its first shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[allow(missing_docs, reason = "named after what they are")]
pub enum JointSolver {
    #[default]
    Auto,
    Reduced,
    Impulse,
    Tree,
}

impl JointSolver {
    /// Returns the solver with a name, or `Auto` for any other name.
    pub fn parse(name: &str) -> Self {
        [Self::Reduced, Self::Impulse, Self::Tree].into_iter().find(|s| s.name() == name).unwrap_or_default()
    }
    /// Returns the solver's name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Reduced => "reduced",
            Self::Impulse => "impulse",
            Self::Tree => "tree",
        }
    }
}

/// Control modes of a joint's motor.
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

/// A joint. Units are rad and N m, or m and N if it is prismatic. The data that changes in each step fits in one cache
/// line.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[allow(missing_docs, reason = "`rows.rs` describes each property")]
#[repr(C, align(64))]
pub struct Joint {
    pub position: f64,
    pub velocity: f64,
    /// Rotation of the moved frame of a spherical joint.
    pub rotation: UnitQuaternion<f64>,
    pub effort: f64,
    pub target_velocity: f64,
    pub max_force: f64,
    pub slip: f64,
    /// Id of its joint in the engine, if it connects two bodies.
    pub id: Option<JointId>,
    pub kind: JointType,
    pub dynamic: bool,
    pub control: Control,
    pub target_position: f64,
    pub max_velocity: f64,
    pub limits: Option<(f64, f64)>,
    pub follow: Follow,
    /// Gains P, I and D of the position controller; if `None`, the default controller is used.
    pub gains: Option<[f64; 3]>,
    /// Translation along the axis per turn, m, if the joint is a screw; otherwise 0.
    pub lead: f64,
    /// Passive properties: damping, dry friction, armature and spring.
    pub passive: Passive,
    pub smooth_target: bool,
    /// The trajectory of the position target between scene steps; `None` if there is no target, or if it is applied at
    /// once.
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
    /// Returns the translation along the joint's axis per radian, m, which is 0 if it is not a screw.
    pub fn lead_per_radian(&self) -> f64 {
        if self.kind == JointType::Revolute { self.lead / std::f64::consts::TAU } else { 0.0 }
    }
    /// Returns the pose of the frame of the joint's children in the joint's own frame, at its current position.
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

/// A sensor. Data that most sensors lack is allocated separately, which keeps objects small.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[repr(C)]
pub struct SensorData {
    /// Noise that is added to the fields of each measurement.
    pub noise: Option<Arc<NoiseSpec>>,
    /// Measurement rate, Hz; 0 stands for each step.
    pub rate: f64,
    /// Index of the sensor's kind in the registry.
    pub kind: usize,
    /// Name of the preset that was last set; empty if none was set.
    pub preset: Box<str>,
    /// Whether the sensor measures only on request.
    pub explicit: bool,
    /// The objects that the sensor detects; if `None`, all objects.
    pub view: Option<Arc<SensorTargets>>,
}

/// The objects that a sensor detects, by paths relative to the sensor. Each path includes all descendants of its
/// object; if paths are nested, the innermost one takes precedence.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SensorTargets {
    /// Paths of the objects that are detected; if empty, all objects.
    pub targets: Vec<String>,
    /// Paths of the objects that are not detected.
    pub ignored: Vec<String>,
}

impl SensorData {
    /// Creates a sensor with default settings; `kind` is an index in the registry.
    pub fn new(kind: usize) -> Self {
        SensorData { kind, explicit: false, rate: 0.0, preset: Box::default(), noise: None, view: None }
    }
}

/// The properties of an actuator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ActuatorData {
    /// Index of the actuator's kind in the registry.
    pub kind: usize,
    /// Current values of the commands that the actuator's kind declares. They change during a run, and a stop resets
    /// them.
    pub commands: Vec<f64>,
}
