//! Joints of bodies, in three forms.
//!
//! `table` declares [`Joints`], and `record` the data of each joint. `solver` declares the interface of all forms;
//! `impulse`, `reduced` and `tree` implement it, and `forms` chooses among them. Common to all forms are `position`
//! (with `turns`, which counts whole turns), `controller` (the velocities that drives command), `drives` (their updates
//! before a step), `reading` (the states of joints) and `load` (forces in measured joints); `motor` sets rapier's
//! motors, and `park` lets parked mechanisms sleep.

mod controller;
mod drives;
mod forms;
mod impulse;
mod load;
mod motor;
mod park;
mod position;
mod reading;
mod record;
mod reduced;
mod solver;
mod table;
mod tree;
mod turns;

pub(crate) use forms::JointForms;
pub(crate) use position::{turned, zero};
pub(crate) use solver::NewJoint;
pub(crate) use table::Joints;
