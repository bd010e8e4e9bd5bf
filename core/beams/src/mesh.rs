//! The triangles of one mesh in a tree, built once and shared by all its targets.

use std::sync::OnceLock;

use nalgebra::Vector3;
use tatu_geometry::Mesh;

use super::{
    aabb::Aabb,
    bundle::PacketTree,
    convex::flat,
    grid::Clusters,
    planar::polygon,
    ray,
    sight::{Found, Probe},
    tree::Tree,
};

#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    pub corners: [Vector3<f64>; 3],
    pub normal: Vector3<f64>,
    pub primitive: u32,
}

/// A mesh ready for beams. Triangles without area, or with corners that are missing or not finite, are left out.
#[derive(Debug)]
pub(super) struct MeshTree {
    /// In the order of the tree's leaves.
    pub triangles: Vec<Triangle>,
    tree: Tree,
    pub aabb: Aabb,
    /// The same for bundles of rays.
    pub packets: PacketTree,
    /// The same for images, made for the first one.
    pub clusters: OnceLock<Clusters>,
}

impl MeshTree {
    pub fn new(mesh: &Mesh) -> Self {
        let all: Vec<Triangle> = (0..mesh.triangles.len()).filter_map(|i| triangle(mesh, i)).collect();
        let boxes: Vec<Aabb> = all.iter().map(|t| Aabb::around(&t.corners)).collect();
        let mut tree = Tree::default();
        tree.build(0..all.len() as u32, &boxes, 4);
        let triangles: Vec<Triangle> = tree.order.iter().map(|&i| all[i as usize]).collect();
        let aabb = boxes.iter().fold(Aabb::EMPTY, |a, b| a.merge(b));
        let packets = PacketTree::new(&aabb, &tree, &triangles);
        Self { triangles, tree, aabb, packets, clusters: OnceLock::new() }
    }

    /// The nearest point that counts; the probe is given in the mesh's frame.
    pub fn cast(&self, probe: &Probe) -> Option<Found> {
        let mut best = None;
        self.tree.walk(probe, probe.far(), |place, limit| {
            best = Found::nearer(best, self.triangles[place].cast(probe, limit));
            best.map_or(limit, |found| found.distance)
        });
        best
    }
}

impl Triangle {
    fn cast(&self, probe: &Probe, limit: f64) -> Option<Found> {
        let Self { corners, normal, primitive } = self;
        match probe {
            Probe::Ray(sight) => {
                let corners = corners.map(|c| c - sight.origin.coords);
                let mut best = None;
                if let Some(t) = ray::triangle(&sight.axis, &corners, normal) {
                    ray::offer(&mut best, sight, t, *normal, *primitive);
                }
                best
            }
            Probe::Cone(cone) => {
                let corners = corners.map(|c| c - cone.sight.origin.coords);
                // Most triangles end here: their plane is beyond what is known.
                if normal.dot(&corners[0]).abs() > limit {
                    return None;
                }
                let (distance, point) = polygon(cone, &corners, normal)?;
                Some(Found { distance, point, normal: *normal, primitive: *primitive })
            }
            Probe::Convex(space) => {
                let corners = corners.map(|c| c - space.sight.origin.coords);
                if normal.dot(&corners[0]).abs() > limit {
                    return None;
                }
                let (distance, point) = flat(space, &corners, normal, None)?;
                Some(Found { distance, point, normal: *normal, primitive: *primitive })
            }
        }
    }
}

/// A triangle, unless it has no area or a corner that is missing or no place.
pub(super) fn triangle(mesh: &Mesh, index: usize) -> Option<Triangle> {
    let mut corners = [Vector3::zeros(); 3];
    for (corner, vertex) in corners.iter_mut().zip(mesh.triangles[index]) {
        *corner = mesh.vertices.get(vertex as usize)?.coords;
    }
    let [a, b, c] = &corners;
    let normal = (b - a).cross(&(c - a)).try_normalize(1e-300)?;
    let finite = normal.iter().chain(corners.iter().flatten()).all(|x| x.is_finite());
    finite.then_some(Triangle { corners, normal, primitive: index as u32 })
}
