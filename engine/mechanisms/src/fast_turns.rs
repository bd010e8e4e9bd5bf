//! The treatment of fast turns in a step.

/// The treatment of joints and free links that turn so fast that gyroscopic forces, which are evaluated at mean poses
/// and velocities, would add energy.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum FastTurns {
    /// Fast turns are ignored, so the energy may increase.
    #[default]
    Ignore,
    /// Fails with [`DynamicsError::TooFast`](crate::DynamicsError::TooFast), so that the step can be repeated in parts,
    /// if a link turns by more than `max_turn`, rad, or if the iterations of the step have not converged while a link
    /// turns by more than 0.02 rad.
    Fail {
        /// Maximum turn, rad, at the greater of the velocities before and after the step.
        max_turn: f64,
    },
    /// Reduces the velocities of all trees until the kinetic energy does not exceed what the state before the step,
    /// gravity, drives, springs, external forces and moving objects account for: the last resort for steps that cannot
    /// be divided further. Costs two additional computations of poses and mass matrix.
    LimitEnergy,
}
