//! A tree of an island.

use crate::{drive::TreeDrives, solver::TreeSolver, state::TreeState, tree::Tree};

/// One tree of an island, with the data that its step reads and writes.
#[derive(Debug)]
pub struct IslandTree<'a> {
    /// The links and joints.
    pub tree: &'a Tree,
    /// Positions and velocities.
    pub state: &'a mut TreeState,
    /// Drives, springs and forces on the joints.
    pub drives: &'a TreeDrives,
    /// The solver, which must have been created for the tree.
    pub solver: &'a mut TreeSolver,
    /// Efforts of the drives, Nm or N, one per axis. As an input, those of the previous step; as an output, those
    /// of this step.
    pub carried: &'a mut [f64],
}
