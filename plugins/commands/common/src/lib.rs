//! Helpers shared by the command plugins: commands that do nothing, and the values that failed calls by old names
//! return.

use tatu_plugin_api::safe::{Command, Param, Plugin, Value};

/// Return value of a failed call by an old name if the command returns a string or a table.
pub const NIL: [Value; 1] = [Value::Nil];
/// Return value of a failed call by an old name if the command returns a handle, a count or a state, or only has an
/// effect.
pub const MINUS: [Value; 1] = [Value::Int(-1)];

/// The neutral value that a stub returns.
#[derive(Debug, Clone, Copy)]
pub enum Gives {
    /// No value.
    Nothing,
    /// An integer.
    Int(i64),
    /// A float.
    Float(f64),
    /// A string.
    Text(&'static str),
    /// An empty table.
    Empty,
    /// A table of three zeros.
    Zeros,
}

impl Gives {
    /// Returns the value that a failed call by an old name returns.
    pub fn on_error(self) -> [Value; 1] {
        if matches!(self, Gives::Int(_) | Gives::Float(_)) { MINUS } else { NIL }
    }
}

/// Builds a command that accepts any arguments and returns a neutral value. `why` states which feature is missing.
pub fn stub<P: Plugin>(name: &str, gives: Gives, why: &str) -> Command<P> {
    let command = Command::new(name, move |c| {
        match gives {
            Gives::Nothing => {}
            Gives::Int(i) => c.ret(i),
            Gives::Float(x) => c.ret(x),
            Gives::Text(t) => c.ret(t),
            Gives::Empty => c.ret(Value::List(Vec::new())),
            Gives::Zeros => c.ret(&[0.0; 3][..]),
        }
        Ok(())
    });
    let command = command.param(Param::any("arguments").rest());
    let command = match gives {
        Gives::Nothing => command,
        Gives::Int(_) => command.returns(Param::int("result")),
        Gives::Float(_) => command.returns(Param::float("result")),
        Gives::Text(_) => command.returns(Param::string("text")),
        Gives::Empty => command.returns(Param::any("result")),
        Gives::Zeros => command.returns(Param::floats("result", 3)),
    };
    command.text("Accepts any arguments, and does nothing.").stub(why)
}
