//! Objects, with the properties that all kinds have, and the kinds without data of their own.

use std::{any::Any, collections::BTreeMap};

use serde::{Deserialize, Serialize};
use tatu_plugin_api::safe::Value;

use super::{
    Camera, ForceSensor, Joint, Light, ObjectKind, ScenePath, Shape,
    custom::{notes, notes_value},
    devices::{ActuatorObject, SensorObject},
};
use crate::{
    drive::WheelDrive,
    graph::GraphSpec,
    property::{PropertyOwner, properties, refusal_as_text, text_of},
};

/// An object of the scene. The data that a step needs for a device is at the start of the struct, where it fits in one
/// cache line.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[repr(C)]
pub struct Object {
    /// Properties specific to the kind of the object.
    pub data: ObjectVariant,
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
    pub drive: Option<Box<WheelDrive>>,
}

/// The path of the dummy that a dummy is linked to, if any.
pub type DummyLink = Option<Box<str>>;

/// Properties of each kind of object.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub enum ObjectVariant {
    /// A solid.
    Shape(Box<Shape>),
    /// A joint, which moves its children relative to its parent.
    Joint(Box<Joint>),
    /// A frame, with the path of the dummy that it is linked to, if any.
    Dummy(DummyLink),
    /// A sensor, whose kind a plugin defines.
    Sensor(SensorObject),
    /// An actuator, whose kind a plugin defines.
    Actuator(ActuatorObject),
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
    Path(Box<ScenePath>),
    /// A controller in native code, whose kind a plugin defines.
    Part(ActuatorObject),
}

impl ObjectVariant {
    /// Creates a new object of a kind; for a sensor, actuator or part, `device` is the index of its kind in the registry.
    pub fn of_kind(kind: ObjectKind, device: usize) -> ObjectVariant {
        match kind {
            ObjectKind::Shape => ObjectVariant::Shape(Box::default()),
            ObjectKind::Joint => ObjectVariant::Joint(Box::default()),
            ObjectKind::Dummy => ObjectVariant::Dummy(None),
            ObjectKind::Sensor => ObjectVariant::Sensor(SensorObject::new(device)),
            // The commands are filled in when the device is created.
            ObjectKind::Actuator => {
                ObjectVariant::Actuator(ActuatorObject { kind: device, commands: Vec::new(), targets: Vec::new() })
            }
            ObjectKind::Part => {
                ObjectVariant::Part(ActuatorObject { kind: device, commands: Vec::new(), targets: Vec::new() })
            }
            ObjectKind::ForceSensor => ObjectVariant::ForceSensor(Box::default()),
            ObjectKind::Graph => ObjectVariant::Graph(Box::default()),
            ObjectKind::Camera => ObjectVariant::Camera(Box::default()),
            ObjectKind::Light => ObjectVariant::Light(Box::default()),
            ObjectKind::Path => ObjectVariant::Path(Box::default()),
            ObjectKind::Script => ObjectVariant::Script,
        }
    }

    /// Returns the kind and the commands of an actuator or a part.
    pub fn actuator_or_part(&self) -> Option<&ActuatorObject> {
        if let ObjectVariant::Actuator(a) | ObjectVariant::Part(a) = self { Some(a) } else { None }
    }

    /// Like `actuator_or_part`, to change the commands.
    pub fn actuator_or_part_mut(&mut self) -> Option<&mut ActuatorObject> {
        if let ObjectVariant::Actuator(a) | ObjectVariant::Part(a) = self { Some(a) } else { None }
    }
}

