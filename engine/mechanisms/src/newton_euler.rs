//! The recursive Newton-Euler algorithm: the forces that cause given accelerations.

use crate::{
    kinematics::Kinematics,
    paths::NO_INDEX,
    spatial::{SpatialForce, SpatialMotion},
    tree::{Tree, TreeJointKind},
    vector::{Vec3, scale},
};

/// Working memory of the algorithm: velocity, acceleration and force of each link.
#[derive(Debug, Clone)]
pub(crate) struct NewtonEuler {
    velocities: Vec<SpatialMotion>,
    accelerations: Vec<SpatialMotion>,
    forces: Vec<SpatialForce>,
}

impl NewtonEuler {
    pub fn new(tree: &Tree) -> Self {
        let n = tree.nodes.len();
        NewtonEuler {
            velocities: vec![SpatialMotion::default(); n],
            accelerations: vec![SpatialMotion::default(); n],
            forces: vec![SpatialForce::default(); n],
        }
    }

    /// Writes the generalised forces that cause the given accelerations at the given velocities, without those of
    /// armatures. Without accelerations, these are the bias forces (Coriolis, centrifugal, gravity).
    ///
    /// Source: Featherstone, chapter 5, here in world axes. Gravity is modelled as an opposite acceleration of the
    /// root.
    pub fn compute_forces(
        &mut self,
        tree: &Tree,
        kinematics: &Kinematics,
        v: &[f64],
        acceleration: Option<&[f64]>,
        gravity: Vec3,
        out: &mut [f64],
    ) {
        let root = SpatialMotion { angular: [0.0; 3], linear: scale(gravity, -1.0) };
        for (i, node) in tree.nodes.iter().enumerate() {
            let (mut velocity, mut a) = if node.parent == NO_INDEX {
                (SpatialMotion::default(), root)
            } else {
                (self.velocities[node.parent as usize], self.accelerations[node.parent as usize])
            };
            let (mut axes, mut speeds) = (&kinematics.axes[node.axes()], &v[node.range()]);
            if let TreeJointKind::Free = node.kind {
                // World axes do not rotate with the link.
                for (linear, speed) in velocity.linear.iter_mut().zip(speeds) {
                    *linear += speed;
                }
                (axes, speeds) = (&axes[3..], &speeds[3..]);
            }
            // An axis may be fixed in the parent or in the link. The derivative is the same, because the contributions
            // of the axes of one joint cancel in the sum.
            let moving = velocity;
            for (axis, &speed) in axes.iter().zip(speeds) {
                let step = axis.times(speed);
                a = a.plus(moving.cross(&step));
                velocity = velocity.plus(step);
            }
            if let Some(acceleration) = acceleration {
                for (axis, &own) in kinematics.axes[node.axes()].iter().zip(&acceleration[node.range()]) {
                    a = a.plus(axis.times(own));
                }
            }
            self.velocities[i] = velocity;
            self.accelerations[i] = a;
            let inertia = &kinematics.inertias[i];
            self.forces[i] = inertia.times(&a).plus(velocity.cross_force(&inertia.times(&velocity)));
        }
        out.fill(0.0);
        for (i, node) in tree.nodes.iter().enumerate().rev() {
            let force = self.forces[i];
            for (out, axis) in out[node.range()].iter_mut().zip(&kinematics.axes[node.axes()]) {
                *out += axis.dot(&force);
            }
            if node.parent != NO_INDEX {
                let sum = &mut self.forces[node.parent as usize];
                *sum = sum.plus(force);
            }
        }
    }

    /// Returns the kinetic energy of the links without armatures, J, after [`compute_forces`](Self::compute_forces).
    pub fn kinetic_energy(&self, kinematics: &Kinematics) -> f64 {
        let pairs = self.velocities.iter().zip(&kinematics.inertias);
        pairs.map(|(v, inertia)| 0.5 * v.dot(&inertia.times(v))).sum()
    }
}
