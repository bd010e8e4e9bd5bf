//! Contact points of a pair, reduced, joined across the triangles of meshes, and written to rapier's manifolds.

use rapier3d::{
    geometry::{ContactData, ContactManifold},
    math::Vector,
    parry::{query::TrackedContact, shape::PackedFeatureId},
};

use super::spread::{MAX_POINTS, select_spread};

/// Number of points of a manifold that rapier solves.
const SOLVED_POINTS: usize = 4;

/// Weight of the depth of a point relative to its position in the face. With this value, a point above another one is
/// not selected, and a slightly tilted face retains its corners.
const DEPTH_WEIGHT: f64 = 10.0;

/// Cosine of the maximum angle between faces of a mesh that are treated as one, 5 degrees.
const PARALLEL_COSINE: f64 = 0.996;

/// Maximum distance between points that are treated as one, as a fraction of the prediction distance.
const MERGE_DISTANCE_SHARE: f64 = 0.25;

/// Depth by which the deepest point must exceed the selected ones to replace one of them, m.
const MIN_DEPTH_LEAD: f64 = 1e-5;

/// Maximum distance of a point from one of the previous step for a warm start, m.
const MAX_WARM_START_DISTANCE: f64 = 1e-3;

type ManifoldPoint = TrackedContact<ContactData>;

/// Retains the points that enclose the largest area, in counterclockwise order about the normal.
pub(super) fn reduce(points: &mut Vec<ManifoldPoint>, normal: Vector) {
    if points.len() <= SOLVED_POINTS {
        return;
    }
    let (x, y) = normal.any_orthonormal_pair();
    let origin = points[0].local_p1;
    let places: Vec<[f64; 2]> = points.iter().map(|p| p.local_p1 - origin).map(|p| [p.dot(x), p.dot(y)]).collect();
    let lowest = (0..points.len()).reduce(|a, b| if points[b].dist < points[a].dist { b } else { a });
    let least = lowest.map_or(0.0, |i| points[i].dist);
    let mut selected = select_spread(&places, |i| DEPTH_WEIGHT * (points[i].dist - least));
    let deepest = selected.iter().map(|i| points[*i].dist).fold(f64::INFINITY, f64::min);
    if let Some(lowest) = lowest.filter(|_| deepest > least + MIN_DEPTH_LEAD) {
        if selected.len() == MAX_POINTS {
            selected.pop();
        }
        selected.push(lowest);
    }
    *points = selected.iter().map(|i| points[*i]).collect();
}

/// Joins manifolds with nearly equal normals, in the frames of the pair.
pub(super) fn join(found: Vec<ContactManifold>, prediction: f64) -> Vec<ContactManifold> {
    let mut joined: Vec<ContactManifold> = Vec::new();
    let same = MERGE_DISTANCE_SHARE * prediction;
    for manifold in found.into_iter().filter(|m| !m.points.is_empty()) {
        let [one, two] = [manifold.subshape_pos1().copied(), manifold.subshape_pos2().copied()];
        let n1 = one.map_or(manifold.local_n1, |pose| pose.rotation * manifold.local_n1);
        let n2 = two.map_or(manifold.local_n2, |pose| pose.rotation * manifold.local_n2);
        let at = joined.iter().position(|m| m.local_n1.dot(n1) >= PARALLEL_COSINE).unwrap_or_else(|| {
            joined.push(ContactManifold::new());
            joined.len() - 1
        });
        let whole = &mut joined[at];
        if whole.points.is_empty() {
            (whole.local_n1, whole.local_n2) = (n1, n2);
        }
        for mut point in manifold.points {
            point.local_p1 = one.map_or(point.local_p1, |pose| pose * point.local_p1);
            point.local_p2 = two.map_or(point.local_p2, |pose| pose * point.local_p2);
            point.fid1 = part_feature(point.fid1, manifold.subshape1);
            point.fid2 = part_feature(point.fid2, manifold.subshape2);
            let twin = whole.points.iter_mut().find(|p| p.local_p1.distance_squared(point.local_p1) < same * same);
            match twin {
                Some(twin) if point.dist < twin.dist => *twin = point,
                Some(_) => {}
                None => whole.points.push(point),
            }
        }
    }
    for manifold in &mut joined {
        reduce(&mut manifold.points, manifold.local_n1);
    }
    joined
}

/// Returns a number for a feature of one part of a shape. The numbers of two features are almost never equal; if they
/// are, a point is warm started with the impulse of another one.
fn part_feature(feature: PackedFeatureId, part: u32) -> PackedFeatureId {
    PackedFeatureId(feature.0 ^ part.wrapping_mul(0x9e37_79b9))
}

/// Writes points to manifolds of at most four, each spread over the whole face, with the forces of the previous step.
/// Manifolds that are no longer needed remain, without points: rapier refers to them by their index.
pub(super) fn write(found: Vec<ContactManifold>, manifolds: &mut Vec<ContactManifold>) {
    let old: Vec<ManifoldPoint> = manifolds.iter_mut().flat_map(|m| std::mem::take(&mut m.points)).collect();
    let mut used = 0;
    for face in &found {
        let count = face.points.len().div_ceil(SOLVED_POINTS).max(1);
        for part in 0..count {
            if manifolds.len() == used {
                manifolds.push(ContactManifold::new());
            }
            let manifold = &mut manifolds[used];
            (manifold.local_n1, manifold.local_n2) = (face.local_n1, face.local_n2);
            manifold.points.extend(face.points.iter().skip(part).step_by(count).copied());
            for point in &mut manifold.points {
                point.data = previous_data(point, &old);
            }
            used += 1;
        }
    }
}

/// Returns the data of a point in the previous step: that of the point with the same features or, if there is none, of
/// the point at the same position.
fn previous_data(point: &ManifoldPoint, old: &[ManifoldPoint]) -> ContactData {
    let same = |p: &&ManifoldPoint| p.fid1 == point.fid1 && p.fid2 == point.fid2;
    let known = point.fid1 != PackedFeatureId::UNKNOWN && point.fid2 != PackedFeatureId::UNKNOWN;
    let place = |p: &&ManifoldPoint| {
        p.local_p1.distance_squared(point.local_p1) < MAX_WARM_START_DISTANCE * MAX_WARM_START_DISTANCE
            && p.local_p2.distance_squared(point.local_p2) < MAX_WARM_START_DISTANCE * MAX_WARM_START_DISTANCE
    };
    let found = old.iter().find(|p| known && same(p)).or_else(|| old.iter().find(place));
    found.map_or_else(ContactData::default, |p| p.data)
}
