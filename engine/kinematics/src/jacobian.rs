//! The Jacobian of a group of tasks.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::{
    linkage::{FrameId, JointType, Linkage},
    task::{Constraints, IkTask, TaskError},
};

/// A column of a Jacobian, which corresponds to a degree of freedom of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointColumn {
    /// The joint.
    pub joint: FrameId,
    /// Index of the axis of a spherical joint: 0, 1 or 2 for x, y or z. It is 0 for all other joints.
    pub axis: usize,
}

/// The Jacobian of tasks, and their errors.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupJacobian {
    /// The columns: task by task, and for each task from the base of its chain to the tip.
    pub columns: Vec<JointColumn>,
    /// One row per constrained direction of each task, weighted: x, y, z, alpha, beta, gamma.
    pub matrix: DMatrix<f64>,
    /// The error in each row, from tip to target, m or rad, weighted.
    pub error: DVector<f64>,
}

impl GroupJacobian {
    /// Allocates the Jacobian of tasks; [`update`](Self::update) computes its values.
    pub(crate) fn new(linkage: &Linkage, tasks: &[IkTask]) -> Self {
        let columns = columns(linkage, tasks);
        let rows = tasks.iter().map(IkTask::rows).sum();
        let (matrix, error) = (DMatrix::zeros(rows, columns.len()), DVector::zeros(rows));
        GroupJacobian { columns, matrix, error }
    }

    /// Computes the Jacobian and the errors at the current joint positions.
    pub(crate) fn update(&mut self, linkage: &Linkage, tasks: &[IkTask]) {
        self.matrix.fill(0.0);
        let mut row = 0;
        for task in tasks.iter().filter(|t| t.enabled) {
            self.add_task(linkage, task, row);
            row += task.rows();
        }
    }

    fn add_task(&mut self, linkage: &Linkage, task: &IkTask, first: usize) {
        let (tip, target) = (linkage.pose(task.tip), linkage.pose(task.target));
        let error = TaskError::between(task, linkage, &tip, &target);
        let has = |c| task.constraints.contains(c);
        let along = [Constraints::X, Constraints::Y, Constraints::Z].map(has);
        let turned = match (has(Constraints::ALPHA_BETA), has(Constraints::GAMMA)) {
            (true, true) => 3,
            (true, false) => 2,
            _ => 0,
        };
        let axes = [error.axes[0].inverse(), error.axes[1].inverse()];
        let mut write = |row: usize, column: usize, linear: &Vector3<f64>, angular: &Vector3<f64>| {
            let mut at = row;
            for k in (0..3).filter(|k| along[*k]) {
                self.matrix[(at, column)] += linear[k] * task.weights[0];
                at += 1;
            }
            for k in 0..turned {
                self.matrix[(at, column)] += angular[k] * task.weights[1];
                at += 1;
            }
        };
        for joint in chain(linkage, task) {
            let Some((mover, ratio)) = linkage.mover(joint) else { continue };
            let Some(column) = self.columns.iter().position(|c| c.joint == mover) else { continue };
            let Some(described) = linkage.joint(joint) else { continue };
            let (axis, through) = linkage.axis(joint);
            let arm = tip.translation.vector - through;
            match described.kind {
                JointType::Revolute => {
                    let linear = axis.cross(&arm) + axis * described.lead;
                    write(first, column, &(axes[0] * linear * ratio), &(axes[1] * axis * ratio));
                }
                JointType::Prismatic => write(first, column, &(axes[0] * axis * ratio), &Vector3::zeros()),
                JointType::Spherical => {
                    let frame = linkage.pose(joint).rotation;
                    for k in 0..3 {
                        let axis = frame * Vector3::ith(k, 1.0);
                        write(first, column + k, &(axes[0] * axis.cross(&arm)), &(axes[1] * axis));
                    }
                }
            }
        }
        let mut at = first;
        for k in (0..3).filter(|k| along[*k]) {
            self.error[at] = error.along[k] * task.weights[0];
            at += 1;
        }
        for k in 0..turned {
            self.error[at] = error.about[k] * task.weights[1];
            at += 1;
        }
    }
}

/// Returns the Jacobian of tasks at the current joint positions, for callers that need only the Jacobian. Allocates
/// memory.
pub fn group_jacobian(linkage: &Linkage, tasks: &[IkTask]) -> GroupJacobian {
    let mut all = GroupJacobian::new(linkage, tasks);
    all.update(linkage, tasks);
    all
}

/// Returns the joints of a task's chain, from its tip to its base, without the base.
pub(crate) fn chain<'l>(linkage: &'l Linkage, task: &'l IkTask) -> impl Iterator<Item = FrameId> + 'l {
    linkage
        .above(task.tip)
        .skip(1)
        .take_while(move |id| Some(*id) != task.base)
        .filter(|id| linkage.joint(*id).is_some())
}

/// Returns the degrees of freedom that move the tips of tasks, from base to tip.
fn columns(linkage: &Linkage, tasks: &[IkTask]) -> Vec<JointColumn> {
    let mut columns: Vec<JointColumn> = Vec::new();
    for task in tasks.iter().filter(|t| t.enabled) {
        let mut joints: Vec<FrameId> = chain(linkage, task).collect();
        joints.reverse();
        for joint in joints.into_iter().filter_map(|j| Some(linkage.mover(j)?.0)) {
            if columns.iter().any(|c| c.joint == joint) {
                continue;
            }
            let freedoms = linkage.joint(joint).map_or(0, |j| j.freedoms());
            columns.extend((0..freedoms).map(|axis| JointColumn { joint, axis }));
        }
    }
    columns
}
