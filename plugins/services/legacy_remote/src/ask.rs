//! Calls commands of the world for a client.

use tatu_plugin_api::safe::{Called, Fail, Result, Turn, Value};

/// Calls a command of the world; returns its results.
pub fn ask(turn: &Turn<'_>, name: &str, args: &[Value]) -> Result<Vec<Value>> {
    match turn.call(name, args, 0)? {
        Called::Done(values) => Ok(values),
        Called::Waits => Err(Fail::unsupported(format!("`{name}` waits, which is not possible in a remote call"))),
    }
}
