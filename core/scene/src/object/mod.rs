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

pub use any::{Data, Object};
pub use course::Course;
pub use custom::{notes, notes_value, part_images, part_meshes};
pub use derived::Derived;
pub(crate) use derived::{Lump, Matter, Solid};
pub use devices::{ActuatorData, SensorData, SensorTargets};
pub use follow::Follow;
pub use force_sensor::ForceSensor;
pub use joint::{Control, Joint, JointType};
pub use kind::Kind;
pub use parts::ShapePart;
pub use primitive::Primitive;
pub use shape::{Body, Shape};
pub use solver::JointSolver;
pub use views::{Camera, Light, LightForm, Path};
