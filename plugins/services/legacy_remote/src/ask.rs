//! Calls commands of the world on behalf of a client.

use tatu_plugin_api::safe::{Called, Fail, Result, Turn, Value};

/// Calls a command of the world and returns its results. Fails if the command would have to wait.
pub fn call_command(turn: &Turn<'_>, name: &str, args: &[Value]) -> Result<Vec<Value>> {
    match turn.call(name, args, 0)? {
        Called::Done(values) => Ok(values),
        Called::Waits => Err(Fail::unsupported(format!(
            "`{name}` waits for the simulation, so it cannot be called by the legacy remote API"
        ))),
    }
}
