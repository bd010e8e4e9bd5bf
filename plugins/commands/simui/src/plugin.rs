//! The plugin as its commands see it.

pub(crate) use tatu_commands_common::{MINUS, NIL};
use tatu_plugin_api::safe::{Call, Command, IntoResult, Result, Value};

/// The plugin.
pub struct SimUi;

/// A running command of this plugin.
pub(crate) type Ctx<'a> = Call<'a, SimUi>;
/// A command of this plugin.
pub(crate) type Cmd = Command<SimUi>;

/// A command under its name and the one that it had before version 3.5.
pub(crate) fn both<T: IntoResult + 'static>(
    name: &str,
    on_error: [Value; 1],
    f: impl Fn(&mut Ctx<'_>) -> Result<T> + Send + Sync + 'static,
) -> Cmd {
    Cmd::new(name, f).old_name(old_name(name), on_error)
}
/// The name of a command before version 3.5.
pub(crate) fn old_name(name: &str) -> String {
    name.replace("simUI.", "simExtCustomUI_")
}
