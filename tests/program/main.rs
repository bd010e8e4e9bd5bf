//! The built program from outside: real plugin libraries, real compilers, real scripts.
//!
//! One binary, one module per subject; `kit` runs the program, writes scenes and builds plugins. Expected values name
//! their source: a measurement of the original program, a data sheet, a formula. Tests that need `../shared` skip with
//! a printed reason where it is absent. Nothing here looks at how long something takes.

mod away;
mod cli;
mod course;
mod demos;
mod determinism;
mod errors;
mod header;
mod kit;
mod mirror;
mod nesting;
mod plugins;
mod restart;
mod sonar;
mod state;
mod tree;
mod wheels;
