//! Plugins: finding, loading, and what they offer.
//!
//! - `search`: the folders and files that may be plugins;
//! - `load`: opens one and copies its tables;
//! - [`Registry`]: everything that the loaded plugins offer, by id;
//! - `guard`: floating-point mode and locale, which plugins must leave alone;
//! - [`watchdog`]: which plugin call is running, and for how long;
//! - `declared`: declarations (parameters, commands) in Rust's words; `checks`: those that make no sense;
//! - [`schemas`]: what readings mean;
//! - `instance`: making the instance of a device;
//! - `thread_grant`: instances on several threads;
//! - `services`: the host's side of the border, one file per table.

mod checks;
mod declared;
mod drafts;
mod elf;
pub(crate) mod guard;
pub(crate) mod instance;
mod load;
mod registry;
pub mod schemas;
mod search;
pub(crate) mod services;
mod tables;
pub(crate) mod thread_grant;
pub mod watchdog;

pub use declared::{Declared, check_value};
pub use registry::{
    ActuatorKind, Choice, CommandEntry, Constant, DeviceKind, FieldInfo, Importer, Language, Model, NameEntry, Plugin,
    Prelude, PresetInfo, Registry, SensorKind, ServiceKind, Status,
};
pub use search::{Copies, Search, Source};
