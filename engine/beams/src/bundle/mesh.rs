//! Intersection of 16 rays with a mesh, using a copy of its tree with 32-bit coordinates relative to the mesh's centre.

use arrayvec::ArrayVec;
use fearless_simd::prelude::*;
use nalgebra::Vector3;

use super::{
    lanes::{FloatLanes, MaskLanes, UintLanes, VectorLanes, inverse, splat, to_f32},
    packet::CastLimits,
};
use crate::{
    aabb::Aabb,
    simd::{greatest, least},
    tree::{BoxTree, QuadNode, STACK_CAPACITY},
    triangle::Triangle,
};

/// The boxes of up to four children.
#[derive(Debug, Clone, Copy)]
struct PacketNode {
    low: [[f32; 4]; 3],
    high: [[f32; 4]; 3],
    first: [u32; 4],
    count: [u32; 4],
    lanes: u32,
}

#[derive(Debug, Clone, Copy)]
struct PacketTriangle {
    corners: [[f32; 3]; 3],
    normal: [f32; 3],
    primitive: u32,
}

/// The triangles of a mesh and the tree over them, for packets of rays.
#[derive(Debug)]
pub(crate) struct PacketTree {
    centre: Vector3<f64>,
    /// Half of the diagonal of the bounding box.
    radius: f64,
    nodes: Vec<PacketNode>,
    triangles: Vec<PacketTriangle>,
}

/// The origin of the rays relative to a mesh.
pub(super) struct RayOrigin {
    origin: [f32; 3],
    /// Margin for boxes, far larger than rounding errors.
    slack: f32,
    /// Magnitude of the coordinates involved, m.
    pub size: f32,
}

/// The hits of 16 rays.
pub(super) struct LaneHits<S: Simd> {
    pub ok: MaskLanes<S>,
    pub t: FloatLanes<S>,
    pub slope: FloatLanes<S>,
    pub primitive: UintLanes<S>,
}

impl PacketTree {
    /// Copies a tree and its triangles, which must be in the order of the leaves of `tree`.
    pub fn new(aabb: &Aabb, tree: &BoxTree, triangles: &[Triangle]) -> Self {
        if triangles.is_empty() {
            return Self { centre: Vector3::zeros(), radius: 0.0, nodes: Vec::new(), triangles: Vec::new() };
        }
        let centre = aabb.centre();
        let node = |quad: &QuadNode| {
            let mut node = PacketNode {
                low: [[0.0; 4]; 3],
                high: [[0.0; 4]; 3],
                first: quad.first,
                count: quad.count,
                lanes: quad.lanes as u32,
            };
            for lane in 0..quad.lanes {
                let aabb = quad.get(lane);
                for axis in 0..3 {
                    node.low[axis][lane] = ((aabb.low[axis] - centre[axis]) as f32).next_down();
                    node.high[axis][lane] = ((aabb.high[axis] - centre[axis]) as f32).next_up();
                }
            }
            node
        };
        let flat = |t: &Triangle| PacketTriangle {
            corners: t.corners.map(|c| to_f32(&(c - centre))),
            normal: to_f32(&t.normal),
            primitive: t.primitive,
        };
        Self {
            centre,
            radius: 0.5 * (aabb.high - aabb.low).norm(),
            nodes: tree.quads().iter().map(node).collect(),
            triangles: triangles.iter().map(flat).collect(),
        }
    }

    /// Prepares the origin of rays, given in the mesh's frame.
    pub(super) fn ray_origin(&self, origin: &Vector3<f64>) -> RayOrigin {
        let origin = origin - self.centre;
        let size = (origin.norm() + self.radius) as f32;
        RayOrigin { origin: to_f32(&origin), slack: size * 1e-6 + 1e-9, size }
    }

