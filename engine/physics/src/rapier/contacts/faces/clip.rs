//! Contact points of two convex forms, at least one of which is a hull.

use rapier3d::{
    geometry::{ContactManifold, Shape},
    math::{Pose, Vector},
    parry::{
        query::{
            TrackedContact, Unsupported,
            details::{NormalConstraints, NormalConstraintsPair, contact_support_map_support_map_with_params},
            gjk::{GJKResult, VoronoiSimplex},
        },
        shape::{PackedFeatureId, PolygonalFeature},
    },
};

use super::{face::FeaturePolygon, merge};

/// Depth by which the pair of closest points must exceed all other points to be added as a contact point, m.
const MIN_DEPTH_LEAD: f64 = 1e-4;

/// Distance of the closest points, m, below which rounding errors dominate the direction between them.
const MIN_RELIABLE_DISTANCE: f64 = 1e-8;

/// Maximum depth at which touching forms are treated as separated by a plane, m.
const MAX_TOUCH_DEPTH: f64 = 1e-6;

/// Maximum depth of a point, relative to that of the deepest, if the normal was corrected for a mesh: the corrected
/// normal may be far from the direction in which the forms are closest.
const MAX_CORRECTED_DEPTH_RATIO: f64 = 5.0;

/// A form, with constraints on its contact normals, which prevent contacts with the triangle of a mesh from the side.
type LimitedShape<'a> = (&'a dyn Shape, Option<&'a dyn NormalConstraints>);

/// A polygon seen along the normal: its corners in a plane and along the normal.
struct PolygonView<'a> {
    polygon: &'a FeaturePolygon,
    corners: Vec<Vector>,
    flat: Vec<[f64; 2]>,
}

/// Finds the contact points of two convex forms; `manifold.local_n1` is used as a guess of the normal.
pub(super) fn contacts(
    pos12: &Pose,
    (a, limits_a): LimitedShape<'_>,
    (b, limits_b): LimitedShape<'_>,
    prediction: f64,
    manifold: &mut ContactManifold,
) -> Result<(), Unsupported> {
    let (Some((map_a, round_a)), Some((map_b, round_b))) = (a.as_polygonal_feature_map(), b.as_polygonal_feature_map())
    else {
        return Err(Unsupported);
    };
    let guess = manifold.local_n1.try_normalize();
    let reach = prediction + round_a + round_b;
    let simplex = &mut VoronoiSimplex::new();
    let closest = contact_support_map_support_map_with_params(pos12, map_a, map_b, reach, simplex, guess);
    manifold.points.clear();
    let (p1, p2, direction) = match closest {
        GJKResult::ClosestPoints(p1, p2, direction) => (p1, p2, direction),
        GJKResult::NoIntersection(direction) => {
            manifold.local_n1 = direction;
            return Ok(());
        }
        _ => {
            manifold.local_n1 = Vector::ZERO;
            return Ok(());
        }
    };
    // For forms that touch exactly, the direction between the closest points is undefined, or dominated by rounding
    // errors. The normal of the previous step is then preferred, if it still separates the forms. If no direction is
    // defined, that between the origins is used.
    let separates = |normal: &Vector| {
        let second = pos12 * map_b.local_support_point(pos12.rotation.inverse() * -*normal);
        (second - map_a.local_support_point(*normal)).dot(*normal) > -MAX_TOUCH_DEPTH
    };
    let (found, last) = (Some(direction), guess.filter(separates));
    let touch = (p2 - p1).length() < MIN_RELIABLE_DISTANCE;
    let [first, second] = if touch { [last, found] } else { [found, last] };
    let direction = [first, second, pos12.translation.try_normalize()]
        .into_iter()
        .flatten()
        .find(|d| d.length_squared() > 0.5)
        .unwrap_or(Vector::Z);
    let (mut n1, mut n2) = (direction, pos12.rotation.inverse() * -direction);
    let closest = (p2 - p1).dot(n1);
    if !(limits_a, limits_b).project_local_normals(pos12, &mut n1, &mut n2) {
        return Ok(());
    }
    let (near_a, near_b) = (p1, pos12.inverse_transform_point(p2));
    let polygon_of = |shape: &dyn Shape, map: &dyn rapier3d::parry::shape::PolygonalFeatureMap, normal, near| {
        shape.as_convex_polyhedron().map(|hull| FeaturePolygon::of_hull(hull, normal)).unwrap_or_else(|| {
            let mut feature = PolygonalFeature::default();
            map.local_support_feature_toward(normal, near, &mut feature);
            FeaturePolygon::new(&feature)
        })
    };
    let polygons = [polygon_of(a, map_a, n1, near_a), polygon_of(b, map_b, n2, near_b)];
    let (x, y) = n1.any_orthonormal_pair();
    let view = |polygon, pose: Option<&Pose>| {
        let polygon: &FeaturePolygon = polygon;
        let corners: Vec<Vector> = polygon.corners.iter().map(|(p, ..)| pose.map_or(*p, |pose| pose * *p)).collect();
        let flat = corners.iter().map(|p| [p.dot(x), p.dot(y)]).collect();
        PolygonView { polygon, corners, flat }
    };
    let views = [view(&polygons[0], None), view(&polygons[1], Some(pos12))];
    clip(&views, pos12, n1, manifold);
    let deepest = manifold.points.iter().map(|p| p.dist).fold(f64::INFINITY, f64::min);
    if n1 == direction && closest < deepest - MIN_DEPTH_LEAD {
        let unknown = PackedFeatureId::UNKNOWN;
        manifold.points.push(TrackedContact::new(near_a, near_b, unknown, unknown, closest));
    }
    if limits_a.is_some() || limits_b.is_some() {
        manifold.points.retain(|p| closest >= 0.0 || p.dist >= closest * MAX_CORRECTED_DEPTH_RATIO);
    }
    merge::reduce(&mut manifold.points, n1);
    for point in &mut manifold.points {
        point.local_p1 += n1 * round_a;
        point.local_p2 += n2 * round_b;
        point.dist -= round_a + round_b;
    }
    (manifold.local_n1, manifold.local_n2) = (n1, n2);
    Ok(())
}

