//! Builds robots of links and joints, for importers of files that describe these.
//!
//! An importer reads a `robot`; `tree` checks how its links and joints are connected and merges links that are fixed to
//! each other into bodies, `build` creates the objects: `form` converts geometries, `mesh`
//! reads mesh files, `collision` makes collision shapes, `joint` joints and their motors with the efforts that `effort`
//! assumes, and `closure` joints that close loops. `sensors` builds those of SDF, from an `element`. `findings` collects what the user should know, and `materials` has
//! the colours of Gazebo.

mod build;
mod closure;
mod collision;
mod effort;
mod element;
mod findings;
mod form;
mod joint;
mod materials;
mod mesh;
mod robot;
mod sensors;
mod settings;
mod tree;

pub use build::{BuiltLink, BuiltRobot, build};
pub use element::{Element, is_true, shortened};
pub use findings::{FindingKind, Findings};
pub use form::set_object_pose;
pub use materials::gazebo_color;
pub use robot::{
    Geometry, Inertial, Joint, JointDynamics, JointKind, JointLimit, Link, LinkShape, Mimic, MotorKind, Robot,
    RobotStructure, Surface, alias,
};
pub use sensors::{DEFAULT_FIELD, SensorBuilder, magnetic_field};
pub use settings::BuildSettings;
pub use tree::{BodyTree, check_finite, pose};
