//! Plugins: finding, loading, and what they offer.
//!
//! - `search`: folders and files in which plugins are searched, the user's own last;
//! - `load`: opens one and copies its tables; `elf`, `drafts`: reasons to reject it;
//! - [`Registry`]: everything that the loaded plugins offer, by id;
//! - [`HostTables`]: the host's functions that plugins ask for by id, and the keys that they interned;
//! - [`thread_grant`]: instances on several threads;
//! - [`guard`]: floating-point mode, locale and the like, which plugins must not change;
//! - [`guarded`], [`state_block`]: memory that plugins write to;
//! - [`watchdog`]: which plugin call is running, and for how long;
//! - `declared`: declarations (parameters, commands) as Rust types; `checks`: those that contradict themselves;
//!   `names`: which names are valid, and whose name space they are in;
//! - [`texts`]: texts of plugins, made safe to display;
//! - [`schemas`]: what readings mean; [`events`]: the events of the host itself; [`units`]: units in keys;
//! - [`border`]: texts and error objects at the ABI.
//!
//! A plugin is refused in `load` (its file), `registry::read` (its tables) or `checks` (its declarations).

pub mod border;
mod checks;
mod declared;
mod drafts;
mod elf;
pub mod events;
pub mod guard;
pub mod guarded;
mod host_tables;
mod load;
mod names;
mod registry;
pub mod schemas;
mod search;
pub mod state_block;
pub mod tables;
pub mod texts;
pub mod thread_grant;
pub mod units;
pub mod watchdog;

pub use declared::{Declared, check_value, describe};
pub use elf::{Unfit, check as check_library};
pub use host_tables::{Holder, HostTables};
pub use registry::{
    ActuatorKind, Choice, CommandEntry, Constant, DeviceKind, FieldInfo, Importer, KindMark, Language, MOST_ELEMENTS,
    Model, NameEntry, Plugin, Prelude, PresetInfo, Registry, SensorKind, ServiceKind, Status,
};
pub use search::{Copies, Search, Source};
