//! Iterations towards the targets, starting from the current joint positions.

use nalgebra::{DMatrix, DVector, Vector3};
use serde::{Deserialize, Serialize};

use crate::{
    group::{IkGroup, IkMethod},
    jacobian::{GroupJacobian, JointColumn},
    linkage::{FrameId, Joint, JointType, Linkage, turned},
    matrix::{damped_square, factor, pseudo_inverse, solve_factored, transposed_product},
    task::IkTask,
};

/// Singular values below this fraction of the greatest one are treated as 0.
const SINGULAR_SHARE: f64 = 1e-6;
/// Damping of the inverse that projects onto motions that do not disturb tasks of higher priority.
const PROJECTION_DAMPING: f64 = 1e-6;

/// Whether the targets were reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IkResult {
    /// No group is enabled, or none has a task.
    NotPerformed,
    /// All tips are within the precisions of their tasks.
    Success,
    /// At least one tip is not within the precision of its task.
    Fail,
}

/// A joint at one of its limits.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LimitHit {
    /// The joint.
    pub joint: FrameId,
    /// Amount by which the step would have exceeded the limit, rad or m; negative at the lower limit.
    pub excess: f64,
}

/// The result of [`solve`].
#[derive(Debug, Clone, PartialEq)]
pub struct IkOutcome {
    /// Whether the targets were reached.
    pub result: IkResult,
    /// The largest distance of a tip from its target, m, and the largest angle, rad, in the constrained directions.
    pub precision: [f64; 2],
    /// Whether a step was shortened because it exceeded the maximum step of a joint.
    pub was_shortened: bool,
    /// The joints that the last iteration left at a limit.
    pub limit_hits: Vec<LimitHit>,
    /// Number of iterations.
    pub iterations: u32,
}

/// Moves joints until the tips of all groups are within the precisions of their tasks, or until the greatest number of
/// iterations of any group has been reached. Earlier groups have priority: later groups use only motions that do not
/// affect their tasks. The first group determines how limits and maximum steps are treated, and whether positions are
/// restored.
///
/// Joints remain at the positions of the last iteration, unless the first group restores them. Allocates memory.
pub fn solve(linkage: &mut Linkage, groups: &[&IkGroup]) -> IkOutcome {
    let groups: Vec<&IkGroup> =
        groups.iter().copied().filter(|g| g.enabled && g.tasks.iter().any(|t| t.enabled)).collect();
    let mut outcome = IkOutcome {
        result: IkResult::NotPerformed,
        precision: [0.0; 2],
        was_shortened: false,
        limit_hits: Vec::new(),
        iterations: 0,
    };
    let Some(first) = groups.first() else { return outcome };
    let before = linkage.clone();
    let iterations = groups.iter().map(|g| g.max_iterations).max().unwrap_or(0);
    let mut jacobians: Vec<GroupJacobian> = groups.iter().map(|g| GroupJacobian::new(linkage, &g.tasks)).collect();
    while outcome.iterations < iterations && !are_within(linkage, &groups) {
        outcome.iterations += 1;
        outcome.limit_hits.clear();
        iterate(linkage, &groups, &mut jacobians, &mut outcome);
        if first.stops_at_limits && !outcome.limit_hits.is_empty() {
            break;
        }
    }
    outcome.precision = precision(linkage, groups.iter().flat_map(|g| &g.tasks));
    outcome.result = if are_within(linkage, &groups) { IkResult::Success } else { IkResult::Fail };
    if outcome.result == IkResult::Fail {
        let misses = |i: usize| {
            let all = groups.iter().flat_map(|g| &g.tasks).filter(|t| t.enabled);
            all.map(|t| (t, t.error(linkage))).any(|(t, e)| [e.distance(), e.angle()][i] > t.precision[i])
        };
        if (0..2).any(|i| first.restores[i] && misses(i)) {
            *linkage = before;
        }
    }
    outcome
}

/// Returns whether all tips are within the precisions of their tasks.
fn are_within(linkage: &Linkage, groups: &[&IkGroup]) -> bool {
    let mut tasks = groups.iter().flat_map(|g| &g.tasks).filter(|t| t.enabled);
    tasks.all(|t| t.error(linkage).is_within(t.precision))
}

/// Returns the largest distance, m, and the largest angle, rad, of enabled tasks.
pub(crate) fn precision<'t>(linkage: &Linkage, tasks: impl IntoIterator<Item = &'t IkTask>) -> [f64; 2] {
    tasks
        .into_iter()
        .filter(|t| t.enabled)
        .map(|t| t.error(linkage))
        .fold([0.0; 2], |[distance, angle], e| [f64::max(distance, e.distance()), f64::max(angle, e.angle())])
}

/// One iteration of all groups.
fn iterate(linkage: &mut Linkage, groups: &[&IkGroup], jacobians: &mut [GroupJacobian], outcome: &mut IkOutcome) {
    for (group, jacobian) in groups.iter().zip(&mut *jacobians) {
        jacobian.update(linkage, &group.tasks);
        scale_columns(linkage, jacobian);
    }
    let mut columns: Vec<JointColumn> = Vec::new();
    for column in jacobians.iter().flat_map(|j| &j.columns) {
        if !columns.contains(column) {
            columns.push(*column);
        }
    }
    let mut step = prioritized_step(groups, jacobians, &columns);
    if groups[0].keeps_limits {
        freeze_at_limits(linkage, groups, jacobians, &columns, &mut step);
    }
    for (dq, column) in step.iter_mut().zip(&columns) {
        *dq *= weight(linkage.joint(column.joint));
    }
    if !step.iter().all(|dq| dq.is_finite()) {
        return;
    }
    if !groups[0].ignores_max_steps {
        outcome.was_shortened |= shorten(linkage, &columns, &mut step);
    }
    apply(linkage, &columns, &step, &mut outcome.limit_hits);
}

