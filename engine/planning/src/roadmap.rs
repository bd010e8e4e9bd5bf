//! PRM: L. E. Kavraki et al., "Probabilistic roadmaps for path planning in high-dimensional configuration spaces" (1996);
//! PRM*: S. Karaman and E. Frazzoli, "Sampling-based algorithms for optimal motion planning" (2011).

use std::{cmp::Reverse, collections::BinaryHeap};

use crate::{
    problem::{Path, PlanError},
    search::{Ends, Search, Stop},
    tree::Tree,
};

/// Neighbours of a state in PRM, and per logarithm of the number of states in PRM*.
const NEIGHBOURS: usize = 10;
const NEIGHBOURS_PER_LOG: f64 = 4.0;

/// Adds random states to a network until start and goal are connected; if `improves`, until the budget is used up.
pub(crate) fn prm(search: &mut Search<'_>, ends: &Ends<'_>, improves: bool) -> Result<Path, PlanError> {
    let mut network = Network { nodes: Tree::new(search.space.dimension()), edges: Vec::new(), groups: Vec::new() };
    let goals = 1..1 + ends.goals.len();
    let outcome = network.build(search, ends, improves);
    match (outcome, network.shortest(goals)) {
        (Ok(()) | Err(Stop::Budget), Some(path)) => Ok(path),
        (Ok(()), None) => Err(search.error(Stop::Budget, None)),
        (Err(stop), _) => Err(search.error(stop, None)),
    }
}

struct Network {
    nodes: Tree,
    edges: Vec<Vec<(usize, f64)>>,
    /// For each node, one with a smaller number in the same connected group, or itself.
    groups: Vec<usize>,
}

impl Network {
    fn build(&mut self, search: &mut Search<'_>, ends: &Ends<'_>, improves: bool) -> Result<(), Stop> {
        self.connect(search, &ends.start, improves)?;
        for goal in &ends.goals {
            self.connect(search, goal, improves)?;
        }
        let goals = ends.goals.len();
        loop {
            let start = self.group(0);
            if !improves && (1..=goals).any(|g| self.group(g) == start) {
                return Ok(());
            }
            let state = search.space.sample(&mut search.random);
            if search.is_valid(&state)? {
                self.connect(search, &state, improves)?;
            }
        }
    }

    fn group(&self, mut node: usize) -> usize {
        while self.groups[node] != node {
            node = self.groups[node];
        }
        node
    }

    /// Adds a possible state, with edges to its neighbours.
    fn connect(&mut self, search: &mut Search<'_>, state: &[f64], improves: bool) -> Result<(), Stop> {
        let space = search.space;
        let per_log = libm::ceil(NEIGHBOURS_PER_LOG * libm::log((self.nodes.len() + 2) as f64)) as usize;
        let count = if improves { per_log.max(1) } else { NEIGHBOURS };
        search.charge_comparisons(2 * self.nodes.len())?;
        let around = self.nodes.nearest_few(space, state, count);
        let new = self.nodes.add(state, None, 0.0);
        self.edges.push(Vec::new());
        self.groups.push(new);
        search.nodes = self.nodes.len();
        for (distance, i) in around {
            // A network without cycles finds a path as soon as one with all edges.
            if (improves || self.group(i) != self.group(new)) && search.is_free(self.nodes.state(i), state)? {
                self.edges[i].push((new, distance));
                self.edges[new].push((i, distance));
                let (a, b) = (self.group(i), self.group(new));
                self.groups[a.max(b)] = a.min(b);
            }
        }
        Ok(())
    }

    /// Returns the shortest path from the first node to any of these (Dijkstra).
    fn shortest(&self, goals: std::ops::Range<usize>) -> Option<Path> {
        let mut costs = vec![f64::INFINITY; self.nodes.len()];
        let mut from = vec![None; self.nodes.len()];
        let mut open = BinaryHeap::new();
        *costs.first_mut()? = 0.0;
        // The bits of numbers that are not negative are ordered as the numbers are.
        open.push(Reverse((0u64, 0usize)));
        while let Some(Reverse((bits, i))) = open.pop() {
            let cost = f64::from_bits(bits);
            if cost > costs[i] {
                continue;
            }
            if goals.contains(&i) {
                let mut states: Vec<Vec<f64>> =
                    std::iter::successors(Some(i), |n| from[*n]).map(|n| self.nodes.state(n).to_vec()).collect();
                states.reverse();
                return Some(Path { states });
            }
            for (next, length) in &self.edges[i] {
                let way = cost + length;
                if way < costs[*next] {
                    (costs[*next], from[*next]) = (way, Some(i));
                    open.push(Reverse((way.to_bits(), *next)));
                }
            }
        }
        None
    }
}
