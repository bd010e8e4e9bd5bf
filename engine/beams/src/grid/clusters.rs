//! A mesh prepared for rasterisation: neighbouring triangles in vectors of 16, which form groups.
//!
//! A whole group is skipped if it is outside the image or shows only sides that are not requested. Each triangle stores
//! its own corners, because transforming a shared corner again costs less than looking it up.

use std::collections::HashMap;

use nalgebra::Vector3;
use tatu_geometry::Mesh;

use super::raster::LANES;
use crate::{aabb::Aabb, triangle::Triangle};

const VECTORS_PER_GROUP: usize = 4;

/// The triangles of a mesh in groups, built once per mesh.
#[derive(Debug)]
pub(crate) struct MeshClusters {
    /// Centre of the mesh, to which corners are relative. `half` is half of its extents, negative if the mesh is empty.
    pub(super) centre: Vector3<f64>,
    pub(super) half: Vector3<f64>,
    pub(super) vectors: Vec<TriangleVector>,
    /// Indices of the triangles in the mesh, stored separately because most images do not need them.
    pub(super) primitives: Vec<[u32; LANES]>,
    pub(super) groups: Vec<GroupRow>,
    /// Whether only front faces are visible from outside.
    pub(super) closed: bool,
}

/// 16 triangles; the last vector of a mesh may be padded with degenerate triangles.
#[derive(Debug, Clone)]
pub(super) struct TriangleVector {
    /// The x, y and z coordinates of each corner.
    pub corners: [[[f32; LANES]; 3]; 3],
}

impl TriangleVector {
    pub fn corner(&self, corner: usize, lane: usize) -> Vector3<f64> {
        let [x, y, z] = &self.corners[corner];
        Vector3::new(f64::from(x[lane]), f64::from(y[lane]), f64::from(z[lane]))
    }
}

/// Number of groups that are tested together.
pub(super) const GROUPS_PER_ROW: usize = 8;

/// Eight groups of neighbouring triangles as a structure of arrays; the last one of a mesh may be padded.
#[derive(Debug, Clone)]
pub(super) struct GroupRow {
    /// Centres of the bounding spheres: x, y and z relative to the centre of the mesh.
    pub centre: [[f64; GROUPS_PER_ROW]; 3],
    pub radius: [f64; GROUPS_PER_ROW],
    /// Axis of the cone of normals: all normals are within an angle of it.
    pub axis: [[f64; GROUPS_PER_ROW]; 3],
    /// Sine of the angle of the cone of normals, plus a margin for rounding; above 2 if the angle is a right angle or
    /// more.
    pub sine: [f64; GROUPS_PER_ROW],
    /// Ranges of vectors as (first, end); empty for padding.
    pub vectors: [(u32, u32); GROUPS_PER_ROW],
}

impl MeshClusters {
    /// Groups the triangles; `members` are the triangles of the mesh that are not degenerate, in an order in which
    /// neighbours are adjacent.
    pub fn new(mesh: &Mesh, members: &[Triangle]) -> Self {
        if members.is_empty() {
            let (centre, half) = (Vector3::zeros(), Vector3::repeat(-1.0));
            let (sixteens, primitives, groups) = (Vec::new(), Vec::new(), Vec::new());
            return Self { centre, half, vectors: sixteens, primitives, groups, closed: false };
        }
        let whole = Aabb::of_points(members.iter().flat_map(|t| &t.corners));
        let (centre, half) = (whole.centre(), (whole.high - whole.low) * 0.5);
        let sixteens = members.chunks(LANES).map(|some| triangle_vector(some, &centre)).collect();
        let number = |some: &[Triangle]| std::array::from_fn(|lane| some[lane.min(some.len() - 1)].primitive);
        let primitives = members.chunks(LANES).map(number).collect();
        let mut groups = Vec::new();
        for (number, some) in members.chunks(VECTORS_PER_GROUP * LANES).enumerate() {
            let (first, lane) = ((number * VECTORS_PER_GROUP) as u32, number % GROUPS_PER_ROW);
            if lane == 0 {
                groups.push(GroupRow::empty());
            }
            if let Some(groups) = groups.last_mut() {
                groups.set(lane, some, &centre, (first, first + some.len().div_ceil(LANES) as u32));
            }
        }
        Self { centre, half, vectors: sixteens, primitives, groups, closed: is_closed(mesh, members) }
    }
}

