//! The built program from outside: real plugin libraries, real compilers, real scripts.
//!
//! One binary, one module per subject; `kit` runs the program, writes scenes and builds plugins. Expected values name
//! their source: a formula, or a fact restated in `tests/facts/`. Tests that need files which are not part of the
//! repository, or a compiler that is missing, count as ignored. Nothing here looks at how long something takes.

mod addons;
mod away;
mod beside;
mod bounds;
mod cascades;
mod catalogue;
mod claims;
mod cli;
mod compat;
mod configure;
mod course;
mod crowd;
mod declarations;
mod demos;
mod depth;
mod describe;
mod determinism;
mod driver;
mod eras;
mod errors;
mod events;
mod gps;
mod graphs;
mod header;
mod import;
mod importers;
#[cfg(unix)]
mod interactive;
mod isolation;
mod keys;
mod kit;
mod laser;
mod layers;
mod layout;
mod library;
mod lives;
mod look;
mod made;
mod manta;
mod mirror;
mod misbehaves;
mod nesting;
mod noise;
mod order;
mod outputs;
mod plugins;
mod processors;
mod proximity;
mod refusals;
mod reload;
mod removals;
mod replay;
mod restart;
mod returns;
mod said;
mod scans;
mod script_errors;
mod seeds;
mod service;
mod sonar;
mod standins;
mod state;
mod talk;
mod threads;
mod thruster;
mod tree;
mod vision;
mod vrep_files;
mod watchers;
mod wheels;
mod worlds;
