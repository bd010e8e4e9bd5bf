//! The binary tree from which a tree of boxes is built; items are split where the expected traversal cost is lowest.

use nalgebra::Vector3;

use super::aabb::Aabb;

/// Builds the tree over the items in `order`, which are indices into `boxes`, and sorts `order` into the order of the
/// leaves. In the returned list, every child follows its parent. The result is deterministic.
pub(super) fn build(order: &mut [u32], boxes: &[Aabb], leaf_size: usize) -> Vec<BinaryNode> {
    let mut nodes = vec![BinaryNode { aabb: Aabb::EMPTY, first: 0, count: order.len() as u32, depth: 0 }];
    let mut at = 0;
    while at < nodes.len() {
        split(&mut nodes, order, at, boxes, leaf_size);
        at += 1;
    }
    for at in (0..nodes.len()).rev() {
        nodes[at].aabb = nodes[at].fit(order, boxes, |child| nodes[child].aabb);
    }
    nodes
}

/// A node of the tree: a leaf or an inner node.
#[derive(Debug, Clone, Copy)]
pub(super) struct BinaryNode {
    pub aabb: Aabb,
    /// Index into `order` of the first item of a leaf, or index of the first of the two adjacent children of an inner
    /// node.
    pub first: u32,
    /// Number of items of a leaf; 0 for an inner node.
    pub count: u32,
    /// Number of ancestors.
    depth: u32,
}

impl BinaryNode {
    /// Returns the bounding box of the items of a leaf, or of the two children of an inner node.
    fn fit(&self, order: &[u32], boxes: &[Aabb], child: impl Fn(usize) -> Aabb) -> Aabb {
        let first = self.first as usize;
        match self.count {
            0 => child(first).merge(&child(first + 1)),
            n => order[first..first + n as usize].iter().fold(Aabb::EMPTY, |b, i| b.merge(&boxes[*i as usize])),
        }
    }
}

/// Depth from which nodes are split at the median, to bound the depth of the tree.
const MEDIAN_SPLIT_DEPTH: u32 = 32;
/// Number of bins per axis.
const BINS: usize = 16;

/// A plane that splits a set of items in two.
struct SplitPlane {
    axis: usize,
    low: f64,
    per_metre: f64,
    /// Index of the last bin of the first part.
    last: usize,
}

impl SplitPlane {
    fn bin(&self, centre: &Vector3<f64>) -> usize {
        (((centre[self.axis] - self.low) * self.per_metre) as usize).min(BINS - 1)
    }

    /// Returns the cheapest cut, or `None` if all centres coincide.
    fn best(items: &[u32], boxes: &[Aabb], centres: &Aabb) -> Option<Self> {
        let mut best: Option<(f64, Self)> = None;
        for axis in 0..3 {
            let length = centres.high[axis] - centres.low[axis];
            if !(length > 0.0 && length.is_finite()) {
                continue;
            }
            let mut cut = SplitPlane { axis, low: centres.low[axis], per_metre: BINS as f64 / length, last: 0 };
            let mut bins = [(Aabb::EMPTY, 0usize); BINS];
            for item in items {
                let aabb = &boxes[*item as usize];
                let bin = &mut bins[cut.bin(&aabb.centre())];
                *bin = (bin.0.merge(aabb), bin.1 + 1);
            }
            // The cost of the second part if it starts at this bin, computed from right to left.
            let mut after = [0.0; BINS];
            let mut part = (Aabb::EMPTY, 0);
            for i in (1..BINS).rev() {
                part = (part.0.merge(&bins[i].0), part.1 + bins[i].1);
                after[i] = part.0.cost(part.1);
            }
            part = (Aabb::EMPTY, 0);
            for last in 0..BINS - 1 {
                part = (part.0.merge(&bins[last].0), part.1 + bins[last].1);
                let cost = part.0.cost(part.1) + after[last + 1];
                if part.1 > 0 && part.1 < items.len() && best.as_ref().is_none_or(|(least, _)| cost < *least) {
                    cut.last = last;
                    best = Some((cost, SplitPlane { ..cut }));
                }
            }
        }
        best.map(|(_, cut)| cut)
    }
}

/// Splits a leaf where the expected traversal cost is lowest (surface area heuristic, in bins along each axis), or at
/// the median if no cut between bins separates the items or the tree would become too deep.
fn split(nodes: &mut Vec<BinaryNode>, order: &mut [u32], at: usize, boxes: &[Aabb], leaf_size: usize) {
    let BinaryNode { first, count, depth, .. } = nodes[at];
    if count as usize <= leaf_size {
        return;
    }
    let items = &mut order[first as usize..(first + count) as usize];
    let centres = items.iter().fold(Aabb::EMPTY, |b, &item| {
        let c = boxes[item as usize].centre();
        Aabb { low: b.low.inf(&c), high: b.high.sup(&c) }
    });
    let cut = if depth < MEDIAN_SPLIT_DEPTH { SplitPlane::best(items, boxes, &centres) } else { None };
    let left = match cut {
        Some(cut) => {
            items.sort_by_cached_key(|item| (cut.bin(&boxes[*item as usize].centre()) > cut.last, *item));
            items.iter().filter(|item| cut.bin(&boxes[**item as usize].centre()) <= cut.last).count()
        }
        None => {
            let axis = (centres.high - centres.low).imax();
            let half = items.len() / 2;
            let centre = |item: &u32| boxes[*item as usize].centre()[axis];
            items.select_nth_unstable_by(half, |a, b| centre(a).total_cmp(&centre(b)).then(a.cmp(b)));
            half
        }
    } as u32;
    let child = |first, count| BinaryNode { aabb: Aabb::EMPTY, first, count, depth: depth + 1 };
    nodes[at].first = nodes.len() as u32;
    nodes[at].count = 0;
    nodes.push(child(first, left));
    nodes.push(child(first + left, count - left));
}
