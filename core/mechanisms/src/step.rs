//! The phases of a step of one tree. A solver runs them for a single tree, a group for trees that touch.
//!
//! [`Step::begin`] advances positions by half a step at the old velocities, and computes poses and laws there;
//! [`Step::guess`] computes bias forces; [`Step::solve`] finds the velocities at the end;
//! [`Step::take_mean_velocities`] and [`Step::take_mean_poses`] refine the equation for the next `solve`;
//! [`Step::conclude`] computes forces, [`Step::finish`] positions at the end, [`Step::limit`] applies joint limits to
//! them, and [`Step::commit`] writes the state.

use crate::{
    composite::MassMatrix,
    drive::{Bound, Drive, Drives},
    error::DynamicsError,
    kinematics::Kinematics,
    law::Piece,
    motor::{Motor, within},
    newton_euler::Sweep,
    pivot::{Pivot, Search},
    state::{State, advance},
    tree::{Dof, NONE, Tree},
    vector::Vec3,
};

/// Time constant with which a joint beyond a limit returns to it, s.
const RETURN_TIME: f64 = 0.1;
/// Maximum speed of this return, rad/s or m/s.
const RETURN_SPEED: f64 = 1.0;
/// Fraction of the velocity of an isolated joint that a damper may remove in a step before it is treated as stiff; also
/// the phase, rad, by which a spring may advance in a step.
const STIFF: f64 = 0.5;
/// Slope, in units of inertia over step duration, with which the force of a velocity drive depends on the velocity in
/// steps with contacts: an impulse that would change the velocity of the free joint by 1 changes it by about 1 /
/// `HOLD`.
const HOLD: f64 = 1e3;
/// Maximum force of such a drive, Nm or N, even if its bound is greater or infinite.
const STRONGEST: f64 = 1e9;

/// Forces of the last step, Nm or N, with one entry per velocity.
#[derive(Debug, Clone, PartialEq)]
pub struct Efforts {
    /// Forces of drives, within their bounds.
    pub drive: Vec<f64>,
    /// Forces of dry friction, within their bounds.
    pub friction: Vec<f64>,
    /// Forces of limits: not negative at a lower limit and not positive at an upper one, unless [`Report::met`] is
    /// false.
    ///
    /// [`Report::met`]: crate::Report::met
    pub limit: Vec<f64>,
}

/// Results and memory of a step of one tree.
#[derive(Debug, Clone)]
pub(crate) struct Step {
    pub kinematics: Kinematics,
    pub mass: MassMatrix,
    sweep: Sweep,
    pub pivot: Pivot,
    motors: Vec<Motor>,
    /// The linear part of each law: `at - slope v` of springs, viscous friction and external forces.
    passive: Vec<(f64, f64)>,
    /// Positions after half a step at the old velocities; after `finish`, positions at the end of the step.
    pub q: Vec<f64>,
    /// Positions for which poses are computed.
    place: Vec<f64>,
    /// Means of the velocities before and after the step.
    middle: Vec<f64>,
    bias: Vec<f64>,
    /// Generalised forces of contacts.
    pub contact: Vec<f64>,
    /// Bias forces minus forces of contacts.
    load: Vec<f64>,
    pub efforts: Efforts,
}

impl Step {
    pub fn new(tree: &Tree) -> Self {
        let n = tree.velocities();
        let zeros = vec![0.0; n];
        Step {
            kinematics: Kinematics::new(tree),
            mass: MassMatrix::new(tree),
            sweep: Sweep::new(tree),
            pivot: Pivot::new(tree),
            motors: vec![Motor::OFF; n],
            passive: vec![(0.0, 0.0); n],
            q: vec![0.0; tree.positions()],
            place: vec![0.0; tree.positions()],
            middle: zeros.clone(),
            bias: zeros.clone(),
            contact: zeros.clone(),
            load: zeros.clone(),
            efforts: Efforts { drive: zeros.clone(), friction: zeros.clone(), limit: zeros },
        }
    }

