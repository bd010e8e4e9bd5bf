//! Approximate convex decomposition of meshes.

use std::panic::{AssertUnwindSafe, catch_unwind};

use nalgebra::Point3;
use rapier3d::parry::transformation::vhacd::{VHACD, VHACDParameters};
use tatu_geometry::Mesh;

use crate::convert::{vector, vector_back};

/// Number of voxels along the longest side of a mesh.
const RESOLUTION: u32 = 64;

/// Divides a mesh into at most `max_parts` convex meshes that together have about its form, by the method V-HACD of
/// parry. A convex mesh, and one that cannot be divided, gives no parts. Costs 0.05 to several seconds.
///
/// The parts are hulls of pieces of the surface, so they never reach beyond the hull of the mesh.
pub fn convex_parts(mesh: &Mesh, max_parts: u32) -> Vec<Mesh> {
    let points: Vec<_> = mesh.vertices.iter().map(|p| vector(&p.coords)).collect();
    let is_valid = |triangle: &&[u32; 3]| triangle.iter().all(|i| (*i as usize) < points.len());
    let triangles: Vec<[u32; 3]> = mesh.triangles.iter().filter(is_valid).copied().collect();
    let finite = points.iter().all(|p| p.is_finite());
    if triangles.is_empty() || !finite || max_parts < 2 {
        return Vec::new();
    }
    let params = VHACDParameters { max_convex_hulls: max_parts, resolution: RESOLUTION, ..Default::default() };
    // Parry panics if a piece is flat.
    let hulls = catch_unwind(AssertUnwindSafe(|| {
        VHACD::decompose(&params, &points, &triangles, true).compute_exact_convex_hulls(&points, &triangles)
    }));
    let Ok(hulls) = hulls else { return Vec::new() };
    let part = |(points, triangles): (Vec<_>, Vec<[u32; 3]>)| Mesh {
        vertices: points.into_iter().map(|p| Point3::from(vector_back(p))).collect(),
        triangles,
        coordinates: Vec::new(),
    };
    let parts: Vec<Mesh> = hulls.into_iter().filter(|(_, triangles)| triangles.len() >= 4).map(part).collect();
    if parts.len() < 2 { Vec::new() } else { parts }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a prism with this outline, from z = 0 to 1; the outline is star-shaped as seen from its first point.
    fn prism(outline: &[[f64; 2]]) -> Mesh {
        let n = outline.len() as u32;
        let at = |z: f64| outline.iter().map(move |[x, y]| Point3::new(*x, *y, z));
        let mut triangles = Vec::new();
        for i in 0..n {
            let j = (i + 1) % n;
            triangles.extend([[i, j, n + j], [i, n + j, n + i]]);
        }
        for i in 1..n - 1 {
            triangles.extend([[0, i + 1, i], [n, n + i, n + i + 1]]);
        }
        Mesh { vertices: at(0.0).chain(at(1.0)).collect(), triangles, coordinates: Vec::new() }
    }

    #[test]
    fn an_l_is_divided_and_its_notch_stays_free() {
        // The inner corner comes first: from it, all others can be seen.
        let l = prism(&[[1.0, 1.0], [1.0, 3.0], [0.0, 3.0], [0.0, 0.0], [3.0, 0.0], [3.0, 1.0]]);
        let parts = convex_parts(&l, 8);
        assert!((2..=8).contains(&parts.len()), "{} parts", parts.len());
        for part in &parts {
            let low = part.vertices.iter().fold([f64::MAX; 2], |low, p| [low[0].min(p.x), low[1].min(p.y)]);
            let high = part.vertices.iter().fold([f64::MIN; 2], |high, p| [high[0].max(p.x), high[1].max(p.y)]);
            // A part in both legs would cover the notch.
            assert!(high[0] < 1.2 || high[1] < 1.2, "{low:?} {high:?}");
        }
        assert_eq!(convex_parts(&l, 8).len(), parts.len());
    }

    #[test]
    fn meshes_that_cannot_be_divided_have_no_parts() {
        let flat = Mesh {
            vertices: vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)],
            triangles: vec![[0, 1, 2], [0, 1, 9]],
            coordinates: Vec::new(),
        };
        assert!(convex_parts(&flat, 8).is_empty());
        let square = prism(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert!(convex_parts(&square, 1).is_empty());
        assert!(convex_parts(&Mesh { triangles: Vec::new(), ..square }, 8).is_empty());
    }
}
