//! The tests of `main.rs` with the joint solvers that `auto` does not choose: `reduced` for mechanisms that it would
//! solve as trees, and `tree` for vehicles.

#![allow(clippy::disallowed_methods, reason = "expected values need not have the same bits on every processor")]

/// Keys that are added to the table `[scene]` of all scenes.
const SETTINGS: &str = "joint_solver = \"reduced\"\n";

/// The `joint_solver` of vehicles.
const VEHICLES: &str = "tree";

#[path = "../program/kit/base.rs"]
#[allow(dead_code, reason = "shared with the tests of the program")]
mod kit;

mod arms;
mod contacts;
mod grippers;
mod links;
mod mechanisms;
mod overlaps;
mod parts;
mod resting;
#[allow(dead_code, reason = "shared with the other tests")]
mod scenes;
mod surfaces;
mod swings;
mod targets;
mod vehicles;