    /// Returns an error if the size of an argument does not match the tree, or a value is invalid.
    pub fn check(&self, tree: &Tree, state: &State, drives: &Drives) -> Result<(), DynamicsError> {
        self.kinematics.belongs(tree)?;
        state.check(tree)?;
        drives.check(tree)
    }

    /// Begins a step. For steps with contacts, `carried` contains the efforts of drives in the previous step. The force
    /// of a velocity drive then varies about this effort with a finite slope, because a contact with an immovable joint
    /// would have no solution.
    pub fn begin(&mut self, tree: &Tree, state: &State, drives: &Drives, h: f64, carried: Option<&[f64]>) {
        self.q.copy_from_slice(&state.q);
        advance(tree, &mut self.q, &state.v, 0.5 * h);
        self.place.copy_from_slice(&self.q);
        self.set_poses(tree);
        for d in 0..state.v.len() {
            self.set_law(tree, drives, state, d, h, carried.map(|c| c[d]));
        }
    }

    /// Computes the bias forces at the old velocities and guesses the piece of each law.
    pub fn guess(&mut self, tree: &Tree, v: &[f64], gravity: Vec3, h: f64) {
        self.sweep.run(tree, &self.kinematics, v, None, gravity, &mut self.bias);
        self.set_load();
        self.pivot.begin(tree, &self.mass, &self.load, v, h);
    }

    /// Recomputes the bias forces at the mean velocities.
    pub fn take_mean_velocities(&mut self, tree: &Tree, v: &[f64], gravity: Vec3) {
        for (middle, (v, end)) in self.middle.iter_mut().zip(v.iter().zip(&self.pivot.ends)) {
            *middle = 0.5 * (v + end);
        }
        self.sweep.run(tree, &self.kinematics, &self.middle, None, gravity, &mut self.bias);
    }

    /// Sets the bias forces to the mean of those before and after the step; must follow [`Step::guess`].
    pub fn take_mean_forces(&mut self, tree: &Tree, gravity: Vec3) {
        self.sweep.run(tree, &self.kinematics, &self.pivot.ends, None, gravity, &mut self.middle);
        for (bias, after) in self.bias.iter_mut().zip(&self.middle) {
            *bias = 0.5 * (*bias + after);
        }
    }

    /// Recomputes poses, mass matrix and bias forces for the positions half a step after the old ones, at the mean
    /// velocities.
    pub fn take_mean_poses(&mut self, tree: &Tree, state: &State, gravity: Vec3, h: f64) {
        for (middle, (v, end)) in self.middle.iter_mut().zip(state.v.iter().zip(&self.pivot.ends)) {
            *middle = 0.5 * (v + end);
        }
        self.place.copy_from_slice(&state.q);
        advance(tree, &mut self.place, &self.middle, 0.5 * h);
        self.set_poses(tree);
        self.pivot.renew();
        self.sweep.run(tree, &self.kinematics, &self.middle, None, gravity, &mut self.bias);
    }

