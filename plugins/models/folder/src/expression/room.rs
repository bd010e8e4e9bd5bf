//! How much expressions may compute: values that double from one constant to the next must not fill the memory.

use std::cell::Cell;

use super::value::Value;
use crate::wrong::{Result, Wrong};

/// Most numbers and bytes of texts that expressions with one room compute, intermediate values included.
const MOST: usize = 4 << 20;
/// Deepest nesting of lists. Readers of TOML take little more.
const DEEPEST: usize = 60;

/// What expressions that belong together may still compute.
#[derive(Debug)]
pub struct Room(Cell<usize>);

impl Default for Room {
    fn default() -> Self {
        Room(Cell::new(MOST))
    }
}

impl Room {
    /// Takes the room that a value needs.
    pub fn take(&self, value: &Value) -> Result {
        let left = self.0.get().checked_sub(size(value, 0)?);
        let wrong = || Wrong::new(format!("expressions compute more than {MOST} numbers and characters"));
        self.0.set(left.ok_or_else(|| wrong().help("values are limited so that a model cannot fill the memory"))?);
        Ok(())
    }
}

/// Returns how many numbers and bytes of texts a value has.
fn size(value: &Value, depth: usize) -> Result<usize> {
    Ok(match value {
        Value::Number(_) | Value::Bool(_) => 1,
        Value::Text(t) => 1 + t.len(),
        Value::List(_) if depth == DEEPEST => {
            return Err(Wrong::new(format!("a list is nested more than {DEEPEST} deep")));
        }
        Value::List(all) => all.iter().try_fold(1, |sum, v| size(v, depth + 1).map(|n| sum + n))?,
    })
}
