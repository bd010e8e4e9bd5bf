//! The sparsity of matrices along a tree: which axes move each link, and which velocities are coupled.
//!
//! Without gears, the velocities on the path from the root to a link are coupled, and a factorisation from the leaves
//! to the root adds no entries (Featherstone, chapter 6). A gear merges velocities of several branches. The velocities
//! that move one link are then still coupled pairwise, but elimination adds entries. The elimination tree, whose paths
//! contain all of them, takes the place of the tree of links; entries on its paths that are 0 are stored.
//!
//! Source: Liu, The role of elimination trees in sparse factorization, SIAM Journal on Matrix Analysis and Applications
//! 11, 1990.

use std::{collections::BTreeSet, ops::Range};

/// Index that stands for "no parent", "no velocity closer to the root" or "no single position".
pub(crate) const NO_INDEX: u32 = u32::MAX;

/// An axis of a joint.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TreeAxis {
    /// Index of the velocity with which it moves.
    pub velocity: u32,
    /// Index of the link.
    pub node: u32,
}

/// The axes on the path from the root to each link: those that move it.
#[derive(Debug, Clone, Default)]
pub(crate) struct AxisPaths {
    /// Indices of axes, in ascending order on each path. The path to axis `i`, itself last, is `columns[paths[i]]`.
    pub columns: Vec<u32>,
    paths: Vec<Range<usize>>,
    /// Index of the last axis on the path to each link, or [`NO_INDEX`].
    last: Vec<u32>,
}

/// The place of a product of two axes in the mass matrix.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MassTerm {
    /// Index of the entry.
    pub entry: u32,
    /// How often the product is added: twice if both axes are different and move with the same velocity.
    pub count: f64,
}

impl AxisPaths {
    /// Adds a link with the given axes.
    pub fn push(&mut self, parent: Option<usize>, axes: Range<usize>) {
        let mut last = parent.map_or(NO_INDEX, |p| self.last[p]);
        for axis in axes {
            let first = self.columns.len();
            if last != NO_INDEX {
                self.columns.extend_from_within(self.paths[last as usize].clone());
            }
            self.columns.push(axis as u32);
            self.paths.push(first..self.columns.len());
            last = axis as u32;
        }
        self.last.push(last);
    }

    /// Returns the axes that move a link.
    #[inline]
    pub fn of_link(&self, link: usize) -> &[u32] {
        match self.last.get(link) {
            None | Some(&NO_INDEX) => &[],
            Some(&axis) => &self.columns[self.path(axis as usize)],
        }
    }

    /// Returns the path to an axis, itself last: a range of `columns`.
    #[inline]
    pub fn path(&self, axis: usize) -> Range<usize> {
        self.paths[axis].clone()
    }

    /// Returns, for each entry of all paths, where the product of that axis and the last one of the path belongs.
    pub fn mass_terms(&self, axes: &[TreeAxis], rows: &[usize], columns: &[u32]) -> Vec<MassTerm> {
        let mut terms = Vec::with_capacity(self.columns.len());
        for (axis, path) in self.paths.iter().enumerate() {
            let own = axes[axis].velocity;
            for &other in &self.columns[path.clone()] {
                let velocity = axes[other as usize].velocity;
                let (row, column) = (own.max(velocity) as usize, own.min(velocity));
                // The elimination tree contains all velocities that move a link on one path.
                let place = columns[rows[row]..rows[row + 1]].partition_point(|c| *c < column);
                let count = if own == velocity && other as usize != axis { 2.0 } else { 1.0 };
                terms.push(MassTerm { entry: (rows[row] + place) as u32, count });
            }
        }
        terms
    }
}

/// Returns the parent of each velocity in the elimination tree, or [`NO_INDEX`].
pub(crate) fn elimination_parents(velocities: usize, paths: &AxisPaths, axes: &[TreeAxis]) -> Vec<u32> {
    let mut above: Vec<BTreeSet<u32>> = vec![BTreeSet::new(); velocities];
    for path in &paths.paths {
        let together: BTreeSet<u32> = paths.columns[path.clone()].iter().map(|a| axes[*a as usize].velocity).collect();
        if let Some(&last) = together.last() {
            above[last as usize].extend(together.range(..last));
        }
    }
    let mut parents = vec![NO_INDEX; velocities];
    for d in (0..velocities).rev() {
        let mut own = std::mem::take(&mut above[d]);
        if let Some(parent) = own.pop_last() {
            parents[d] = parent;
            above[parent as usize].append(&mut own);
        }
    }
    parents
}
