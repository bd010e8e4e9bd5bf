//! A tree of boxes over numbered items: of a scene's targets, or of a mesh's triangles.

use nalgebra::{Isometry3, Vector3};

use super::sight::{Cone, Probe, Sight};
use crate::geometry::Form;

/// A box along the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Aabb {
    pub low: Vector3<f64>,
    pub high: Vector3<f64>,
}

/// Slack of every bound, in metres: far above rounding, far below what costs time.
const SLACK: f64 = 1e-9;

impl Aabb {
    pub const EMPTY: Self = Self {
        low: Vector3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Vector3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    pub fn around<'a>(points: impl IntoIterator<Item = &'a Vector3<f64>>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { low: b.low.inf(p), high: b.high.sup(p) })
    }

    pub fn merge(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// The box around a form in the world; nothing for a form without end.
    pub fn of_form(form: &Form, pose: &Isometry3<f64>) -> Option<Self> {
        let rotation = pose.rotation.to_rotation_matrix();
        let rotation = rotation.matrix();
        let centre = pose.translation.vector;
        let along = rotation.column(2).abs();
        let (centre, half) = match form {
            Form::Plane => return None,
            Form::Box { half } => (centre, rotation.abs() * half),
            Form::Sphere { radius } => (centre, Vector3::repeat(*radius)),
            Form::Capsule { radius, half_length } => (centre, (along * *half_length).add_scalar(*radius)),
            Form::Cylinder { radius, half_length } => {
                let across = along.map(|x| (1.0 - x * x).max(0.0).sqrt());
                (centre, along * *half_length + across * *radius)
            }
            Form::Mesh { mesh, .. } => {
                let own = Self::around(mesh.vertices.iter().map(|p| &p.coords));
                return Some(own.moved(pose));
            }
        };
        Some(Self { low: centre - half, high: centre + half })
    }

    /// The box around this one after a motion.
    pub fn moved(&self, pose: &Isometry3<f64>) -> Self {
        let centre = pose * nalgebra::Point3::from((self.low + self.high) * 0.5);
        let half = pose.rotation.to_rotation_matrix().matrix().abs() * ((self.high - self.low) * 0.5);
        Self { low: centre.coords - half, high: centre.coords + half }
    }

    fn centre(&self) -> Vector3<f64> {
        (self.low + self.high) * 0.5
    }

    /// What going through so many items in this box costs.
    fn cost(&self, items: usize) -> f64 {
        if items == 0 { 0.0 } else { self.area() * items as f64 }
    }

    fn area(&self) -> f64 {
        let size = self.high - self.low;
        size.x * size.y + size.y * size.z + size.z * size.x
    }

    /// No point in this box that the cone sees is nearer than this; infinity when it sees none.
    fn cone_bound(&self, cone: &Cone, limit: f64) -> f64 {
        let (low, high) = (self.low - cone.sight.origin.coords, self.high - cone.sight.origin.coords);
        let least = low.sup(&-high).map(|x| x.max(0.0)).norm() - SLACK;
        if least > limit {
            return f64::INFINITY;
        }
        let radius = 0.5 * (high - low).norm() + SLACK;
        if cone.misses_ball(&((low + high) * 0.5), radius) { f64::INFINITY } else { least }
    }
}

/// A ray made ready for many boxes.
struct Slabs {
    origin: Vector3<f64>,
    /// One over the direction; infinite along axes that the ray is square to.
    inverse: Vector3<f64>,
    near: f64,
}

impl Slabs {
    fn new(sight: &Sight) -> Self {
        Slabs { origin: sight.origin.coords, inverse: sight.axis.map(|x| 1.0 / x), near: sight.near }
    }

    /// No point of the ray in this box is nearer than this; infinity when there is none.
    #[inline(always)]
    fn bound(&self, aabb: &Aabb, _: f64) -> f64 {
        let (mut enter, mut leave) = (self.near, f64::INFINITY);
        for i in 0..3 {
            let low = (aabb.low[i] - SLACK - self.origin[i]) * self.inverse[i];
            let high = (aabb.high[i] + SLACK - self.origin[i]) * self.inverse[i];
            let (first, last) = if low < high { (low, high) } else { (high, low) };
            // Comparisons pass over the NaN of a ray in the very plane of a side.
            enter = if first > enter { first } else { enter };
            leave = if last < leave { last } else { leave };
        }
        if enter > leave { f64::INFINITY } else { enter - SLACK }
    }
}

#[derive(Debug, Clone, Copy)]
struct Node {
    aabb: Aabb,
    /// A leaf's first place in `order`, or the first of two children, which are neighbours.
    first: u32,
    /// Items of a leaf; 0 for an inner node.
    count: u32,
    /// Nodes above.
    depth: u32,
}

/// Bins along an axis.
const BINS: usize = 16;

/// Where a set of items is split in two.
struct Cut {
    axis: usize,
    low: f64,
    per_metre: f64,
    /// The last bin of the first part.
    last: usize,
}

impl Cut {
    fn bin(&self, centre: &Vector3<f64>) -> usize {
        (((centre[self.axis] - self.low) * self.per_metre) as usize).min(BINS - 1)
    }

