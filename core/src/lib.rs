//! The core of Tatu: the scene, the physics step, and the plugin host. It names no plugin.
//!
//! Where to begin: [`World`] runs a [`document::Document`] with what a [`host::Registry`] offers; one step stands in
//! `step/mod.rs`.
//!
//! ```no_run
//! use std::{path::Path, sync::Arc};
//! use tatu_core::{World, document, host::{Registry, Search}};
//!
//! let registry = Arc::new(Registry::load(Search::standard(None, None, &[])));
//! let scene = document::load(Path::new("scenes/first/pioneer_avoids_walls.toml"), &registry, &Default::default())?;
//! let world = World::new(Arc::new(scene), registry)?;
//! world.start();
//! for _ in 0..20 {
//!     world.step();
//! }
//! println!("{:016x}", world.hash().total);
//! # Ok::<(), tatu_core::error::Error>(())
//! ```

mod act;
pub mod beams;
mod calls;
pub mod document;
pub mod error;
pub mod events;
pub mod figures;
pub mod geometry;
pub mod host;
pub mod look;
pub mod physics;
pub mod reload;
pub mod scene;
mod scripts;
mod sense;
pub mod session;
pub mod state;
pub mod step;
mod world;

pub use figures::{Figures, Graph};
pub use scripts::ScriptTold;
pub use session::Session;
pub use world::{LogLine, Observed, Phase, StandIn, Wish, World};