    /// Returns the nearest admissible hits up to distance `far`; among hits at the same distance, that with the lowest
    /// primitive.
    #[inline(always)]
    pub(super) fn cast<S: Simd>(
        &self,
        simd: S,
        eye: &RayOrigin,
        d: &VectorLanes<S>,
        limits: &CastLimits,
        far: FloatLanes<S>,
    ) -> LaneHits<S> {
        let no = MaskLanes::splat(simd, false);
        let mut met = LaneHits { ok: no, t: far, slope: splat(simd, 0.0), primitive: UintLanes::splat(simd, u32::MAX) };
        if self.nodes.is_empty() {
            return met;
        }
        let inverse = VectorLanes { x: inverse(simd, d.x), y: inverse(simd, d.y), z: inverse(simd, d.z) };
        let near = splat(simd, limits.near);
        let mut farthest = far.reduce_max();
        // Nodes to visit, as lower bound of the distance, first and count, with the nearest one on top.
        let mut stack = ArrayVec::<(f32, u32, u32), STACK_CAPACITY>::new();
        stack.push((0.0, 0, 0));
        while let Some((bound, first, count)) = stack.pop() {
            if bound > farthest {
                continue;
            }
            if count > 0 {
                let mut any = false;
                for triangle in &self.triangles[first as usize..(first + count) as usize] {
                    any |= triangle.cast(simd, eye, d, limits, near, &mut met);
                }
                if any {
                    farthest = met.t.reduce_max();
                }
                continue;
            }
            let node = &self.nodes[first as usize];
            let bottom = stack.len();
            for lane in 0..node.lanes as usize {
                let Some(bound) = node.child_distance(simd, lane, eye, &inverse, near, met.t) else { continue };
                let mut at = stack.len();
                while at > bottom && stack[at - 1].0 < bound {
                    at -= 1;
                }
                stack.insert(at, (bound, node.first[lane], node.count[lane]));
            }
        }
        met
    }
}

impl PacketNode {
    /// Returns a lower bound of the distance to a child's box, if a ray may hit something in it.
    #[inline(always)]
    fn child_distance<S: Simd>(
        &self,
        simd: S,
        lane: usize,
        eye: &RayOrigin,
        inverse: &VectorLanes<S>,
        near: FloatLanes<S>,
        far: FloatLanes<S>,
    ) -> Option<f32> {
        let (mut enter, mut leave) = (near, far);
        let mut bound = 0.0;
        for (axis, inverse) in [inverse.x, inverse.y, inverse.z].into_iter().enumerate() {
            let low = self.low[axis][lane] - eye.origin[axis] - eye.slack;
            let high = self.high[axis][lane] - eye.origin[axis] + eye.slack;
            let (a, b) = (inverse * low, inverse * high);
            enter = greatest(enter, least(a, b));
            leave = least(leave, greatest(a, b));
            let beside = if low > 0.0 {
                low
            } else if high < 0.0 {
                -high
            } else {
                0.0
            };
            bound += beside * beside;
        }
        let slack = splat(simd, eye.slack);
        if enter.simd_le(leave + slack).any_true() { Some(bound.sqrt() * (1.0 - 1e-5)) } else { None }
    }
}

impl PacketTriangle {
    /// Tests 16 rays against a triangle. Neighbouring triangles compute the sign for a shared edge from the same
    /// values, so no ray can pass between them.
    #[inline(always)]
    fn cast<S: Simd>(
        &self,
        simd: S,
        eye: &RayOrigin,
        d: &VectorLanes<S>,
        limits: &CastLimits,
        near: FloatLanes<S>,
        met: &mut LaneHits<S>,
    ) -> bool {
        let [a, b, c] = &self.corners;
        let (a, b, c) = (sub(a, &eye.origin), sub(b, &eye.origin), sub(c, &eye.origin));
        let sides = [d.dot(&edge(&a, &b)), d.dot(&edge(&b, &c)), d.dot(&edge(&c, &a))];
        let zero = splat(simd, 0.0);
        let left = sides[0].simd_ge(zero) & sides[1].simd_ge(zero) & sides[2].simd_ge(zero);
        let right = sides[0].simd_le(zero) & sides[1].simd_le(zero) & sides[2].simd_le(zero);
        let crossed = left | right;
        if !crossed.any_true() {
            return false;
        }
        let n = &self.normal;
        let height = n[0] * a[0] + n[1] * a[1] + n[2] * a[2];
        let slope = d.dot(n);
        let t = splat(simd, height) / slope;
        let number = UintLanes::splat(simd, self.primitive);
        let nearer = t.simd_lt(met.t) | (t.simd_eq(met.t) & number.simd_lt(met.primitive));
        let mut ok = crossed & t.simd_ge(near) & nearer;
        if !limits.any_surface {
            ok &= limits.admits(simd, slope);
        }
        if !ok.any_true() {
            return false;
        }
        met.ok |= ok;
        met.t = ok.select(t, met.t);
        met.slope = ok.select(slope, met.slope);
        met.primitive = ok.select(number, met.primitive);
        true
    }
}

#[inline(always)]
fn sub(a: &[f32; 3], b: &[f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Returns twice the cross product of an edge's ends, in a form with little cancellation. Swapping the ends changes
/// only its sign.
#[inline(always)]
fn edge(a: &[f32; 3], b: &[f32; 3]) -> [f32; 3] {
    let (d, s) = (sub(a, b), [a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
    [d[1] * s[2] - d[2] * s[1], d[2] * s[0] - d[0] * s[2], d[0] * s[1] - d[1] * s[0]]
}
