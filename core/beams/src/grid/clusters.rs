//! A mesh ready for drawing: neighbouring triangles in vectors of 16, and these in groups.
//!
//! A group is passed over as a whole when it is out of sight or shows only sides that nobody asked for. Triangles hold
//! their corners themselves: moving a corner once more costs less than looking it up.

use std::collections::HashMap;

use nalgebra::Vector3;
use tatu_geometry::Mesh;

use super::raster::WIDE;
use crate::{aabb::Aabb, triangle::Triangle};

/// Vectors of a group.
const GROUP: usize = 4;

/// A mesh in groups, made once.
#[derive(Debug)]
pub(crate) struct Clusters {
    /// Middle of the mesh, to which corners are relative, and half of its extents; negative when there is nothing.
    pub(super) centre: Vector3<f64>,
    pub(super) half: Vector3<f64>,
    pub(super) sixteens: Vec<Sixteen>,
    /// Their numbers in the mesh; apart, since most images do not need them.
    pub(super) primitives: Vec<[u32; WIDE]>,
    pub(super) groups: Vec<Groups>,
    /// Whether only front faces are visible from outside.
    pub(super) closed: bool,
}

/// 16 triangles; the last of a mesh may be filled up with some that have no area.
#[derive(Debug, Clone)]
pub(super) struct Sixteen {
    /// Of each corner: x, y, z.
    pub corners: [[[f32; WIDE]; 3]; 3],
}

impl Sixteen {
    pub fn corner(&self, corner: usize, lane: usize) -> Vector3<f64> {
        let [x, y, z] = &self.corners[corner];
        Vector3::new(f64::from(x[lane]), f64::from(y[lane]), f64::from(z[lane]))
    }
}

/// Groups looked at together.
pub(super) const ROW: usize = 8;

/// 8 groups of neighbouring triangles, numbers of one kind side by side; the last of a mesh may be filled up.
#[derive(Debug, Clone)]
pub(super) struct Groups {
    /// Of the balls around them: x, y and z relative to the middle of the mesh.
    pub centre: [[f64; ROW]; 3],
    pub radius: [f64; ROW],
    /// All normals are within an angle of this axis.
    pub axis: [[f64; ROW]; 3],
    /// Sine of that angle; 2 where it is a right angle or more.
    pub sine: [f64; ROW],
    /// First vector, and the one after the last; none where it is filled up.
    pub sixteens: [(u32, u32); ROW],
}

impl Clusters {
    /// `members` are those of the mesh's triangles that have an area, neighbours near one another.
    pub fn new(mesh: &Mesh, members: &[Triangle]) -> Self {
        if members.is_empty() {
            let (centre, half) = (Vector3::zeros(), Vector3::repeat(-1.0));
            let (sixteens, primitives, groups) = (Vec::new(), Vec::new(), Vec::new());
            return Self { centre, half, sixteens, primitives, groups, closed: false };
        }
        let whole = Aabb::around(members.iter().flat_map(|t| &t.corners));
        let (centre, half) = (whole.centre(), (whole.high - whole.low) * 0.5);
        let sixteens = members.chunks(WIDE).map(|some| sixteen(some, &centre)).collect();
        let number = |some: &[Triangle]| std::array::from_fn(|lane| some[lane.min(some.len() - 1)].primitive);
        let primitives = members.chunks(WIDE).map(number).collect();
        let mut groups = Vec::new();
        for (number, some) in members.chunks(GROUP * WIDE).enumerate() {
            let (first, lane) = ((number * GROUP) as u32, number % ROW);
            if lane == 0 {
                groups.push(Groups::none());
            }
            if let Some(groups) = groups.last_mut() {
                groups.put(lane, some, &centre, (first, first + some.len().div_ceil(WIDE) as u32));
            }
        }
        Self { centre, half, sixteens, primitives, groups, closed: closed(mesh, members) }
    }
}

fn sixteen(some: &[Triangle], centre: &Vector3<f64>) -> Sixteen {
    let mut out = Sixteen { corners: [[[0.0; WIDE]; 3]; 3] };
    for lane in 0..WIDE {
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

impl Groups {
    fn none() -> Self {
        let (zeros, threes) = ([0.0; ROW], [[0.0; ROW]; 3]);
        Self { centre: threes, radius: zeros, axis: threes, sine: zeros, sixteens: [(0, 0); ROW] }
    }

    fn put(&mut self, lane: usize, some: &[Triangle], origin: &Vector3<f64>, sixteens: (u32, u32)) {
        let around = Aabb::around(some.iter().flat_map(|t| &t.corners));
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
        // Single precision moves corners, and so normals, a little.
        (self.radius[lane], self.sine[lane]) = (radius * (1.0 + 1e-6), sine + 1e-3);
        self.sixteens[lane] = sixteens;
    }
}

/// Whether a surface is closed and all its pieces turn their fronts outward: each edge is there once in each direction,
/// and each connected piece encloses a positive volume. Corners at the same place are the same.
fn closed(mesh: &Mesh, kept: &[Triangle]) -> bool {
    if kept.len() != mesh.triangles.len() {
        return false;
    }
    // The same place has the same number.
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
    // Pieces: each corner points to one of its piece with a lower number.
    let mut lower: Vec<u32> = (0..numbers.len() as u32).collect();
    for (a, b) in &edges {
        let (a, b) = (root(&mut lower, *a), root(&mut lower, *b));
        lower[a.max(b) as usize] = a.min(b);
    }
    // Volumes relative to a point of the piece, so that a distant origin blurs nothing.
    let mut volumes: HashMap<u32, (Vector3<f64>, f64)> = HashMap::new();
    for (triangle, [first, ..]) in kept.iter().zip(&corners) {
        let [a, b, c] = &triangle.corners;
        let (o, volume) = volumes.entry(root(&mut lower, *first)).or_insert((*a, 0.0));
        *volume += (a - *o).dot(&(b - *o).cross(&(c - *o)));
    }
    volumes.values().all(|(_, volume)| *volume > 0.0)
}

/// The lowest number of a piece.
fn root(lower: &mut [u32], mut at: u32) -> u32 {
    while lower[at as usize] != at {
        lower[at as usize] = lower[lower[at as usize] as usize];
        at = lower[at as usize];
    }
    at
}