impl Object {
    /// Returns the object's kind.
    pub fn kind(&self) -> ObjectKind {
        match self.data {
            ObjectVariant::Shape(_) => ObjectKind::Shape,
            ObjectVariant::Joint(_) => ObjectKind::Joint,
            ObjectVariant::Dummy(_) => ObjectKind::Dummy,
            ObjectVariant::Sensor(_) => ObjectKind::Sensor,
            ObjectVariant::Actuator(_) => ObjectKind::Actuator,
            ObjectVariant::Part(_) => ObjectKind::Part,
            ObjectVariant::ForceSensor(_) => ObjectKind::ForceSensor,
            ObjectVariant::Graph(_) => ObjectKind::Graph,
            ObjectVariant::Script => ObjectKind::Script,
            ObjectVariant::Camera(_) => ObjectKind::Camera,
            ObjectVariant::Light(_) => ObjectKind::Light,
            ObjectVariant::Path(_) => ObjectKind::Path,
        }
    }
    /// Returns the struct that stores a property's values.
    pub(crate) fn property_store(&self, of: PropertyOwner) -> &dyn Any {
        match (&self.data, of) {
            (_, PropertyOwner::Any | PropertyOwner::World) => self,
            (ObjectVariant::Shape(x), _) => &**x,
            (ObjectVariant::Joint(x), _) => &**x,
            (ObjectVariant::Dummy(x), _) => x,
            (ObjectVariant::Sensor(x), _) => x,
            (ObjectVariant::Actuator(x) | ObjectVariant::Part(x), _) => x,
            (ObjectVariant::ForceSensor(x), _) => &**x,
            (ObjectVariant::Graph(x), _) => &**x,
            (ObjectVariant::Script, _) => &(),
            (ObjectVariant::Camera(x), _) => &**x,
            (ObjectVariant::Light(x), _) => &**x,
            (ObjectVariant::Path(x), _) => &**x,
        }
    }
    /// Returns the struct that stores a property's values, to change it.
    pub(crate) fn property_store_mut(&mut self, of: PropertyOwner) -> &mut dyn Any {
        if matches!(of, PropertyOwner::Any | PropertyOwner::World) {
            return self;
        }
        match &mut self.data {
            ObjectVariant::Shape(x) => &mut **x,
            ObjectVariant::Joint(x) => &mut **x,
            ObjectVariant::Dummy(x) => x,
            ObjectVariant::Sensor(x) => x,
            ObjectVariant::Actuator(x) | ObjectVariant::Part(x) => x,
            ObjectVariant::ForceSensor(x) => &mut **x,
            ObjectVariant::Graph(x) => &mut **x,
            ObjectVariant::Script => &mut self.layer,
            ObjectVariant::Camera(x) => &mut **x,
            ObjectVariant::Light(x) => &mut **x,
            ObjectVariant::Path(x) => &mut **x,
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
        if let ObjectVariant::Shape(s) = &self.data { Some(s) } else { None }
    }
    /// Returns the object as a joint, if it is one.
    pub fn joint(&self) -> Option<&Joint> {
        if let ObjectVariant::Joint(j) = &self.data { Some(j) } else { None }
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

/// The largest coordinate that a position may have, m. Beyond it, a position is less exact than 0.1 um.
pub(crate) const MAX_COORDINATE: f64 = 1e9;

properties! { PROPERTIES: Object, PropertyOwner::Any =>
    "object.alias" text, None { get |o: &Object| Value::text(&o.alias) }: "Name of the object in paths; siblings can share it.";
    "object.name" text, None { get |o: &Object| Value::text(o.name()) }: "Unique name of the object: the alias, followed by `#n` on copies.";
    "object.path" text, ReadOnly _: "Path of the object in the tree of objects.";
    "object.kind" text, ReadOnly { get |o: &Object| Value::text(o.kind().name()) }: "Kind of the object.";
    "object.parent" object, Rebuild _: "Parent of the object; a change preserves the pose in the world.";
    "object.position" numbers 3 in "m" from (-MAX_COORDINATE) to MAX_COORDINATE = [0.0, 0.0, 0.0], Moved _: "Position in the parent's frame.";
    "object.quaternion" numbers 4 = [0.0, 0.0, 0.0, 1.0], Moved _: "Orientation in the parent's frame, x y z w.";
    "object.orientation" numbers 3 in "rad" = [0.0, 0.0, 0.0], Moved _: "Orientation in the parent's frame: intrinsic rotations about x, then y, then z.";
    "object.pose" numbers 7 = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], Moved _: "Position and quaternion in the parent's frame.";
    "object.world_pose" numbers 7, Moved _: "Position and quaternion in the world frame.";
    "object.twist" numbers 6, ReadOnly _: "Linear velocity, m/s, then angular velocity, rad/s, along the axes of the world; for a dynamic shape, the velocity of its centre of mass.";
    "object.local_twist" numbers 6, ReadOnly _: "The velocities of `object.twist` along the object's own axes.";
    "object.model_base" bool = false, Rebuild _: "Whether the object is the base of a model.";
    "object.visible" bool = true, Look visible: "Whether pictures show the object.";
    "object.layer" int from 0.0 to (u32::MAX as f64) = 1, Look layer: "Layers that the object belongs to, one bit each.";
    "object.data" data = none, None { get |o: &Object| notes_value(&o.notes), set |o: &mut Object, v| { o.notes = refusal_as_text(notes(v))?; Ok(true) } }: "Custom data: strings by tag, for scripts and plugins; a stop preserves the data, except for tags that begin with a control character.";
    "object.drive" drive = none, None { get |o: &Object| WheelDrive::to_value(o.drive.as_deref()), set |o: &mut Object, v| { o.drive = refusal_as_text(WheelDrive::from_value(v))?.map(Box::new); Ok(true) } }: "Wheel drive of the robot whose base the object is, for clients that steer the robot: type (differential, ackermann, omni), joints, steering, radius, track, wheelbase, axle, angles; setting an empty table removes it.";
}

properties! { DUMMY: DummyLink, PropertyOwner::Kind(ObjectKind::Dummy) =>
    "dummy.link" text = none, Rebuild { get |link: &DummyLink| Value::text(link.as_deref().unwrap_or("")), set |link: &mut DummyLink, v| { let path = text_of(v)?; *link = (!path.is_empty()).then(|| path.into()); Ok(true) } }: "Path of another dummy, relative to this one: the shapes above both are held together so that the two dummies coincide in position and orientation (all six degrees of freedom), which closes a loop; a dummy below a static shape or below none is fixed to the world.";
}

properties! { SCRIPT: (), PropertyOwner::Kind(ObjectKind::Script) =>
    "script.language" text, ReadOnly _: "Language of the script.";
    "script.dialect" text, ReadOnly _: "Dialect chosen for the script.";
    "script.kind" text, ReadOnly _: "child, customization, main, addon or sandbox.";
    "script.name" text, ReadOnly _: "File that the script was read from, or a name for messages.";
    "script.calls" int, ReadOnly _: "Number of calls of the script's callbacks.";
    "script.instructions" int, ReadOnly _: "Number of instructions of its language that the script has executed.";
}
