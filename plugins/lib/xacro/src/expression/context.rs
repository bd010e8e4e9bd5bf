//! What an expression needs from the file that it is in.

use crate::{error::Result, limits::Budget, value::Value};

/// How serious a message of a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Severity {
    Message,
    Warning,
    Error,
}

/// The surroundings of an expression.
pub(crate) trait Context {
    fn budget(&mut self) -> &mut Budget;

    /// The value of a property, seen from where the expression stands.
    fn property(&mut self, name: &str) -> Result<Option<Value>>;

    /// The value of a property of an include with `ns`.
    fn property_in(&mut self, table: usize, name: &str) -> Result<Option<Value>>;

    /// The value of an argument of the file.
    fn argument(&mut self, name: &str) -> Result<Value>;

    /// The name of a file, relative to the file that is being read.
    fn file_name(&mut self, name: &str) -> String;

    /// The contents of a file with YAML.
    fn load_yaml(&mut self, name: &str) -> Result<Value>;

    /// Records a message of the file.
    fn say(&mut self, severity: Severity, text: &str);

    /// Records that something deserves a note: its kind, and the first case.
    fn note(&mut self, kind: &'static str, text: &str);
}
