//! The physics step of all trees, with the contacts that rapier or `detect` has found.

use nalgebra::Vector3;
use rapier3d::math::Vector;
use rayon::prelude::*;
use tatu_mechanisms::{ContactPoint, DynamicsError, FastTurns, Island, IslandError, IslandTree};

use super::{
    build::place_bodies, contacts::DetectedContact, drives::set_drives, gears::close_gaps, records::Mechanism,
    table::TreeJoints,
};
use crate::{
    BodyId, convert,
    rapier::{
        bodies::Bodies,
        joints::{record::JointBackend, table::Joints},
    },
};

/// Minimum total number of velocities of all trees for which stepping them on several threads pays off.
const MIN_PARALLEL_VELOCITIES: usize = 64;

/// Maximum angle by which a joint turns in a part of a sub-step, rad: 160 rad/s at the default settings.
const MAX_TURN: f64 = 0.2;
/// Maximum number of parts of a sub-step.
const MAX_PARTS: usize = 16;

/// Trees that touch each other, with their contacts.
pub(super) struct MechanismIsland {
    /// Indices of the mechanisms, ascending, and the mechanisms themselves.
    pub members: Vec<usize>,
    pub mechanisms: Vec<Mechanism>,
    /// Indices of the contacts, and the contacts themselves, whose sides refer to members of this island.
    pub contact_indices: Vec<usize>,
    pub contacts: Vec<ContactPoint>,
    /// Impulse of each contact, summed over sub-steps, N s.
    pub totals: Vec<Vector3<f64>>,
    /// Number of sub-steps of this physics step.
    substeps: usize,
    /// Whether the island has been calm for a while.
    pub calm: bool,
    /// Time over which the contact forces are integrated to impulses, s.
    impulse_time: f64,
    /// Whether the state was no longer finite.
    diverged: bool,
}

impl TreeJoints {
    /// Advances all trees by one physics step, with the contacts that were found at its beginning.
    pub(super) fn step(&mut self, bodies: &mut Bodies, joints: &mut Joints) {
        if self.mechanisms.is_empty() {
            self.touches.clear();
            self.warm_start.clear();
            return;
        }
        let mut found = self.find_contacts(bodies);
        let (gravity, dt) = (convert::vector_back(bodies.world.gravity), bodies.world.integration_parameters.dt);
        for mechanism in &mut self.mechanisms {
            close_gaps(mechanism, dt);
            set_drives(mechanism, joints);
            set_loads(mechanism, bodies);
        }
        let mut islands = self.build_islands(&found);
        for island in &mut islands {
            island.substeps = island.choose_substeps(&found, dt, bodies.substeps.usual);
        }
        let total: usize = islands.iter().flat_map(|i| &i.mechanisms).map(|m| m.v.len()).sum();
        let advance = |island: &mut MechanismIsland| island.advance(gravity, dt);
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
                self.mechanisms[*index] = mechanism;
                if island.diverged {
                    lost.push(*index);
                }
            }
        }
        self.store_contacts(bodies, &found);
        for mechanism in &mut self.mechanisms {
            if mechanism.built.as_ref().is_none_or(|built| !built.at_rest) {
                place_bodies(mechanism, bodies);
                record_efforts(mechanism, joints);
            }
        }
        bodies.forces.step_loads.clear();
        lost.into_iter().for_each(|i| self.freeze_mechanism(bodies, i));
    }

    /// Moves the mechanisms out of the table into islands: mechanisms that touch each other.
    fn build_islands(&mut self, found: &[DetectedContact]) -> Vec<MechanismIsland> {
        let count = self.mechanisms.len();
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
        for (i, mechanism) in std::mem::take(&mut self.mechanisms).into_iter().enumerate() {
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
        // Placeholders, which `step` replaces by the mechanisms in their original order.
        self.mechanisms = islands.iter().flat_map(|i| &i.members).map(|_| Mechanism::new(BodyId(0))).collect();
        islands
    }
}

/// Converts the forces on the bodies of a mechanism to generalised forces, at the poses at the start of the step.
fn set_loads(mechanism: &mut Mechanism, bodies: &Bodies) {
    let Some(built) = &mut mechanism.built else { return };
    built.drives.force.fill(0.0);
    for (link, body) in mechanism.bodies.iter().enumerate() {
        let (force, torque) = bodies.tree_load(*body);
        if force == Vector::ZERO && torque == Vector::ZERO {
            continue;
        }
        let at = built.poses[link].translation.vector;
        let (force, torque) = (convert::vector_back(force), convert::vector_back(torque));
        // This fails only for values that are not finite, which `push` has rejected.
        let _ = built.kinematics.add_force(&built.tree, link, at, force, torque, &mut built.drives.force);
    }
}

