//! The physics step of all trees.

use nalgebra::Vector3;
use rapier3d::math::Vector;
use rayon::prelude::*;
use tatu_mechanisms::{ContactPoint, DynamicsError, FastTurns, Island, IslandError, IslandTree};

use super::{
    contacts::DetectedContact,
    records::{BodyLoad, Mechanism},
};
use crate::{BodyId, convert, rapier::state::Rapier};

/// Minimum total number of velocities of all trees for which stepping them on several threads pays off.
const MIN_PARALLEL_VELOCITIES: usize = 64;

/// Maximum angle by which a joint turns in a part of a sub-step, rad: 160 rad/s at the default settings.
const MAX_TURN: f64 = 0.2;
/// Maximum number of parts of a sub-step.
const MAX_PARTS: usize = 16;

/// Trees that touch each other, with their contacts.
struct MechanismIsland {
    /// Indices of the mechanisms, ascending, and the mechanisms themselves.
    members: Vec<usize>,
    mechanisms: Vec<Mechanism>,
    /// Indices of the contacts, and the contacts themselves, whose sides refer to members of this island.
    contact_indices: Vec<usize>,
    contacts: Vec<ContactPoint>,
    /// Impulse of each contact, summed over sub-steps, N s.
    totals: Vec<Vector3<f64>>,
    /// Whether the state was no longer finite.
    diverged: bool,
}

impl Rapier {
    /// Advances all trees by one physics step, with the contacts that rapier detected at its beginning.
    pub(in crate::rapier) fn step_trees(&mut self) {
        if self.state.mechanisms.is_empty() {
            self.state.touches.clear();
            self.state.kept.clear();
            return;
        }
        let links = std::mem::take(&mut self.state.links);
        let mut found = self.find_contacts(&links);
        for i in 0..self.state.mechanisms.len() {
            self.set_tree_drives(i);
            self.set_loads(i);
        }
        let mut islands = self.build_islands(&found);
        let (gravity, h) = (convert::vector_back(self.world.gravity), self.tree_substep());
        let substeps = self.state.substeps;
        let total: usize = islands.iter().flat_map(|i| &i.mechanisms).map(|m| m.v.len()).sum();
        let advance = |island: &mut MechanismIsland| island.advance(gravity, h, substeps);
        if total >= MIN_PARALLEL_VELOCITIES && islands.len() > 1 && rayon::current_num_threads() > 1 {
            islands.par_iter_mut().for_each(advance);
        } else {
            islands.iter_mut().for_each(advance);
        }
        let mut lost = Vec::new();
        for island in islands {
            for (i, (contact, total)) in
                island.contact_indices.iter().zip(island.contacts.into_iter().zip(island.totals))
            {
                found[*i].contact.impulse = contact.impulse;
                found[*i].total = total;
            }
            for (index, mechanism) in island.members.iter().zip(island.mechanisms) {
                self.state.mechanisms[*index] = mechanism;
                if island.diverged {
                    lost.push(*index);
                }
            }
        }
        self.store_contacts(&found);
        for i in 0..self.state.mechanisms.len() {
            self.place_bodies(i);
            self.record_mechanism_efforts(i);
        }
        self.state.step_loads.clear();
        self.state.links = links;
        lost.into_iter().for_each(|i| self.freeze_mechanism(i));
    }

    /// Returns the length of a sub-step of trees, s.
    pub(super) fn tree_substep(&self) -> f64 {
        self.world.integration_parameters.dt / self.state.substeps as f64
    }

    /// Moves the mechanisms out of the engine's state into islands: mechanisms that touch each other.
    fn build_islands(&mut self, found: &[DetectedContact]) -> Vec<MechanismIsland> {
        let count = self.state.mechanisms.len();
        let mut above: Vec<usize> = (0..count).collect();
        fn root(above: &mut [usize], mut i: usize) -> usize {
            while above[i] != i {
                above[i] = above[above[i]];
                i = above[i];
            }
            i
        }
        for f in found {
            if let [Some(a), Some(b)] = f.contact.sides {
                let (a, b) = (root(&mut above, a.member), root(&mut above, b.member));
                above[a.max(b)] = a.min(b);
            }
        }
        let mut islands: Vec<MechanismIsland> = Vec::new();
        let mut place = vec![(usize::MAX, 0); count];
        for (i, mechanism) in std::mem::take(&mut self.state.mechanisms).into_iter().enumerate() {
            let first = root(&mut above, i);
            if first == i {
                place[i].0 = islands.len();
                islands.push(MechanismIsland::new());
            }
            let island = &mut islands[place[first].0];
            place[i] = (place[first].0, island.members.len());
            island.members.push(i);
            island.mechanisms.push(mechanism);
        }
        for (i, f) in found.iter().enumerate() {
            let mut contact = f.contact.clone();
            let mut island = None;
            for side in contact.sides.iter_mut().flatten() {
                island = Some(place[side.member].0);
                side.member = place[side.member].1;
            }
            let Some(island) = island else { continue };
            islands[island].contact_indices.push(i);
            islands[island].contacts.push(contact);
        }
        // Placeholders, which `step_trees` replaces by the mechanisms in their original order.
        self.state.mechanisms = islands.iter().flat_map(|i| &i.members).map(|_| Mechanism::new(BodyId(0))).collect();
        islands
    }

