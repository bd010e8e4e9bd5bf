//! Tasks: a frame that must reach a target.

use std::ops::BitOr;

use nalgebra::{Isometry3, Rotation3, Vector3};
use serde::{Deserialize, Serialize};

use crate::linkage::{FrameId, Linkage};

/// The directions in which a frame must coincide with its target. The axes are those of the task's base.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Constraints(pub u32);

impl Constraints {
    /// Position along x.
    pub const X: Self = Constraints(1);
    /// Position along y.
    pub const Y: Self = Constraints(2);
    /// Position along z.
    pub const Z: Self = Constraints(4);
    /// Direction of the z axis: rotations about it remain free.
    pub const ALPHA_BETA: Self = Constraints(8);
    /// Together with `ALPHA_BETA`, the whole orientation; alone, it has no effect.
    pub const GAMMA: Self = Constraints(16);
    /// The whole position.
    pub const POSITION: Self = Constraints(7);
    /// Position and orientation.
    pub const POSE: Self = Constraints(31);

    /// Returns whether all of these directions are constrained.
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Returns the number of constrained directions, each of which is a row of the Jacobian.
    pub fn rows(self) -> usize {
        let along = [Self::X, Self::Y, Self::Z].iter().filter(|axis| self.contains(**axis)).count();
        along + self.turned_rows()
    }
    fn turned_rows(self) -> usize {
        match (self.contains(Self::ALPHA_BETA), self.contains(Self::GAMMA)) {
            (true, true) => 3,
            (true, false) => 2,
            _ => 0,
        }
    }
}

impl BitOr for Constraints {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Constraints(self.0 | other.0)
    }
}

/// A task: a frame that must reach another frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IkTask {
    /// The frame that moves.
    pub tip: FrameId,
    /// The frame that the tip must reach.
    pub target: FrameId,
    /// The frame at which the chain of joints begins; `None` for the world. If the base is a joint, it is not moved.
    pub base: Option<FrameId>,
    /// The frame whose axes the constraints use; `None` for those of the base.
    pub axes: Option<FrameId>,
    /// The directions in which the two frames must coincide.
    pub constraints: Constraints,
    /// Accepted distance, m, and angle, rad.
    pub precision: [f64; 2],
    /// Weights of position and orientation.
    pub weights: [f64; 2],
    /// Whether the task is solved; a disabled task is ignored.
    pub enabled: bool,
}

impl IkTask {
    /// Returns a task that constrains position and orientation relative to the world. Its precision is 0.5 mm and 0.1
    /// degrees, V-REP's defaults.
    pub fn new(tip: FrameId, target: FrameId) -> Self {
        IkTask {
            tip,
            target,
            base: None,
            axes: None,
            constraints: Constraints::POSE,
            precision: [0.0005, 0.1 * std::f64::consts::PI / 180.0],
            weights: [1.0, 1.0],
            enabled: true,
        }
    }

    /// Returns the rows that this task adds to a Jacobian.
    pub fn rows(&self) -> usize {
        if self.enabled { self.constraints.rows() } else { 0 }
    }

    /// Returns the deviation of the tip from its target, at the current joint positions.
    pub fn error(&self, linkage: &Linkage) -> TaskError {
        let (tip, target) = (linkage.pose(self.tip), linkage.pose(self.target));
        TaskError::between(self, linkage, &tip, &target)
    }
}

/// The deviation of a frame from its target, in the constrained directions.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskError {
    /// Vector from the tip to the target, m, in the axes of `axes`; 0 in unconstrained directions.
    pub along: Vector3<f64>,
    /// Rotation vector from the orientation of the tip to that of the target, rad, in the axes of `axes`; 0 in
    /// unconstrained directions.
    pub about: Vector3<f64>,
    /// The axes of `along` and those of `about`, in the world frame.
    pub axes: [Rotation3<f64>; 2],
}

impl TaskError {
    /// Compares the poses of tip and target, both in the world.
    pub(crate) fn between(task: &IkTask, linkage: &Linkage, tip: &Isometry3<f64>, target: &Isometry3<f64>) -> Self {
        let frame = task.axes.or(task.base);
        let base = frame.map_or_else(Rotation3::identity, |f| linkage.pose(f).rotation.to_rotation_matrix());
        let has = |c| task.constraints.contains(c);
        let to_target = base.inverse() * (target.translation.vector - tip.translation.vector);
        let free = |value: f64, c| if has(c) { value } else { 0.0 };
        let along = Vector3::new(
            free(to_target.x, Constraints::X),
            free(to_target.y, Constraints::Y),
            free(to_target.z, Constraints::Z),
        );
        let (about, axes) = match (has(Constraints::ALPHA_BETA), has(Constraints::GAMMA)) {
            (true, true) => (base.inverse() * rotation_vector(tip, target), base),
            // The axes are those of the tip, which may turn about its z axis. With the axes of the base, a direction
            // would be lost if the tip pointed along x or y.
            (true, false) => {
                let own = tip.rotation.to_rotation_matrix();
                let wanted = own.inverse() * (target.rotation * Vector3::z());
                let sine = libm::hypot(wanted.x, wanted.y);
                let angle = libm::atan2(sine, wanted.z);
                let about = match (sine > 0.0, wanted.z > 0.0) {
                    // The cross product of z and the wanted direction, scaled to the angle between them.
                    (true, _) => Vector3::new(-wanted.y, wanted.x, 0.0) * (angle / sine),
                    (false, true) => Vector3::zeros(),
                    (false, false) => Vector3::new(std::f64::consts::PI, 0.0, 0.0),
                };
                (about, own)
            }
            _ => (Vector3::zeros(), base),
        };
        TaskError { along, about, axes: [base, axes] }
    }

    /// Returns the distance, m.
    pub fn distance(&self) -> f64 {
        self.along.norm()
    }
    /// Returns the angle, rad.
    pub fn angle(&self) -> f64 {
        self.about.norm()
    }
    /// Returns whether the distance, m, and the angle, rad, are at most those in `precision`.
    pub fn is_within(&self, precision: [f64; 2]) -> bool {
        self.distance() <= precision[0] && self.angle() <= precision[1]
    }
}

/// Returns the rotation vector, rad, that turns the tip to the orientation of the target, in world axes.
fn rotation_vector(tip: &Isometry3<f64>, target: &Isometry3<f64>) -> Vector3<f64> {
    let q = (target.rotation * tip.rotation.inverse()).into_inner();
    // q and -q are the same rotation; this sign selects the shorter way.
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    let (sine, cosine) = (q.imag().norm(), q.w * sign);
    if sine < 1e-300 {
        return Vector3::zeros();
    }
    q.imag() * (sign * 2.0 * libm::atan2(sine, cosine) / sine)
}
