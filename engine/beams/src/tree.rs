//! A bounding volume hierarchy over items that are identified by indices: the targets of a scene, or the triangles of a
//! mesh.

use arrayvec::ArrayVec;
use fearless_simd::{f64x4, prelude::*};
use nalgebra::Vector3;

use super::{
    aabb::{Aabb, BOX_TOLERANCE_M},
    binary::{self, BinaryNode},
    probe::Probe,
    sight::SightLine,
    simd::{dispatch, greatest, least, level},
};

/// Capacity of the traversal stack, enough for a tree of 2^32 items; each level leaves up to three children on it.
pub(super) const STACK_CAPACITY: usize = 3 * 64 + 4;

/// The boxes of up to four children as a structure of arrays, so that one vector operation tests all of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct QuadNode {
    low: [[f64; 4]; 3],
    high: [[f64; 4]; 3],
    /// Index into `order` of a leaf's first item, or index of another quad.
    pub first: [u32; 4],
    /// Number of items of a leaf; 0 for a quad.
    pub count: [u32; 4],
    /// Number of children.
    pub lanes: usize,
}

impl QuadNode {
    const EMPTY: Self = QuadNode { low: [[0.0; 4]; 3], high: [[0.0; 4]; 3], first: [0; 4], count: [0; 4], lanes: 0 };

    /// Builds a quad of up to four boxes, one for each item from `first` on.
    pub fn of_items<'a>(first: u32, boxes: impl Iterator<Item = &'a Aabb>) -> Self {
        let mut quad = QuadNode::EMPTY;
        for (lane, aabb) in boxes.enumerate() {
            quad.set(lane, aabb);
            (quad.first[lane], quad.count[lane]) = (first + lane as u32, 1);
            quad.lanes += 1;
        }
        quad
    }
    /// Returns, for each box, whether it overlaps the given one.
    fn overlaps(&self, other: &Aabb) -> [bool; 4] {
        let mut out = [true; 4];
        for i in 0..3 {
            for (k, meets) in out.iter_mut().enumerate() {
                *meets &= self.low[i][k] <= other.high[i] && self.high[i][k] >= other.low[i];
            }
        }
        out
    }
    pub fn get(&self, lane: usize) -> Aabb {
        let corner = |c: &[[f64; 4]; 3]| Vector3::new(c[0][lane], c[1][lane], c[2][lane]);
        Aabb { low: corner(&self.low), high: corner(&self.high) }
    }
    /// Returns, for each box, a lower bound of the distance of its points from the origin of the probe.
    #[inline(always)]
    pub fn distances(&self, origin: &Vector3<f64>) -> [f64; 4] {
        let mut squares = [0.0; 4];
        for i in 0..3 {
            for (k, square) in squares.iter_mut().enumerate() {
                let (below, above) = (self.low[i][k] - origin[i], origin[i] - self.high[i][k]);
                let beside = if below > above { below } else { above };
                let beside = if beside > 0.0 { beside } else { 0.0 };
                *square += beside * beside;
            }
        }
        squares.map(
            #[inline(always)]
            |x| x.sqrt() - BOX_TOLERANCE_M,
        )
    }
    /// Returns the same bounds as `distances`, but infinity for boxes that are beyond the limit or that a volume
    /// misses. `misses` receives the centre of a box, relative to the origin, and half of its size.
    #[inline(always)]
    fn bounds(
        &self,
        origin: &Vector3<f64>,
        limit: f64,
        misses: impl Fn(&Vector3<f64>, &Vector3<f64>) -> bool,
    ) -> [f64; 4] {
        let mut out = self.distances(origin);
        for (lane, bound) in out.iter_mut().enumerate().take(self.lanes) {
            let Aabb { low, high } = self.get(lane);
            if *bound > limit || misses(&((low + high) * 0.5 - origin), &((high - low) * 0.5)) {
                *bound = f64::INFINITY;
            }
        }
        out
    }
    fn set(&mut self, lane: usize, aabb: &Aabb) {
        for i in 0..3 {
            self.low[i][lane] = aabb.low[i];
            self.high[i][lane] = aabb.high[i];
        }
    }
}

