//! Conversion of packet results to 64-bit results in the order of the bundle, for the requested fields only.

use nalgebra::{Point3, Vector3};
use tatu_geometry::Form;

use super::{
    BundleCast, BundleHits,
    pack::{BundlePart, LANES},
    packet::{NO_TARGET, PartHits},
};
use crate::{BeamScene, Faces, ray, sight::SightLine, solid::unit, triangle::triangle};

/// Sets all results to those of rays that hit nothing.
pub(super) fn clear_hits(hits: BundleHits<'_>) {
    hits.distance.fill(f64::INFINITY);
    hits.object.fill(0);
    hits.primitive.fill(0);
    hits.point.fill([0.0; 3]);
    hits.normal.fill([0.0; 3]);
}

/// Writes the results of a part.
pub(super) fn write_hits(
    scene: &BeamScene,
    cast: &BundleCast<'_>,
    part: &BundlePart,
    seen: &PartHits,
    hits: BundleHits<'_>,
) {
    let directions = &cast.bundle.directions()[part.first..part.first + part.rays()];
    let (near, far) = (cast.near.max(0.0), cast.far);
    for (slot, &ray) in part.order[..part.rays()].iter().enumerate() {
        let ray = ray as usize;
        let (best, lane) = (&seen.best[slot / LANES], slot % LANES);
        let (index, primitive) = (best.target[lane], best.primitive[lane]);
        if index == NO_TARGET {
            put(hits.distance, ray, f64::INFINITY);
            put(hits.object, ray, 0);
            put(hits.primitive, ray, 0);
            put(hits.point, ray, [0.0; 3]);
            put(hits.normal, ray, [0.0; 3]);
            continue;
        }
        let direction = &directions[ray];
        let mut distance = f64::from(best.t.0[lane]);
        if best.margin.0[lane] < 0.0 {
            distance = recompute_distance(scene, cast, index as usize, primitive, direction, distance);
        }
        // Rounding to 32 bits may have moved the distance beyond a limit.
        distance = distance.min(far).max(near);
        put(hits.distance, ray, distance);
        put(hits.object, ray, scene.targets[index as usize].object);
        put(hits.primitive, ray, primitive);
        if !hits.point.is_empty() {
            hits.point[ray] = (direction * distance).into();
        }
        if !hits.normal.is_empty() {
            hits.normal[ray] = normal(scene, cast, index as usize, primitive, direction, distance).into();
        }
    }
}

fn put<T>(all: &mut [T], at: usize, value: T) {
    if let Some(place) = all.get_mut(at) {
        *place = value;
    }
}

/// Recomputes in 64 bits the distance of a surface that is known to be hit.
///
/// If in 64 bits the ray misses the target, or the distance differs by more than a tolerance, the ray passes close to
/// an edge, and the 32-bit result is used.
#[cold]
fn recompute_distance(
    scene: &BeamScene,
    cast: &BundleCast<'_>,
    index: usize,
    primitive: u32,
    direction: &Vector3<f64>,
    rough: f64,
) -> f64 {
    let target = &scene.targets[index];
    let pose = &cast.world_from_sensor;
    let sight = SightLine {
        origin: pose.translation.vector.into(),
        axis: pose.rotation * direction,
        near: 0.0,
        far: f64::INFINITY,
        cos_incidence: 0.0,
        faces: Faces::BOTH,
    };
    let mut sight = sight.in_form(&target.world_from_target, f64::INFINITY);
    let slack = 0.01 * (1.0 + rough);
    // Exclude crossings nearer than the 32-bit result, such as an inadmissible point at which the ray enters a solid.
    sight.near = (rough - slack).max(0.0);
    let exact = match &target.form {
        Form::Mesh { mesh, .. } => triangle(mesh, primitive as usize).map(|t| {
            let height = t.normal.dot(&(t.corners[0] - sight.origin.coords));
            height / t.normal.dot(&sight.axis)
        }),
        form => ray::cast(&sight, form).map(|found| found.distance),
    };
    exact.filter(|t| (t - rough).abs() <= slack).unwrap_or(rough)
}

/// Returns the surface normal on the sensor's side, in the sensor's frame.
fn normal(
    scene: &BeamScene,
    cast: &BundleCast<'_>,
    index: usize,
    primitive: u32,
    direction: &Vector3<f64>,
    distance: f64,
) -> Vector3<f64> {
    let target = &scene.targets[index];
    let pose = &target.world_from_target;
    let sensor_from_target = cast.world_from_sensor.rotation.inverse() * pose.rotation;
    let point = || {
        let world = cast.world_from_sensor * Point3::from(direction * distance);
        pose.inverse_transform_point(&world).coords
    };
    let end = |sign: f64| Vector3::new(0.0, 0.0, sign);
    let own = match &target.form {
        Form::Plane => Vector3::z(),
        Form::Box { .. } => {
            let mut normal = Vector3::zeros();
            normal[primitive as usize / 2 % 3] = if primitive % 2 == 1 { 1.0 } else { -1.0 };
            normal
        }
        Form::Sphere { .. } => unit(&point()),
        Form::Cylinder { .. } | Form::Capsule { .. } if primitive == 0 => {
            let point = point();
            unit(&Vector3::new(point.x, point.y, 0.0))
        }
        Form::Cylinder { .. } => end(if primitive == 1 { 1.0 } else { -1.0 }),
        Form::Capsule { half_length, .. } => {
            unit(&(point() - end(if primitive == 1 { *half_length } else { -half_length })))
        }
        Form::Mesh { mesh, .. } => triangle(mesh, primitive as usize).map_or(Vector3::zeros(), |t| t.normal),
    };
    let own = sensor_from_target * own;
    if own.dot(direction) > 0.0 { -own } else { own }
}
