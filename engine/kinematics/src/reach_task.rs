//! Targets of a [`ReachSolver`](crate::ReachSolver), how far tips are from them, and their Jacobian.

use nalgebra::{Isometry3, Matrix3, Vector3};

use crate::{chain::Chain, task::Constraints};

/// The pose that a tip shall reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// The pose in the world, m.
    pub pose: Isometry3<f64>,
    /// The directions that count, along the axes of the world; `ALPHA_BETA` alone is the direction of the z axis.
    pub constraints: Constraints,
    /// Accepted distance, m, and angle, rad. Default 1e-6.
    pub precision: [f64; 2],
    /// Weights of position and orientation: what counts if not all goals can be reached. Default 1.
    pub weights: [f64; 2],
}

impl Goal {
    /// Returns the goal to reach a pose.
    pub fn new(pose: Isometry3<f64>) -> Self {
        Goal { pose, constraints: Constraints::POSE, precision: [1e-6; 2], weights: [1.0; 2] }
    }
    /// Returns the goal to reach a position, with any orientation.
    pub fn position(at: Vector3<f64>) -> Self {
        Goal { constraints: Constraints::POSITION, ..Goal::new(Isometry3::translation(at.x, at.y, at.z)) }
    }
}

/// A goal in the form that computations need.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Target {
    rotation: Matrix3<f64>,
    pub place: Vector3<f64>,
    along: [bool; 3],
    /// Rows of orientation: 0, 2 or 3.
    turned: usize,
    precision: [f64; 2],
    weights: [f64; 2],
}

impl Target {
    /// Returns the target of a goal; `oriented` is false if its orientation shall not count.
    pub fn new(goal: &Goal, oriented: bool) -> Self {
        let has = |c| goal.constraints.contains(c);
        Target {
            rotation: goal.pose.rotation.to_rotation_matrix().into_inner(),
            place: goal.pose.translation.vector,
            along: [Constraints::X, Constraints::Y, Constraints::Z].map(has),
            turned: match (oriented && has(Constraints::ALPHA_BETA), has(Constraints::GAMMA)) {
                (true, true) => 3,
                (true, false) => 2,
                _ => 0,
            },
            precision: goal.precision,
            weights: goal.weights,
        }
    }

    pub fn rows(&self) -> usize {
        self.along.iter().filter(|a| **a).count() + self.turned
    }

    /// Writes the values of this target's rows as a translation and a rotation in world axes. `own` is the rotation of the
    /// tip.
    pub fn spread(&self, own: &Matrix3<f64>, rows: &[f64], out: &mut [f64; 6]) {
        let mut rows = rows.iter();
        for k in (0..3).filter(|k| self.along[*k]) {
            out[k] = rows.next().copied().unwrap_or_default();
        }
        let mut about = Vector3::zeros();
        for (value, row) in about.iter_mut().take(self.turned).zip(rows) {
            *value = *row;
        }
        if self.turned == 2 {
            about = own * about;
        }
        out[3..].copy_from_slice(about.as_slice());
    }

    /// Returns the vector to the target and the rotation vector to it. With two rows of orientation, the latter is along
    /// the x and y axes of the tip; otherwise, both are along the axes of the world.
    fn error(&self, (rotation, at): &(Matrix3<f64>, Vector3<f64>)) -> (Vector3<f64>, Vector3<f64>) {
        let mut along = self.place - at;
        for (value, counts) in along.iter_mut().zip(self.along) {
            if !counts {
                *value = 0.0;
            }
        }
        let about = match self.turned {
            3 => rotation_vector(&(self.rotation * rotation.transpose())),
            2 => {
                let wanted = rotation.transpose() * self.rotation.column(2);
                let sine = (wanted.x * wanted.x + wanted.y * wanted.y).sqrt();
                match (sine > 0.0, wanted.z > 0.0) {
                    (true, _) => Vector3::new(-wanted.y, wanted.x, 0.0) * (libm::atan2(sine, wanted.z) / sine),
                    (false, true) => Vector3::zeros(),
                    (false, false) => Vector3::new(std::f64::consts::PI, 0.0, 0.0),
                }
            }
            _ => Vector3::zeros(),
        };
        (along, about)
    }
}

/// How far the tips are from their targets.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Distance {
    /// The greatest distance, m.
    pub distance: f64,
    /// The greatest angle, rad.
    pub angle: f64,
}

/// Writes the weighted errors of all targets, row by row; returns the distances, and whether all are small enough.
pub(crate) fn measure(chain: &Chain, targets: &[Target], error: &mut [f64]) -> (Distance, bool) {
    let (mut all, mut reached, mut row) = (Distance::default(), true, 0);
    for (tip, target) in targets.iter().enumerate() {
        let (along, about) = target.error(&chain.tip(tip));
        let (distance, angle) = (along.norm(), about.norm());
        reached &= distance <= target.precision[0] && angle <= target.precision[1];
        all = Distance { distance: all.distance.max(distance), angle: all.angle.max(angle) };
        for k in (0..3).filter(|k| target.along[*k]) {
            error[row] = along[k] * target.weights[0];
            row += 1;
        }
        for k in 0..target.turned {
            error[row] = about[k] * target.weights[1];
            row += 1;
        }
    }
    (all, reached)
}

/// Writes the weighted Jacobian of all targets, column by column, each with a value for each of `rows`.
pub(crate) fn write_jacobian(chain: &Chain, targets: &[Target], rows: usize, jacobian: &mut [f64]) {
    jacobian.fill(0.0);
    let mut first = 0;
    for (tip, target) in targets.iter().enumerate() {
        let own = chain.tip(tip).0;
        chain.each_motion(tip, |column, linear, mut angular| {
            if target.turned == 2 {
                angular = own.transpose() * angular;
            }
            let out = &mut jacobian[column * rows..][..rows];
            let mut row = first;
            for k in (0..3).filter(|k| target.along[*k]) {
                out[row] += linear[k] * target.weights[0];
                row += 1;
            }
            for k in 0..target.turned {
                out[row] += angular[k] * target.weights[1];
                row += 1;
            }
        });
        first += target.rows();
    }
}

/// Returns the rotation vector of a rotation, rad.
fn rotation_vector(r: &Matrix3<f64>) -> Vector3<f64> {
    let twice = Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]);
    let (sine, cosine) = (0.5 * twice.norm(), 0.5 * (r[(0, 0)] + r[(1, 1)] + r[(2, 2)] - 1.0));
    if sine > 1e-6 {
        return twice * (0.5 * libm::atan2(sine, cosine) / sine);
    }
    if cosine > 0.0 {
        return twice * 0.5;
    }
    // Half a turn: the axis is the longest column of R + I.
    let columns = [0, 1, 2].map(|k| Vector3::from(r.column(k)) + Vector3::ith(k, 1.0));
    let longest = columns.iter().fold(columns[0], |a, b| if b.norm() > a.norm() { *b } else { a });
    longest * (libm::atan2(sine, cosine) / longest.norm())
}
