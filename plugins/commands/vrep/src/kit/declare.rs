//! Declaring commands: under both names, and the parameters that many have.

use tatu_plugin_api::safe::{IntoResult, Param, Result, Value};

use super::plugin::{Cmd, Ctx, Shared};

/// Old error values: nil for values and tables,
pub(crate) const NIL: [Value; 1] = [Value::Nil];
/// and -1 for handles, counts, states and setters.
pub(crate) const MINUS: [Value; 1] = [Value::Int(-1)];

/// A command under its name `sim.abc` and the flat one that follows from it, `simAbc`, whose failure value is given.
pub(crate) fn both<T: IntoResult + 'static>(
    name: &str,
    on_error: [Value; 1],
    run: impl Fn(&mut Ctx<'_>) -> Result<T> + Send + Sync + 'static,
) -> Cmd {
    Cmd::new(name, run).old_name(flat_name(name), on_error)
}
/// The same for one that others may run beside.
pub(crate) fn both_beside<T: IntoResult + 'static>(
    name: &str,
    on_error: [Value; 1],
    run: impl Fn(&mut Shared<'_>) -> Result<T> + Send + Sync + 'static,
) -> Cmd {
    Cmd::side_by_side(name, run).old_name(flat_name(name), on_error)
}
/// `sim.abc` -> `simAbc`
pub(crate) fn flat_name(name: &str) -> String {
    let rest = name.strip_prefix("sim.").unwrap_or(name);
    let (first, others) = rest.split_at(rest.len().min(1));
    format!("sim{}{others}", first.to_uppercase())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_names() {
        assert_eq!(flat_name("sim.getJointPosition"), "simGetJointPosition");
    }
}
