//! The phases of a step of one tree. A solver runs them for a tree on its own, a group for trees that touch.
//!
//! [`Step::begin`] moves positions half a step at the old velocities and computes poses, laws and bias forces there;
//! [`Step::solve`] finds the velocities at the end; [`Step::take_mean_velocities`] and [`Step::take_mean_poses`] make
//! the equation more exact for the next `solve`; [`Step::finish`] computes forces and positions at the end, and
//! [`Step::commit`] writes them.

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

/// Time in which a joint that is beyond a limit comes back, s, and the greatest speed at which it does, rad/s or m/s.
const RETURN_TIME: f64 = 0.1;
const RETURN_SPEED: f64 = 1.0;
/// Share of a velocity that a damper may take in a step, of the joint alone, before it is treated as stiff; likewise,
/// in rad, the part of a swing that a spring may go through.
const STIFF: f64 = 0.5;
/// Stiffness of a drive that holds a velocity where contacts may act against it, in units of the joint's inertia over
/// the step: an impulse that would change the velocity by 1 changes it by the inverse of this.
const HOLD: f64 = 1e3;
/// Bound of such a drive if it has none, Nm or N.
const STRONGEST: f64 = 1e9;

/// Forces of the last step, Nm or N, one for each velocity.
#[derive(Debug, Clone, PartialEq)]
pub struct Efforts {
    /// Of drives: never beyond their bounds.
    pub drive: Vec<f64>,
    /// Of dry friction: never beyond it.
    pub friction: Vec<f64>,
    /// Of limits: not below 0 at a lower one, not above 0 at an upper one, unless [`Report::met`] is false.
    ///
    /// [`Report::met`]: crate::Report::met
    pub limit: Vec<f64>,
}

/// What a step of one tree computes, and the room for it.
#[derive(Debug, Clone)]
pub(crate) struct Step {
    pub kinematics: Kinematics,
    pub mass: MassMatrix,
    sweep: Sweep,
    pub pivot: Pivot,
    motors: Vec<Motor>,
    /// Forces without corners: `at - slope v` of springs, viscous friction and forces from outside.
    passive: Vec<(f64, f64)>,
    /// Half a step at the old velocities, then the positions at the end.
    pub q: Vec<f64>,
    /// Positions for which poses are computed.
    place: Vec<f64>,
    /// Means of velocities before and after the step.
    middle: Vec<f64>,
    bias: Vec<f64>,
    /// Generalised forces of contacts.
    pub contact: Vec<f64>,
    /// Bias forces less those of contacts.
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

    /// Refuses what belongs to another tree, and numbers that make no sense.
    pub fn check(&self, tree: &Tree, state: &State, drives: &Drives) -> Result<(), DynamicsError> {
        self.kinematics.belongs(tree)?;
        state.check(tree)?;
        drives.check(tree)
    }

    /// Begins a step. With `carried`, the efforts of drives in the step before, drives that hold a velocity do so with
    /// a finite stiffness about that effort, as contacts need it: a contact with a joint that nothing can move would
    /// have no solution.
    pub fn begin(&mut self, tree: &Tree, state: &State, drives: &Drives, h: f64, carried: Option<&[f64]>) {
        self.q.copy_from_slice(&state.q);
        advance(tree, &mut self.q, &state.v, 0.5 * h);
        self.place.copy_from_slice(&self.q);
        self.set_poses(tree);
        for d in 0..state.v.len() {
            self.set_law(tree, drives, state, d, h, carried.map(|c| c[d]));
        }
    }

    /// Computes the bias forces of the old velocities and guesses the piece of each law.
    pub fn guess(&mut self, tree: &Tree, v: &[f64], gravity: Vec3, h: f64) {
        self.sweep.run(tree, &self.kinematics, v, None, gravity, &mut self.bias);
        self.set_load();
        self.pivot.begin(tree, &self.mass, &self.load, v, h);
    }

    /// Computes the bias forces again, of the means of velocities.
    pub fn take_mean_velocities(&mut self, tree: &Tree, v: &[f64], gravity: Vec3) {
        for (middle, (v, end)) in self.middle.iter_mut().zip(v.iter().zip(&self.pivot.ends)) {
            *middle = 0.5 * (v + end);
        }
        self.sweep.run(tree, &self.kinematics, &self.middle, None, gravity, &mut self.bias);
    }

    /// Computes poses and bias forces again, half a step from the old positions at the means of velocities.
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

    /// Computes the forces, and the positions at the end; `met` tells whether the last search met all laws.
    pub fn finish(&mut self, tree: &Tree, state: &State, h: f64, met: bool) -> Result<(), DynamicsError> {
        self.share_forces(tree);
        if !met {
            self.settle(tree, &state.v, h)?;
        }
        advance(tree, &mut self.q, &self.pivot.ends, 0.5 * h);
        Ok(())
    }

    /// Puts joints onto the limits that they passed, and refuses results that are not finite.
    pub fn limit(&mut self, tree: &Tree, state: &State, h: f64) -> Result<(), DynamicsError> {
        self.stop_at_limits(tree, &state.q, h);
        let finite = self.q.iter().chain(&self.pivot.ends).all(|x| x.is_finite());
        if finite { Ok(()) } else { Err(DynamicsError::Diverged) }
    }

    /// Returns the greatest change of a velocity so far.
    pub fn changes(&self, v: &[f64]) -> f64 {
        self.pivot.ends.iter().zip(v).map(|(end, v)| (end - v).abs()).fold(0.0, f64::max)
    }

    /// Writes the result.
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

    /// Ends a step whose laws were not met: drives and friction give what was found last, which is within their bounds.
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

    /// Sets the law of one velocity.
    ///
    /// Springs pull with the mean of their forces before and after the step, and so do dampers: errors are of the order
    /// h². That is stable at any stiffness, but what is stiff would then swing from step to step. So the share of the
    /// velocity after the step grows for stiff dampers, which thus never turn a velocity round, and springs that swing
    /// faster than steps can follow get a damper.
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
        // the force `stiffness (target - q) + damping (velocity - v)` as `at - slope v`
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
                // pushing with infinite force against a limit has no solution: it stops there instead
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

    /// Splits the forces of laws into those of drives, friction and limits. Where several could give a force, the drive
    /// gives what it can, then friction.
    fn share_forces(&mut self, tree: &Tree) {
        for (d, dof) in tree.dofs.iter().enumerate() {
            let (law, piece) = (&self.pivot.laws[d], self.pivot.pieces[d]);
            let (at, slope) = self.passive[d];
            let rest = self.pivot.forces[d] - (at - slope * self.pivot.ends[d]);
            // a velocity that is beyond its piece by rounding counts as on it
            let v = law.nearest(piece, self.pivot.ends[d]);
            let (low, high) = match (self.motors[d], law.piece(piece)) {
                // off vertical pieces, the rest is known better than the force of a steep line
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

    /// Puts joints that passed a limit by the discretisation of the step onto it. Those that were beyond before come
    /// back slowly, by positions only, so that they have no momentum when they arrive.
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

/// The velocities that limits allow at the end of a step.
struct Allowed {
    low: f64,
    high: f64,
}

impl Allowed {
    /// `q`: position after half of the step. A limit may be reached, not passed; a joint that hits it stops.
    fn new(dof: &Dof, q: f64, h: f64) -> Self {
        if dof.position == NONE {
            return Allowed { low: f64::NEG_INFINITY, high: f64::INFINITY };
        }
        let most = |gap: f64| if gap > 0.0 { 2.0 * gap / h } else { 0.0 };
        Allowed { low: -most(q - dof.low), high: most(dof.high - q) }
    }
}
