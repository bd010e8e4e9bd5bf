//! L'DL of a matrix along a tree, with some velocities held.

use crate::tree::Tree;

/// Least share of its diagonal entry that a pivot may keep: below, what is left is rounding.
const SINGULAR: f64 = 1e-14;

/// M = L' D L, with L unit lower triangular and as sparse as the tree: no entry is filled in.
///
/// Velocities that are held are left out, as if their rows and columns were not there. That is what an infinite viscous
/// friction on them would do, without its rounding.
///
/// Source: Featherstone, chapter 6, for the factors; chapter 9 (hybrid dynamics) for joints whose acceleration is
/// given.
#[derive(Debug, Clone)]
pub(crate) struct Factor {
    l: Vec<f64>,
    /// 1 / D; 0 for held velocities.
    pub inverse: Vec<f64>,
}

impl Factor {
    pub fn new(tree: &Tree) -> Self {
        Factor { l: vec![0.0; tree.entries()], inverse: vec![0.0; tree.velocities()] }
    }

    /// Factorises a matrix plus a diagonal, `added`. Time: sum of the squares of depths at most.
    ///
    /// # Errors
    ///
    /// The velocity whose pivot is 0 to rounding, or not a number.
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
            // written so that NaN is refused, too
            let sound = pivot > SINGULAR * (matrix[last] + added[k]) && pivot > 0.0;
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
                // the way to the root from i is the beginning of the way from k
                let target = &mut above[tree.rows[i]..tree.rows[i] + m + 1];
                for (x, y) in target.iter_mut().zip(&row[..m + 1]) {
                    *x -= factor * y;
                }
                row[m] = factor;
            }
        }
        Ok(())
    }

    /// Returns the entries of a row of L left of its diagonal, with their columns.
    #[inline]
    pub fn row<'a>(&'a self, tree: &'a Tree, k: usize) -> impl Iterator<Item = (f64, u32)> + 'a {
        let range = tree.rows[k]..tree.rows[k + 1] - 1;
        self.l[range.clone()].iter().copied().zip(tree.columns[range].iter().copied())
    }

    /// Replaces `x` = L v by v. Time: entries of L.
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

    /// Replaces `x` by the solution of M y = x, with 0 for held velocities. Time: entries of L, twice.
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