    /// Converts the forces on the bodies of a mechanism to generalised forces, at the poses at the start of the step.
    fn set_loads(&mut self, index: usize) {
        let Some(mut built) = self.state.mechanisms[index].built.take() else { return };
        built.drives.force.fill(0.0);
        for (link, body) in self.state.mechanisms[index].bodies.iter().enumerate() {
            let (force, torque) = self.tree_load(*body);
            if force == Vector::ZERO && torque == Vector::ZERO {
                continue;
            }
            let at = built.poses[link].translation.vector;
            let (force, torque) = (convert::vector_back(force), convert::vector_back(torque));
            // This fails only for values that are not finite, which `push` has rejected.
            let _ = built.kinematics.add_force(&built.tree, link, at, force, torque, &mut built.drives.force);
        }
        self.state.mechanisms[index].built = Some(built);
    }

    /// Sets the poses and velocities of a mechanism's bodies to those of its links.
    pub(super) fn place_bodies(&mut self, index: usize) {
        let mechanism = &mut self.state.mechanisms[index];
        if mechanism.frozen {
            return;
        }
        let Some(mut built) = mechanism.built.take() else { return };
        built.state.q.copy_from_slice(&mechanism.q);
        built.state.v.copy_from_slice(&mechanism.v);
        let bodies = mechanism.bodies.clone();
        if built.kinematics.update(&built.tree, &built.state).is_ok() {
            for (link, body) in bodies.iter().enumerate() {
                let (Some(pose), Some(handle)) = (built.kinematics.pose(link), self.record(*body).map(|r| r.handle))
                else {
                    continue;
                };
                built.origins[link] = pose.translation.vector;
                let pose = pose * built.to_body[link];
                built.poses[link] = pose;
                let velocity = built.kinematics.velocity(link, pose.translation.vector);
                let (angular, linear) = velocity.unwrap_or_default();
                // Rapier treats a body as changed whenever its state is set, even to the same values.
                let (pose, linear, angular) =
                    (convert::pose(&pose), convert::vector(&linear), convert::vector(&angular));
                let body = &self.world.bodies[handle];
                if *body.position() != pose || body.linvel() != linear || body.angvel() != angular {
                    let moved = &mut self.world.bodies[handle];
                    moved.set_position(pose, true);
                    moved.set_linvel(linear, true);
                    moved.set_angvel(angular, true);
                }
            }
        }
        self.state.mechanisms[index].built = Some(built);
    }

    /// Records the mean efforts of a mechanism's drives in the step.
    fn record_mechanism_efforts(&mut self, index: usize) {
        let mechanism = &self.state.mechanisms[index];
        let Some(built) = &mechanism.built else { return };
        for (joint, (_, v, count)) in mechanism.joints.iter().zip(&mechanism.offsets) {
            if let (Some(joint), 1) = (joint, *count)
                && let Some(Some(record)) = self.state.joints.get_mut(joint.0 as usize)
                && let Some(tied) = record.tree_joint_mut()
            {
                tied.effort = built.efforts[*v] / self.state.substeps as f64;
            }
        }
    }

    /// Returns the force on a body of a tree, N, and the torque about its centre of mass, N m, excluding gravity and
    /// contacts.
    pub(in crate::rapier) fn tree_load(&self, body: BodyId) -> (Vector, Vector) {
        let mut load = self.state.loads.get(&body).copied().unwrap_or_default();
        for (_, more) in self.state.step_loads.iter().filter(|(b, _)| *b == body) {
            load = BodyLoad { force: load.force + more.force, torque: load.torque + more.torque };
        }
        (convert::vector(&load.force), convert::vector(&load.torque))
    }
}

impl MechanismIsland {
    fn new() -> Self {
        MechanismIsland {
            members: Vec::new(),
            mechanisms: Vec::new(),
            contact_indices: Vec::new(),
            contacts: Vec::new(),
            totals: Vec::new(),
            diverged: false,
        }
    }

