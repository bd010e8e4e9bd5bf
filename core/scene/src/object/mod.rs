//! Objects: properties common to all objects, and those of each kind. Each file declares its properties in a table of
//! rows beside the struct that stores them; see `property.rs`.
//!
//! - `any`: objects, and the properties that all have; `kind`: their kinds;
//! - `shape`: shapes; `primitive`: forms by name; `parts`: parts of compounds; `custom`: their values, and custom data;
//!   `derived`: what is computed from the form of a shape; `solver`: the solvers of mechanisms;
//! - `joint`: joints; `follow`: joints that follow a leader; `course`: position targets;
//! - `devices`: sensors and actuators; `force_sensor`: force sensors; `views`: cameras, lights and paths.

pub(crate) mod any;
mod course;
pub(crate) mod custom;
mod derived;
pub(crate) mod devices;
mod follow;
pub(crate) mod force_sensor;
pub(crate) mod joint;
mod kind;
mod parts;
mod primitive;
pub(crate) mod shape;
mod solver;
pub(crate) mod views;

pub use any::{Object, ObjectVariant};
pub use course::TargetSpline;
pub use custom::{notes, notes_value, part_images, part_meshes};
pub use derived::DerivedGeometry;
pub(crate) use derived::{LumpForm, MassDistribution, MassLump};
pub use devices::{ActuatorObject, SensorObject, SensorTargets};
pub use follow::FollowRule;
pub use force_sensor::ForceSensor;
pub use joint::{ControlMode, Joint, JointType};
pub use kind::ObjectKind;
pub use parts::ShapePart;
pub use primitive::Primitive;
pub use shape::{Shape, ShapeBody};
pub use solver::JointSolver;
pub use views::{Camera, Light, LightForm, ScenePath};
