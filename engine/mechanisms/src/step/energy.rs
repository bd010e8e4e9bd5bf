//! Measures that prevent a step from adding energy: a check that gyroscopic forces have converged, and compensation for
//! corrections of positions.

use super::TreeStep;
use crate::{error::DynamicsError, fast_turns::FastTurns, state::TreeState, tree::Tree, vector::Vec3};

/// Corrections of positions by less than this, m or rad, hardly change the inertia; those of a contact at rest are of
/// the order of 1e-6.
const SMALL_CORRECTION: f64 = 1e-4;
/// Turn in a step, rad, above which it is checked whether gyroscopic forces have converged.
const CONSIDERABLE_TURN: f64 = 0.02;
/// Change of the velocities by the last iteration, relative to the velocities and weighted by inertia, above which a
/// step is too long. The remaining error is smaller than this change by about the ratio of the last two changes.
const CONVERGENCE_TOLERANCE: f64 = 1e-3;

/// The kinetic energy of one or several trees, and its upper bound, J.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct EnergyBalance {
    pub energy: f64,
    pub allowed: f64,
}

impl TreeStep {
    /// Stores the velocities that an iteration has found, for [`check_convergence`](Self::check_convergence).
    pub fn store_velocities(&mut self) {
        self.previous.copy_from_slice(&self.pivot.ends);
    }

    /// Returns an error if fast turns must fail, links turn considerably, and the energy of the change that the last
    /// iteration made is not small.
    pub fn check_convergence(&mut self, tree: &Tree, h: f64) -> Result<(), DynamicsError> {
        if !matches!(self.fast_turns, FastTurns::Fail { .. }) {
            return Ok(());
        }
        let turns = self.pivot.ends.iter().map(|v| v.abs() * h).zip(&tree.dofs).enumerate();
        let mut turns = turns.map(|(d, (turn, dof))| (d, turn * dof.turning));
        let Some((dof, turn)) = turns.find(|(_, turn)| *turn > CONSIDERABLE_TURN) else { return Ok(()) };
        for (change, end) in self.previous.iter_mut().zip(&self.pivot.ends) {
            *change -= end;
        }
        let changed = self.mass.product(tree, &self.previous, &mut self.middle);
        let energy = self.mass.product(tree, &self.pivot.ends, &mut self.middle);
        if changed <= CONVERGENCE_TOLERANCE * CONVERGENCE_TOLERANCE * energy {
            Ok(())
        } else {
            Err(DynamicsError::TooFast { dof, turn })
        }
    }

    /// Reduces the velocities if corrections of the positions would otherwise have increased the kinetic energy: at the
    /// same joint velocities, a mechanism has more kinetic energy in a pose with more inertia.
    pub fn limit_corrected_energy(&mut self, tree: &Tree) {
        let moved = self.q.iter().zip(&self.uncorrected).any(|(q, old)| (q - old).abs() > SMALL_CORRECTION);
        if !moved {
            return;
        }
        self.place.copy_from_slice(&self.uncorrected);
        let allowed = self.kinetic_energy(tree);
        self.place.copy_from_slice(&self.q);
        let energy = self.kinetic_energy(tree);
        self.slow_down(EnergyBalance { energy, allowed });
    }

    /// Reduces the velocities at the end of the step if the kinetic energy exceeds its upper bound.
    pub fn slow_down(&mut self, EnergyBalance { energy, allowed }: EnergyBalance) {
        if energy > allowed {
            let share = (allowed.max(0.0) / energy).sqrt();
            self.pivot.ends.iter_mut().for_each(|v| *v *= share);
        }
    }

    /// Returns the kinetic energy at the end of the step, and its upper bound, for which the state before the step,
    /// gravity, drives, springs and external forces account.
    pub fn balance(&mut self, tree: &Tree, state: &TreeState, gravity: Vec3, h: f64) -> EnergyBalance {
        self.place.copy_from_slice(&state.q);
        self.set_poses(tree);
        let before =
            0.5 * self.mass.product(tree, &state.v, &mut self.middle) + self.kinematics.potential_energy(gravity);
        self.place.copy_from_slice(&self.q);
        let energy = self.kinetic_energy(tree);
        let means = state.v.iter().zip(&self.pivot.ends).map(|(v, end)| (0.5 * (v + end), *end));
        let power: f64 = means.zip(&self.passive).map(|((v, end), (at, slope))| v * (at - slope * end)).sum();
        let work = h * (self.drive_power + power);
        EnergyBalance { energy, allowed: before - self.kinematics.potential_energy(gravity) + work }
    }

    /// Returns the kinetic energy at the positions in `place` and the velocities at the end of the step, J.
    fn kinetic_energy(&mut self, tree: &Tree) -> f64 {
        self.set_poses(tree);
        0.5 * self.mass.product(tree, &self.pivot.ends, &mut self.middle)
    }
}
