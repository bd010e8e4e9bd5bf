//! Intersection of a beam with a triangle of a mesh.

use nalgebra::Vector3;
use tatu_geometry::Mesh;

use super::{convex::nearest_on_face, planar::polygon, probe::Probe, ray, sight::FormHit};

#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    pub corners: [Vector3<f64>; 3],
    pub normal: Vector3<f64>,
    pub primitive: u32,
}

impl Triangle {
    pub fn cast(&self, probe: &Probe, limit: f64) -> Option<FormHit> {
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
                // Most triangles are rejected here, because their plane is farther away than the nearest hit so far.
                if normal.dot(&corners[0]).abs() > limit {
                    return None;
                }
                let (distance, point) = polygon(cone, &corners, normal)?;
                Some(FormHit { distance, point, normal: *normal, primitive: *primitive })
            }
            Probe::Convex(space) => {
                let corners = corners.map(|c| c - space.sight.origin.coords);
                if normal.dot(&corners[0]).abs() > limit {
                    return None;
                }
                let (distance, point) = nearest_on_face(space, &corners, normal, None)?;
                Some(FormHit { distance, point, normal: *normal, primitive: *primitive })
            }
        }
    }
}

/// Returns a triangle of a mesh, or `None` if it is degenerate, or if a corner is missing or not finite.
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
