//! Raises errors of the plugin in Lua, and reports errors of Lua to the host.
//!
//! - `raise`: raises errors in Lua;
//! - `protect`, `report`: convert the error of a protected call to a failure with position, hint and traceback;
//! - `places`: finds the current position of a script; `hints`: help for common errors.

pub(crate) mod hints;
mod places;
mod protect;
mod raise;
mod report;

pub(crate) use places::{note_memory, place};
pub(crate) use protect::protect;
pub(crate) use raise::{raise, raise_text};
pub(crate) use report::{record, split_position};
