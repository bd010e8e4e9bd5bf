//! Helpers that declare commands under both of their names, and common parameters.

pub(crate) use tatu_commands_common::{MINUS_ONE, NIL};
use tatu_plugin_api::safe::{IntoResult, Param, Result, Value};

use super::plugin::{Cmd, Ctx, SharedCtx};

/// A command's name in the `sim` table, and its flat name in older scripts. Both are spelled in full, so that a search
/// for either finds the declaration.
pub(crate) type CommandNames = [&'static str; 2];

/// Builds a command under both names; `on_error` is the result of a failed call by the flat name.
pub(crate) fn both<T: IntoResult + 'static>(
    [name, old]: CommandNames,
    on_error: [Value; 1],
    run: impl Fn(&mut Ctx<'_>) -> Result<T> + Send + Sync + 'static,
) -> Cmd {
    Cmd::new(name, run).old_name(old, on_error)
}
/// Like [`both`], but for a command that may run in parallel with others.
pub(crate) fn both_parallel<T: IntoResult + 'static>(
    [name, old]: CommandNames,
    on_error: [Value; 1],
    run: impl Fn(&mut SharedCtx<'_>) -> Result<T> + Send + Sync + 'static,
) -> Cmd {
    Cmd::side_by_side(name, run).old_name(old, on_error)
}

/// Declares a parameter that is the handle of an object.
pub(crate) fn object(key: &str) -> Param {
    Param::object(key).text("a handle")
}
/// Declares a parameter that is the handle of an object, to which old scripts can add flags.
pub(crate) fn flagged(key: &str) -> Param {
    Param::int(key).text("a handle, to which flags can be added")
}
/// Declares the parameter that selects the reference frame.
pub(crate) fn frame_param() -> Param {
    Param::int("relativeTo")
        .default(-1)
        .optional()
        .text("-1: the world, sim.handle_parent: its parent, or an object; for a joint, its moving frame")
}
/// Declares a table of numbers, described by `text`. Longer tables are accepted.
pub(crate) fn table(key: &str, text: &str) -> Param {
    Param::floats(key, 0).text(text)
}
