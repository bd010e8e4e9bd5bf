//! Converts between solver methods and results and the numbers that represent them in scripts.

use tatu_kinematics::{IkMethod, IkResult};

/// Damping of the method "pseudo-inverse", which keeps its steps finite at singular positions. The value is an
/// estimate, because V-REP's own damping is not published. Steps differ from those without damping by less than 1e-6.
pub const BUILT_IN_DAMPING: f64 = 1e-4;
/// Maximum number of iterations of a group.
pub const MAX_ITERATIONS: u32 = 10_000;

/// Returns the method that a number represents in scripts, and its damping. Unknown numbers yield the pseudo-inverse.
pub fn method(number: i64, damping: f64) -> (IkMethod, f64) {
    match number {
        1 => (IkMethod::DampedLeastSquares, if damping.is_finite() { damping.abs() } else { 0.1 }),
        2 => (IkMethod::JacobianTranspose, 0.0),
        3 => (IkMethod::PseudoInverse, 0.0),
        _ => (IkMethod::DampedLeastSquares, BUILT_IN_DAMPING),
    }
}

/// Returns the number that represents a result in scripts.
pub fn result_number(result: IkResult) -> i64 {
    match result {
        IkResult::NotPerformed => 0,
        IkResult::Success => 1,
        IkResult::Fail => 2,
    }
}