/// Adds the corners of each polygon that lie within the other, and the crossings of their edges.
fn clip(views: &[PolygonView<'_>; 2], pos12: &Pose, normal: Vector, manifold: &mut ContactManifold) {
    let [a, b] = views;
    let mut add = |first: Vector, second: Vector, ids: [PackedFeatureId; 2]| {
        let distance = (second - first).dot(normal);
        let second = pos12.inverse_transform_point(second);
        manifold.points.push(TrackedContact::new(first, second, ids[0], ids[1], distance));
    };
    for (i, corner) in a.corners.iter().enumerate().filter(|(i, _)| b.covers(a.flat[*i])) {
        if let Some(distance) = b.height(*corner, normal) {
            add(*corner, *corner + normal * distance, [a.polygon.corners[i].1, b.polygon.face]);
        }
    }
    for (i, corner) in b.corners.iter().enumerate().filter(|(i, _)| a.covers(b.flat[*i])) {
        if let Some(distance) = a.height(*corner, normal) {
            add(*corner + normal * distance, *corner, [a.polygon.face, b.polygon.corners[i].1]);
        }
    }
    for (i, next_i) in a.edges() {
        for (k, next_k) in b.edges() {
            let Some([s, t]) = crossing([a.flat[i], a.flat[next_i]], [b.flat[k], b.flat[next_k]]) else { continue };
            let first = a.corners[i] + (a.corners[next_i] - a.corners[i]) * s;
            let second = b.corners[k] + (b.corners[next_k] - b.corners[k]) * t;
            add(first, second, [a.polygon.corners[i].2, b.polygon.corners[k].2]);
        }
    }
}

impl PolygonView<'_> {
    /// Returns the indices of the ends of each edge.
    fn edges(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let count = self.corners.len();
        let edges = if count > 2 { count } else { count.saturating_sub(1) };
        (0..edges).map(move |i| (i, (i + 1) % count))
    }

    /// Returns whether a point in the plane lies within the polygon or on its boundary.
    fn covers(&self, p: [f64; 2]) -> bool {
        if self.flat.len() < 3 {
            return false;
        }
        let (mut left, mut right) = (false, false);
        for (i, next) in self.edges() {
            let (a, b) = (self.flat[i], self.flat[next]);
            let side = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
            left |= side > 0.0;
            right |= side < 0.0;
        }
        !(left && right)
    }

    /// Returns the distance of a point from the plane of the polygon along the normal, m, or `None` if the plane is
    /// parallel to the normal.
    fn height(&self, point: Vector, normal: Vector) -> Option<f64> {
        let origin = *self.corners.first()?;
        let spokes = self.corners.windows(2).skip(1).map(|w| (w[0] - origin).cross(w[1] - origin));
        let across: Vector = spokes.fold(Vector::ZERO, |sum, cross| sum + cross);
        let slope = across.dot(normal);
        (slope.abs() > 1e-9 * across.length()).then(|| (origin - point).dot(across) / slope)
    }
}

/// Returns where two edges cross, as fractions of their lengths strictly between 0 and 1, or `None`.
fn crossing(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> Option<[f64; 2]> {
    let sub = |p: [f64; 2], q: [f64; 2]| [p[0] - q[0], p[1] - q[1]];
    let cross = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
    let (u, v, w) = (sub(a[1], a[0]), sub(b[1], b[0]), sub(b[0], a[0]));
    let area = cross(u, v);
    let sizes = (u[0] * u[0] + u[1] * u[1]) * (v[0] * v[0] + v[1] * v[1]);
    if area * area <= 1e-12 * sizes {
        return None;
    }
    let (s, t) = (cross(w, v) / area, cross(w, u) / area);
    (s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0).then_some([s, t])
}