    /// Advances the trees by `substeps` sub-steps of length `h`, s. If a state would not be finite, all
    /// mechanisms of the island keep their positions and velocities.
    fn advance(&mut self, gravity: Vector3<f64>, h: f64, substeps: usize) {
        self.totals = vec![Vector3::zeros(); self.contacts.len()];
        for mechanism in &mut self.mechanisms {
            let Some(built) = &mut mechanism.built else { continue };
            built.state.q.copy_from_slice(&mechanism.q);
            built.state.v.copy_from_slice(&mechanism.v);
            built.efforts.fill(0.0);
            built.work = 0.0;
        }
        let first = self.mechanisms.first_mut().and_then(|m| m.built.as_mut());
        let mut group = first.map(|built| std::mem::take(&mut built.island)).unwrap_or_default();
        for _ in 0..substeps {
            let parts = self.part_count(h);
            for _ in 0..parts {
                if self.advance_part(&mut group, gravity, h / parts as f64, h).is_err() {
                    self.diverged = true;
                    return;
                }
            }
        }
        if let Some(built) = self.mechanisms.first_mut().and_then(|m| m.built.as_mut()) {
            built.island = group;
        }
        for Mechanism { q, v, built, .. } in &mut self.mechanisms {
            let Some(built) = built else { continue };
            q.copy_from_slice(&built.state.q);
            v.copy_from_slice(&built.state.v);
            for (i, v) in v.iter_mut().enumerate().take(6).filter(|_| built.damping != [0.0; 2]) {
                *v /= 1.0 + h * substeps as f64 * built.damping[usize::from(i >= 3)];
            }
        }
    }

    /// Returns the number of parts into which a sub-step of length `h`, s, is divided, so that no joint turns by more
    /// than [`MAX_TURN`] in a part: forces of gyration are computed from the velocities by few iterations, which
    /// diverge for light links that spin fast.
    fn part_count(&self, h: f64) -> usize {
        let mut most = 0.0f64;
        for built in self.mechanisms.iter().filter_map(|m| m.built.as_ref()) {
            let turns = built.state.v.iter().enumerate().map(|(i, v)| built.tree.turning(i) * v.abs());
            most = turns.fold(most, f64::max);
        }
        ((h * most / MAX_TURN).ceil() as usize).clamp(1, MAX_PARTS)
    }

    /// Advances the trees by a part `h` of a sub-step, s. If something would turn too far, because an impact has made
    /// it spin, the part is divided further.
    fn advance_part(
        &mut self,
        group: &mut Island,
        gravity: Vector3<f64>,
        h: f64,
        substep: f64,
    ) -> Result<(), DynamicsError> {
        let divisible = h > substep / MAX_PARTS as f64;
        let fast_turns = if divisible { FastTurns::Fail { max_turn: 1.25 * MAX_TURN } } else { FastTurns::LimitEnergy };
        match self.step(group, gravity, h, fast_turns) {
            Err(DynamicsError::TooFast { .. }) => {
                self.advance_part(group, gravity, 0.5 * h, substep)?;
                return self.advance_part(group, gravity, 0.5 * h, substep);
            }
            other => other?,
        }
        for (total, contact) in self.totals.iter_mut().zip(&self.contacts) {
            *total += contact.impulse;
        }
        for mechanism in &mut self.mechanisms {
            let Some(built) = &mut mechanism.built else { continue };
            let efforts = built.efforts.iter_mut().zip(&mechanism.carried);
            efforts.for_each(|(sum, effort)| *sum += effort * (h / substep));
            built.work += h * built.solver.drive_power();
        }
        Ok(())
    }

    /// Advances the trees by one step of their solver; if this fails, no tree has moved.
    fn step(
        &mut self,
        group: &mut Island,
        gravity: Vector3<f64>,
        h: f64,
        fast_turns: FastTurns,
    ) -> Result<(), DynamicsError> {
        let mut members = Vec::with_capacity(self.mechanisms.len());
        for mechanism in &mut self.mechanisms {
            let Some(built) = &mut mechanism.built else {
                // Contacts refer to members by their indices, so none may be left out.
                if self.contacts.is_empty() { continue } else { return Err(DynamicsError::Diverged) }
            };
            built.solver.set_fast_turns(fast_turns);
            if self.contacts.is_empty() {
                built.solver.step(&mut built.state, &built.tree, &built.drives, gravity, h)?;
                mechanism.carried.copy_from_slice(&built.solver.efforts().drive);
                continue;
            }
            members.push(IslandTree {
                tree: &built.tree,
                state: &mut built.state,
                drives: &built.drives,
                solver: &mut built.solver,
                carried: &mut mechanism.carried,
            });
        }
        if members.is_empty() {
            return Ok(());
        }
        match group.step(&mut members, &mut self.contacts, gravity, h) {
            Ok(_) => Ok(()),
            Err(IslandError::Member { source, .. }) => Err(source),
            Err(IslandError::Contact { .. }) => Err(DynamicsError::Diverged),
        }
    }
}
