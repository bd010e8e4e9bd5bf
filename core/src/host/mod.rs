//! Plugins: finding, loading, and what they offer.
//!
//! - `search`: the folders and files that may be plugins;
//! - `load`: opens one and copies its tables;
//! - [`Registry`]: everything that the loaded plugins offer, by id;
//! - `guard`: floating-point mode and locale, which plugins must leave alone;
//! - [`watchdog`]: which plugin call is running, and for how long;
//! - `declared`: declarations (parameters, commands) in Rust's words;
//! - `services`: the host's side of the border, one file per table.

mod declared;
mod drafts;
mod elf;
pub(crate) mod guard;
mod load;
mod registry;
mod search;
pub(crate) mod services;
mod tables;
pub mod watchdog;

pub use declared::{Declared, check_value};
pub use registry::{
    CommandEntry, Constant, FieldInfo, Language, Model, NameEntry, Plugin, Prelude, Registry, SensorKind,
};
pub use search::{Search, Source};
