//! One tree of a group.

use crate::{drive::Drives, solver::Solver, state::State, tree::Tree};

/// One tree of a group, and all that a step of it needs.
#[derive(Debug)]
pub struct Member<'a> {
    /// Its links.
    pub tree: &'a Tree,
    /// Positions and velocities.
    pub state: &'a mut State,
    /// What acts on its joints.
    pub drives: &'a Drives,
    /// Room for the step, made for the tree.
    pub solver: &'a mut Solver,
    /// Efforts of its drives, Nm or N: in the step before, then in this one. One for each velocity.
    pub carried: &'a mut [f64],
}