/// Records the mean efforts of a mechanism's drives in the step.
fn record_efforts(mechanism: &Mechanism, joints: &mut Joints) {
    let Some(built) = &mechanism.built else { return };
    for (joint, place) in mechanism.joints.iter().zip(&mechanism.places) {
        if let (Some(joint), 1) = (joint, place.axes)
            && let Some(record) = joints.get_mut(*joint)
            && let JointBackend::Tree(tree) = &mut record.backend
        {
            tree.effort = built.efforts[place.axis];
        }
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
            substeps: 1,
            calm: false,
            impulse_time: 0.0,
            diverged: false,
        }
    }

    /// Advances the trees by a physics step of length `dt`, s. If a state would not be finite, all mechanisms of the
    /// island keep their positions and velocities.
    fn advance(&mut self, gravity: Vector3<f64>, dt: f64) {
        let rests = self.repeats(gravity, dt);
        self.mechanisms.iter_mut().filter_map(|m| m.built.as_mut()).for_each(|built| built.at_rest = rests);
        if rests {
            self.repeat_impulses();
            return;
        }
        let start = self.is_nearly_at_rest().then(|| self.rest_start());
        let h = dt / self.substeps as f64;
        self.impulse_time = dt;
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
        for _ in 0..self.substeps {
            let parts = self.part_count(h);
            for _ in 0..parts {
                if self.advance_part(&mut group, gravity, h / parts as f64, [h, dt]).is_err() {
                    self.diverged = true;
                    return;
                }
            }
        }
        self.scale_impulses(dt);
        if let Some(built) = self.mechanisms.first_mut().and_then(|m| m.built.as_mut()) {
            built.island = group;
        }
        if let Some(start) = start {
            self.settle(start, gravity, dt);
        }
        for Mechanism { q, v, built, .. } in &mut self.mechanisms {
            let Some(built) = built else { continue };
            q.copy_from_slice(&built.state.q);
            v.copy_from_slice(&built.state.v);
            for (i, v) in v.iter_mut().enumerate().take(6).filter(|_| built.damping != [0.0; 2]) {
                *v /= 1.0 + dt * built.damping[usize::from(i >= 3)];
            }
        }
    }

    /// Converts the impulses of the contacts to those of the same forces over the time `h`, s. Between physics steps,
    /// they refer to a whole step, because the next step may have a different number of sub-steps.
    fn scale_impulses(&mut self, h: f64) {
        let factor = h / self.impulse_time;
        if factor != 1.0 {
            self.contacts.iter_mut().for_each(|contact| contact.impulse *= factor);
        }
        self.impulse_time = h;
    }

    /// Returns the number of parts into which a sub-step of length `h`, s, is divided, so that no joint turns by more
    /// than [`MAX_TURN`] in a part: gyroscopic forces are computed from the velocities in a few iterations, which
    /// diverge for light links that spin fast.
    fn part_count(&self, h: f64) -> usize {
        let mut most = 0.0f64;
        for built in self.mechanisms.iter().filter_map(|m| m.built.as_ref()) {
            let turns = built.state.v.iter().enumerate().map(|(i, v)| built.tree.turning(i) * v.abs());
            most = turns.fold(most, f64::max);
        }
        ((h * most / MAX_TURN).ceil() as usize).clamp(1, MAX_PARTS)
    }

    /// Advances the trees by a part `h` of a sub-step of a physics step, s. If a joint would turn too far, because an
    /// impact has made a link spin, the part is divided further.
    fn advance_part(
        &mut self,
        group: &mut Island,
        gravity: Vector3<f64>,
        h: f64,
        [substep, dt]: [f64; 2],
    ) -> Result<(), DynamicsError> {
        self.scale_impulses(h);
        let divisible = h > substep / MAX_PARTS as f64;
        let fast_turns = if divisible { FastTurns::Fail { max_turn: 1.25 * MAX_TURN } } else { FastTurns::LimitEnergy };
        match self.step(group, gravity, h, fast_turns) {
            Err(DynamicsError::TooFast { .. }) => {
                self.advance_part(group, gravity, 0.5 * h, [substep, dt])?;
                return self.advance_part(group, gravity, 0.5 * h, [substep, dt]);
            }
            other => other?,
        }
        for (total, contact) in self.totals.iter_mut().zip(&self.contacts) {
            *total += contact.impulse;
        }
        for mechanism in &mut self.mechanisms {
            let Some(built) = &mut mechanism.built else { continue };
            let efforts = built.efforts.iter_mut().zip(&mechanism.carried);
            efforts.for_each(|(sum, effort)| *sum += effort * (h / dt));
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
