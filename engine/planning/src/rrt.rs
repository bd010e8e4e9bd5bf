//! RRT: S. M. LaValle, "Rapidly-exploring random trees" (1998); RRT*: S. Karaman and E. Frazzoli, "Sampling-based
//! algorithms for optimal motion planning" (2011).

use crate::{
    problem::{Path, PlanError, Settings},
    search::{Ends, Search, Stop},
    tree::Tree,
};

/// Number of neighbours of RRT* per logarithm of the number of nodes: e + e / d for large d, rounded up.
const NEIGHBOURS: f64 = 4.0;

/// Grows one tree from the start; if `improves`, until the budget is used up.
pub(crate) fn rrt(
    search: &mut Search<'_>,
    ends: &mut Ends<'_>,
    settings: &Settings,
    range: f64,
    improves: bool,
) -> Result<Path, PlanError> {
    let space = search.space;
    let mut growth =
        Growth { tree: Tree::new(space.dimension()), children: Vec::new(), reached: Vec::new(), nearest: None };
    let start = ends.start.clone();
    growth.add(&start, None, 0.0, ends, search);
    let stop = loop {
        if !improves && let Some(node) = growth.reached.first() {
            return Ok(growth.tree.path(*node));
        }
        if let Err(stop) = growth.grow(search, ends, settings, range, improves) {
            break stop;
        }
    };
    let costs = growth.reached.iter().map(|i| (growth.tree.costs[*i], *i));
    if let Some((_, best)) = costs.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|_| stop == Stop::Budget) {
        return Ok(growth.tree.path(best));
    }
    let nearest = growth.nearest.map(|(i, distance)| (growth.tree.path(i), distance));
    Err(search.error(stop, nearest))
}

struct Growth {
    tree: Tree,
    children: Vec<Vec<u32>>,
    /// Nodes that are goals.
    reached: Vec<usize>,
    nearest: Option<(usize, f64)>,
}

impl Growth {
    fn add(&mut self, state: &[f64], parent: Option<usize>, cost: f64, ends: &mut Ends<'_>, search: &mut Search<'_>) {
        let node = self.tree.add(state, parent, cost);
        self.children.push(Vec::new());
        if let Some(parent) = parent {
            self.children[parent].push(node as u32);
        }
        search.nodes = self.tree.len();
        let distance = ends.distance(search.space, state);
        if distance <= 1e-12 {
            self.reached.push(node);
        }
        if self.nearest.is_none_or(|(_, least)| distance < least) {
            self.nearest = Some((node, distance));
        }
    }

    fn grow(
        &mut self,
        search: &mut Search<'_>,
        ends: &mut Ends<'_>,
        settings: &Settings,
        range: f64,
        improves: bool,
    ) -> Result<(), Stop> {
        let space = search.space;
        let towards = if !ends.goals.is_empty() && search.random.unit() < settings.goal_bias {
            ends.goals[search.random.index(ends.goals.len())].clone()
        } else {
            space.sample(&mut search.random)
        };
        search.charge_comparisons(self.tree.len())?;
        let (near, distance) = self.tree.nearest(space, &towards, false);
        if distance <= 0.0 {
            // A goal that is already in the tree: counted, so that the search ends.
            search.is_valid(&towards)?;
            return Ok(());
        }
        let node = self.tree.state(near);
        let state = if distance <= range { towards } else { space.motion(node, &towards).at(range / distance) };
        if !search.is_free(node, &state)? {
            return Ok(());
        }
        let cost = self.tree.costs[near] + space.distance(self.tree.state(near), &state);
        if !improves {
            self.add(&state, Some(near), cost, ends, search);
            return Ok(());
        }
        let count = libm::ceil(NEIGHBOURS * libm::log((self.tree.len() + 1) as f64)) as usize;
        // These are sorted, too.
        search.charge_comparisons(2 * self.tree.len())?;
        let around = self.tree.nearest_few(space, &state, count.max(1));
        let (mut parent, mut least) = (near, cost);
        let mut ways: Vec<(f64, usize)> = around.iter().map(|(d, i)| (self.tree.costs[*i] + d, *i)).collect();
        ways.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (way, i) in ways {
            if way >= least {
                break;
            }
            if search.is_free(self.tree.state(i), &state)? {
                (parent, least) = (i, way);
                break;
            }
        }
        self.add(&state, Some(parent), least, ends, search);
        let node = self.tree.len() - 1;
        for (_, i) in around {
            let way = least + space.distance(&state, self.tree.state(i));
            if way < self.tree.costs[i] - 1e-12 && search.is_free(&state, self.tree.state(i))? {
                self.move_branch(i, node, way);
            }
        }
        Ok(())
    }

    /// Attaches a node to another parent, which shortens the ways to everything above it.
    fn move_branch(&mut self, node: usize, parent: usize, cost: f64) {
        if let Some(old) = self.tree.parents[node] {
            self.children[old as usize].retain(|child| *child != node as u32);
        }
        self.tree.parents[node] = Some(parent as u32);
        self.children[parent].push(node as u32);
        let gain = self.tree.costs[node] - cost;
        let mut open = vec![node];
        while let Some(i) = open.pop() {
            self.tree.costs[i] -= gain;
            open.extend(self.children[i].iter().map(|c| *c as usize));
        }
    }
}
