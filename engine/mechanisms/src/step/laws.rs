//! The laws of joints in a step, and the division of their forces among drives, friction and limits.

use super::TreeStep;
use crate::{
    drive::{DofDrive, ForceBound, JointSpring, TreeDrives},
    law::LawPiece,
    motor::{MotorCurve, within},
    paths::NO_INDEX,
    state::TreeState,
    tree::{Dof, Tree},
};

/// Fraction of the velocity of an isolated joint that a damper may remove in a step before it is treated as stiff; also
/// the phase, rad, by which a spring may advance in a step.
const STIFF_SHARE: f64 = 0.5;
/// Slope, in units of inertia over step duration, with which the force of a velocity drive depends on the velocity in
/// steps with contacts: an impulse that would change the velocity of the free joint by 1 changes it by about 1 /
/// `HOLD_SLOPE`.
const HOLD_SLOPE: f64 = 1e3;
/// Maximum force of such a drive, Nm or N, even if its bound is greater or infinite.
const MAX_HOLD_FORCE: f64 = 1e9;
/// Difference, relative to 1 plus the velocity, up to which the targets of drives that gears couple are one target: they
/// differ by rounding if they are computed for each joint.
const SAME_TARGET: f64 = 1e-9;

impl TreeStep {
    /// Sets the laws of all velocities. For steps with contacts, `carried` contains the efforts of drives in the
    /// previous step. The force of a velocity drive then varies about this effort with a finite slope, because a
    /// contact with an immovable joint would have no solution.
    pub fn set_laws(&mut self, tree: &Tree, state: &TreeState, drives: &TreeDrives, h: f64, carried: Option<&[f64]>) {
        for d in 0..state.v.len() {
            self.set_law(tree, drives, state, d, h, carried);
        }
    }

