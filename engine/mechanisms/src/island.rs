//! Simulation of trees that touch each other or other bodies.

mod excess;
mod guided;
mod sweeps;

use nalgebra::Vector3;

use crate::{
    contact::{ContactPoint, ContactSide, MAX_RECOVERY_SPEED},
    error::{DynamicsError, IslandError},
    island_tree::IslandTree,
    jacobian::{ContactJacobian, ContactRows},
    law::LawPiece,
    resting::{RestingOutcome, RestingSolver},
    solver::check_step,
    state::advance,
    vector::{Vec3, add, dot, scale},
};

/// Maximum number of rounds, in each of which first the joints and then the contacts are solved.
const MAX_ROUNDS: usize = 8;
/// Maximum number of sweeps over all contacts in a round.
const MAX_SWEEPS: usize = 32;
/// Tolerance of the sweeps, m/s: they have converged if no impulse changes the velocity of its contact by more.
const SWEEP_TOLERANCE: f64 = 1e-11;
/// Change of velocities in a step, m/s or rad/s, below which bias forces are not recomputed, because that would change
/// the velocities by only a thousandth of this value. Also the speed, m/s, by which a contact may fall short of its
/// minimum velocity before immovable joints are released.
const VELOCITY_TOLERANCE: f64 = 1e-7;
/// Impact speed below which bodies do not bounce, m/s.
const MIN_BOUNCE_SPEED: f64 = 0.01;

/// Statistics of a step of an island.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct IslandReport {
    /// Number of rounds, in each of which first the joints and then the contacts are solved. If the equations were
    /// solved a second time with updated bias forces, this is the greater of the two counts.
    pub rounds: usize,
    /// Total number of sweeps over all contacts.
    pub sweeps: usize,
    /// Whether the laws of all joints and contacts were satisfied simultaneously. If not, all forces are within their
    /// bounds, but some bodies may have approached each other more than allowed.
    pub satisfied: bool,
}

/// Simulates trees that touch. Owns the memory that a step needs in addition to that of its trees.
///
/// The result of a step depends only on its arguments, not on previous steps.
#[derive(Debug, Clone, Default)]
pub struct Island {
    rows: ContactJacobian,
    /// Impulses along the rows of each contact, N s.
    impulses: Vec<Vec3>,
    /// For each tree, whether its last solution satisfies all its laws.
    satisfied: Vec<bool>,
    /// Whether each contact bounces in this step.
    bounces: Vec<bool>,
    /// Desired separation speed of each contact, m/s; 0 unless the bodies overlap.
    speeds: Vec<f64>,
    /// For each tree, the sequence number of the factorisation from which its rows were computed.
    factorizations: Vec<u64>,
    /// For each velocity of each tree, the piece of its law that was selected in the previous round.
    pieces: Vec<LawPiece>,
    velocities: Vec<f64>,
    /// Velocities of all rows in the sweeps, m/s; empty if the responses of the rows to each other are unknown.
    row_velocities: Vec<f64>,
    resting: RestingSolver,
    /// For each tree, whether contacts are solved as if its drives yielded.
    yielding: Vec<bool>,
}

impl Island {
    /// Creates an empty island, which allocates memory as trees and contacts are added.
    pub fn new() -> Self {
        Island::default()
    }

