//! The plugin type, and short names for its commands and calls.

pub(crate) use tatu_commands_common::{MINUS_ONE, NIL};
use tatu_plugin_api::safe::{Call, Command, IntoResult, Result, Value};

/// The plugin; its state per world is `window::Windows`.
pub struct SimUi;

/// A call of one of this plugin's commands.
pub(crate) type Ctx<'a> = Call<'a, SimUi>;
/// A command of this plugin.
pub(crate) type Cmd = Command<SimUi>;

/// Builds a command with its current name and the name that it had before V-REP 3.5.
pub(crate) fn both<T: IntoResult + 'static>(
    name: &str,
    on_error: [Value; 1],
    f: impl Fn(&mut Ctx<'_>) -> Result<T> + Send + Sync + 'static,
) -> Cmd {
    Cmd::new(name, f).old_name(old_name(name), on_error)
}
/// Returns the name that a command had before V-REP 3.5.
pub(crate) fn old_name(name: &str) -> String {
    name.replace("simUI.", "simExtCustomUI_")
}
