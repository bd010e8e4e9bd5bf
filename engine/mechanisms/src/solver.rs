//! A time step of one tree, under drives, springs, friction and limits.

use nalgebra::Vector3;

use crate::{
    drive::TreeDrives,
    error::DynamicsError,
    fast_turns::FastTurns,
    pivot::PivotStats,
    state::TreeState,
    step::{JointEfforts, TreeStep},
    tree::Tree,
};

/// The integration scheme of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum IntegrationScheme {
    /// Implicit midpoint rule: forces are evaluated at the mean pose and the mean velocities. Poses are computed twice,
    /// forces three times.
    #[default]
    Midpoint,
    /// Forces are evaluated at the pose after half a step at the old velocities. Poses are computed once, forces twice.
    /// Compared with the midpoint rule, this needs 60 % of the time, and has 5 to 20 times the energy error.
    Leapfrog,
}

/// Statistics of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepReport {
    /// Number of linear solves: 3 ([`IntegrationScheme::Leapfrog`]: 2) if every guess was correct, or 1 if, in
    /// addition, velocities hardly changed.
    pub solutions: usize,
    /// Whether the laws of all drives, friction and limits were satisfied. If not, the forces of this step are within
    /// their bounds, but a drive may have missed its target, or a joint may have lost momentum at a limit.
    pub satisfied: bool,
}

/// Change of velocities in a step, m/s or rad/s, below which bias forces and poses are not recomputed: they would change
/// the velocities by less than a thousandth of it.
const STEADY_VELOCITY_CHANGE: f64 = 1e-9;

/// Simulates a tree. Owns all memory that a step needs; only [`new`](Self::new) allocates.
///
/// The result of a step depends only on its arguments, not on previous steps.
#[derive(Debug, Clone)]
pub struct TreeSolver {
    scheme: IntegrationScheme,
    pub(crate) step: TreeStep,
}

impl TreeSolver {
    /// Creates a solver for a tree, with the default scheme.
    pub fn new(tree: &Tree) -> Self {
        Self::with_scheme(tree, IntegrationScheme::default())
    }

    /// Creates a solver for a tree, with the given scheme.
    pub fn with_scheme(tree: &Tree, scheme: IntegrationScheme) -> Self {
        TreeSolver { scheme, step: TreeStep::new(tree) }
    }

    /// Sets the treatment of joints and free links that turn fast; [`FastTurns::Ignore`] by default.
    pub fn set_fast_turns(&mut self, fast_turns: FastTurns) {
        self.step.fast_turns = fast_turns;
    }

    /// Advances a state by a time `h`, s, under gravity, m/s². Complexity: that of forward dynamics per linear solve.
    ///
    /// The scheme's equation is iterated a fixed number of times, starting from the old velocities; errors are of the
    /// order h².
    ///
    /// # Errors
    ///
    /// Fails if the size of an argument does not match the tree, a value is not finite, a drive or spring is invalid,
    /// the mass matrix is singular, `h` is not positive, or the result would not be finite. The state is then
    /// unchanged.
    pub fn step(
        &mut self,
        state: &mut TreeState,
        tree: &Tree,
        drives: &TreeDrives,
        gravity: Vector3<f64>,
        h: f64,
    ) -> Result<StepReport, DynamicsError> {
        check_step(gravity, h)?;
        let step = &mut self.step;
        step.check(tree, state, drives)?;
        step.contact.fill(0.0);
        let gravity = gravity.into();
        step.begin(tree, state, h);
        step.set_laws(tree, state, drives, h, None);
        step.guess(tree, &state.v, gravity, h);
        let mut search = step.solve(tree, &state.v, h)?;
        // If velocities hardly change, further iterations would yield nearly the same result.
        step.store_velocities();
        if step.max_velocity_change(&state.v) > STEADY_VELOCITY_CHANGE {
            step.use_mean_velocities(tree, &state.v, gravity);
            search = search.and(step.solve(tree, &state.v, h)?);
        }
        step.store_velocities();
        if step.max_velocity_change(&state.v) > STEADY_VELOCITY_CHANGE && self.scheme == IntegrationScheme::Midpoint {
            step.use_mean_poses(tree, state, gravity, h);
            search = search.and(step.solve(tree, &state.v, h)?);
        }
        step.check_convergence(tree, h)?;
        step.conclude(tree, state, h, search.satisfied)?;
        step.finish(tree, h);
        step.limit(tree, state, h)?;
        if step.fast_turns == FastTurns::LimitEnergy {
            let balance = step.balance(tree, state, gravity, h);
            step.slow_down(balance);
        }
        step.commit(state);
        let PivotStats { solutions, satisfied: met } = search;
        Ok(StepReport { solutions, satisfied: met })
    }

    /// Returns the forces of the last step.
    pub fn efforts(&self) -> &JointEfforts {
        &self.step.efforts
    }

    /// Returns the mean power of all drives in the last step, W.
    pub fn drive_power(&self) -> f64 {
        self.step.drive_power
    }

    /// Returns the accelerations of the last step, rad/s² or m/s²: the changes of velocity, including impacts at
    /// limits, divided by the duration.
    pub fn accelerations(&self) -> &[f64] {
        &self.step.pivot.accelerations
    }
}

/// Returns an error if gravity is not finite, or the duration of a step is not positive and finite.
pub(crate) fn check_step(gravity: Vector3<f64>, h: f64) -> Result<(), DynamicsError> {
    if !gravity.iter().all(|x| x.is_finite()) {
        return Err(DynamicsError::NotFinite { what: "gravity" });
    }
    if h > 0.0 && h.is_finite() { Ok(()) } else { Err(DynamicsError::Step { h }) }
}

#[cfg(test)]
#[path = "solver_tests.rs"]
mod tests;
