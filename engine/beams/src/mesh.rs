//! The tree of a mesh's triangles, built once and shared by all targets with this mesh.

use std::sync::OnceLock;

use tatu_geometry::Mesh;

use super::{
    aabb::Aabb,
    bundle::PacketTree,
    grid::MeshClusters,
    probe::Probe,
    sight::FormHit,
    tree::BoxTree,
    triangle::{Triangle, triangle},
};

/// A mesh prepared for beams. Degenerate triangles, and triangles with missing or non-finite corners, are omitted.
#[derive(Debug)]
pub(super) struct MeshTree {
    /// Triangles, in the order of the tree's leaves.
    pub triangles: Vec<Triangle>,
    tree: BoxTree,
    pub aabb: Aabb,
    /// The tree for bundles of rays.
    pub packets: PacketTree,
    /// The clusters for images, built when the first image is rendered.
    pub clusters: OnceLock<MeshClusters>,
}

impl MeshTree {
    pub fn new(mesh: &Mesh) -> Self {
        let all: Vec<Triangle> = (0..mesh.triangles.len()).filter_map(|i| triangle(mesh, i)).collect();
        let boxes: Vec<Aabb> = all.iter().map(|t| Aabb::of_points(&t.corners)).collect();
        let mut tree = BoxTree::default();
        tree.build(0..all.len() as u32, &boxes, 4);
        let triangles: Vec<Triangle> = tree.order.iter().map(|&i| all[i as usize]).collect();
        let aabb = boxes.iter().fold(Aabb::EMPTY, |a, b| a.merge(b));
        let packets = PacketTree::new(&aabb, &tree, &triangles);
        Self { triangles, tree, aabb, packets, clusters: OnceLock::new() }
    }

    /// Returns the nearest admissible point; the probe is in the mesh's frame.
    pub fn cast(&self, probe: &Probe) -> Option<FormHit> {
        let mut best = None;
        self.tree.walk(probe, probe.far(), |place, limit| {
            best = FormHit::nearer(best, self.triangles[place].cast(probe, limit));
            best.map_or(limit, |found| found.distance)
        });
        best
    }
}