    /// Advances all members by a time `h`, s, under gravity, m/s². Forces are evaluated at the pose after half a step
    /// at the old velocities, and at the mean of old and new velocities. Contacts are rigid, with Coulomb friction;
    /// overlaps are removed by position changes only, which add no momentum.
    ///
    /// Joints and contacts are solved alternately: first all joints exactly, under the current contact forces, and then
    /// all contacts, with the current compliance of the joints: directly if they rest, otherwise by Gauss-Seidel
    /// sweeps. One round suffices unless a joint changes between holding and yielding. Complexity: that of the step of
    /// each tree, plus the depth of each contact per sweep.
    ///
    /// # Errors
    ///
    /// Fails like [`TreeSolver::step`](crate::TreeSolver::step), with the index of the member. Fails if `carried` of a
    /// member does not have one entry per axis, or a contact has an invalid value or refers to a link that does not
    /// exist. The states of the members are then unchanged.
    pub fn step(
        &mut self,
        members: &mut [IslandTree<'_>],
        contacts: &mut [ContactPoint],
        gravity: Vector3<f64>,
        h: f64,
    ) -> Result<IslandReport, IslandError> {
        check_step(gravity, h).map_err(|source| IslandError::Member { member: 0, source })?;
        check(members, contacts)?;
        for_each_tree(members, |m| m.solver.step.check(m.tree, m.state, m.drives))?;
        let gravity = gravity.into();
        for m in members.iter_mut() {
            m.solver.step.begin(m.tree, m.state, h);
        }
        self.rows.build(members, contacts, h);
        self.add_guided_friction(members, contacts, gravity);
        for m in members.iter_mut() {
            m.solver.step.set_laws(m.tree, m.state, m.drives, h, Some(m.carried));
        }
        self.warm_start(members, contacts, h);
        for m in members.iter_mut() {
            m.solver.step.guess(m.tree, &m.state.v, gravity, h);
        }
        let mut report = self.resolve(members, contacts, h)?;
        if members.iter().any(|m| m.solver.step.max_velocity_change(&m.state.v) > VELOCITY_TOLERANCE) {
            // In an impact, velocities jump in the middle of the step: the mean of the forces before and after it, not
            // the force at the mean velocity, preserves momentum.
            let pressed = contacts.iter().zip(&self.impulses);
            let impact = pressed.into_iter().any(|(c, l)| c.impulse == Vector3::zeros() && l[0] > 0.0);
            for m in members.iter_mut() {
                m.solver.step.store_velocities();
                match impact {
                    true => m.solver.step.use_mean_forces(m.tree, gravity),
                    false => m.solver.step.use_mean_velocities(m.tree, &m.state.v, gravity),
                }
            }
            let last = self.resolve(members, contacts, h)?;
            for_each_tree(members, |m| m.solver.step.check_convergence(m.tree, h))?;
            let (rounds, sweeps) = (report.rounds.max(last.rounds), report.sweeps + last.sweeps);
            report = IslandReport { rounds, sweeps, satisfied: last.satisfied };
        }
        for (i, member) in members.iter_mut().enumerate() {
            let concluded = member.solver.step.conclude(member.tree, member.state, h, self.satisfied[i]);
            concluded.map_err(|source| IslandError::Member { member: i, source })?;
        }
        if !report.satisfied {
            self.dissipate_velocities(members, contacts);
        }
        for m in members.iter_mut() {
            m.solver.step.finish(m.tree, h);
        }
        self.refresh_rows(members);
        self.separate_overlaps(members, contacts, h);
        for_each_tree(members, |m| m.solver.step.limit(m.tree, m.state, h))?;
        self.limit_energy(members, contacts, gravity, h);
        self.store_distances(contacts, h);
        for m in members.iter_mut() {
            m.solver.step.commit(m.state);
            m.carried.copy_from_slice(&m.solver.step.efforts.drive);
        }
        for (contact, (point, impulse)) in contacts.iter_mut().zip(self.rows.points.iter().zip(&self.impulses)) {
            contact.impulse = point.axes.iter().zip(impulse).map(|(axis, l)| Vector3::from(*axis) * *l).sum();
        }
        Ok(report)
    }

    /// Initialises the impulses with those of the previous step, and applies them to the members.
    fn warm_start(&mut self, members: &mut [IslandTree<'_>], contacts: &[ContactPoint], h: f64) {
        self.impulses.clear();
        self.bounces.clear();
        self.bounces.resize(contacts.len(), false);
        self.factorizations.clear();
        self.factorizations.resize(members.len(), 0);
        for (contact, point) in contacts.iter().zip(&self.rows.points) {
            let impulse = point.axes.map(|axis| dot(axis, contact.impulse.into()));
            self.impulses.push([impulse[0].max(0.0), impulse[1], impulse[2]]);
        }
        self.apply_impulses(members, h);
    }

    /// Sets the contact forces of the members to those of the current impulses.
    fn apply_impulses(&self, members: &mut [IslandTree<'_>], h: f64) {
        for m in members.iter_mut() {
            m.solver.step.contact.fill(0.0);
        }
        for (point, impulse) in self.rows.points.iter().zip(&self.impulses) {
            self.rows.add_forces(point, *impulse, h, members);
        }
    }

    /// Solves joints and contacts alternately until the solutions no longer affect each other, for at most
    /// [`MAX_ROUNDS`] rounds.
    fn resolve(
        &mut self,
        members: &mut [IslandTree<'_>],
        contacts: &[ContactPoint],
        h: f64,
    ) -> Result<IslandReport, IslandError> {
        self.pieces.clear();
        let mut sweeps = 0;
        let mut solved = true;
        self.yielding.clear();
        self.yielding.resize(members.len(), false);
        for round in 1..=MAX_ROUNDS {
            let met = self.solve_joints(members, h)?;
            // If no law has changed its piece, the impulses of the last sweeps still satisfy the contacts.
            let forms = std::mem::take(&mut self.pieces);
            let all = members.iter().flat_map(|m| m.solver.step.pivot.selected_pieces());
            self.pieces.extend(all);
            if self.pieces == forms {
                let met = if solved && !self.is_stuck() { met } else { self.dissipate(members, contacts, h)? };
                return Ok(IslandReport { rounds: round, sweeps, satisfied: met });
            }
            self.refresh_rows(members);
            self.rows.read_velocities(members);
            if self.drop_excess(h) {
                self.pieces.clear();
                self.apply_impulses(members, h);
                continue;
            }
            let released = self.free_stuck_trees(members, h);
            let alternates = round > MAX_ROUNDS / 2;
            let before = if alternates { self.impulses.clone() } else { Vec::new() };
            let (count, changed) = self.solve_contacts(contacts, h);
            // If a drive alternates between holding and yielding, the solution is between the two.
            for (new, old) in self.impulses.iter_mut().zip(&before) {
                *new = scale(add(*new, *old), 0.5);
            }
            sweeps += count;
            solved = count < MAX_SWEEPS && !released && !alternates;
            if !changed {
                return Ok(IslandReport { rounds: round, sweeps, satisfied: met });
            }
            self.apply_impulses(members, h);
        }
        self.solve_joints(members, h)?;
        self.dissipate(members, contacts, h)?;
        Ok(IslandReport { rounds: MAX_ROUNDS, sweeps, satisfied: false })
    }

    /// Solves all joints under the current contact forces; returns whether all laws are satisfied.
    fn solve_joints(&mut self, members: &mut [IslandTree<'_>], h: f64) -> Result<bool, IslandError> {
        self.satisfied.clear();
        let met = &mut self.satisfied;
        for_each_tree(members, |m| {
            met.push(m.solver.step.solve(m.tree, &m.state.v, h)?.satisfied);
            Ok(())
        })?;
        Ok(self.satisfied.iter().all(|met| *met))
    }

    /// Recomputes the rows of members whose matrix has been factorised again since their rows were computed.
    fn refresh_rows(&mut self, members: &[IslandTree<'_>]) {
        let mut renewed = false;
        for (i, member) in members.iter().enumerate() {
            let pivot = &member.solver.step.pivot;
            if std::mem::replace(&mut self.factorizations[i], pivot.factorizations) != pivot.factorizations {
                self.rows.factorize(&pivot.factor, members, i);
                renewed = true;
            }
        }
        if renewed {
            self.rows.update_responses();
        }
    }

    /// Allows contacts to push joints that are held by friction or a limit: if the bodies of a contact should separate
    /// but no joint can move, the rows of its trees are computed with all joints and drives free, so that an impulse is
    /// found. The next round decides which joints yield. Returns whether there were any such trees.
    fn free_stuck_trees(&mut self, members: &[IslandTree<'_>], h: f64) -> bool {
        let mut stuck: Vec<usize> = (0..members.len()).filter(|i| self.yielding[*i]).collect();
        for point in &self.rows.points {
            if point.normal == 0.0 && point.start[0] < point.min_velocity(h) - VELOCITY_TOLERANCE {
                stuck.extend(point.halves.iter().flatten().map(|half| half.member));
            }
        }
        stuck.sort_unstable();
        stuck.dedup();
        for &i in &stuck {
            let IslandTree { tree, solver, .. } = &members[i];
            let step = &solver.step;
            let free = vec![false; tree.velocities()];
            let mut factor = step.pivot.factor.clone();
            if factor.update(tree, &step.mass.entries, &step.damping(h), &free).is_ok() {
                self.rows.factorize(&factor, members, i);
                // Forces the rows to be recomputed in the next round.
                self.factorizations[i] = 0;
            }
        }
        if !stuck.is_empty() {
            self.rows.update_responses();
        }
        !stuck.is_empty()
    }

    /// Solves all contacts; returns the number of sweeps, and whether the impulses have changed any velocity.
    fn solve_contacts(&mut self, contacts: &[ContactPoint], h: f64) -> (usize, bool) {
        let bounces = |(contact, point): (&ContactPoint, &ContactRows)| {
            contact.restitution > 0.0 && point.approach < -MIN_BOUNCE_SPEED
        };
        if !RestingSolver::is_small_enough(&self.rows) || contacts.iter().zip(&self.rows.points).any(bounces) {
            self.resting.forget();
            return self.sweep(contacts, h);
        }
        let mut resting = std::mem::take(&mut self.resting);
        let outcome = resting.solve(&self.rows, contacts, &self.impulses, h, SWEEP_TOLERANCE);
        let moves =
            matches!(outcome, RestingOutcome::Rests) && resting.greatest_change(&self.impulses) > SWEEP_TOLERANCE;
        if !matches!(outcome, RestingOutcome::Fails) {
            for (i, impulse) in resting.impulses.iter().enumerate() {
                for (row, new) in impulse.iter().enumerate() {
                    self.rows.apply_impulse(i, row, new - self.impulses[i][row]);
                }
                self.impulses[i] = *impulse;
            }
        }
        self.resting = resting;
        match outcome {
            RestingOutcome::Rests => (0, moves),
            RestingOutcome::Slides => (self.sweep(contacts, h).0, true),
            RestingOutcome::Fails => self.sweep(contacts, h),
        }
    }

    /// Separates bodies that overlap at the end of the step, by position changes only.
    fn separate_overlaps(&mut self, members: &mut [IslandTree<'_>], contacts: &[ContactPoint], h: f64) {
        self.rows.read_velocities(members);
        let mut speeds = std::mem::take(&mut self.speeds);
        speeds.clear();
        speeds.extend(contacts.iter().zip(&self.rows.points).map(|(contact, point): (_, &ContactRows)| {
            let overlap = -(point.distance + 0.5 * h * point.start[0]);
            (contact.recovery.min(1.0 / h) * overlap).clamp(0.0, MAX_RECOVERY_SPEED)
        }));
        if speeds.iter().any(|s| *s > 0.0) {
            self.solve_separation(&speeds);
            for (m, offset) in members.iter_mut().zip(&self.rows.offsets) {
                let step = &mut m.solver.step;
                self.velocities.clear();
                self.velocities.extend_from_slice(&self.rows.z[*offset..][..m.tree.velocities()]);
                step.pivot.factor.finish(m.tree, &mut self.velocities);
                advance(m.tree, &mut step.q, &self.velocities, h);
                step.limit_corrected_energy(m.tree);
            }
        }
        self.speeds = speeds;
    }

    /// Stores the distances at the end of the step; `z` contains the separation velocities.
    fn store_distances(&self, contacts: &mut [ContactPoint], h: f64) {
        for (contact, point) in contacts.iter_mut().zip(&self.rows.points) {
            contact.distance = point.distance + h * (0.5 * point.start[0] + self.rows.velocity_change(point, 0));
        }
    }
}

/// Calls a function for each member, and adds the index of the member to its error.
fn for_each_tree(
    members: &mut [IslandTree<'_>],
    mut call: impl FnMut(&mut IslandTree<'_>) -> Result<(), DynamicsError>,
) -> Result<(), IslandError> {
    for (member, m) in members.iter_mut().enumerate() {
        call(m).map_err(|source| IslandError::Member { member, source })?;
    }
    Ok(())
}

/// Returns an error if `carried` of a member has the wrong length, or a contact refers to a link that does not exist or
/// contains an invalid value.
fn check(members: &[IslandTree<'_>], contacts: &[ContactPoint]) -> Result<(), IslandError> {
    for (member, m) in members.iter().enumerate() {
        let (found, expected) = (m.carried.len(), m.tree.axes());
        if found != expected {
            let source = DynamicsError::Length { what: "carried", found, expected };
            return Err(IslandError::Member { member, source });
        }
    }
    for (contact, c) in contacts.iter().enumerate() {
        let known = |s: &ContactSide| members.get(s.member).is_some_and(|m| s.link < m.tree.nodes.len());
        if !c.sides.iter().flatten().all(known) {
            return Err(IslandError::Contact { contact, why: "one of its links does not exist" });
        }
        if !c.is_valid() {
            return Err(IslandError::Contact { contact, why: "a value is not finite or out of range" });
        }
    }
    Ok(())
}
