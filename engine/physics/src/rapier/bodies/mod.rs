//! Rigid bodies: rapier's world, and the data about each body that rapier does not store.
//!
//! `table` declares [`Bodies`], and `record` the data that it contains. `create` adds bodies and prepares them for
//! joints, `shapes` is a cache of their shapes, `placing` sets and reads poses, `velocity` computes velocities,
//! `forces` applies forces, `spin` integrates gyroscopic motion, `sleep` decides which bodies can sleep, `handover`
//! passes bodies to trees and back, and `substeps` chooses the number of sub-steps.

mod create;
mod forces;
mod handover;
mod placing;
mod record;
mod shapes;
pub(crate) mod sleep;
mod spin;
mod substeps;
mod table;
mod velocity;

pub(crate) use create::is_valid_surface;
pub(crate) use handover::IN_TREE_FLAG;
pub(crate) use record::{BodyRecord, SavedForces};
pub(crate) use shapes::ShapeCache;
pub(crate) use table::Bodies;
