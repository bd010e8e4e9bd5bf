//! Tests of physics against closed forms, at the default settings: one small scene for each row of `docs/physics.md`.
//!
//! The bounds are those that the page states; measured values, also on the page, are well within them.

/// Keys of `[scene]` that all scenes get.
const SETTINGS: &str = "";

/// The solver of vehicles.
const VEHICLES: &str = "auto";

#[path = "../program/kit/base.rs"]
#[allow(dead_code, reason = "shared with the tests of the program")]
mod kit;

mod arms;
mod checks;
mod contacts;
mod flight;
mod grippers;
mod mechanisms;
mod overlaps;
mod parts;
mod scenes;
mod stacks;
mod surfaces;
mod swings;
mod targets;
mod tree;
mod vehicles;
