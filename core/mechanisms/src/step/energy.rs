//! What keeps a step from adding energy: the convergence of forces of gyration, and corrections of positions.

use super::Step;
use crate::{error::DynamicsError, tree::Tree};

/// Corrections of positions by less than this, m or rad, hardly change the inertia; those of a contact at rest are of
/// the order of 1e-6.
const SMALL_CORRECTION: f64 = 1e-4;
/// Turn in a step, rad, above which it is checked whether forces of gyration have converged.
const CONSIDERABLE_TURN: f64 = 0.02;
/// Change of the velocities by the last iteration, relative to the velocities and weighted by inertia, above which a
/// step is too long. The error that is left is smaller by about the ratio of the last two changes.
const CONVERGED: f64 = 1e-3;

impl Step {
    /// Stores the velocities that an iteration has found, for [`check_convergence`](Self::check_convergence).
    pub fn remember(&mut self) {
        self.previous.copy_from_slice(&self.pivot.ends);
    }

    /// Returns an error if steps that turn too far may fail, links turn considerably, and the energy of the change by
    /// the last iteration is not small.
    pub fn check_convergence(&mut self, tree: &Tree, h: f64) -> Result<(), DynamicsError> {
        if self.max_turn == f64::INFINITY {
            return Ok(());
        }
        let turns = self.pivot.ends.iter().map(|v| v.abs() * h).zip(&tree.dofs).enumerate();
        let fast = turns.into_iter().find(|(_, (turn, dof))| dof.angular && *turn > CONSIDERABLE_TURN);
        let Some((dof, (turn, _))) = fast else { return Ok(()) };
        for (change, end) in self.previous.iter_mut().zip(&self.pivot.ends) {
            *change -= end;
        }
        let changed = self.mass.product(tree, &self.previous, &mut self.middle);
        let energy = self.mass.product(tree, &self.pivot.ends, &mut self.middle);
        if changed <= CONVERGED * CONVERGED * energy { Ok(()) } else { Err(DynamicsError::TooFast { dof, turn }) }
    }

    /// Reduces the velocities if corrections of the positions would otherwise have increased the kinetic energy: at the
    /// same velocities of its joints, a mechanism has more of it in a pose with more inertia.
    pub fn keep_energy(&mut self, tree: &Tree) {
        let moved = self.q.iter().zip(&self.uncorrected).any(|(q, old)| (q - old).abs() > SMALL_CORRECTION);
        if !moved {
            return;
        }
        self.place.copy_from_slice(&self.uncorrected);
        let old = self.kinetic_energy(tree);
        self.place.copy_from_slice(&self.q);
        let new = self.kinetic_energy(tree);
        if new > old {
            let share = (old / new).sqrt();
            self.pivot.ends.iter_mut().for_each(|v| *v *= share);
        }
    }

    /// Returns the kinetic energy at the positions in `place` and the velocities at the end of the step, J.
    fn kinetic_energy(&mut self, tree: &Tree) -> f64 {
        self.set_poses(tree);
        0.5 * self.mass.product(tree, &self.pivot.ends, &mut self.middle)
    }
}
