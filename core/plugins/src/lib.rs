//! Plugins: finding and loading them, and everything they offer.
//!
//! - `search`: the folders and files that are searched for plugins, the user's own folder last;
//! - `load`: opens a plugin and copies its tables; `elf`, `drafts`: reasons to reject it;
//! - [`Registry`]: everything that the loaded plugins offer, by id;
//! - `tickets`: delivery of results by plugins' own threads;
//! - [`HostTables`]: the host's functions, which plugins request by id, and interned keys;
//! - [`setup_turn`]: ensures that only one thread at a time starts plugins and creates instances;
//! - [`thread_grant`]: use of instances on several threads;
//! - [`guard`]: floating-point mode, locale and other state that plugins must not change;
//! - [`guarded`], [`state_block`]: memory that plugins write to;
//! - [`watchdog`]: records which plugin call is running, and for how long;
//! - `declared`: declarations (parameters, commands) as Rust types; `checks`: detects faulty ones; `names`: checks of
//!   names and their name spaces;
//! - [`texts`]: texts of plugins, prepared for display;
//! - [`schemas`]: the meaning of readings; [`events`]: the host's own events; [`units`]: units in keys;
//! - [`border`]: texts and error objects of the ABI.
//!
//! Errors in a file reject the whole plugin (`load`), and errors in a table reject the item that the table describes
//! (`registry`). Errors in the declaration of a parameter are only reported (`checks`).

pub mod border;
mod checks;
mod declared;
mod drafts;
mod elf;
pub mod events;
pub mod guard;
pub mod guard_page;
pub mod guarded;
mod host_tables;
mod inspect;
mod load;
mod names;
mod registry;
pub mod schemas;
mod search;
mod setup_turn;
pub mod state_block;
pub mod tables;
pub mod texts;
pub mod thread_grant;
mod tickets;
pub mod units;
pub mod watchdog;

pub use checks::parameters as parameter_flaws;
pub use declared::{Declared, check_value, describe};
pub use elf::{Unfit, check as check_library};
pub use host_tables::{Holder, HostTables};
pub use inspect::Inspector;
pub use load::assets_folder;
pub use registry::{
    ActuatorKind, Choice, CommandEntry, Constant, DeviceKind, FieldInfo, Found, Importer, KindMark, Language,
    MODEL_FILE, MOST_ELEMENTS, Model, ModelNumber, NameEntry, Plugin, Prelude, PresetInfo, Registry, SensorKind,
    ServiceKind, Slot, Status,
};
pub use search::{Copies, Search, Source};
pub use setup_turn::setup_turn;
pub use tickets::{MOST_BYTES as MOST_RESULT_BYTES, Mailbox};
