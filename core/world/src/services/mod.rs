//! The host functions of the plugin ABI, with one file per table.
//!
//! A function looks up its world, borrows the parts that it uses, and releases them. If a part is already borrowed, for
//! example during a `measure` call, the function returns an error and never panics. `by_path` is for programs, not for
//! plugins.

mod answer;
mod bodies;
mod by_path;
mod commands;
mod devices;
mod edits;
mod events;
mod figures;
mod files;
mod log;
mod properties;
mod readings;
mod scene;
mod scripts;
mod session;
mod signals;
mod solids;
mod stand_ins;
mod subtrees;
mod ui_data;

pub use by_path::Channel;

use std::ffi::CStr;

use tatu_plugin_api::abi::*;
use tatu_plugins::{HostTable, HostTables};
use tatu_scene::property_table::PROPERTIES;

/// Returns the tables that are passed to plugins, as an argument of [`Registry::load`](tatu_plugins::Registry::load).
pub fn host_tables() -> HostTables {
    HostTables::new(table, PROPERTIES.iter().map(|row| row.key))
}

fn table(id: &CStr) -> Option<HostTable> {
    Some(match id {
        id if id == TATU_HOST_SCENE => HostTable::new(&scene::TABLE),
        id if id == TATU_HOST_STAND_INS => HostTable::new(&stand_ins::TABLE),
        id if id == TATU_HOST_READINGS => HostTable::new(&readings::TABLE),
        id if id == TATU_HOST_BODIES => HostTable::new(&bodies::TABLE),
        id if id == TATU_HOST_COMMANDS => HostTable::new(&commands::TABLE),
        id if id == TATU_HOST_SCRIPTS => HostTable::new(&scripts::TABLE),
        id if id == TATU_HOST_SIGNALS => HostTable::new(&signals::TABLE),
        id if id == TATU_HOST_EVENTS => HostTable::new(&events::TABLE),
        id if id == TATU_HOST_SESSION => HostTable::new(&session::TABLE),
        id if id == TATU_HOST_STAGE => HostTable::new(&session::STAGE_TABLE),
        id if id == TATU_HOST_LOG => HostTable::new(&log::TABLE),
        id if id == TATU_HOST_FILES => HostTable::new(&files::TABLE),
        id if id == TATU_HOST_FIGURES => HostTable::new(&figures::TABLE),
        id if id == TATU_HOST_EDITS => HostTable::new(&edits::TABLE),
        _ => return None,
    })
}
