//! Reads and returns matrices, which scripts pass as a list of elements, row by row, and a number of rows.

use tatu_plugin_api::safe::{Command, Fail, Param, Result, SharedCall};

use crate::decompositions::Matrix;

/// The plugin; it has no state.
pub struct Linalg;

/// A command of this plugin.
pub type Cmd = Command<Linalg>;
/// A call of one of this plugin's commands, which may run in parallel with others.
pub type SharedCtx<'a> = SharedCall<'a, Linalg>;

/// Maximum number of elements of a matrix. The time for a decomposition grows with this number to the power of 1.5.
const MAX_ELEMENTS: usize = 250_000;

/// Declares the parameter with the elements of a matrix.
pub fn matrix(key: &str) -> Param {
    Param::floats(key, 0).text("its elements, row by row")
}

/// Declares the parameter with the number of rows of a matrix.
pub fn rows(key: &str) -> Param {
    Param::int(key).text("its number of rows")
}

/// Reads a matrix: argument `i` contains its elements, row by row, and the argument after it its number of rows.
pub fn matrix_argument(c: &SharedCtx<'_>, i: usize) -> Result<Matrix> {
    let wrong = |what: &str| Fail::argument(format!("argument {}: {what}", i + 1));
    let numbers = c.arg(i).numbers().ok_or_else(|| wrong("expected the elements of a matrix, a list of numbers"))?;
    if numbers.len() > MAX_ELEMENTS {
        return Err(wrong(&format!(
            "a matrix can have at most {MAX_ELEMENTS} elements, but this one has {}",
            numbers.len()
        )));
    }
    if !numbers.iter().all(|x| x.is_finite()) {
        return Err(wrong("the elements of a matrix must be finite"));
    }
    let rows = usize::try_from(c.i64(i + 1)?).unwrap_or(0);
    if rows == 0 || numbers.is_empty() || !numbers.len().is_multiple_of(rows) {
        return Err(wrong(&format!("{} elements cannot form a matrix with {rows} rows", numbers.len())));
    }
    Ok(Matrix::from_row_slice(rows, numbers.len() / rows, &numbers))
}

/// Sets the result of a call to the elements of a matrix, row by row. Returns an error if an element is not finite.
pub fn return_matrix(c: &mut SharedCtx<'_>, m: &Matrix) -> Result {
    let by_rows = m.transpose();
    if !by_rows.iter().all(|x| x.is_finite()) {
        return Err(Fail::argument("the result overflows: it has an element that is not finite"));
    }
    c.ret(by_rows.as_slice());
    Ok(())
}