/// A ray prepared for tests against many boxes.
struct RaySlabs {
    /// Origin of the ray, displaced by the tolerance; compared with the low and the high sides of boxes, respectively.
    low: Vector3<f64>,
    high: Vector3<f64>,
    /// Reciprocal of the direction; infinite along axes to which the ray is perpendicular.
    inverse: Vector3<f64>,
    near: f64,
}

impl RaySlabs {
    fn new(sight: &SightLine) -> Self {
        let origin = &sight.origin.coords;
        RaySlabs {
            low: origin.add_scalar(BOX_TOLERANCE_M),
            high: origin.add_scalar(-BOX_TOLERANCE_M),
            inverse: sight.axis.map(|x| 1.0 / x),
            near: sight.near,
        }
    }

    /// Returns, for each box, a lower bound of the distance at which the ray is in it, or infinity if the ray misses
    /// it.
    #[inline(always)]
    fn bounds<S: Simd>(&self, simd: S, quad: &QuadNode) -> [f64; 4] {
        let (mut enter, mut leave) = (f64x4::splat(simd, self.near), f64x4::splat(simd, f64::INFINITY));
        for i in 0..3 {
            let low = (f64x4::load_array_ref(simd, &quad.low[i]) - self.low[i]) * self.inverse[i];
            let high = (f64x4::load_array_ref(simd, &quad.high[i]) - self.high[i]) * self.inverse[i];
            // A ray in the plane of a side yields NaN, for which `least` and `greatest` return their second argument.
            enter = greatest(least(low, high), enter);
            leave = least(greatest(low, high), leave);
        }
        let mut out = [0.0; 4];
        enter.simd_gt(leave).select(f64x4::splat(simd, f64::INFINITY), enter - BOX_TOLERANCE_M).store_array(&mut out);
        out
    }
}

/// The hierarchy. In its list of quads, every child follows its parent.
#[derive(Debug, Clone, Default)]
pub(super) struct BoxTree {
    quads: Vec<QuadNode>,
    /// Items in the order of the leaves.
    pub order: Vec<u32>,
    /// Sum of the areas of the boxes, an estimate of the traversal cost. `built_area` is the sum when the tree was
    /// built.
    area: f64,
    built_area: f64,
    /// Position of each quad in its parent: four times the index of the parent, plus the lane; [`NO_POSITION`] for the
    /// root.
    parents: Vec<u32>,
    /// Position of each item's leaf, encoded in the same way.
    leaves: Vec<u32>,
}

/// Position of an item that is not in the tree, or of a quad without a parent.
const NO_POSITION: u32 = u32::MAX;

impl BoxTree {
    /// Builds the tree over `items`, which are indices into `boxes`. The result is deterministic.
    pub fn build(&mut self, items: impl IntoIterator<Item = u32>, boxes: &[Aabb], leaf_size: usize) {
        self.order.clear();
        self.order.extend(items);
        self.quads.clear();
        self.leaves.clear();
        self.leaves.resize(boxes.len(), NO_POSITION);
        self.parents.clear();
        (self.area, self.built_area) = (0.0, 0.0);
        if self.order.is_empty() {
            return;
        }
        let nodes = binary::build(&mut self.order, boxes, leaf_size);
        self.collapse(&nodes);
        self.parents.resize(self.quads.len(), NO_POSITION);
        for (at, quad) in self.quads.iter().enumerate() {
            for lane in 0..quad.lanes {
                let (first, count) = (quad.first[lane] as usize, quad.count[lane] as usize);
                let place = 4 * at as u32 + lane as u32;
                if count == 0 {
                    self.parents[first] = place;
                }
                for item in &self.order[first..first + count] {
                    self.leaves[*item as usize] = place;
                }
            }
        }
        self.refit(boxes);
        self.built_area = self.area;
    }

