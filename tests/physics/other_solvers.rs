//! The same tests with the solvers that `auto` does not choose: the reduced form for mechanisms that would be solved as
//! trees, and trees for vehicles.

/// Keys of `[scene]` that all scenes get.
const SETTINGS: &str = "joint_solver = \"reduced\"\n";

/// The solver of vehicles.
const VEHICLES: &str = "tree";

#[path = "../program/kit/base.rs"]
#[allow(dead_code, reason = "shared with the tests of the program")]
mod kit;

mod arms;
mod contacts;
mod grippers;
mod mechanisms;
mod overlaps;
mod parts;
#[allow(dead_code, reason = "shared with the other tests")]
mod scenes;
mod surfaces;
mod swings;
mod targets;
mod vehicles;