fn weight(joint: Option<&Joint>) -> f64 {
    joint.map_or(1.0, |j| j.weight)
}

/// Multiplies the columns by the weights of their joints.
fn scale_columns(linkage: &Linkage, jacobian: &mut GroupJacobian) {
    for (c, column) in jacobian.columns.iter().enumerate() {
        let weight = weight(linkage.joint(column.joint));
        if weight != 1.0 {
            jacobian.matrix.column_mut(c).scale_mut(weight);
        }
    }
}

/// Returns the step of all columns: dq0 + N0 (dq1 + N1 (dq2 + ...)), where N projects onto the motions that do not
/// affect the tasks of a group.
fn prioritized_step(groups: &[&IkGroup], jacobians: &[GroupJacobian], columns: &[JointColumn]) -> DVector<f64> {
    let mut step = DVector::zeros(columns.len());
    for (i, (group, jacobian)) in groups.iter().zip(jacobians).enumerate().rev() {
        let own = group_step(group, &jacobian.matrix, &jacobian.error);
        let place = |c: &JointColumn| columns.iter().position(|all| all == c).unwrap_or(0);
        if i + 1 < groups.len() {
            let mut wide = DMatrix::zeros(jacobian.matrix.nrows(), columns.len());
            for (c, column) in jacobian.columns.iter().enumerate() {
                wide.set_column(place(column), &jacobian.matrix.column(c));
            }
            let disturbance = &wide * &step;
            step -= damped_step(&wide, &disturbance, PROJECTION_DAMPING);
        }
        for (dq, column) in own.iter().zip(&jacobian.columns) {
            step[place(column)] += dq;
        }
    }
    step
}

/// Returns the step of one group, for its own columns.
fn group_step(group: &IkGroup, j: &DMatrix<f64>, e: &DVector<f64>) -> DVector<f64> {
    match group.method {
        IkMethod::PseudoInverse => pseudo_inverse(j, SINGULAR_SHARE) * e,
        IkMethod::DampedLeastSquares => damped_step(j, e, group.damping),
        IkMethod::JacobianTranspose => {
            let mut dq = DVector::zeros(j.ncols());
            transposed_product(j, e, &mut dq);
            let moved = j * &dq;
            let square = moved.dot(&moved);
            if square > 0.0 { dq * (e.dot(&moved) / square) } else { dq * 0.0 }
        }
    }
}

/// Returns the step J' (J J' + d² I)⁻¹ e, or zeros if the matrix cannot be factorised.
fn damped_step(j: &DMatrix<f64>, e: &DVector<f64>, damping: f64) -> DVector<f64> {
    let mut square = DMatrix::zeros(j.nrows(), j.nrows());
    damped_square(j, damping * damping, &mut square);
    let mut out = DVector::zeros(j.ncols());
    if factor(&mut square) {
        let mut y = e.clone();
        solve_factored(&square, &mut y);
        transposed_product(j, &y, &mut out);
    }
    out
}

/// Holds joints that the step would move beyond a limit, and recomputes the step of the other joints to compensate, at
/// most once per joint.
fn freeze_at_limits(
    linkage: &Linkage,
    groups: &[&IkGroup],
    jacobians: &mut [GroupJacobian],
    columns: &[JointColumn],
    step: &mut DVector<f64>,
) {
    for _ in 0..columns.len() {
        let beyond = columns.iter().zip(step.iter()).position(|(column, dq)| {
            let Some(joint) = linkage.joint(column.joint) else { return false };
            let Some([low, high]) = joint.limits else { return false };
            let to = joint.position + dq * joint.weight;
            (to < low && joint.position <= low && *dq < 0.0) || (to > high && joint.position >= high && *dq > 0.0)
        });
        let Some(frozen) = beyond else { return };
        for jacobian in &mut *jacobians {
            if let Some(c) = jacobian.columns.iter().position(|c| *c == columns[frozen]) {
                jacobian.matrix.column_mut(c).fill(0.0);
            }
        }
        *step = prioritized_step(groups, jacobians, columns);
    }
}

/// Halves a step until no joint exceeds its maximum step. Returns whether the step was halved.
fn shorten(linkage: &Linkage, columns: &[JointColumn], step: &mut DVector<f64>) -> bool {
    let too_big = |step: &DVector<f64>| {
        let max = |c: &JointColumn| linkage.joint(c.joint).map_or(f64::INFINITY, |j| j.max_step);
        columns.iter().zip(step.iter()).any(|(c, dq)| max(c) > 0.0 && dq.abs() > max(c))
    };
    let mut was_shortened = false;
    while too_big(step) {
        *step *= 0.5;
        was_shortened = true;
    }
    was_shortened
}

/// Moves the joints by a step, and keeps them within their limits.
fn apply(linkage: &mut Linkage, columns: &[JointColumn], step: &DVector<f64>, hits: &mut Vec<LimitHit>) {
    for (column, dq) in columns.iter().zip(step.iter()) {
        let Some(joint) = linkage.joint_mut(column.joint) else { continue };
        if joint.kind == JointType::Spherical {
            if column.axis == 0 {
                let first = columns.iter().position(|c| c == column).unwrap_or(0);
                let turn = Vector3::from_fn(|k, _| step[first + k]);
                joint.rotation = turned(turn) * joint.rotation;
            }
            continue;
        }
        let wanted = joint.position + dq;
        joint.position = joint.limits.map_or(wanted, |[low, high]| wanted.clamp(low, high));
        if joint.position != wanted {
            hits.push(LimitHit { joint: column.joint, excess: wanted - joint.position });
        }
    }
}
