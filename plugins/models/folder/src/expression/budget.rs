//! Limits the size of results: values that double from one constant to the next must not exhaust memory.

use std::cell::Cell;

use super::value::ExpressionValue;
use crate::error::{ModelError, Result};

/// Maximum total size of the values that expressions sharing one [`SizeBudget`] can compute, including intermediate
/// values; `size` defines the size of a value.
const MAX_SIZE: usize = 4 << 20;
/// Maximum nesting depth of lists, slightly less than that of TOML parsers.
const MAX_LIST_DEPTH: usize = 60;

/// The total size that the results of a group of expressions can still have.
#[derive(Debug)]
pub struct SizeBudget(Cell<usize>);

impl Default for SizeBudget {
    fn default() -> Self {
        SizeBudget(Cell::new(MAX_SIZE))
    }
}

impl SizeBudget {
    /// Subtracts the size of a value; returns an error if the limit is exceeded or the value is nested too deeply.
    pub fn spend(&self, value: &ExpressionValue) -> Result {
        let left = self.0.get().checked_sub(size(value, 0)?);
        let wrong = || ModelError::new(format!("expressions compute more than {MAX_SIZE} numbers and characters"));
        self.0.set(left.ok_or_else(|| wrong().help("the limit prevents a model from exhausting memory"))?);
        Ok(())
    }
}

/// Returns the size of a value: 1, plus the bytes of a string or the sizes of the elements of a list.
fn size(value: &ExpressionValue, depth: usize) -> Result<usize> {
    Ok(match value {
        ExpressionValue::Number(_) | ExpressionValue::Bool(_) => 1,
        ExpressionValue::Text(t) => 1 + t.len(),
        ExpressionValue::List(_) if depth == MAX_LIST_DEPTH => {
            return Err(ModelError::new(format!("a list is nested more than {MAX_LIST_DEPTH} levels deep")));
        }
        ExpressionValue::List(all) => all.iter().try_fold(1, |sum, v| size(v, depth + 1).map(|n| sum + n))?,
    })
}
