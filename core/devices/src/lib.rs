//! The devices of a world, which do not know the world: plans, casts, measures and noise of sensors; what actuators push;
//! graphs and drawings.
//!
//! Whoever steps a world passes in what a batch needs: the scene, the engine, the registry of kinds, the time.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "what tests compare with decides no bits"))]

pub mod actuators;
pub mod figures;
pub mod sense;
