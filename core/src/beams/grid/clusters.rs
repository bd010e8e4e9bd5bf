//! A mesh ready for drawing: small groups of neighbouring triangles, each with its own vertices.
//!
//! A group is passed over as a whole when it is out of sight or shows only sides that nobody asked for; else its vertices
//! are moved into the image, 16 at a time, and stay near while its triangles are drawn.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::raster::WIDE;
use crate::beams::aabb::Aabb;
use crate::beams::binary;
use crate::geometry::Mesh;

/// Most triangles of a group.
const MOST: usize = 128;
/// Most vertices of a group: all different, in whole vectors.
pub(super) const MOST_VERTICES: usize = 3 * MOST;

/// A mesh in groups, made once.
#[derive(Debug)]
pub(in crate::beams) struct Clusters {
    /// Middle of the mesh, to which vertices are relative, and half of its extents.
    pub(super) centre: Vector3<f64>,
    pub(super) half: Vector3<f64>,
    /// Vertices of one group after the other; each group begins at a multiple of 16.
    pub(super) vertices: [Vec<f32>; 3],
    /// Corners of triangles: places within the group. Groups are filled up with triangles without area.
    pub(super) corners: [Vec<u16>; 3],
    /// The triangle in the mesh.
    pub(super) primitive: Vec<u32>,
    pub(super) groups: Vec<Group>,
    /// Whether whoever looks from outside sees only fronts.
    pub(super) closed: bool,
}

/// Neighbouring triangles.
#[derive(Debug, Clone)]
pub(super) struct Group {
    /// The ball around them, relative to the middle of the mesh.
    pub centre: Vector3<f64>,
    pub radius: f64,
    /// All normals are within an angle of this axis.
    pub axis: Vector3<f64>,
    /// Sine of that angle; 2 where it is a right angle or more.
    pub sine: f64,
    pub first_vertex: usize,
    pub vertices: usize,
    pub first_triangle: usize,
    pub triangles: usize,
}

impl Clusters {
    /// Triangles without area, or with corners that are missing or not finite, are left out.
    pub fn new(mesh: &Mesh) -> Self {
        let kept: Vec<(u32, [u32; 3], Vector3<f64>)> =
            (0..mesh.triangles.len()).filter_map(|i| sound(mesh, i)).collect();
        let point = |vertex: u32| mesh.vertices[vertex as usize].coords;
        let boxes: Vec<Aabb> = kept.iter().map(|(_, corners, _)| Aabb::around(&corners.map(point))).collect();
        let whole = boxes.iter().fold(Aabb::EMPTY, |a, b| a.merge(b));
        let empty = kept.is_empty();
        let mut out = Self {
            centre: if empty { Vector3::zeros() } else { whole.centre() },
            half: if empty { Vector3::repeat(-1.0) } else { (whole.high - whole.low) * 0.5 },
            vertices: Default::default(),
            corners: Default::default(),
            primitive: Vec::new(),
            groups: Vec::new(),
            closed: !empty && closed(mesh, &kept),
        };
        let mut order: Vec<u32> = (0..kept.len() as u32).collect();
        if empty {
            return out;
        }
        let nodes = binary::build(&mut order, &boxes, MOST);
        let mut leaves: Vec<_> = nodes.iter().filter(|n| n.count > 0).map(|n| (n.first, n.count)).collect();
        leaves.sort_unstable();
        for (first, count) in leaves {
            let members = order[first as usize..(first + count) as usize].iter().map(|i| &kept[*i as usize]);
            out.push(mesh, members);
        }
        out
    }

