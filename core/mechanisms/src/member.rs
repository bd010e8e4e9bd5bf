//! A member of a group.

use crate::{drive::Drives, solver::Solver, state::State, tree::Tree};

/// One tree of a group, with the data that its step reads and writes.
#[derive(Debug)]
pub struct Member<'a> {
    /// The links and joints.
    pub tree: &'a Tree,
    /// Positions and velocities.
    pub state: &'a mut State,
    /// Drives, springs and forces on the joints.
    pub drives: &'a Drives,
    /// The solver, which must have been created for the tree.
    pub solver: &'a mut Solver,
    /// Efforts of the drives, Nm or N, one per velocity. As an input, those of the previous step; as an output, those
    /// of this step.
    pub carried: &'a mut [f64],
}
