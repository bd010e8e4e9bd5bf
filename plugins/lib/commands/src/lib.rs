//! Helpers shared by the command plugins: commands that do nothing, the values that failed calls by old names return,
//! and the addresses that a run may access ([`permission`]).

pub mod permission;

use tatu_plugin_api::safe::{Command, Param, Plugin, Value};

/// Return value of a failed call by an old name if the command returns a string or a table.
pub const NIL: [Value; 1] = [Value::Nil];
/// Return value of a failed call by an old name if the command returns a handle, a count or a state, or only has an
/// effect.
pub const MINUS_ONE: [Value; 1] = [Value::Int(-1)];

/// The neutral value that a stub returns.
#[derive(Debug, Clone, Copy)]
pub enum StubResult {
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

impl StubResult {
    /// Returns the value that a failed call by an old name returns.
    pub fn on_error(self) -> [Value; 1] {
        if matches!(self, StubResult::Int(_) | StubResult::Float(_)) { MINUS_ONE } else { NIL }
    }
}

/// Builds a command that accepts any arguments and returns a neutral value. `why` states which feature is missing.
pub fn stub<P: Plugin>(name: &str, gives: StubResult, why: &str) -> Command<P> {
    let command = Command::new(name, move |c| {
        match gives {
            StubResult::Nothing => {}
            StubResult::Int(i) => c.ret(i),
            StubResult::Float(x) => c.ret(x),
            StubResult::Text(t) => c.ret(t),
            StubResult::Empty => c.ret(Value::List(Vec::new())),
            StubResult::Zeros => c.ret(&[0.0; 3][..]),
        }
        Ok(())
    });
    let command = command.param(Param::any("arguments").rest());
    let command = match gives {
        StubResult::Nothing => command,
        StubResult::Int(_) => command.returns(Param::int("result")),
        StubResult::Float(_) => command.returns(Param::float("result")),
        StubResult::Text(_) => command.returns(Param::string("text")),
        StubResult::Empty => command.returns(Param::any("result")),
        StubResult::Zeros => command.returns(Param::floats("result", 3)),
    };
    command.text("Accepts any arguments, and does nothing.").stub(why)
}