    /// Converts the binary tree to quads: the largest child is repeatedly replaced by its own two children.
    fn collapse(&mut self, nodes: &[BinaryNode]) {
        let mut roots = vec![0];
        let mut at = 0;
        while at < roots.len() {
            let root = &nodes[roots[at]];
            let mut children = match root.count {
                0 => vec![root.first as usize, root.first as usize + 1],
                _ => vec![roots[at]],
            };
            while children.len() < 4 {
                let inner = children.iter().enumerate().filter(|(_, c)| nodes[**c].count == 0);
                let largest = inner.max_by(|a, b| nodes[*a.1].aabb.area().total_cmp(&nodes[*b.1].aabb.area()));
                let Some((place, child)) = largest.map(|(place, child)| (place, *child)) else { break };
                children[place] = nodes[child].first as usize;
                children.push(nodes[child].first as usize + 1);
            }
            let mut quad = QuadNode { lanes: children.len(), ..QuadNode::EMPTY };
            for (lane, child) in children.into_iter().enumerate() {
                quad.count[lane] = nodes[child].count;
                quad.first[lane] = nodes[child].first;
                if nodes[child].count == 0 {
                    quad.first[lane] = roots.len() as u32;
                    roots.push(child);
                }
            }
            self.quads.push(quad);
            at += 1;
        }
    }

    /// Refits all boxes of the tree to the current boxes of the items.
    pub fn refit(&mut self, boxes: &[Aabb]) {
        self.area = 0.0;
        for at in (0..self.quads.len()).rev() {
            for lane in 0..self.quads[at].lanes {
                let aabb = self.fit(at, lane, boxes);
                self.area += aabb.area();
                self.quads[at].set(lane, &aabb);
            }
        }
    }

    /// Refits the boxes above one item that moved; stops at the first box that does not change.
    pub fn update(&mut self, item: u32, boxes: &[Aabb]) {
        let mut place = self.leaves[item as usize];
        while place != NO_POSITION {
            let (at, lane) = (place as usize / 4, place as usize % 4);
            let (old, new) = (self.quads[at].get(lane), self.fit(at, lane, boxes));
            if old == new {
                return;
            }
            self.area += new.area() - old.area();
            self.quads[at].set(lane, &new);
            place = self.parents[at];
        }
    }

    /// Returns whether the tree contains an item.
    pub fn contains(&self, item: u32) -> bool {
        self.leaves.get(item as usize).is_some_and(|place| *place != NO_POSITION)
    }

    /// Returns the bounding box of the contents of a lane.
    fn fit(&self, at: usize, lane: usize, boxes: &[Aabb]) -> Aabb {
        let (first, count) = (self.quads[at].first[lane] as usize, self.quads[at].count[lane] as usize);
        if count == 0 {
            let child = &self.quads[first];
            (0..child.lanes).fold(Aabb::EMPTY, |b, k| b.merge(&child.get(k)))
        } else {
            self.order[first..first + count].iter().fold(Aabb::EMPTY, |b, i| b.merge(&boxes[*i as usize]))
        }
    }

    pub fn quads(&self) -> &[QuadNode] {
        &self.quads
    }

    /// Returns whether refitting has enlarged the boxes so much that rebuilding the tree pays off.
    pub fn needs_rebuild(&self) -> bool {
        self.area > 1.5 * self.built_area
    }

