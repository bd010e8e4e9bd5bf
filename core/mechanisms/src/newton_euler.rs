//! The recursive Newton-Euler sweep: forces that an acceleration needs.

use crate::{
    kinematics::Kinematics,
    spatial::{Force, Motion},
    tree::{Kind, NONE, Tree},
    vector::{Vec3, scale},
};

/// Room for one sweep: velocity, acceleration and force of each link.
#[derive(Debug, Clone)]
pub(crate) struct Sweep {
    velocities: Vec<Motion>,
    accelerations: Vec<Motion>,
    forces: Vec<Force>,
}

impl Sweep {
    pub fn new(tree: &Tree) -> Self {
        let n = tree.nodes.len();
        Sweep {
            velocities: vec![Motion::default(); n],
            accelerations: vec![Motion::default(); n],
            forces: vec![Force::default(); n],
        }
    }

    /// Writes the generalised forces that links with the given velocities need to accelerate as given, without those of
    /// armatures; without accelerations: the bias forces (Coriolis, centrifugal, gravity).
    ///
    /// Source: Featherstone, chapter 5, here in world axes. Gravity is an acceleration of the root the other way.
    pub fn run(
        &mut self,
        tree: &Tree,
        kinematics: &Kinematics,
        v: &[f64],
        acceleration: Option<&[f64]>,
        gravity: Vec3,
        out: &mut [f64],
    ) {
        let root = Motion { angular: [0.0; 3], linear: scale(gravity, -1.0) };
        for (i, node) in tree.nodes.iter().enumerate() {
            let (mut velocity, mut a) = if node.parent == NONE {
                (Motion::default(), root)
            } else {
                (self.velocities[node.parent as usize], self.accelerations[node.parent as usize])
            };
            let mut first = node.velocity;
            let end = first + node.velocities;
            if let Kind::Free = node.kind {
                // axes of the world: they do not turn with the link
                for k in 0..3 {
                    velocity.linear[k] += v[first + k];
                }
                first += 3;
            }
            // Axes at rest in the parent turn with it, those at rest in the link with the link; both have the same
            // derivative, since what the axes of one joint add to it cancels in the sum.
            let moving = velocity;
            for (axis, &speed) in kinematics.axes[first..end].iter().zip(&v[first..end]) {
                let step = axis.times(speed);
                a = a.plus(moving.cross(&step));
                velocity = velocity.plus(step);
            }
            if let Some(acceleration) = acceleration {
                for (axis, &own) in kinematics.axes[node.range()].iter().zip(&acceleration[node.range()]) {
                    a = a.plus(axis.times(own));
                }
            }
            self.velocities[i] = velocity;
            self.accelerations[i] = a;
            let inertia = &kinematics.inertias[i];
            self.forces[i] = inertia.times(&a).plus(velocity.cross_force(&inertia.times(&velocity)));
        }
        for (i, node) in tree.nodes.iter().enumerate().rev() {
            let force = self.forces[i];
            for (out, axis) in out[node.range()].iter_mut().zip(&kinematics.axes[node.range()]) {
                *out = axis.dot(&force);
            }
            if node.parent != NONE {
                let sum = &mut self.forces[node.parent as usize];
                *sum = sum.plus(force);
            }
        }
    }

    /// Returns the kinetic energy of the links, J, without armatures, after a run.
    pub fn kinetic(&self, kinematics: &Kinematics) -> f64 {
        let pairs = self.velocities.iter().zip(&kinematics.inertias);
        pairs.map(|(v, inertia)| 0.5 * v.dot(&inertia.times(v))).sum()
    }
}
