//! The plugin as its commands see it.

use tatu_plugin_api::safe::{Call, Command, IntoResult, Result, Value};

/// The plugin.
pub struct SimUi;

/// A running command of this plugin.
pub(crate) type Ctx<'a> = Call<'a, SimUi>;
/// A command of this plugin.
pub(crate) type Cmd = Command<SimUi>;

/// Old error values: nil for texts and tables,
pub(crate) const NIL: [Value; 1] = [Value::Nil];
/// and -1 for numbers and setters.
pub(crate) const MINUS: [Value; 1] = [Value::Int(-1)];
/// A command under its name and the one that it had before version 3.5.
pub(crate) fn both<T: IntoResult + 'static>(
    name: &str,
    on_error: [Value; 1],
    f: impl Fn(&mut Ctx<'_>) -> Result<T> + Send + Sync + 'static,
) -> Cmd {
    Cmd::new(name, f).old_name(name.replace("simUI.", "simExtCustomUI_"), on_error)
}
