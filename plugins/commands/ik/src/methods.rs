//! Methods of calculation, and results, by their numbers for scripts.

use tatu_kinematics::{IkMethod, IkResult};

/// Damping of the method "pseudo-inverse", which keeps its steps finite at singular positions. An estimate: the original
/// has a small one of unknown size; with this one, the steps differ from those without damping by less than 1e-6.
pub const BUILT_IN_DAMPING: f64 = 1e-4;
/// Maximum number of iterations of a group.
pub const MAX_ITERATIONS: u32 = 10_000;

/// Returns the method with a number of scripts, and its damping. Unknown numbers mean the pseudo-inverse.
pub fn method(number: i64, damping: f64) -> (IkMethod, f64) {
    match number {
        1 => (IkMethod::DampedLeastSquares, if damping.is_finite() { damping.abs() } else { 0.1 }),
        2 => (IkMethod::JacobianTranspose, 0.0),
        3 => (IkMethod::PseudoInverse, 0.0),
        _ => (IkMethod::DampedLeastSquares, BUILT_IN_DAMPING),
    }
}

/// Returns the number of a result for scripts.
pub fn result_number(result: IkResult) -> i64 {
    match result {
        IkResult::NotPerformed => 0,
        IkResult::Success => 1,
        IkResult::Fail => 2,
    }
}
