//! Tests of physics against closed forms, at the default settings: one small scene for each row of `docs/physics.md`.
//!
//! The bounds are those that the page states; measured values, also on the page, are well within them.

#![allow(clippy::disallowed_methods, reason = "expected values need not have the same bits on every processor")]

/// Keys that are added to the table `[scene]` of all scenes.
const SETTINGS: &str = "";

/// The `joint_solver` of vehicles.
const VEHICLES: &str = "auto";

#[path = "../program/kit/base.rs"]
#[allow(dead_code, reason = "shared with the tests of the program")]
mod kit;

mod arms;
mod checks;
mod contacts;
mod flight;
mod grippers;
mod links;
mod masses;
mod mechanisms;
mod overlaps;
mod parts;
mod resting;
mod scenes;
mod stacks;
mod surfaces;
mod swings;
mod targets;
mod tree;
mod vehicles;
