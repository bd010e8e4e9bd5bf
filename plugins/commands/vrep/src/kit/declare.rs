//! Declaring commands: under both names, and the parameters that many have.

pub(crate) use tatu_commands_common::{MINUS, NIL};
use tatu_plugin_api::safe::{IntoResult, Param, Result, Value};

use super::plugin::{Cmd, Ctx, Shared};

/// A command's name in the `sim` table, and the flat one of older scripts. Both stand as they are written in scripts, so
/// that a search for either finds the declaration.
pub(crate) type Names = [&'static str; 2];

/// A command under both names; `on_error` is what a failed call under the flat one returns.
pub(crate) fn both<T: IntoResult + 'static>(
    [name, old]: Names,
    on_error: [Value; 1],
    run: impl Fn(&mut Ctx<'_>) -> Result<T> + Send + Sync + 'static,
) -> Cmd {
    Cmd::new(name, run).old_name(old, on_error)
}
/// The same for one that others may run beside.
pub(crate) fn both_beside<T: IntoResult + 'static>(
    [name, old]: Names,
    on_error: [Value; 1],
    run: impl Fn(&mut Shared<'_>) -> Result<T> + Send + Sync + 'static,
) -> Cmd {
    Cmd::side_by_side(name, run).old_name(old, on_error)
}

/// A parameter that names an object.
pub(crate) fn object(key: &str) -> Param {
    Param::object(key).text("a handle")
}
/// A parameter that names an object, where old scripts may add flags to the number.
pub(crate) fn flagged(key: &str) -> Param {
    Param::int(key).text("a handle, flags may be added")
}
/// The object whose frame is meant.
pub(crate) fn frame_param() -> Param {
    Param::int("relativeTo")
        .default(-1)
        .optional()
        .text("-1: the world, sim.handle_parent: its parent, or an object; a joint's moved frame")
}
/// A table of at least as many numbers as its text says; longer ones are accepted.
pub(crate) fn table(key: &str, text: &str) -> Param {
    Param::floats(key, 0).text(text)
}
