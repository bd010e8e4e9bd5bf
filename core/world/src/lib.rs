//! The core of Tatu: a world, which owns the scene and the physics step and calls plugins. It does not depend on any
//! particular plugin.
//!
//! Start with [`World`], which runs a [`document::Document`] with the kinds and commands that a [`plugins::Registry`]
//! offers. `step/mod.rs` defines the order of a step. The other crates of the core are re-exported here, so a program
//! needs only this crate.
//!
//! ```no_run
//! use std::{path::Path, sync::Arc};
//! use tatu_core::{World, document, host_tables, plugins::{Registry, SearchPath}};
//!
//! let registry = Arc::new(Registry::load(SearchPath::standard(None, None, &[]), host_tables()));
//! let scene = document::load(Path::new("scenes/first/pioneer_avoids_walls.toml"), &registry, &Default::default())?;
//! let world = World::new(Arc::new(scene), registry)?;
//! world.start();
//! for _ in 0..20 {
//!     world.step();
//! }
//! println!("{:016x}", world.hash().total);
//! # Ok::<(), tatu_core::errors::Error>(())
//! ```

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "values that tests compare with do not affect results"))]

mod calls;
mod cell;
mod events;
mod instances;
mod parts;
mod recording;
pub mod reload;
mod run;
mod scripts;
mod services;
pub mod session;
pub mod state;
mod step;

pub use cell::{
    LogBuffer, LogLine, NextScene, OptionalObject, PartSummary, Phase, ScriptSummary, StandIn, record_breach,
};
pub use run::{ObjectState, Reading, ReadingField, Session, World, replay_to};
pub use services::{Channel, host_tables};
pub use tatu_beams as beams;
pub use tatu_devices::{figures, figures::Figures, sense::OutlineEdge};
pub use tatu_errors as errors;
pub use tatu_geometry as geometry;
pub use tatu_physics as physics;
pub use tatu_plugins as plugins;
pub use tatu_scene::{self as scene, document, graph::Graph};
