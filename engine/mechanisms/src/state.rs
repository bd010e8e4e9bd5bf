//! Positions and velocities of a tree, and the integration of positions.

use crate::{
    error::{DynamicsError, check},
    tree::{Tree, TreeJointKind},
    vector::{Quat, normalized, turned},
};

/// Positions and velocities of all joints that are not geared, in the order of the links; see [`Joint`](crate::Joint)
/// for units and layout, and [`Tree::offsets`] for their places.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeState {
    /// Positions: rad, m, or quaternions.
    pub q: Vec<f64>,
    /// Velocities: rad/s or m/s.
    pub v: Vec<f64>,
}

impl TreeState {
    /// Creates a state with all joints at position 0 and at rest.
    pub fn new(tree: &Tree) -> Self {
        let mut q = vec![0.0; tree.positions()];
        for node in &tree.nodes {
            match node.kind {
                TreeJointKind::Spherical => q[node.position] = 1.0,
                TreeJointKind::Free => q[node.position + 3] = 1.0,
                _ => {}
            }
        }
        TreeState { q, v: vec![0.0; tree.velocities()] }
    }

    /// Returns an error if the state has a size that does not match the tree, or a value is not finite.
    pub(crate) fn check(&self, tree: &Tree) -> Result<(), DynamicsError> {
        check("q", &self.q, tree.positions())?;
        check("v", &self.v, tree.velocities())
    }
}

/// Returns the quaternion that starts at index `at`, normalised because a user may have set rounded values.
pub(crate) fn quaternion(q: &[f64], at: usize) -> Quat {
    normalized([q[at], q[at + 1], q[at + 2], q[at + 3]])
}

/// Advances positions by a time `h`, s, at constant velocities.
pub(crate) fn advance(tree: &Tree, q: &mut [f64], v: &[f64], h: f64) {
    for node in tree.nodes.iter().filter(|node| !node.gear.geared) {
        let (p, d) = (node.position, node.velocity);
        match node.kind {
            TreeJointKind::Fixed => {}
            TreeJointKind::Revolute | TreeJointKind::Prismatic => q[p] += h * v[d],
            TreeJointKind::Spherical => turn_quaternion(q, p, [v[d], v[d + 1], v[d + 2]], h),
            TreeJointKind::Free => {
                for k in 0..3 {
                    q[p + k] += h * v[d + k];
                }
                turn_quaternion(q, p + 3, [v[d + 3], v[d + 4], v[d + 5]], h);
            }
        }
    }
}

fn turn_quaternion(q: &mut [f64], at: usize, w: [f64; 3], h: f64) {
    let next = turned(quaternion(q, at), w, h);
    q[at..at + 4].copy_from_slice(&next);
}
