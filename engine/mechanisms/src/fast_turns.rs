//! What a step does about fast turns.

/// What a step does if a joint or a free link turns so fast that forces of gyration, which are evaluated at means of
/// poses and velocities, would add energy.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum FastTurns {
    /// Nothing.
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