    fn push<'a>(&mut self, mesh: &Mesh, members: impl Iterator<Item = &'a (u32, [u32; 3], Vector3<f64>)> + Clone) {
        let (first_vertex, first_triangle) = (self.vertices[0].len(), self.primitive.len());
        let mut places: HashMap<u32, u16> = HashMap::new();
        let mut around = Aabb::EMPTY;
        let mut axis = Vector3::zeros();
        for (primitive, corners, normal) in members.clone() {
            for (k, vertex) in corners.iter().enumerate() {
                let next = places.len() as u16;
                let place = *places.entry(*vertex).or_insert(next);
                if place == next {
                    let p = mesh.vertices[*vertex as usize].coords - self.centre;
                    around = around.merge(&Aabb { low: p, high: p });
                    for axis in 0..3 {
                        self.vertices[axis].push(p[axis] as f32);
                    }
                }
                self.corners[k].push(place);
            }
            self.primitive.push(*primitive);
            axis += normal;
        }
        let axis = axis.try_normalize(1e-9).unwrap_or_else(Vector3::z);
        let least = members.map(|(_, _, normal)| normal.dot(&axis)).fold(1.0, f64::min);
        let vertices = places.len();
        let triangles = self.primitive.len() - first_triangle;
        let centre = around.centre();
        let size = first_vertex..first_vertex + vertices;
        let radius = size.map(|i| (self.vertex(i) - centre).norm()).fold(0.0, f64::max);
        for axis in 0..3 {
            let fill = self.vertices[axis][first_vertex];
            self.vertices[axis].resize((first_vertex + vertices).next_multiple_of(WIDE), fill);
            self.corners[axis].resize((first_triangle + triangles).next_multiple_of(WIDE), 0);
        }
        self.primitive.resize((first_triangle + triangles).next_multiple_of(WIDE), 0);
        let sine = if least > 0.0 { (1.0 - least * least).max(0.0).sqrt() } else { 2.0 };
        // Single precision moves vertices, and so normals, a little.
        let (radius, sine) = (radius * (1.0 + 1e-6), sine + 1e-3);
        self.groups.push(Group { centre, radius, axis, sine, first_vertex, vertices, first_triangle, triangles });
    }

    pub(super) fn vertex(&self, place: usize) -> Vector3<f64> {
        let [x, y, z] = &self.vertices;
        Vector3::new(f64::from(x[place]), f64::from(y[place]), f64::from(z[place]))
    }
}

/// A triangle that has an area: its number, corners and normal.
fn sound(mesh: &Mesh, index: usize) -> Option<(u32, [u32; 3], Vector3<f64>)> {
    let corners = mesh.triangles[index];
    let mut points = [Vector3::zeros(); 3];
    for (point, vertex) in points.iter_mut().zip(corners) {
        *point = mesh.vertices.get(vertex as usize)?.coords;
    }
    let [a, b, c] = &points;
    let normal = (b - a).cross(&(c - a)).try_normalize(1e-300)?;
    let finite = normal.iter().chain(points.iter().flatten()).all(|x| x.is_finite());
    finite.then_some((index as u32, corners, normal))
}

/// Whether a surface is closed and all its pieces turn their fronts outward: each edge is there once in each direction,
/// and each connected piece encloses a positive volume. Vertices at the same place are the same.
fn closed(mesh: &Mesh, kept: &[(u32, [u32; 3], Vector3<f64>)]) -> bool {
    if kept.len() != mesh.triangles.len() {
        return false;
    }
    // The same place has the same number.
    let mut numbers = HashMap::new();
    let same: Vec<u32> = mesh
        .vertices
        .iter()
        .enumerate()
        .map(|(i, p)| *numbers.entry([p.x, p.y, p.z].map(|x| (x + 0.0).to_bits())).or_insert(i as u32))
        .collect();
    let corners = |t: &(u32, [u32; 3], Vector3<f64>)| t.1.map(|v| same[v as usize]);
    let mut edges: Vec<(u32, u32)> = kept
        .iter()
        .flat_map(|t| corners(t))
        .enumerate()
        .map(|(i, a)| (a, corners(&kept[i / 3])[(i + 1) % 3]))
        .collect();
    edges.sort_unstable();
    let twice = edges.windows(2).any(|pair| pair[0] == pair[1]);
    if twice || !edges.iter().all(|(a, b)| edges.binary_search(&(*b, *a)).is_ok()) {
        return false;
    }
    // Pieces: each vertex points to one of its piece with a lower number.
    let mut lower: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    fn root(lower: &mut [u32], mut v: u32) -> u32 {
        while lower[v as usize] != v {
            lower[v as usize] = lower[lower[v as usize] as usize];
            v = lower[v as usize];
        }
        v
    }
    for (a, b) in &edges {
        let (a, b) = (root(&mut lower, *a), root(&mut lower, *b));
        lower[a.max(b) as usize] = a.min(b);
    }
    let mut volumes = vec![0.0; mesh.vertices.len()];
    for t in kept {
        let c = corners(t);
        let [a, b, d] = c.map(|v| mesh.vertices[v as usize].coords);
        let piece = root(&mut lower, c[0]) as usize;
        // Relative to a point of the piece, so that a distant origin blurs nothing.
        let o = mesh.vertices[piece].coords;
        volumes[piece] += (a - o).dot(&(b - o).cross(&(d - o)));
    }
    kept.iter().all(|t| volumes[root(&mut lower, corners(t)[0]) as usize] > 0.0)
}
