//! A step of time of one tree: positions and velocities a step later, under drives, springs, friction and limits.

use nalgebra::Vector3;

use crate::{
    drive::Drives,
    error::DynamicsError,
    pivot::Search,
    state::State,
    step::{Efforts, Step},
    tree::Tree,
};

/// How the equation of a step is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scheme {
    /// Implicit midpoint rule: forces of the mean pose and the mean velocities. Poses are computed twice, forces three
    /// times.
    #[default]
    Midpoint,
    /// Forces of the pose that half a step at the old velocities leads to. Poses are computed once, forces twice: six
    /// tenths of the time, five to twenty times the error of the energy.
    Leapfrog,
}

/// How a step went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Report {
    /// Linear systems that were solved: 3 (2 by [`Scheme::Leapfrog`]) if every guess was right, 1 if moreover no
    /// velocity changed.
    pub solutions: usize,
    /// Whether all drives, friction and limits were met. If not, the forces of this step are allowed ones, but a drive
    /// may have missed its target, or a joint lost momentum at a limit.
    pub met: bool,
}

/// Moves trees through time. Owns all room that a step needs; only [`new`](Self::new) allocates.
///
/// A step depends on its arguments only, not on the steps before.
#[derive(Debug, Clone)]
pub struct Solver {
    scheme: Scheme,
    pub(crate) step: Step,
}

impl Solver {
    /// Makes room for a tree.
    pub fn new(tree: &Tree) -> Self {
        Self::with_scheme(tree, Scheme::default())
    }

    /// Makes room for a tree, to move it by another scheme.
    pub fn with_scheme(tree: &Tree, scheme: Scheme) -> Self {
        Solver { scheme, step: Step::new(tree) }
    }

    /// Moves a state by a time `h`, s, under gravity, m/s². Time: as forward dynamics, for each linear system solved.
    ///
    /// The scheme's equation is iterated a fixed number of times, beginning from the old velocities; errors are of the
    /// order h².
    ///
    /// # Errors
    ///
    /// A list belongs to another tree, a number is not finite, a drive makes no sense, the mass matrix is singular, or
    /// the result would not be finite. The state then is as before.
    pub fn step(
        &mut self,
        state: &mut State,
        tree: &Tree,
        drives: &Drives,
        gravity: Vector3<f64>,
        h: f64,
    ) -> Result<Report, DynamicsError> {
        check_step(gravity, h)?;
        let step = &mut self.step;
        step.check(tree, state, drives)?;
        step.contact.fill(0.0);
        let gravity = gravity.into();
        step.begin(tree, state, drives, h, None);
        step.guess(tree, &state.v, gravity, h);
        let mut search = step.solve(tree, &state.v, h)?;
        // if no velocity changes, further iterations would repeat the first
        if step.pivot.ends != state.v {
            step.take_mean_velocities(tree, &state.v, gravity);
            search = search.and(step.solve(tree, &state.v, h)?);
        }
        if step.pivot.ends != state.v && self.scheme == Scheme::Midpoint {
            step.take_mean_poses(tree, state, gravity, h);
            search = search.and(step.solve(tree, &state.v, h)?);
        }
        step.finish(tree, state, h, search.met)?;
        step.limit(tree, state, h)?;
        step.commit(state);
        let Search { solutions, met } = search;
        Ok(Report { solutions, met })
    }

    /// Returns the forces of the last step.
    pub fn efforts(&self) -> &Efforts {
        &self.step.efforts
    }

    /// Returns the accelerations of the last step, rad/s² or m/s²: change of velocity over time, jolts included.
    pub fn accelerations(&self) -> &[f64] {
        &self.step.pivot.accelerations
    }
}

/// Refuses a gravity and a length of a step that make no sense.
pub(crate) fn check_step(gravity: Vector3<f64>, h: f64) -> Result<(), DynamicsError> {
    if !gravity.iter().all(|x| x.is_finite()) {
        return Err(DynamicsError::NotFinite { what: "gravity" });
    }
    if h > 0.0 && h.is_finite() { Ok(()) } else { Err(DynamicsError::Step { h }) }
}

#[cfg(test)]
#[path = "solver_tests.rs"]
mod tests;