    /// Sets the law of velocity `d` from its drives, springs, friction and limits.
    ///
    /// Springs and dampers exert the mean of their forces before and after the step, so that errors are of the order
    /// h². This is stable at any stiffness, but a stiff joint would oscillate from step to step. For stiff dampers, the
    /// weight of the velocity after the step is therefore increased, so that they never reverse a velocity, and springs
    /// whose oscillation is too fast for the step get an additional damper.
    fn set_law(
        &mut self,
        tree: &Tree,
        drives: &TreeDrives,
        state: &TreeState,
        d: usize,
        h: f64,
        carried: Option<&[f64]>,
    ) {
        let dof = &tree.dofs[d];
        let spring = spring_of(tree, drives, d);
        let v = state.v[d];
        let q = if dof.position == NO_INDEX { 0.0 } else { self.q[dof.position as usize] };
        let (mut own_stiffness, mut own_damping) = (0.0, 0.0);
        for axis in tree.axes_of(d) {
            if let DofDrive::Position { stiffness, damping, .. } = drive_of(tree, drives, *axis) {
                (own_stiffness, own_damping) = (own_stiffness + stiffness, own_damping + damping);
            }
        }
        let per_inertia = h / self.mass.diagonal(tree, d);
        let taken = per_inertia * (dof.damping + spring.damping + own_damping);
        let late = if taken > STIFF_SHARE { 1.0 - 0.5 * STIFF_SHARE / taken } else { 0.5 };
        let turned = h * per_inertia * (spring.stiffness + own_stiffness);
        let calmed =
            if turned > STIFF_SHARE * STIFF_SHARE { 0.5 * h * (1.0 - STIFF_SHARE * STIFF_SHARE / turned) } else { 0.0 };
        // Converts the force `stiffness (target - q) + damping (velocity - v)` to the form `at - slope v`.
        let line = |target: f64, stiffness: f64, velocity: f64, damping: f64| {
            let calm = calmed * stiffness;
            let pull = stiffness * (target - q + 0.25 * h * v);
            let at = pull + damping * (velocity - (1.0 - late) * v) + calm * velocity;
            (at, 0.25 * h * stiffness + late * damping + calm)
        };
        let bounds = VelocityRange::new(dof, q, h);
        for (i, &axis) in tree.axes_of(d).iter().enumerate() {
            let node = tree.node_of(axis);
            let carried = carried.map(|carried| node.gear.ratio * carried[axis as usize]);
            let curve = match drive_of(tree, drives, axis) {
                DofDrive::Off => MotorCurve::OFF,
                DofDrive::Velocity { target, bound } if let Some(carried) = carried => {
                    let slope = HOLD_SLOPE / per_inertia;
                    let bound = ForceBound { force: bound.force.min(MAX_HOLD_FORCE), ..bound };
                    MotorCurve::Line { at: carried + slope * target, slope, bound }
                }
                DofDrive::Velocity { target, bound } if bound.force == f64::INFINITY => {
                    // An infinite force against a limit would have no solution, so the target is limited to the
                    // allowed range.
                    MotorCurve::Hold { target: within(target, bounds.low, bounds.high), bound }
                }
                DofDrive::Velocity { target, bound } => MotorCurve::Hold { target, bound },
                DofDrive::Position { target, velocity, stiffness, damping, bound } => {
                    let (at, slope) = line(target, stiffness, velocity, damping);
                    MotorCurve::Line { at, slope, bound }
                }
                DofDrive::Force { force, bound } => MotorCurve::Line { at: force, slope: 0.0, bound },
            };
            let others = tree.axes_of(d)[..i].iter().map(|other| &self.motors[*other as usize]);
            self.motors[axis as usize] = with_same_target(curve, others);
        }
        let (at, slope) = line(spring.rest, spring.stiffness, 0.0, spring.damping + dof.damping);
        self.passive[d] = (at + drives.force[d], slope);
        let law = &mut self.pivot.laws[d];
        law.set_motors(tree.axes_of(d).iter().map(|axis| &self.motors[*axis as usize]));
        let friction = dof.friction + self.contact_friction[d];
        if friction > 0.0 {
            law.add_friction(friction);
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
    pub(super) fn share_forces(&mut self, tree: &Tree) {
        for (d, dof) in tree.dofs.iter().enumerate() {
            let (law, piece) = (&self.pivot.laws[d], self.pivot.pieces[d]);
            let (at, slope) = self.passive[d];
            let rest = self.pivot.forces[d] - (at - slope * self.pivot.ends[d]);
            // A velocity that is outside its piece due to rounding is moved to the end of the piece.
            let v = law.clamp_to_piece(piece, self.pivot.ends[d]);
            let (mut low, mut high) = (0.0, 0.0);
            for axis in tree.axes_of(d) {
                let (least, greatest) = match (self.motors[*axis as usize], law.piece(piece)) {
                    // Except on vertical pieces, `rest` is more precise than the force of a steep line.
                    (MotorCurve::Line { slope, bound, .. }, LawPiece::Line { .. }) if slope > 0.0 => bound.range(v),
                    (motor, _) => motor.range(v),
                };
                (low, high) = (low + least, high + greatest);
            }
            let most = dof.friction + self.contact_friction[d];
            let (least, greatest) = (if v < 0.0 { most } else { -most }, if v > 0.0 { -most } else { most });
            let drive = within(rest - within(0.0, least, greatest), low, high);
            let friction = within(rest - drive, least, greatest);
            let left = rest - drive - friction;
            let (low, high) = law.velocity_range();
            let limit = if v <= low {
                left.max(0.0)
            } else if v >= high {
                left.min(0.0)
            } else {
                0.0
            };
            self.drive_forces[d] = drive;
            self.efforts.friction[d] = friction;
            self.efforts.limit[d] = limit;
            self.share_drive(tree, d, v, drive);
        }
    }

    /// Divides the force of all drives of velocity `d` among them, at velocity `v`.
    fn share_drive(&mut self, tree: &Tree, d: usize, v: f64, drive: f64) {
        let axes = tree.axes_of(d);
        let efforts = &mut self.efforts.drive;
        if let [axis] = axes
            && !tree.node_of(*axis).gear.geared
        {
            efforts[*axis as usize] = drive;
            return;
        }
        // Each first exerts what its own curve gives, and the same fraction of the range on a vertical piece.
        let ranges = |axis: &u32| self.motors[*axis as usize].range_at(v);
        let (low, high) = axes.iter().map(ranges).fold((0.0, 0.0), |sum, range| (sum.0 + range.0, sum.1 + range.1));
        let share = if high > low { within((drive - low) / (high - low), 0.0, 1.0) } else { 0.0 };
        let mut left = drive;
        for axis in axes {
            let (low, high) = ranges(axis);
            let force = low + share * (high - low);
            efforts[*axis as usize] = force;
            left -= force;
        }
        // Steep lines carry what remains because the velocity is rounded.
        let slope = |axis: &u32| match self.motors[*axis as usize] {
            MotorCurve::Line { slope, .. } => slope,
            MotorCurve::Hold { .. } => 0.0,
        };
        let slopes: f64 = axes.iter().map(slope).sum();
        for axis in axes {
            let ratio = tree.node_of(*axis).gear.ratio;
            let effort = &mut efforts[*axis as usize];
            if let MotorCurve::Line { slope, bound, .. } = self.motors[*axis as usize]
                && slope > 0.0
            {
                let (low, high) = bound.range(v);
                *effort = within(*effort + left * (slope / slopes), low, high);
            }
            *effort = if ratio == 0.0 { 0.0 } else { *effort / ratio };
        }
    }
}

/// Returns the drive of an axis, in the coordinate of the velocity that moves it.
#[inline(always)]
fn drive_of(tree: &Tree, drives: &TreeDrives, axis: u32) -> DofDrive {
    let (node, drive) = (tree.node_of(axis), drives.drive[axis as usize]);
    if node.gear.geared { drive.through_gear(node.gear.ratio, node.gear.offset) } else { drive }
}

/// Returns a spring that has the effect of those of all axes that a velocity moves.
#[inline(always)]
fn spring_of(tree: &Tree, drives: &TreeDrives, d: usize) -> JointSpring {
    let axes = tree.axes_of(d);
    if let [axis] = axes
        && !tree.node_of(*axis).gear.geared
    {
        return drives.spring[*axis as usize];
    }
    let mut sum = JointSpring::default();
    let mut force = 0.0;
    for axis in axes {
        let (node, spring) = (tree.node_of(*axis), &drives.spring[*axis as usize]);
        sum.stiffness += node.gear.ratio * node.gear.ratio * spring.stiffness;
        sum.damping += node.gear.ratio * node.gear.ratio * spring.damping;
        force += node.gear.ratio * spring.stiffness * (spring.rest - node.gear.offset);
    }
    if sum.stiffness > 0.0 {
        sum.rest = force / sum.stiffness;
    }
    sum
}

/// Returns a curve whose target is exactly that of another motor if the two differ by rounding only.
#[inline(always)]
fn with_same_target<'a>(curve: MotorCurve, others: impl Iterator<Item = &'a MotorCurve>) -> MotorCurve {
    let MotorCurve::Hold { target, bound } = curve else { return curve };
    for other in others {
        if let MotorCurve::Hold { target: other, .. } = *other
            && (other - target).abs() <= SAME_TARGET * (1.0 + target.abs())
        {
            return MotorCurve::Hold { target: other, bound };
        }
    }
    curve
}

/// The range of velocities that limits allow at the end of a step.
struct VelocityRange {
    low: f64,
    high: f64,
}

impl VelocityRange {
    /// Computes the range for position `q` after half of the step. A joint can reach a limit but not pass it, and stops
    /// at it.
    fn new(dof: &Dof, q: f64, h: f64) -> Self {
        if dof.position == NO_INDEX {
            return VelocityRange { low: f64::NEG_INFINITY, high: f64::INFINITY };
        }
        let most = |gap: f64| if gap > 0.0 { 2.0 * gap / h } else { 0.0 };
        VelocityRange { low: -most(q - dof.low), high: most(dof.high - q) }
    }
}
