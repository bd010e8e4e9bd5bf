//! The phases of a step of one tree. A solver runs them for a single tree, an island for trees that touch.
//!
//! [`TreeStep::begin`] advances positions by half a step at the old velocities, and computes poses there;
//! [`TreeStep::set_laws`] sets the laws of joints; [`TreeStep::guess`] computes bias forces; [`TreeStep::solve`] finds
//! the velocities at the end; [`TreeStep::use_mean_velocities`] and [`TreeStep::use_mean_poses`] refine the equation
//! for the next `solve`; [`TreeStep::conclude`] computes forces, [`TreeStep::finish`] positions at the end,
//! [`TreeStep::limit`] applies joint limits to them, and [`TreeStep::commit`] writes the state.

mod energy;
mod laws;

pub(crate) use energy::EnergyBalance;

use crate::{
    composite::MassMatrix,
    drive::TreeDrives,
    error::DynamicsError,
    fast_turns::FastTurns,
    kinematics::Kinematics,
    motor::MotorCurve,
    newton_euler::NewtonEuler,
    paths::NO_INDEX,
    pivot::{PivotSolver, PivotStats},
    state::{TreeState, advance},
    tree::Tree,
    vector::Vec3,
};

/// Time constant with which a joint beyond a limit returns to it, s.
const RETURN_TIME: f64 = 0.1;
/// Maximum speed of this return, rad/s or m/s.
const MAX_RETURN_SPEED: f64 = 1.0;

/// Forces of the last step, Nm or N.
#[derive(Debug, Clone, PartialEq)]
pub struct JointEfforts {
    /// Forces of drives, within their bounds, with one entry per axis. Of several drives that gears couple, each exerts
    /// the same fraction of its bounds, as far as their forces are undetermined.
    pub drive: Vec<f64>,
    /// Forces of dry friction, within their bounds, with one entry per velocity.
    pub friction: Vec<f64>,
    /// Forces of limits, with one entry per velocity: not negative at a lower limit and not positive at an upper one,
    /// unless [`StepReport::satisfied`] is false.
    ///
    /// [`StepReport::satisfied`]: crate::StepReport::satisfied
    pub limit: Vec<f64>,
}

/// Results and memory of a step of one tree.
#[derive(Debug, Clone)]
pub(crate) struct TreeStep {
    pub kinematics: Kinematics,
    pub mass: MassMatrix,
    newton_euler: NewtonEuler,
    pub pivot: PivotSolver,
    /// The drive of each axis, in the coordinate of the velocity that moves it.
    motors: Vec<MotorCurve>,
    /// Forces of all drives of each velocity, Nm or N.
    drive_forces: Vec<f64>,
    /// The linear part of each law: `at - slope v` of springs, viscous friction and external forces.
    passive: Vec<(f64, f64)>,
    /// Positions after half a step at the old velocities; after `finish`, positions at the end of the step.
    pub q: Vec<f64>,
    /// Positions at the end of the step before overlaps are corrected.
    uncorrected: Vec<f64>,
    /// Positions for which poses are computed.
    place: Vec<f64>,
    /// Means of the velocities before and after the step.
    middle: Vec<f64>,
    bias: Vec<f64>,
    /// Dry friction of contacts that act on a joint like friction of its own, Nm or N.
    pub contact_friction: Vec<f64>,
    /// Generalised forces of contacts.
    pub contact: Vec<f64>,
    /// Bias forces minus forces of contacts.
    load: Vec<f64>,
    pub efforts: JointEfforts,
    /// Mean power of all drives in the step, W.
    pub drive_power: f64,
    /// The treatment of links that turn fast.
    pub fast_turns: FastTurns,
    /// Velocities at the end of the step that the previous iteration found.
    previous: Vec<f64>,
}

impl TreeStep {
    pub fn new(tree: &Tree) -> Self {
        let n = tree.velocities();
        let zeros = vec![0.0; n];
        TreeStep {
            kinematics: Kinematics::new(tree),
            mass: MassMatrix::new(tree),
            newton_euler: NewtonEuler::new(tree),
            pivot: PivotSolver::new(tree),
            motors: vec![MotorCurve::OFF; tree.axes()],
            drive_forces: zeros.clone(),
            passive: vec![(0.0, 0.0); n],
            q: vec![0.0; tree.positions()],
            uncorrected: vec![0.0; tree.positions()],
            place: vec![0.0; tree.positions()],
            middle: zeros.clone(),
            bias: zeros.clone(),
            contact_friction: zeros.clone(),
            contact: zeros.clone(),
            load: zeros.clone(),
            efforts: JointEfforts { drive: vec![0.0; tree.axes()], friction: zeros.clone(), limit: zeros },
            drive_power: 0.0,
            fast_turns: FastTurns::Ignore,
            previous: vec![0.0; n],
        }
    }