    /// Calls `visit` with each item whose leaf's box overlaps a region, until a call returns `false`. Returns whether
    /// all calls returned `true`.
    pub fn visit_overlapping(&self, space: &Aabb, mut visit: impl FnMut(u32) -> bool) -> bool {
        let mut stack = ArrayVec::<u32, STACK_CAPACITY>::new();
        stack.extend((!self.quads.is_empty()).then_some(0));
        while let Some(at) = stack.pop() {
            let quad = &self.quads[at as usize];
            let meets = quad.overlaps(space);
            for lane in (0..quad.lanes).filter(|lane| meets[*lane]) {
                let (first, count) = (quad.first[lane] as usize, quad.count[lane] as usize);
                if count == 0 {
                    stack.push(first as u32);
                } else if !self.order[first..first + count].iter().all(|item| visit(*item)) {
                    return false;
                }
            }
        }
        true
    }

    /// Calls `visit` with each index into `order` whose box may contain a point within the limit, nearer boxes first.
    ///
    /// `visit` receives the limit and returns it, lowered to the best distance so far.
    pub fn walk(&self, probe: &Probe, limit: f64, visit: impl FnMut(usize, f64) -> f64) {
        walk(&self.quads, 1, probe, limit, visit);
    }

    /// Visits the items like [`walk`](Self::walk), but with bounds that `bounds_of` computes.
    #[inline(always)]
    pub fn walk_with_bounds(
        &self,
        limit: f64,
        bounds_of: impl Fn(&QuadNode, f64) -> [f64; 4],
        visit: impl FnMut(usize, f64) -> f64,
    ) {
        walk_with_bounds(&self.quads, 1, limit, bounds_of, visit);
    }
}

/// Traverses quads as [`BoxTree::walk`] does, starting with the first `roots` quads.
pub(super) fn walk(quads: &[QuadNode], roots: usize, probe: &Probe, limit: f64, visit: impl FnMut(usize, f64) -> f64) {
    match probe {
        Probe::Ray(sight) => {
            let slabs = RaySlabs::new(sight);
            dispatch!(level(), simd => walk_with_bounds(
                quads,
                roots,
                limit,
                #[inline(always)]
                |quad, _| slabs.bounds(simd, quad),
                visit,
            ));
        }
        Probe::Cone(cone) => walk_with_bounds(
            quads,
            roots,
            limit,
            |quad, limit| {
                quad.bounds(&cone.sight.origin.coords, limit, |c, half| {
                    cone.misses_ball(c, half.norm() + BOX_TOLERANCE_M)
                })
            },
            visit,
        ),
        Probe::Convex(space) => walk_with_bounds(
            quads,
            roots,
            limit,
            |quad, limit| quad.bounds(&space.sight.origin.coords, limit, |c, half| space.misses_box(c, half)),
            visit,
        ),
    }
}

#[inline(always)]
fn walk_with_bounds(
    quads: &[QuadNode],
    roots: usize,
    mut limit: f64,
    bounds_of: impl Fn(&QuadNode, f64) -> [f64; 4],
    mut visit: impl FnMut(usize, f64) -> f64,
) {
    // Entries of bound, first and count, sorted such that the nearest one is on top.
    let mut stack = ArrayVec::<(f64, u32, u32), STACK_CAPACITY>::new();
    stack.extend((0..roots.min(quads.len()) as u32).map(|at| (f64::NEG_INFINITY, at, 0)));
    while let Some((bound, first, count)) = stack.pop() {
        if bound > limit {
            continue;
        }
        if count > 0 {
            for place in first..first + count {
                limit = visit(place as usize, limit);
            }
            continue;
        }
        let quad = &quads[first as usize];
        let bounds = bounds_of(quad, limit);
        let bottom = stack.len();
        for (lane, bound) in bounds.into_iter().enumerate().take(quad.lanes) {
            if bound > limit || bound == f64::INFINITY {
                continue;
            }
            let (child, mut at) = ((bound, quad.first[lane], quad.count[lane]), stack.len());
            stack.push(child);
            // At most three elements are moved, which is cheaper than calling a library function.
            while at > bottom && stack[at - 1].0 < bound {
                stack[at] = stack[at - 1];
                at -= 1;
            }
            stack[at] = child;
        }
    }
}
