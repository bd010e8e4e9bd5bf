//! Faces of hulls.

use arrayvec::ArrayVec;
use rapier3d::{
    geometry::ContactManifold,
    math::{Pose, Vector},
    parry::{
        query::TrackedContact,
        shape::{ConvexPolyhedron, PackedFeatureId, PolygonalFeature},
    },
};

use super::spread::{MAX_POINTS, select_spread};

/// Maximum distance of a corner from the plane of its face, relative to the size of the hull. Corners of meshes are
/// often rounded to 32 bits.
const FACE_TOLERANCE: f64 = 1e-4;

/// Cosine of the maximum angle between two faces that are equally suitable, 1.1 degrees. The larger one is chosen,
/// because the normal of a sliver may be wrong.
const SIMILAR_FACE_COSINE: f64 = 0.9998;

/// Depth by which the lowest point of a hull must exceed the corners of its face to become a contact point, m.
const MIN_DEPTH_LEAD: f64 = 1e-5;

/// A face, edge or corner of a convex form, in the form's frame.
pub(super) struct FeaturePolygon {
    /// Corners in order, each with its feature and that of the edge to the next corner.
    pub corners: ArrayVec<(Vector, PackedFeatureId, PackedFeatureId), MAX_POINTS>,
    pub face: PackedFeatureId,
}

impl FeaturePolygon {
    /// Converts parry's feature, which has at most four corners.
    pub fn new(feature: &PolygonalFeature) -> Self {
        let corner = |i: usize| (feature.vertices[i], feature.vids[i], feature.eids[i]);
        FeaturePolygon { corners: (0..feature.num_vertices.min(4)).map(corner).collect(), face: feature.fid }
    }

    /// Returns the face of a hull whose normal is closest to a direction, without corners that enclose little of it.
    /// Neighbouring faces in the same plane are treated as one.
    pub fn of_hull(hull: &ConvexPolyhedron, direction: Vector) -> Self {
        let faces = hull.faces();
        let best = faces.iter().map(|f| f.normal.dot(direction)).fold(f64::NEG_INFINITY, f64::max);
        let similar =
            faces.iter().enumerate().filter(|(_, f)| f.normal.dot(direction) >= best - (1.0 - SIMILAR_FACE_COSINE));
        let largest = similar.map(|(i, _)| (i, area(hull, i))).reduce(|a, b| if b.1 > a.1 { b } else { a });
        let id = largest.map_or(0, |(i, _)| i);
        let Some(face) = faces.get(id) else {
            return FeaturePolygon { corners: ArrayVec::new(), face: PackedFeatureId(0) };
        };
        let points = hull.points();
        let origin = corners(hull, id).next().unwrap_or_default();
        let size = points.iter().map(|p| (*p - origin).length_squared()).fold(0.0, f64::max).sqrt();
        let (x, y) = face.normal.any_orthonormal_pair();
        let in_plane = |p: &Vector| (*p - origin).dot(face.normal) >= -FACE_TOLERANCE * size;
        let ids: Vec<u32> = (0..).zip(points).filter(|(_, p)| in_plane(p)).map(|(i, _)| i).collect();
        let at = |id: &u32| points[*id as usize] - origin;
        let places: Vec<[f64; 2]> = ids.iter().map(|id| [at(id).dot(x), at(id).dot(y)]).collect();
        let selected = select_spread(&places, |_| 0.0);
        let corner = |i: &usize| {
            let id = ids[*i];
            (points[id as usize], PackedFeatureId::vertex(id), PackedFeatureId::edge(id))
        };
        FeaturePolygon { corners: selected.iter().map(corner).collect(), face: PackedFeatureId::face(id as u32) }
    }
}

/// Returns the corners of a face in order.
fn corners(hull: &ConvexPolyhedron, face: usize) -> impl Iterator<Item = Vector> {
    let range = hull.faces().get(face).map(|f| {
        let first = f.first_vertex_or_edge as usize;
        first..first + f.num_vertices_or_edges as usize
    });
    let ids = range.and_then(|range| hull.vertices_adj_to_face().get(range)).unwrap_or_default();
    ids.iter().map(|id| hull.points()[*id as usize])
}

/// Returns twice the area of a face, m².
fn area(hull: &ConvexPolyhedron, face: usize) -> f64 {
    let mut corners = corners(hull, face);
    let (Some(first), Some(mut last)) = (corners.next(), corners.next()) else { return 0.0 };
    let mut sum = Vector::ZERO;
    for corner in corners {
        sum += (last - first).cross(corner - first);
        last = corner;
    }
    sum.length()
}

/// Finds the contact points of a plane through the origin with a hull at `pose`. `flipped` states that the hull is the
/// first shape of the pair.
pub(super) fn on_plane(
    pose: &Pose,
    plane: Vector,
    hull: &ConvexPolyhedron,
    prediction: f64,
    flipped: bool,
    manifold: &mut ContactManifold,
) {
    let up = pose.rotation.inverse() * plane;
    manifold.points.clear();
    (manifold.local_n1, manifold.local_n2) = if flipped { (-up, plane) } else { (plane, -up) };
    let height = pose.translation.dot(plane);
    let heights = hull.points().iter().map(|p| p.dot(up));
    let Some((lowest, low)) = (0..).zip(heights).reduce(|a: (u32, f64), b| if b.1 < a.1 { b } else { a }) else {
        return;
    };
    if low + height > prediction {
        return;
    }
    let mut polygon = FeaturePolygon::of_hull(hull, -up);
    let corners = polygon.corners.iter().map(|(p, ..)| p.dot(up));
    if corners.fold(f64::INFINITY, f64::min) > low + MIN_DEPTH_LEAD {
        // The lowest point replaces the highest corner if there are too many.
        if polygon.corners.is_full() {
            let heights = polygon.corners.iter().map(|(p, ..)| p.dot(up)).enumerate();
            let highest = heights.reduce(|a, b| if b.1 > a.1 { b } else { a });
            if let Some((i, _)) = highest {
                polygon.corners.remove(i);
            }
        }
        let id = PackedFeatureId::vertex(lowest);
        polygon.corners.push((hull.points()[lowest as usize], id, PackedFeatureId::edge(lowest)));
    }
    for (corner, id, _) in polygon.corners {
        let place = pose * corner;
        let distance = place.dot(plane);
        if distance <= prediction {
            let foot = place - plane * distance;
            let on_plane = PackedFeatureId::face(0);
            manifold.points.push(TrackedContact::flipped(foot, corner, on_plane, id, distance, flipped));
        }
    }
}