    /// Returns an error if the size of an argument does not match the tree, or a value is invalid.
    pub fn check(&self, tree: &Tree, state: &TreeState, drives: &TreeDrives) -> Result<(), DynamicsError> {
        self.kinematics.check_tree(tree)?;
        state.check(tree)?;
        drives.check(tree)
    }

    /// Computes the poses after half a step at the old velocities, and begins a step without friction of contacts on
    /// joints.
    pub fn begin(&mut self, tree: &Tree, state: &TreeState, h: f64) {
        self.q.copy_from_slice(&state.q);
        advance(tree, &mut self.q, &state.v, 0.5 * h);
        self.place.copy_from_slice(&self.q);
        self.set_poses(tree);
        self.contact_friction.fill(0.0);
    }

    /// Computes the bias forces at the old velocities and guesses the piece of each law.
    pub fn guess(&mut self, tree: &Tree, v: &[f64], gravity: Vec3, h: f64) {
        self.newton_euler.compute_forces(tree, &self.kinematics, v, None, gravity, &mut self.bias);
        self.set_load();
        self.pivot.begin(tree, &self.mass, &self.load, v, h);
    }

    /// Recomputes the bias forces at the mean velocities.
    pub fn use_mean_velocities(&mut self, tree: &Tree, v: &[f64], gravity: Vec3) {
        for (middle, (v, end)) in self.middle.iter_mut().zip(v.iter().zip(&self.pivot.ends)) {
            *middle = 0.5 * (v + end);
        }
        self.newton_euler.compute_forces(tree, &self.kinematics, &self.middle, None, gravity, &mut self.bias);
    }

    /// Sets the bias forces to the mean of those before and after the step; must follow [`TreeStep::guess`].
    pub fn use_mean_forces(&mut self, tree: &Tree, gravity: Vec3) {
        self.newton_euler.compute_forces(tree, &self.kinematics, &self.pivot.ends, None, gravity, &mut self.middle);
        for (bias, after) in self.bias.iter_mut().zip(&self.middle) {
            *bias = 0.5 * (*bias + after);
        }
    }

    /// Recomputes poses, mass matrix and bias forces for the positions half a step after the old ones, at the mean
    /// velocities.
    pub fn use_mean_poses(&mut self, tree: &Tree, state: &TreeState, gravity: Vec3, h: f64) {
        for (middle, (v, end)) in self.middle.iter_mut().zip(state.v.iter().zip(&self.pivot.ends)) {
            *middle = 0.5 * (v + end);
        }
        self.place.copy_from_slice(&state.q);
        advance(tree, &mut self.place, &self.middle, 0.5 * h);
        self.set_poses(tree);
        self.pivot.discard_factor();
        self.newton_euler.compute_forces(tree, &self.kinematics, &self.middle, None, gravity, &mut self.bias);
    }

    /// Finds the velocities at the end of the step.
    pub fn solve(&mut self, tree: &Tree, v: &[f64], h: f64) -> Result<PivotStats, DynamicsError> {
        self.set_load();
        let search = self.pivot.solve(tree, &self.mass, &self.load, v, h);
        let search = search.map_err(|dof| DynamicsError::Singular { dof })?;
        if !self.pivot.ends.iter().chain(&self.pivot.forces).all(|x| x.is_finite()) {
            return Err(DynamicsError::Diverged);
        }
        Ok(search)
    }

    /// Computes the forces; `met` states whether the last search satisfied all laws. If not, this also computes the
    /// velocities at the end under forces within their bounds.
    pub fn conclude(&mut self, tree: &Tree, state: &TreeState, h: f64, met: bool) -> Result<(), DynamicsError> {
        self.share_forces(tree);
        if !met {
            self.settle(tree, &state.v, h)?;
        }
        let means = state.v.iter().zip(&self.pivot.ends).map(|(v, end)| 0.5 * (v + end));
        self.drive_power = means.zip(&self.drive_forces).map(|(v, effort)| v * effort).sum();
        Ok(())
    }