fn triangle_vector(some: &[Triangle], centre: &Vector3<f64>) -> TriangleVector {
    let mut out = TriangleVector { corners: [[[0.0; LANES]; 3]; 3] };
    for lane in 0..LANES {
        let triangle = &some[lane.min(some.len() - 1)];
        for corner in 0..3 {
            let p = triangle.corners[if lane < some.len() { corner } else { 0 }] - centre;
            for axis in 0..3 {
                out.corners[corner][axis][lane] = p[axis] as f32;
            }
        }
    }
    out
}

impl GroupRow {
    fn empty() -> Self {
        let (zeros, threes) = ([0.0; GROUPS_PER_ROW], [[0.0; GROUPS_PER_ROW]; 3]);
        Self { centre: threes, radius: zeros, axis: threes, sine: zeros, vectors: [(0, 0); GROUPS_PER_ROW] }
    }

    fn set(&mut self, lane: usize, some: &[Triangle], origin: &Vector3<f64>, sixteens: (u32, u32)) {
        let around = Aabb::of_points(some.iter().flat_map(|t| &t.corners));
        let middle = around.centre();
        let radius = some.iter().flat_map(|t| &t.corners).map(|p| (p - middle).norm()).fold(0.0, f64::max);
        let sum: Vector3<f64> = some.iter().map(|t| t.normal).sum();
        let axis = sum.try_normalize(1e-9).unwrap_or_else(Vector3::z);
        let least = some.iter().map(|t| t.normal.dot(&axis)).fold(1.0, f64::min);
        let sine = if least > 0.0 { (1.0 - least * least).max(0.0).sqrt() } else { 2.0 };
        let centre = middle - origin;
        for i in 0..3 {
            (self.centre[i][lane], self.axis[i][lane]) = (centre[i], axis[i]);
        }
        // Single precision moves corners, and therefore normals, slightly.
        (self.radius[lane], self.sine[lane]) = (radius * (1.0 + 1e-6), sine + 1e-3);
        self.vectors[lane] = sixteens;
    }
}

/// Returns whether a surface is closed and all its connected pieces face outward: each edge occurs once in each
/// direction, and each piece encloses a positive volume. Corners at the same position are treated as one corner.
fn is_closed(mesh: &Mesh, kept: &[Triangle]) -> bool {
    if kept.len() != mesh.triangles.len() {
        return false;
    }
    // Corners at the same position get the same number.
    let mut numbers = HashMap::new();
    let corners: Vec<[u32; 3]> = kept
        .iter()
        .map(|t| {
            t.corners.map(|p| {
                let next = numbers.len() as u32;
                *numbers.entry([p.x, p.y, p.z].map(|x| (x + 0.0).to_bits())).or_insert(next)
            })
        })
        .collect();
    let mut edges: Vec<(u32, u32)> = corners.iter().flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)]).collect();
    edges.sort_unstable();
    let twice = edges.windows(2).any(|pair| pair[0] == pair[1]);
    if twice || !edges.iter().all(|(a, b)| edges.binary_search(&(*b, *a)).is_ok()) {
        return false;
    }
    // Connected pieces, by union-find: each corner points to a corner of its piece with a lower or equal number.
    let mut lower: Vec<u32> = (0..numbers.len() as u32).collect();
    for (a, b) in &edges {
        let (a, b) = (root(&mut lower, *a), root(&mut lower, *b));
        lower[a.max(b) as usize] = a.min(b);
    }
    // Volumes are relative to a point of the piece, so that a distant origin does not reduce precision.
    let mut volumes: HashMap<u32, (Vector3<f64>, f64)> = HashMap::new();
    for (triangle, [first, ..]) in kept.iter().zip(&corners) {
        let [a, b, c] = &triangle.corners;
        let (o, volume) = volumes.entry(root(&mut lower, *first)).or_insert((*a, 0.0));
        *volume += (a - *o).dot(&(b - *o).cross(&(c - *o)));
    }
    volumes.values().all(|(_, volume)| *volume > 0.0)
}

/// Returns the lowest corner number of a piece.
fn root(lower: &mut [u32], mut at: u32) -> u32 {
    while lower[at as usize] != at {
        lower[at as usize] = lower[lower[at as usize] as usize];
        at = lower[at as usize];
    }
    at
}
