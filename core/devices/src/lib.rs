//! The devices of a world, without the world itself: the beams, measurements and noise of sensors; the forces of
//! actuators; graphs and drawings.
//!
//! The caller passes the inputs of a batch: the scene, the engine, the registry of kinds and the time.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "values that tests compare with do not affect results"))]

pub mod actuators;
mod contacts;
pub mod figures;
mod listed;
mod mount;
pub mod sense;
