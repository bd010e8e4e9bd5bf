//! Reduction of contact impulses that violate the laws of the contacts. Such impulses occur if the search ends before
//! it has converged, or if joints change the pieces of their laws afterwards. Without the reduction, they would fling
//! light links, and each step would start with the impulses of the previous one.

use super::{Island, MAX_ROUNDS, VELOCITY_TOLERANCE};
use crate::{
    contact::ContactPoint,
    error::IslandError,
    fast_turns::FastTurns,
    island_tree::IslandTree,
    jacobian::ContactRows,
    step::EnergyBalance,
    vector::{Vec3, dot},
};

/// Energy that impulses may add due to rounding errors, relative to the total effect of the impulses.
const ENERGY_TOLERANCE: f64 = 1e-9;

impl Island {
    /// Removes impulses that were computed for drives that hold, but exceed the bounds of the drives and have therefore
    /// moved the joints to their limits. From then on, contacts of these members are solved as if their drives yielded.
    /// Returns whether there were any such impulses.
    pub(super) fn drop_excess(&mut self, h: f64) -> bool {
        let mut any = false;
        for (point, impulse) in self.rows.points.iter().zip(&mut self.impulses) {
            if point.normal == 0.0 && impulse[0] > 0.0 && point.start[0] > point.min_velocity(h) + VELOCITY_TOLERANCE {
                *impulse = [0.0; 3];
                point.halves.iter().flatten().for_each(|half| self.yielding[half.member] = true);
                any = true;
            }
        }
        any
    }

    /// Returns whether there is an impulse at a contact that cannot move, because of the joints. The law of such a
    /// contact has not been checked.
    pub(super) fn is_stuck(&self) -> bool {
        self.rows.points.iter().zip(&self.impulses).any(|(point, l)| point.normal == 0.0 && l[0] > 0.0)
    }

    /// Reduces impulses that do not satisfy the laws of the contacts until they dissipate energy, as contacts always
    /// do. Otherwise, impulses that were computed for a joint at its limit could fling the same joint when it is free,
    /// and the next step would start with them. Returns whether all laws of the joints are satisfied.
    pub(super) fn dissipate(
        &mut self,
        members: &mut [IslandTree<'_>],
        contacts: &[ContactPoint],
        h: f64,
    ) -> Result<bool, IslandError> {
        for attempt in 1..=MAX_ROUNDS {
            let share = self.dissipative_share(members, contacts);
            if share >= 1.0 {
                break;
            }
            let share = if attempt == MAX_ROUNDS { 0.0 } else { share };
            self.impulses.iter_mut().flatten().for_each(|l| *l *= share);
            self.apply_impulses(members, h);
            self.solve_joints(members, h)?;
        }
        Ok(self.satisfied.iter().all(|met| *met))
    }

    /// Reduces impulses like [`dissipate`](Self::dissipate) after the velocities have been computed, and the velocities
    /// by their effect.
    pub(super) fn dissipate_velocities(&mut self, members: &mut [IslandTree<'_>], contacts: &[ContactPoint]) {
        let share = self.dissipative_share(members, contacts);
        if share >= 1.0 {
            return;
        }
        self.apply_all_impulses(share - 1.0);
        self.impulses.iter_mut().flatten().for_each(|l| *l *= share);
        for (m, offset) in members.iter_mut().zip(&self.rows.offsets) {
            let pivot = &mut m.solver.step.pivot;
            self.velocities.clear();
            self.velocities.extend_from_slice(&self.rows.z[*offset..][..m.tree.velocities()]);
            pivot.factor.finish(m.tree, &mut self.velocities);
            pivot.ends.iter_mut().zip(&self.velocities).for_each(|(end, change)| *end += change);
        }
    }

    /// Returns the fraction of the impulses, at most 1, at which they dissipate energy.
    ///
    /// The velocities at the end of a step under the laws of joints and contacts satisfy a variational inequality. As
    /// bodies at rest satisfy all contacts, it implies that the impulses times these velocities are at most 0, except
    /// for what bouncing contacts return.
    fn dissipative_share(&mut self, members: &[IslandTree<'_>], contacts: &[ContactPoint]) -> f64 {
        self.refresh_rows(members);
        self.rows.read_velocities(members);
        self.apply_all_impulses(1.0);
        // With impulses l, W l their effect, and v the velocities with them, a share s gives l (v - (1 - s) W l).
        let (mut effect, mut given) = (0.0, 0.0);
        for (i, (contact, point)) in contacts.iter().zip(&self.rows.points).enumerate() {
            let back = if self.bounces[i] { -contact.restitution * point.approach } else { 0.0 };
            let slide = |row: usize| dot(point.axes[row], contact.slide.into());
            for (row, target) in [back, slide(1), slide(2)].into_iter().enumerate() {
                effect += self.impulses[i][row] * self.rows.velocity_change(point, row);
                given += self.impulses[i][row] * (point.start[row] - target);
            }
        }
        self.rows.z.fill(0.0);
        if given <= ENERGY_TOLERANCE * effect { 1.0 } else { (1.0 - given / effect).clamp(0.0, 1.0) }
    }

    /// Reduces the velocities of all members if [`FastTurns::LimitEnergy`] requires this. Contacts transfer energy
    /// between members, and add only the energy of moving objects and surfaces.
    pub(super) fn limit_energy(
        &self,
        members: &mut [IslandTree<'_>],
        contacts: &[ContactPoint],
        gravity: Vec3,
        h: f64,
    ) {
        if !members.iter().any(|m| m.solver.step.fast_turns == FastTurns::LimitEnergy) {
            return;
        }
        let mut sum = EnergyBalance::default();
        for m in members.iter_mut() {
            let balance = m.solver.step.balance(m.tree, m.state, gravity, h);
            (sum.energy, sum.allowed) = (sum.energy + balance.energy, sum.allowed + balance.allowed);
        }
        let given = |((contact, point), impulse): ((&ContactPoint, &ContactRows), &Vec3)| -> f64 {
            let moving = |row: usize| if row > 0 { dot(point.axes[row], contact.slide.into()) } else { 0.0 };
            (0..3).map(|row| impulse[row] * (moving(row) - point.drift[row])).sum()
        };
        sum.allowed += contacts.iter().zip(&self.rows.points).zip(&self.impulses).map(given).sum::<f64>();
        members.iter_mut().for_each(|m| m.solver.step.slow_down(sum));
    }

    /// Applies a multiple of all impulses to `z`.
    fn apply_all_impulses(&mut self, multiple: f64) {
        for (i, impulse) in self.impulses.iter().enumerate() {
            for (row, impulse) in impulse.iter().enumerate().filter(|(_, l)| **l != 0.0) {
                self.rows.apply_impulse(i, row, multiple * impulse);
            }
        }
    }
}
