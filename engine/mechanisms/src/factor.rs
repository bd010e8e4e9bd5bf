//! Sparse L'DL factorisation of a matrix along a tree, with some velocities held.

use crate::tree::Tree;

/// Minimum ratio of a pivot to its diagonal entry, below which the pivot is only rounding error.
const MIN_PIVOT_RATIO: f64 = 1e-14;

/// M = L' D L, with L unit lower triangular and as sparse as the tree: there is no fill-in.
///
/// Rows and columns of held velocities are omitted. This has the effect of infinite viscous friction on them, without
/// its rounding errors.
///
/// Source: Featherstone, chapter 6, for the factors; chapter 9 (hybrid dynamics) for joints whose acceleration is
/// given.
#[derive(Debug, Clone)]
pub(crate) struct SparseFactor {
    l: Vec<f64>,
    /// 1 / D; 0 for held velocities.
    pub inverse: Vec<f64>,
}

impl SparseFactor {
    pub fn new(tree: &Tree) -> Self {
        SparseFactor { l: vec![0.0; tree.entries()], inverse: vec![0.0; tree.velocities()] }
    }

    /// Factorises the sum of a matrix and the diagonal matrix `added`. Complexity: at most the sum of squared depths.
    ///
    /// # Errors
    ///
    /// Returns the index of a velocity whose pivot is 0 up to rounding, or NaN.
    pub fn update(&mut self, tree: &Tree, matrix: &[f64], added: &[f64], held: &[bool]) -> Result<(), usize> {
        self.l.copy_from_slice(matrix);
        for k in (0..added.len()).rev() {
            let (first, last) = (tree.rows[k], tree.rows[k + 1] - 1);
            if held[k] {
                self.l[first..last].fill(0.0);
                self.inverse[k] = 0.0;
                continue;
            }
            let pivot = self.l[last] + added[k];
            // The condition is negated so that NaN is rejected, too.
            let sound = pivot > MIN_PIVOT_RATIO * (matrix[last] + added[k]) && pivot > 0.0;
            if !sound {
                return Err(k);
            }
            let inverse = 1.0 / pivot;
            self.inverse[k] = inverse;
            let (above, row) = self.l.split_at_mut(first);
            let row = &mut row[..last - first];
            for m in (0..row.len()).rev() {
                let i = tree.columns[first + m] as usize;
                if held[i] {
                    row[m] = 0.0;
                    continue;
                }
                let factor = row[m] * inverse;
                // The path of row i is a prefix of the path of row k.
                let target = &mut above[tree.rows[i]..tree.rows[i] + m + 1];
                for (x, y) in target.iter_mut().zip(&row[..m + 1]) {
                    *x -= factor * y;
                }
                row[m] = factor;
            }
        }
        Ok(())
    }

    /// Returns the entries of a row of L left of the diagonal, with their columns.
    #[inline]
    pub fn row<'a>(&'a self, tree: &'a Tree, k: usize) -> impl Iterator<Item = (f64, u32)> + 'a {
        let range = tree.rows[k]..tree.rows[k + 1] - 1;
        self.l[range.clone()].iter().copied().zip(tree.columns[range].iter().copied())
    }

    /// Replaces `x` = L v by v. Complexity: number of entries of L.
    pub fn finish(&self, tree: &Tree, x: &mut [f64]) {
        for k in 0..x.len() {
            let (first, last) = (tree.rows[k], tree.rows[k + 1] - 1);
            let mut sum = x[k];
            for (&l, &column) in self.l[first..last].iter().zip(&tree.columns[first..last]) {
                sum -= l * x[column as usize];
            }
            x[k] = sum;
        }
    }

    /// Replaces `x` by the solution y of M y = x, which is 0 for held velocities. Complexity: number of entries of L.
    pub fn solve(&self, tree: &Tree, x: &mut [f64]) {
        for k in (0..x.len()).rev() {
            let (first, last) = (tree.rows[k], tree.rows[k + 1] - 1);
            let own = x[k];
            for (&l, &column) in self.l[first..last].iter().zip(&tree.columns[first..last]) {
                x[column as usize] -= l * own;
            }
        }
        for (x, inverse) in x.iter_mut().zip(&self.inverse) {
            *x *= inverse;
        }
        self.finish(tree, x);
    }
}
