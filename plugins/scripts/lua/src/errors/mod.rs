//! Errors: from the plugin into Lua, and from Lua to the host.
//!
//! - `raise`: into Lua;
//! - `protect`, `report`: what ends a protected call, as a failure with place, hint and traceback;
//! - `places`: where a script is; `hints`: help for frequent errors.

pub(crate) mod hints;
mod places;
mod protect;
mod raise;
mod report;

pub(crate) use places::{note_memory, place};
pub(crate) use protect::protect;
pub(crate) use raise::{raise, raise_text};
pub(crate) use report::{record, split_position};
