//! A tree of boxes over numbered items: of a scene's targets, or of a mesh's triangles.

use nalgebra::{Isometry3, Vector3};

use super::sight::{Probe, Sight};
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

    fn area(&self) -> f64 {
        let size = self.high - self.low;
        size.x * size.y + size.y * size.z + size.z * size.x
    }

    /// No point in this box that the probe sees is nearer than this; infinity when it sees none.
    pub fn bound(&self, probe: &Probe, limit: f64) -> f64 {
        match probe {
            Probe::Ray(sight) => self.ray_bound(sight),
            Probe::Cone(cone) => {
                let (low, high) = (self.low - cone.sight.origin.coords, self.high - cone.sight.origin.coords);
                let least = low.sup(&-high).map(|x| x.max(0.0)).norm() - SLACK;
                if least > limit {
                    return f64::INFINITY;
                }
                let radius = 0.5 * (high - low).norm() + SLACK;
                if cone.misses_ball(&((low + high) * 0.5), radius) { f64::INFINITY } else { least }
            }
        }
    }

    fn ray_bound(&self, sight: &Sight) -> f64 {
        let (mut enter, mut leave) = (sight.near, f64::INFINITY);
        for i in 0..3 {
            let (x, slope) = (sight.origin[i], sight.axis[i]);
            let low = (self.low[i] - SLACK - x) / slope;
            let high = (self.high[i] + SLACK - x) / slope;
            // `max` and `min` pass over the NaN of a ray in the very plane of a side.
            enter = enter.max(low.min(high));
            leave = leave.min(low.max(high));
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

/// Deeper than a tree of 2^32 items halved at the median.
const STACK: usize = 72;

impl Tree {
    /// Builds the tree over `items`, numbers into `boxes`. The same input gives the same tree.
    pub fn build(&mut self, items: impl IntoIterator<Item = u32>, boxes: &[Aabb], leaf_size: usize) {
        self.order.clear();
        self.order.extend(items);
        self.nodes.clear();
        if self.order.is_empty() {
            return;
        }
        let whole = Node { aabb: Aabb::EMPTY, first: 0, count: self.order.len() as u32 };
        self.nodes.push(whole);
        let mut at = 0;
        while at < self.nodes.len() {
            self.split(at, boxes, leaf_size);
            at += 1;
        }
        self.built_area = self.refit(boxes);
    }

    /// Halves a leaf at the median along the longest side of its items' centres.
    fn split(&mut self, at: usize, boxes: &[Aabb], leaf_size: usize) {
        let Node { first, count, .. } = self.nodes[at];
        if count as usize <= leaf_size {
            return;
        }
        let centre = |item: u32| boxes[item as usize].low + boxes[item as usize].high;
        let items = &mut self.order[first as usize..(first + count) as usize];
        let centres: Aabb = items.iter().fold(Aabb::EMPTY, |b, &item| {
            let c = centre(item);
            Aabb { low: b.low.inf(&c), high: b.high.sup(&c) }
        });
        let axis = (centres.high - centres.low).imax();
        let half = items.len() / 2;
        items.select_nth_unstable_by(half, |a, b| centre(*a)[axis].total_cmp(&centre(*b)[axis]).then(a.cmp(b)));
        let half = half as u32;
        self.nodes[at].first = self.nodes.len() as u32;
        self.nodes[at].count = 0;
        self.nodes.push(Node { aabb: Aabb::EMPTY, first, count: half });
        self.nodes.push(Node { aabb: Aabb::EMPTY, first: first + half, count: count - half });
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
    pub fn walk(&self, probe: &Probe, mut limit: f64, mut visit: impl FnMut(usize, f64) -> f64) {
        let Some(root) = self.nodes.first() else {
            return;
        };
        let mut stack = [(0.0, 0); STACK];
        stack[0] = (root.aabb.bound(probe, limit), 0);
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
            let bounds = [0, 1].map(|i| self.nodes[(first + i) as usize].aabb.bound(probe, limit));
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
