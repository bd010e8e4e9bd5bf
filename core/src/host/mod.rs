//! Plugins: finding, loading, and what they offer.
//!
//! - `search`: the folders and files that may be plugins;
//! - `load`: opens one and copies its tables;
//! - [`Registry`]: everything that the loaded plugins offer, by id;
//! - `declared`: declarations (parameters, commands) in Rust's words;
//! - `services`: the host's side of the border, one file per table.

mod declared;
mod elf;
mod load;
mod registry;
mod search;
pub(crate) mod services;
mod tables;

pub use declared::{Declared, check_value};
pub use registry::{
    CommandEntry, Constant, Language, Model, NameEntry, Plugin, Prelude, Registry, SensorKind, ServiceKind,
};
pub use search::{Search, Source};
