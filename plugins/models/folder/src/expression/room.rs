//! Limits the size of results: values that double from one constant to the next must not exhaust memory.

use std::cell::Cell;

use super::value::Value;
use crate::wrong::{Result, Wrong};

/// Maximum total size of the values that expressions sharing one [`Room`] can compute, including intermediate values;
/// `size` defines the size of a value.
const MOST: usize = 4 << 20;
/// Maximum nesting depth of lists, slightly less than that of TOML parsers.
const DEEPEST: usize = 60;

/// The total size that the results of a group of expressions can still have.
#[derive(Debug)]
pub struct Room(Cell<usize>);

impl Default for Room {
    fn default() -> Self {
        Room(Cell::new(MOST))
    }
}

impl Room {
    /// Subtracts the size of a value; returns an error if the limit is exceeded or the value is nested too deeply.
    pub fn take(&self, value: &Value) -> Result {
        let left = self.0.get().checked_sub(size(value, 0)?);
        let wrong = || Wrong::new(format!("expressions compute more than {MOST} numbers and characters"));
        self.0.set(left.ok_or_else(|| wrong().help("the limit prevents a model from exhausting memory"))?);
        Ok(())
    }
}

/// Returns the size of a value: 1, plus the bytes of a string or the sizes of the elements of a list.
fn size(value: &Value, depth: usize) -> Result<usize> {
    Ok(match value {
        Value::Number(_) | Value::Bool(_) => 1,
        Value::Text(t) => 1 + t.len(),
        Value::List(_) if depth == DEEPEST => {
            return Err(Wrong::new(format!("a list is nested more than {DEEPEST} levels deep")));
        }
        Value::List(all) => all.iter().try_fold(1, |sum, v| size(v, depth + 1).map(|n| sum + n))?,
    })
}