    /// The cheapest cut; nothing when all centres coincide.
    fn best(items: &[u32], boxes: &[Aabb], centres: &Aabb) -> Option<Self> {
        let mut best: Option<(f64, Self)> = None;
        for axis in 0..3 {
            let length = centres.high[axis] - centres.low[axis];
            if !(length > 0.0 && length.is_finite()) {
                continue;
            }
            let mut cut = Cut { axis, low: centres.low[axis], per_metre: BINS as f64 / length, last: 0 };
            let mut bins = [(Aabb::EMPTY, 0usize); BINS];
            for item in items {
                let aabb = &boxes[*item as usize];
                let bin = &mut bins[cut.bin(&aabb.centre())];
                *bin = (bin.0.merge(aabb), bin.1 + 1);
            }
            // From the right: what the second part costs if it begins at a bin.
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
                    best = Some((cost, Cut { ..cut }));
                }
            }
        }
        best.map(|(_, cut)| cut)
    }
}

/// The tree. A child always comes after its parent.
#[derive(Debug, Clone, Default)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    /// Items in the order of the leaves.
    pub order: Vec<u32>,
    /// Sum of the nodes' areas when built: what a walk costs, roughly.
    built_area: f64,
}

/// From this depth on items are halved.
const DEEP: u32 = 32;
/// Deeper than a tree of 2^32 items, halved from `DEEP` on; each level leaves one node behind.
const STACK: usize = 66;

impl Tree {
    /// Builds the tree over `items`, numbers into `boxes`. The same input gives the same tree.
    pub fn build(&mut self, items: impl IntoIterator<Item = u32>, boxes: &[Aabb], leaf_size: usize) {
        self.order.clear();
        self.order.extend(items);
        self.nodes.clear();
        if self.order.is_empty() {
            return;
        }
        let whole = Node { aabb: Aabb::EMPTY, first: 0, count: self.order.len() as u32, depth: 0 };
        self.nodes.push(whole);
        let mut at = 0;
        while at < self.nodes.len() {
            self.split(at, boxes, leaf_size);
            at += 1;
        }
        self.built_area = self.refit(boxes);
    }

    /// Splits a leaf where a walk is expected to cost least (surface area heuristic, in bins along each axis); at the
    /// median where bins tell nothing, or where the tree would get too deep.
    fn split(&mut self, at: usize, boxes: &[Aabb], leaf_size: usize) {
        let Node { first, count, depth, .. } = self.nodes[at];
        if count as usize <= leaf_size {
            return;
        }
        let items = &mut self.order[first as usize..(first + count) as usize];
        let centres = items.iter().fold(Aabb::EMPTY, |b, &item| {
            let c = boxes[item as usize].centre();
            Aabb { low: b.low.inf(&c), high: b.high.sup(&c) }
        });
        let cut = if depth < DEEP { Cut::best(items, boxes, &centres) } else { None };
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
        let child = |first, count| Node { aabb: Aabb::EMPTY, first, count, depth: depth + 1 };
        self.nodes[at].first = self.nodes.len() as u32;
        self.nodes[at].count = 0;
        self.nodes.push(child(first, left));
        self.nodes.push(child(first + left, count - left));
    }

    /// Fits the nodes to boxes that moved; returns the sum of their areas.
    pub fn refit(&mut self, boxes: &[Aabb]) -> f64 {
        let mut area = 0.0;
        for at in (0..self.nodes.len()).rev() {
            let Node { first, count, .. } = self.nodes[at];
            let first = first as usize;
            self.nodes[at].aabb = if count == 0 {
                self.nodes[first].aabb.merge(&self.nodes[first + 1].aabb)
            } else {
                self.order[first..first + count as usize]
                    .iter()
                    .fold(Aabb::EMPTY, |b, &item| b.merge(&boxes[item as usize]))
            };
            area += self.nodes[at].aabb.area();
        }
        area
    }

    /// Whether the tree, refitted to a sum of areas, has lost so much that building anew pays.
    pub fn worn(&self, area: f64) -> bool {
        area > 1.5 * self.built_area
    }

    /// Calls `visit` with each place in `order` whose box may hold a point within the limit, nearer boxes first.
    ///
    /// `visit` gets the limit and returns it, lowered to the best distance so far.
    pub fn walk(&self, probe: &Probe, limit: f64, visit: impl FnMut(usize, f64) -> f64) {
        match probe {
            Probe::Ray(sight) => {
                let slabs = Slabs::new(sight);
                self.walk_by(limit, |aabb, limit| slabs.bound(aabb, limit), visit);
            }
            Probe::Cone(cone) => self.walk_by(limit, |aabb, limit| aabb.cone_bound(cone, limit), visit),
        }
    }

    #[inline(always)]
    fn walk_by(&self, mut limit: f64, bound_of: impl Fn(&Aabb, f64) -> f64, mut visit: impl FnMut(usize, f64) -> f64) {
        let Some(root) = self.nodes.first() else {
            return;
        };
        let mut stack = [(0.0, 0u32); STACK];
        stack[0] = (bound_of(&root.aabb, limit), 0);
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (bound, at) = stack[height];
            if bound > limit || bound == f64::INFINITY {
                continue;
            }
            let Node { first, count, .. } = self.nodes[at as usize];
            if count > 0 {
                for place in first..first + count {
                    limit = visit(place as usize, limit);
                }
                continue;
            }
            // The nearer child goes on top.
            let bounds = [0, 1].map(|i| bound_of(&self.nodes[(first + i) as usize].aabb, limit));
            let far = u32::from(bounds[1] >= bounds[0]);
            for child in [far, 1 - far] {
                if bounds[child as usize] <= limit && bounds[child as usize] < f64::INFINITY {
                    stack[height] = (bounds[child as usize], first + child);
                    height += 1;
                }
            }
        }
    }
}
