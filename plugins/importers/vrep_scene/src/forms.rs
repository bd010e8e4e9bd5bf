//! Detects meshes that are boxes, spheres or cylinders, so that they roll and collide like exact primitives.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::read::{
    mesh::{LeafPrimitive, MeshLeaf},
    surface::TriangleSurface,
};

/// A primitive, its full extents, and its pose in the frame of the mesh.
pub type PlacedPrimitive = (&'static str, [f64; 3], Isometry3<f64>);

/// Returns the primitive of a leaf if the file declares one and its points match it.
pub fn declared_primitive(leaf: &MeshLeaf, surface: &TriangleSurface) -> Option<PlacedPrimitive> {
    let form = match leaf.primitive {
        LeafPrimitive::Cuboid => "box",
        LeafPrimitive::Spheroid => "sphere",
        LeafPrimitive::Cylinder if leaf.inside >= 1.0 => "cylinder",
        _ => return None,
    };
    let (low, high) = surface.bounds()?;
    let size: [f64; 3] = std::array::from_fn(|i| high[i] - low[i]);
    let even = |a: f64, b: f64| (a - b).abs() <= 0.02 * a.max(b);
    let middle = (0..3).all(|i| (low[i] + high[i]).abs() <= 0.02 * size[i]);
    let sizes_match = (0..3).all(|i| leaf.size[i].is_finite() && leaf.size[i] > 0.0 && even(leaf.size[i], size[i]));
    let round = match form {
        "sphere" => even(leaf.size[0], leaf.size[1]) && even(leaf.size[1], leaf.size[2]),
        "cylinder" => even(leaf.size[0], leaf.size[1]),
        _ => true,
    };
    (middle && sizes_match && round).then_some((form, leaf.size, Isometry3::identity()))
}

/// Minimum number of corners of a polygon that is treated as a circle.
pub const MIN_CIRCLE_CORNERS: usize = 12;

/// Detects wheels and spheres that are modelled with flat faces and would therefore roll unevenly: convex meshes whose
/// points are all on two circles, or all at the same distance from the centre. Only cylinders along an axis of the
/// mesh's frame are detected.
pub fn detect_round(surface: &TriangleSurface) -> Option<PlacedPrimitive> {
    let (low, high) = surface.bounds()?;
    let middle = Vector3::from_fn(|i, _| (low[i] + high[i]) / 2.0);
    let size = Vector3::from_fn(|i, _| high[i] - low[i]);
    let points: Vec<Vector3<f64>> = surface.points.iter().map(|p| Vector3::from(*p) - middle).collect();
    let even = |a: f64, b: f64| (a - b).abs() <= 0.005 * b;
    let place = |turn| Isometry3::from_parts(Translation3::from(middle), turn);
    // The points of a thin disc or a long rod are also at nearly equal distances from the centre. Only a sphere has the
    // same width along each axis, up to the error of its flat faces.
    let radius = points.iter().map(|p| p.norm()).fold(0.0, f64::max);
    let equal_sides = size.min() >= 2.0 * radius * libm::cos(PI / MIN_CIRCLE_CORNERS as f64);
    if equal_sides && points.len() >= MIN_CIRCLE_CORNERS * 3 && points.iter().all(|p| even(p.norm(), radius)) {
        return Some(("sphere", [2.0 * radius; 3], place(UnitQuaternion::identity())));
    }
    (0..3).find_map(|axis| {
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        let (height, diameter) = (size[axis], size[a].max(size[b]));
        let radial = |p: &Vector3<f64>| libm::hypot(p[a], p[b]);
        let on_end = |p: &Vector3<f64>| even(p[axis].abs(), height / 2.0);
        let on_circle = |p: &&Vector3<f64>| even(radial(p), diameter / 2.0);
        let all = height > 0.0 && points.iter().all(|p| on_end(p) && (on_circle(&p) || radial(p) <= 0.01 * diameter));
        let count = points.iter().filter(on_circle).count();
        (all && count >= 2 * MIN_CIRCLE_CORNERS)
            .then(|| ("cylinder", [diameter, diameter, height], place(axis_turn(axis))))
    })
}

/// Returns the rotation that maps the z axis of a cylinder to axis 0, 1 or 2.
pub fn axis_turn(axis: usize) -> UnitQuaternion<f64> {
    match axis {
        0 => UnitQuaternion::from_axis_angle(&Vector3::y_axis(), FRAC_PI_2),
        1 => UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -FRAC_PI_2),
        _ => UnitQuaternion::identity(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn prism(sides: usize, height: f64, axis: usize) -> TriangleSurface {
        let mut points = Vec::new();
        for i in 0..sides * 2 {
            let t = std::f64::consts::TAU * (i / 2) as f64 / sides as f64;
            let mut p = [0.0; 3];
            p[axis] = if i % 2 == 0 { height / 2.0 } else { -height / 2.0 };
            p[(axis + 1) % 3] = 0.1 * libm::cos(t);
            p[(axis + 2) % 3] = 0.1 * libm::sin(t);
            points.push(p);
        }
        TriangleSurface { points, triangles: vec![[0, 1, 2]] }
    }

    #[test]
    fn wheels_with_many_sides_become_cylinders() {
        for axis in 0..3 {
            let (form, size, place) = detect_round(&prism(32, 0.05, axis)).unwrap();
            assert_eq!(form, "cylinder");
            assert!((size[0] - 0.2).abs() < 1e-12 && (size[2] - 0.05).abs() < 1e-12);
            let along = place * Vector3::z();
            assert!((along[axis].abs() - 1.0).abs() < 1e-12, "axis {axis}: {along}");
        }
    }

    #[test]
    fn thin_discs_and_long_rods_become_cylinders() {
        // All points are within 0.5 % of the largest radius from the centre.
        let (form, size, _) = detect_round(&prism(32, 0.01, 2)).unwrap();
        assert_eq!(form, "cylinder");
        assert!((size[0] - 0.2).abs() < 1e-12 && (size[2] - 0.01).abs() < 1e-12);
        for axis in 0..3 {
            assert_eq!(detect_round(&prism(32, 3.0, axis)).unwrap().0, "cylinder", "axis {axis}");
        }
    }

    #[test]
    fn ball_with_many_faces_becomes_a_sphere_of_equal_sizes() {
        // 18 corners around and 9 rings: the ball is narrower along y than along x.
        let mut points = vec![[0.0, 0.0, 0.3], [0.0, 0.0, -0.3]];
        for ring in 1..9 {
            let up = PI * f64::from(ring) / 9.0;
            for i in 0..18 {
                let t = PI * f64::from(i) / 9.0;
                let r = 0.3 * libm::sin(up);
                points.push([r * libm::cos(t), r * libm::sin(t), 0.3 * libm::cos(up)]);
            }
        }
        let (form, size, _) = detect_round(&TriangleSurface { points, triangles: vec![[0, 1, 2]] }).unwrap();
        assert_eq!(form, "sphere");
        assert!(size.iter().all(|x| (x - 0.6).abs() < 1e-9), "{size:?}");
    }

    #[test]
    fn prisms_with_few_sides_are_not_round() {
        assert!(detect_round(&prism(6, 0.05, 2)).is_none());
        let mut bent = prism(32, 0.05, 2);
        bent.points[0][0] *= 0.9;
        assert!(detect_round(&bent).is_none());
    }
}