    /// Computes the positions at the end.
    pub fn finish(&mut self, tree: &Tree, h: f64) {
        advance(tree, &mut self.q, &self.pivot.ends, 0.5 * h);
        self.uncorrected.copy_from_slice(&self.q);
    }

    /// Moves joints that are beyond a limit back towards it; returns an error if the result is not finite, or a joint
    /// turns too far.
    pub fn limit(&mut self, tree: &Tree, state: &TreeState, h: f64) -> Result<(), DynamicsError> {
        self.stop_at_limits(tree, &state.q, h);
        let finite = self.q.iter().chain(&self.pivot.ends).all(|x| x.is_finite());
        if !finite {
            return Err(DynamicsError::Diverged);
        }
        let FastTurns::Fail { max_turn } = self.fast_turns else { return Ok(()) };
        let fastest = state.v.iter().zip(&self.pivot.ends).map(|(start, end)| start.abs().max(end.abs()));
        let turns = fastest.map(|v| v * h).zip(&tree.dofs).enumerate();
        let mut turns = turns.map(|(d, (turn, dof))| (d, turn * dof.turning));
        match turns.find(|(_, turn)| *turn > max_turn) {
            Some((dof, turn)) => Err(DynamicsError::TooFast { dof, turn }),
            None => Ok(()),
        }
    }

    /// Returns the amounts that springs and dampers add to the diagonal of the mass matrix in a step of duration `h`,
    /// s, if no drive, friction or limit acts.
    pub fn damping(&self, h: f64) -> Vec<f64> {
        self.passive.iter().map(|(_, slope)| h * slope).collect()
    }

    /// Returns the maximum change of a velocity in this step.
    pub fn max_velocity_change(&self, v: &[f64]) -> f64 {
        self.pivot.ends.iter().zip(v).map(|(end, v)| (end - v).abs()).fold(0.0, f64::max)
    }

    /// Writes the result to the state.
    pub fn commit(&self, state: &mut TreeState) {
        state.q.copy_from_slice(&self.q);
        state.v.copy_from_slice(&self.pivot.ends);
    }

    /// Computes poses and the mass matrix for the positions in `place`.
    fn set_poses(&mut self, tree: &Tree) {
        self.kinematics.place(tree, &self.place);
        self.mass.update(tree, &self.kinematics);
    }

    fn set_load(&mut self) {
        for (load, (bias, contact)) in self.load.iter_mut().zip(self.bias.iter().zip(&self.contact)) {
            *load = bias - contact;
        }
    }

    /// Completes a step whose laws could not be satisfied: drives and friction exert the forces found last, which are
    /// within their bounds.
    fn settle(&mut self, tree: &Tree, v: &[f64], h: f64) -> Result<(), DynamicsError> {
        let given = self.drive_forces.iter().zip(&self.efforts.friction);
        for (line, (drive, friction)) in self.passive.iter_mut().zip(given) {
            line.0 += drive + friction;
        }
        let settled = self.pivot.settle(tree, &self.mass, &self.load, v, h, &self.passive);
        settled.map_err(|dof| DynamicsError::Singular { dof })?;
        for (d, limit) in self.efforts.limit.iter_mut().enumerate() {
            let (at, slope) = self.passive[d];
            let (low, high) = self.pivot.laws[d].velocity_range();
            let end = self.pivot.ends[d];
            *limit = if end <= low || end >= high { self.pivot.forces[d] - (at - slope * end) } else { 0.0 };
        }
        Ok(())
    }

    /// Moves joints that passed a limit due to the discretisation of the step back to it. Joints that were beyond a
    /// limit before return slowly, by position changes only, which add no momentum.
    fn stop_at_limits(&mut self, tree: &Tree, before: &[f64], h: f64) {
        let back = |beyond: f64| beyond.min(h * (beyond / RETURN_TIME).min(MAX_RETURN_SPEED));
        for dof in &tree.dofs {
            if dof.position != NO_INDEX {
                let p = dof.position as usize;
                if self.q[p] < dof.low {
                    let least = before[p].min(dof.low);
                    self.q[p] = self.q[p].max(least + back(dof.low - least));
                }
                if self.q[p] > dof.high {
                    let greatest = before[p].max(dof.high);
                    self.q[p] = self.q[p].min(greatest - back(greatest - dof.high));
                }
            }
        }
    }
}
