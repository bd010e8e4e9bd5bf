//! RRT-Connect: J. J. Kuffner and S. M. LaValle, "RRT-Connect: an efficient approach to single-query path planning" (2000).

use crate::{
    problem::{Path, PlanError},
    search::{Ends, Search, Stop},
    tree::Tree,
};

/// Grows two trees until they meet.
pub(crate) fn rrt_connect(search: &mut Search<'_>, ends: &mut Ends<'_>, range: f64) -> Result<Path, PlanError> {
    let space = search.space;
    let (mut ahead, mut back) = (Tree::new(space.dimension()), Tree::new(space.dimension()));
    ahead.add(&ends.start, None, 0.0);
    for goal in &ends.goals {
        back.add(goal, None, 0.0);
    }
    let outcome = grow(search, &mut ahead, &mut back, range);
    let stop = match outcome {
        Ok((a, b)) => {
            let mut path = ahead.path(a);
            // The first of the other tree is the same state.
            path.states.extend(back.way_up(b).skip(1).map(|i| back.state(i).to_vec()));
            return Ok(path);
        }
        Err(stop) => stop,
    };
    let nearest = (0..ahead.len()).map(|i| (ends.distance(space, ahead.state(i)), i));
    let nearest = nearest.min_by(|a, b| a.0.total_cmp(&b.0));
    Err(search.error(stop, nearest.map(|(distance, i)| (ahead.path(i), distance))))
}

/// Returns the nodes of both trees that are the same state.
fn grow(search: &mut Search<'_>, ahead: &mut Tree, back: &mut Tree, range: f64) -> Result<(usize, usize), Stop> {
    // The straight ways first: many problems have no obstacle between.
    for goal in 0..back.len() {
        let state = back.state(goal).to_vec();
        if search.is_free(ahead.state(0), &state)? {
            return Ok((ahead.add(&state, Some(0), 0.0), goal));
        }
    }
    let mut sample = Vec::new();
    loop {
        // The smaller tree grows.
        let forward = ahead.len() <= back.len();
        search.space.sample_into(&mut search.random, &mut sample);
        let (tree, other) = if forward { (&mut *ahead, &mut *back) } else { (&mut *back, &mut *ahead) };
        search.nodes = tree.len() + other.len();
        let Some(new) = extend(search, tree, &sample, range, forward)? else {
            // Even if no motion is tested, the search ends some day.
            continue;
        };
        let target = tree.state(new).to_vec();
        // The other tree goes on towards the new state until something is in the way.
        while let Some(reached) = extend(search, other, &target, range, !forward)? {
            if other.state(reached) == target {
                return Ok(if forward { (new, reached) } else { (reached, new) });
            }
        }
    }
}

/// Adds a state on the way from the nearest node towards a state, or to the nearest node from it if the tree grows
/// backward; the state itself if it is within the range. Returns the new node, or `None` if something is in the way.
fn extend(
    search: &mut Search<'_>,
    tree: &mut Tree,
    towards: &[f64],
    range: f64,
    forward: bool,
) -> Result<Option<usize>, Stop> {
    let space = search.space;
    search.charge_comparisons(tree.len())?;
    let (near, distance) = tree.nearest(space, towards, !forward);
    let node = tree.state(near);
    let state = match (distance <= range, forward) {
        (true, _) => towards.to_vec(),
        (false, true) => space.motion(node, towards).at(range / distance),
        (false, false) => space.motion(towards, node).at(1.0 - range / distance),
    };
    let free = if forward { search.is_free(node, &state)? } else { search.is_free_from(&state, node)? };
    Ok(free.then(|| tree.add(&state, Some(near), 0.0)))
}