    /// Finds the velocities at the end of the step.
    pub fn solve(&mut self, tree: &Tree, v: &[f64], h: f64) -> Result<Search, DynamicsError> {
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
    pub fn conclude(&mut self, tree: &Tree, state: &State, h: f64, met: bool) -> Result<(), DynamicsError> {
        self.share_forces(tree);
        if met { Ok(()) } else { self.settle(tree, &state.v, h) }
    }

    /// Computes the positions at the end.
    pub fn finish(&mut self, tree: &Tree, h: f64) {
        advance(tree, &mut self.q, &self.pivot.ends, 0.5 * h);
    }

    /// Moves joints that are beyond a limit back towards it; returns an error if the result is not finite.
    pub fn limit(&mut self, tree: &Tree, state: &State, h: f64) -> Result<(), DynamicsError> {
        self.stop_at_limits(tree, &state.q, h);
        let finite = self.q.iter().chain(&self.pivot.ends).all(|x| x.is_finite());
        if finite { Ok(()) } else { Err(DynamicsError::Diverged) }
    }

    /// Returns what springs and dampers add to the diagonal of the mass matrix in a step of duration `h`, s, if no drive,
    /// friction or limit acts.
    pub fn damping(&self, h: f64) -> Vec<f64> {
        self.passive.iter().map(|(_, slope)| h * slope).collect()
    }

    /// Returns the maximum change of a velocity in this step.
    pub fn changes(&self, v: &[f64]) -> f64 {
        self.pivot.ends.iter().zip(v).map(|(end, v)| (end - v).abs()).fold(0.0, f64::max)
    }

    /// Writes the result to the state.
    pub fn commit(&self, state: &mut State) {
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
        let given = self.efforts.drive.iter().zip(&self.efforts.friction);
        for (line, (drive, friction)) in self.passive.iter_mut().zip(given) {
            line.0 += drive + friction;
        }
        let settled = self.pivot.settle(tree, &self.mass, &self.load, v, h, &self.passive);
        settled.map_err(|dof| DynamicsError::Singular { dof })?;
        for (d, limit) in self.efforts.limit.iter_mut().enumerate() {
            let (at, slope) = self.passive[d];
            let (low, high) = self.pivot.laws[d].domain();
            let end = self.pivot.ends[d];
            *limit = if end <= low || end >= high { self.pivot.forces[d] - (at - slope * end) } else { 0.0 };
        }
        Ok(())
    }

    /// Sets the law of velocity `d` from its drive, spring, friction and limits.
    ///
    /// Springs and dampers exert the mean of their forces before and after the step, so that errors are of the order
    /// h². This is stable at any stiffness, but a stiff joint would oscillate from step to step. For stiff dampers, the
    /// weight of the velocity after the step is therefore increased, so that they never reverse a velocity, and springs
    /// whose oscillation is too fast for the step get an additional damper.
    fn set_law(&mut self, tree: &Tree, drives: &Drives, state: &State, d: usize, h: f64, carried: Option<f64>) {
        let dof = &tree.dofs[d];
        let (drive, spring) = (&drives.drive[d], &drives.spring[d]);
        let v = state.v[d];
        let q = if dof.position == NONE { 0.0 } else { self.q[dof.position as usize] };
        let (own_stiffness, own_damping) = match drive {
            Drive::Position { stiffness, damping, .. } => (*stiffness, *damping),
            _ => (0.0, 0.0),
        };
        let per_inertia = h / self.mass.diagonal(tree, d);
        let taken = per_inertia * (dof.damping + spring.damping + own_damping);
        let late = if taken > STIFF { 1.0 - 0.5 * STIFF / taken } else { 0.5 };
        let turned = h * per_inertia * (spring.stiffness + own_stiffness);
        let calmed = if turned > STIFF * STIFF { 0.5 * h * (1.0 - STIFF * STIFF / turned) } else { 0.0 };
        // Converts the force `stiffness (target - q) + damping (velocity - v)` to the form `at - slope v`.
        let line = |target: f64, stiffness: f64, velocity: f64, damping: f64| {
            let calm = calmed * stiffness;
            let pull = stiffness * (target - q + 0.25 * h * v);
            let at = pull + damping * (velocity - (1.0 - late) * v) + calm * velocity;
            (at, 0.25 * h * stiffness + late * damping + calm)
        };
        let bounds = Allowed::new(dof, q, h);
        self.motors[d] = match *drive {
            Drive::Off => Motor::OFF,
            Drive::Velocity { target, bound } if let Some(carried) = carried => {
                let slope = HOLD / per_inertia;
                let bound = Bound { force: bound.force.min(STRONGEST), ..bound };
                Motor::Line { at: carried + slope * target, slope, bound }
            }
            Drive::Velocity { target, bound } if bound.force == f64::INFINITY => {
                // An infinite force against a limit would have no solution, so the target is limited to the allowed
                // range.
                Motor::Hold { target: within(target, bounds.low, bounds.high), bound }
            }
            Drive::Velocity { target, bound } => Motor::Hold { target, bound },
            Drive::Position { target, velocity, stiffness, damping, bound } => {
                let (at, slope) = line(target, stiffness, velocity, damping);
                Motor::Line { at, slope, bound }
            }
            Drive::Force { force, bound } => Motor::Line { at: force, slope: 0.0, bound },
        };
        let (at, slope) = line(spring.rest, spring.stiffness, 0.0, spring.damping + dof.damping);
        self.passive[d] = (at + drives.force[d], slope);
        let law = &mut self.pivot.laws[d];
        law.set_motor(&self.motors[d]);
        if dof.friction > 0.0 {
            law.add_friction(dof.friction);
        }
        let (at, slope) = self.passive[d];
        if at != 0.0 || slope != 0.0 {
            law.add_line(at, slope);
        }
        if bounds.low > f64::NEG_INFINITY || bounds.high < f64::INFINITY {
            law.restrict(bounds.low, bounds.high);
        }
    }

    /// Splits the forces of laws into those of drives, friction and limits. If the split is ambiguous, as much as
    /// possible is assigned to the drive, then to friction.
    fn share_forces(&mut self, tree: &Tree) {
        for (d, dof) in tree.dofs.iter().enumerate() {
            let (law, piece) = (&self.pivot.laws[d], self.pivot.pieces[d]);
            let (at, slope) = self.passive[d];
            let rest = self.pivot.forces[d] - (at - slope * self.pivot.ends[d]);
            // A velocity that is outside its piece due to rounding is moved to the end of the piece.
            let v = law.nearest(piece, self.pivot.ends[d]);
            let (low, high) = match (self.motors[d], law.piece(piece)) {
                // Except on vertical pieces, `rest` is more precise than the force of a steep line.
                (Motor::Line { slope, bound, .. }, Piece::Line { .. }) if slope > 0.0 => bound.range(v),
                (motor, _) => motor.range(v),
            };
            let most = dof.friction;
            let (least, greatest) = (if v < 0.0 { most } else { -most }, if v > 0.0 { -most } else { most });
            let drive = within(rest - within(0.0, least, greatest), low, high);
            let friction = within(rest - drive, least, greatest);
            let left = rest - drive - friction;
            let (low, high) = law.domain();
            let limit = if v <= low {
                left.max(0.0)
            } else if v >= high {
                left.min(0.0)
            } else {
                0.0
            };
            self.efforts.drive[d] = drive;
            self.efforts.friction[d] = friction;
            self.efforts.limit[d] = limit;
        }
    }

    /// Moves joints that passed a limit due to the discretisation of the step back to it. Joints that were beyond a
    /// limit before return slowly, by position changes only, which add no momentum.
    fn stop_at_limits(&mut self, tree: &Tree, before: &[f64], h: f64) {
        let back = |beyond: f64| beyond.min(h * (beyond / RETURN_TIME).min(RETURN_SPEED));
        for dof in &tree.dofs {
            if dof.position != NONE {
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

/// The range of velocities that limits allow at the end of a step.
struct Allowed {
    low: f64,
    high: f64,
}

impl Allowed {
    /// Computes the range for position `q` after half of the step. A joint can reach a limit but not pass it, and stops
    /// at it.
    fn new(dof: &Dof, q: f64, h: f64) -> Self {
        if dof.position == NONE {
            return Allowed { low: f64::NEG_INFINITY, high: f64::INFINITY };
        }
        let most = |gap: f64| if gap > 0.0 { 2.0 * gap / h } else { 0.0 };
        Allowed { low: -most(q - dof.low), high: most(dof.high - q) }
    }
}
