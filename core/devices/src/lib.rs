//! The devices of a world, independent of the world itself: plans, beams, measurements and noise of sensors; forces of
//! actuators; graphs and drawings.
//!
//! The caller passes the inputs of a batch: the scene, the engine, the registry of kinds and the time.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "what tests compare with decides no bits"))]

pub mod actuators;
pub mod figures;
mod mount;
pub mod sense;
