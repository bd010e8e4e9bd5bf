//! The mass matrix by the composite-rigid-body algorithm, stored sparsely along the tree.

use crate::{kinematics::Kinematics, paths::NO_INDEX, spatial::SpatialInertia, tree::Tree};

/// The mass matrix, kg m², kg m or kg: the structurally nonzero entries of the lower triangle, in the rows that
/// [`Tree::rows`] defines. A row contains an entry for each velocity on the path from the root, the diagonal entry
/// last.
#[derive(Debug, Clone)]
pub(crate) struct MassMatrix {
    pub entries: Vec<f64>,
    composite: Vec<SpatialInertia>,
}

impl MassMatrix {
    pub fn new(tree: &Tree) -> Self {
        MassMatrix { entries: vec![0.0; tree.entries()], composite: vec![SpatialInertia::default(); tree.nodes.len()] }
    }

    /// Computes the matrix, including armatures. Complexity: number of velocities times depth.
    ///
    /// Source: Featherstone, chapter 6. In world axes, the inertia of a subtree is the sum of those of its links.
    pub fn update(&mut self, tree: &Tree, kinematics: &Kinematics) {
        if !tree.mass_terms.is_empty() {
            self.update_geared(tree, kinematics);
            return;
        }
        self.composite.copy_from_slice(&kinematics.inertias);
        for (i, node) in tree.nodes.iter().enumerate().rev() {
            let composite = self.composite[i];
            for d in node.range() {
                let force = composite.times(&kinematics.axes[d]);
                let (first, end) = (tree.rows[d], tree.rows[d + 1]);
                for (entry, &column) in self.entries[first..end].iter_mut().zip(&tree.columns[first..end]) {
                    *entry = kinematics.axes[column as usize].dot(&force);
                }
                self.entries[end - 1] += tree.dofs[d].armature;
            }
            if node.parent != NO_INDEX {
                self.composite[node.parent as usize].accumulate(&composite);
            }
        }
    }

    /// Computes the matrix of a tree with gears: each product of two axes is added to the entry of their velocities.
    fn update_geared(&mut self, tree: &Tree, kinematics: &Kinematics) {
        self.composite.copy_from_slice(&kinematics.inertias);
        self.entries.fill(0.0);
        for (i, node) in tree.nodes.iter().enumerate().rev() {
            let composite = self.composite[i];
            for axis in node.axes() {
                let force = composite.times(&kinematics.axes[axis]);
                let path = tree.axis_paths.path(axis);
                for (term, &other) in tree.mass_terms[path.clone()].iter().zip(&tree.axis_paths.columns[path]) {
                    self.entries[term.entry as usize] += term.count * kinematics.axes[other as usize].dot(&force);
                }
            }
            if node.parent != NO_INDEX {
                self.composite[node.parent as usize].accumulate(&composite);
            }
        }
        for (d, dof) in tree.dofs.iter().enumerate() {
            self.entries[tree.rows[d + 1] - 1] += dof.armature;
        }
    }

    /// Returns the mass of a link and all links that it carries, kg.
    pub fn mass_below(&self, link: usize) -> f64 {
        self.composite[link].mass
    }

    /// Adds the product of the matrix and `x` to `out`.
    pub fn add_product(&self, tree: &Tree, x: &[f64], out: &mut [f64]) {
        for d in 0..x.len() {
            let (first, last) = (tree.rows[d], tree.rows[d + 1] - 1);
            let (own, mut sum) = (x[d], self.entries[last] * x[d]);
            for (&entry, &column) in self.entries[first..last].iter().zip(&tree.columns[first..last]) {
                sum += entry * x[column as usize];
                out[column as usize] += entry * own;
            }
            out[d] += sum;
        }
    }

    /// Returns the product of the matrix with `x` from both sides; overwrites `work`.
    pub fn product(&self, tree: &Tree, x: &[f64], work: &mut [f64]) -> f64 {
        work.fill(0.0);
        self.add_product(tree, x, work);
        work.iter().zip(x).map(|(product, x)| product * x).sum()
    }

    /// Returns the diagonal entry of velocity `d`.
    #[inline]
    pub fn diagonal(&self, tree: &Tree, d: usize) -> f64 {
        self.entries[tree.rows[d + 1] - 1]
    }
}
