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

use std::ffi::{CStr, c_void};

use tatu_plugin_api::abi::*;
use tatu_plugins::HostTables;
use tatu_scene::property_table::PROPERTIES;

/// Returns the tables that are passed to plugins, as an argument of [`Registry::load`](tatu_plugins::Registry::load).
pub fn host_tables() -> HostTables {
    HostTables::new(table, PROPERTIES.iter().map(|row| row.key))
}

fn table(id: &CStr) -> *const c_void {
    match id {
        id if id == TATU_HOST_SCENE => (&raw const scene::TABLE).cast(),
        id if id == TATU_HOST_STAND_INS => (&raw const stand_ins::TABLE).cast(),
        id if id == TATU_HOST_READINGS => (&raw const readings::TABLE).cast(),
        id if id == TATU_HOST_BODIES => (&raw const bodies::TABLE).cast(),
        id if id == TATU_HOST_COMMANDS => (&raw const commands::TABLE).cast(),
        id if id == TATU_HOST_SCRIPTS => (&raw const scripts::TABLE).cast(),
        id if id == TATU_HOST_SIGNALS => (&raw const signals::TABLE).cast(),
        id if id == TATU_HOST_EVENTS => (&raw const events::TABLE).cast(),
        id if id == TATU_HOST_SESSION => (&raw const session::TABLE).cast(),
        id if id == TATU_HOST_STAGE => (&raw const session::STAGE_TABLE).cast(),
        id if id == TATU_HOST_LOG => (&raw const log::TABLE).cast(),
        id if id == TATU_HOST_FILES => (&raw const files::TABLE).cast(),
        id if id == TATU_HOST_FIGURES => (&raw const figures::TABLE).cast(),
        id if id == TATU_HOST_EDITS => (&raw const edits::TABLE).cast(),
        _ => std::ptr::null(),
    }
}
