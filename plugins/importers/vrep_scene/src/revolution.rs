//! Detects convex meshes that are solids of revolution, modelled with flat faces: bottles, cups, wheels with a chamfer.
//! Such a mesh would not roll on its side, so cylinders are added where it touches the floor.

use nalgebra::{Isometry3, Translation3, Vector3};

use crate::{
    forms::{MIN_CIRCLE_CORNERS, PlacedPrimitive, axis_turn},
    read::surface::TriangleSurface,
};

/// Fraction of the radius by which the mesh is shrunk, so that only its cylinders touch the floor.
const SHRINKAGE: f64 = 0.005;

/// Minimum height of an outline edge on which the body can lie, as a fraction of the total height.
const MIN_EDGE_HEIGHT: f64 = 0.12;

/// Height of the cylinder at each end of such an edge, as a fraction of the total height.
const RIM_HEIGHT: f64 = 0.02;

/// Points at the same height, all at the same distance from the axis.
#[derive(Clone, Copy)]
struct PointRing {
    height: f64,
    radius: f64,
}

/// Returns the cylinders and the shrunk mesh, or `None` if the mesh is not round about an axis of its frame.
pub fn detect_revolution(surface: &TriangleSurface) -> Option<(Vec<PlacedPrimitive>, TriangleSurface)> {
    let (low, high) = surface.bounds()?;
    let middle = Vector3::from_fn(|i, _| (low[i] + high[i]) / 2.0);
    (0..3).find_map(|axis| {
        let rings = rings(surface, &middle, axis)?;
        let lies = supporting_edges(&rings);
        let widest = lies.iter().fold(0.0, |w: f64, (a, b)| w.max(a.radius).max(b.radius));
        if lies.is_empty() || widest <= 0.0 {
            return None;
        }
        let place = |height: f64| {
            let mut at = middle;
            at[axis] = height;
            Isometry3::from_parts(Translation3::from(at), axis_turn(axis))
        };
        let height = rings.last()?.height - rings.first()?.height;
        let cylinder = |low: f64, high: f64, radius: f64| {
            ("cylinder", [2.0 * radius, 2.0 * radius, high - low], place((low + high) / 2.0))
        };
        let mut forms = Vec::new();
        for (a, b) in &lies {
            if (a.radius - b.radius).abs() <= SHRINKAGE * widest {
                forms.push(cylinder(a.height, b.height, a.radius.max(b.radius)));
                continue;
            }
            let thin = (RIM_HEIGHT * height).min((b.height - a.height) / 2.0);
            forms.push(cylinder(a.height, a.height + thin, a.radius));
            forms.push(cylinder(b.height - thin, b.height, b.radius));
        }
        let mut behind = surface.clone();
        for p in &mut behind.points {
            for i in [(axis + 1) % 3, (axis + 2) % 3] {
                p[i] = middle[i] + (p[i] - middle[i]) * (1.0 - SHRINKAGE);
            }
        }
        Some((forms, behind))
    })
}

/// Returns the rings, ordered by height; points on the axis do not form a ring.
fn rings(surface: &TriangleSurface, middle: &Vector3<f64>, axis: usize) -> Option<Vec<PointRing>> {
    let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
    let radial = |p: &[f64; 3]| libm::hypot(p[a] - middle[a], p[b] - middle[b]);
    let widest = surface.points.iter().map(radial).fold(0.0, f64::max);
    let mut points: Vec<&[f64; 3]> = surface.points.iter().filter(|p| radial(p) > 0.01 * widest).collect();
    points.sort_by(|p, q| p[axis].total_cmp(&q[axis]));
    let mut rings = Vec::new();
    let near = 0.002 * widest;
    while let Some(first) = points.first() {
        let count = points.partition_point(|p| p[axis] <= first[axis] + near);
        let (ring, rest) = points.split_at(count);
        // Only the outermost points at each height are relevant.
        let radius = ring.iter().map(|p| radial(p)).fold(0.0, f64::max);
        let mut angles: Vec<f64> = ring
            .iter()
            .filter(|p| radius - radial(p) <= SHRINKAGE * radius)
            .map(|p| libm::atan2(p[b] - middle[b], p[a] - middle[a]))
            .collect();
        angles.sort_by(f64::total_cmp);
        let ends = angles.first()? + std::f64::consts::TAU;
        let gaps = angles.windows(2).map(|w| w[1] - w[0]).chain([ends - angles.last()?]);
        if gaps.fold(0.0, f64::max) > std::f64::consts::TAU / (MIN_CIRCLE_CORNERS as f64 - 0.5) {
            return None;
        }
        rings.push(PointRing { height: first[axis], radius });
        points = rest.to_vec();
    }
    (rings.len() >= 2).then_some(rings)
}

/// Returns the edges of the outline on which the body can lie, as pairs of lower and upper ring.
fn supporting_edges(rings: &[PointRing]) -> Vec<(PointRing, PointRing)> {
    let mut outline: Vec<PointRing> = Vec::new();
    for &ring in rings {
        while let [.., p, q] = outline[..] {
            let turn =
                (q.height - p.height) * (ring.radius - p.radius) - (ring.height - p.height) * (q.radius - p.radius);
            if turn < 0.0 {
                break;
            }
            outline.pop();
        }
        outline.push(ring);
    }
    let (Some(first), Some(last)) = (rings.first(), rings.last()) else { return Vec::new() };
    let long = MIN_EDGE_HEIGHT * (last.height - first.height);
    outline.windows(2).filter(|w| w[1].height - w[0].height > long).map(|w| (w[0], w[1])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lathe(outline: &[(f64, f64)], sides: usize) -> TriangleSurface {
        let mut points = vec![[0.0, 0.0, outline[0].0]];
        for (height, radius) in outline {
            for i in 0..sides {
                let t = std::f64::consts::TAU * i as f64 / sides as f64;
                points.push([radius * libm::cos(t), radius * libm::sin(t), *height]);
            }
        }
        TriangleSurface { points, triangles: vec![[0, 1, 2]] }
    }

    #[test]
    fn bottle_is_supported_by_its_widest_cylinder() {
        let (forms, behind) =
            detect_revolution(&lathe(&[(-0.1, 0.035), (0.03, 0.035), (0.07, 0.012), (0.1, 0.012)], 24)).unwrap();
        let (form, size, place) = &forms[0];
        assert_eq!(*form, "cylinder");
        assert!((size[0] - 0.07).abs() < 1e-9 && (size[2] - 0.13).abs() < 1e-9);
        assert!((place.translation.vector.z + 0.035).abs() < 1e-9);
        // Between shoulder and mouth, the body touches the floor at two circles.
        assert_eq!(forms.len(), 3);
        assert!((behind.points[1][0] - 0.035 * (1.0 - SHRINKAGE)).abs() < 1e-9);
    }

    #[test]
    fn cup_is_supported_by_its_rims() {
        let (forms, _) = detect_revolution(&lathe(&[(0.0, 0.03), (0.1, 0.04)], 16)).unwrap();
        assert_eq!(forms.len(), 2);
        assert!((forms[0].1[0] - 0.06).abs() < 1e-9 && (forms[1].1[0] - 0.08).abs() < 1e-9);
    }

    #[test]
    fn mesh_with_corners_is_not_a_revolution() {
        assert!(detect_revolution(&lathe(&[(0.0, 0.03), (0.1, 0.04)], 8)).is_none());
        let mut bent = lathe(&[(0.0, 0.03), (0.1, 0.04)], 16);
        bent.points.retain(|p| p[0] < 0.02);
        assert!(detect_revolution(&bent).is_none());
    }
}
