//! Trees of states, and their nearest neighbours.

use crate::{problem::Path, space::StateSpace};

/// A tree of states, in one slice.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tree {
    states: Vec<f64>,
    pub parents: Vec<Option<u32>>,
    /// Length of the path from the root.
    pub costs: Vec<f64>,
    dimension: usize,
}

impl Tree {
    pub fn new(dimension: usize) -> Self {
        Tree { dimension, ..Tree::default() }
    }
    pub fn len(&self) -> usize {
        self.parents.len()
    }
    pub fn state(&self, i: usize) -> &[f64] {
        &self.states[i * self.dimension..(i + 1) * self.dimension]
    }
    pub fn add(&mut self, state: &[f64], parent: Option<usize>, cost: f64) -> usize {
        self.states.extend_from_slice(state);
        self.parents.push(parent.map(|p| p as u32));
        self.costs.push(cost);
        self.len() - 1
    }

    /// Returns the node with the smallest distance to a state, or from it, and the distance. The tree is not empty.
    pub fn nearest(&self, space: &StateSpace, state: &[f64], from_state: bool) -> (usize, f64) {
        let (mut best, costly) = ((0, f64::INFINITY), space.has_cars());
        for (i, own) in self.states.chunks_exact(self.dimension).enumerate() {
            if costly && space.least_distance(own, state) >= best.1 {
                continue;
            }
            let d = if from_state { space.distance(state, own) } else { space.distance(own, state) };
            if d < best.1 {
                best = (i, d);
            }
        }
        best
    }

    /// Returns the nodes nearest to a state with their distances to it, at most `count`, the nearest first.
    pub fn nearest_few(&self, space: &StateSpace, state: &[f64], count: usize) -> Vec<(f64, usize)> {
        let mut all: Vec<(f64, usize)> = (0..self.len()).map(|i| (space.distance(self.state(i), state), i)).collect();
        let order = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        if all.len() > count && count > 0 {
            all.select_nth_unstable_by(count - 1, order);
            all.truncate(count);
        }
        all.sort_unstable_by(order);
        all
    }

    /// Returns the nodes from one up to its root.
    pub fn way_up(&self, from: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(from), |i| self.parents[*i].map(|p| p as usize))
    }

    /// Returns the path from the root to a node.
    pub fn path(&self, to: usize) -> Path {
        let mut states: Vec<Vec<f64>> = self.way_up(to).map(|i| self.state(i).to_vec()).collect();
        states.reverse();
        Path { states }
    }
}
