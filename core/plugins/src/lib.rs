//! Plugins: finding and loading them, and everything they offer.
//!
//! - `search`: the folders and files that are searched for plugins, the user's own folder last;
//! - `load`: opens a plugin and copies its tables; `library_file`, `drafts`: reasons to reject it;
//! - `declared`: safe access to what a plugin's tables point to;
//! - [`Registry`]: everything that the loaded plugins offer, by id;
//! - `tickets`: delivery of results by plugins' own threads;
//! - [`HostTables`]: the host's functions, which plugins request by id, and interned keys;
//! - [`lock_setup`]: ensures that only one thread at a time starts plugins and creates instances;
//! - [`thread_grant`]: use of instances on several threads;
//! - [`protected_state`]: floating-point mode, locale and other state that plugins must not change;
//! - [`guarded_array`], [`state_block`], [`reading_arena`]: memory that plugins write to;
//! - `builder`: the table through which plugins build models and import files; `beams`: the beams that an instance declares; `random_table`: random numbers for plugins;
//! - [`watchdog`]: records which plugin call is running, and for how long;
//! - `parameter_spec`: declarations (parameters, commands) as Rust types; `checks`: detects faulty ones; `names`:
//!   checks of names and their name spaces;
//! - [`texts`]: texts of plugins, prepared for display;
//! - [`schemas`]: the meaning of readings; [`events`]: the host's own events; [`units`]: units in keys;
//! - [`border`]: texts and error objects of the ABI.
//!
//! Errors in a file reject the whole plugin (`load`), and errors in a table reject the item that the table describes
//! (`registry`). Errors in the declaration of a parameter are only reported (`checks`).

mod beams;
pub mod border;
mod builder;
mod checks;
mod declared;
mod drafts;
pub mod events;
pub mod guarded_array;
pub mod guarded_copy;
mod host_tables;
mod inspect;
mod library_file;
mod load;
mod names;
mod parameter_spec;
pub mod protected_state;
mod random_table;
pub mod reading_arena;
mod registry;
pub mod schemas;
mod search;
mod setup_lock;
pub mod state_block;
mod tables;
pub mod texts;
pub mod thread_grant;
mod tickets;
pub mod units;
pub mod watchdog;

pub use beams::DeclaredBeams;
pub use builder::{BuildFunction, BuildOptions, BuildTarget, BuiltScript};
pub use checks::parameters as parameter_flaws;
pub use drafts::remedy;
pub use host_tables::{FindTable, HostHolder, HostTable, HostTables, PluginHost};
pub use inspect::Inspector;
pub use library_file::{LibraryFlaw, check as check_library};
pub use load::assets_folder;
pub use parameter_spec::{ParameterSpec, check_value, describe_value};
pub use random_table::{RandomNumbers, RandomTable};
pub use registry::{
    ActuatorKind, AttachmentSlot, CommandEntry, CommandName, CommandStatus, DeviceKind, EventListener, FieldSpec,
    FoundModel, Importer, ImporterChoice, MAX_ELEMENTS, MODEL_FILE, Model, ModelNumber, Plugin, Prelude, PresetSpec,
    Registry, ScriptConstant, ScriptKindMark, ScriptLanguage, SensorKind, ServiceKind,
};
pub use search::{CopyFolder, FolderOrigin, SearchPath};
pub use setup_lock::lock_setup;
pub use tickets::{MAX_RESULT_BYTES, Mailbox};
