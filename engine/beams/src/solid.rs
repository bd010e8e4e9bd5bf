//! Intersection of cones with each analytic form, with a shortcut if no limit excludes the nearest point of the form.

use nalgebra::Vector3;
use tatu_geometry::Form;

use super::{
    cylinder::{CylinderSide, CylinderSidePoint, TangentProof},
    disc::disc,
    planar::{plane, polygon},
    sight::{BeamCone, FormHit},
    sphere::sphere,
};

/// Returns the nearest admissible point of a form other than a mesh; the cone is in the form's frame.
pub(super) fn cast(cone: &BeamCone, form: &Form) -> Option<FormHit> {
    match form {
        Form::Plane => {
            let normal = Vector3::z();
            let (distance, point) = plane(cone, -cone.sight.origin.z, &normal)?;
            Some(FormHit { distance, point, normal, primitive: 0 })
        }
        Form::Box { half } => cuboid(cone, half),
        Form::Sphere { radius } => {
            let centre = -cone.sight.origin.coords;
            let (distance, point) = sphere(cone, &centre, *radius, None)?;
            Some(FormHit { distance, point, normal: unit(&(point - centre)), primitive: 0 })
        }
        Form::Cylinder { radius, half_length } => cylinder(cone, *radius, *half_length),
        Form::Capsule { radius, half_length } => capsule(cone, *radius, *half_length),
        Form::Mesh { .. } => None,
    }
}

/// Returns the corners of a box's face, counter-clockwise as seen from outside, and its normal. Faces are -x +x -y +y
/// -z +z.
pub(super) fn face(half: &Vector3<f64>, index: usize) -> ([Vector3<f64>; 4], Vector3<f64>) {
    let axis = index / 2;
    let sign = if index % 2 == 1 { 1.0 } else { -1.0 };
    let (mut normal, mut u, mut v) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
    normal[axis] = sign;
    u[(axis + 1) % 3] = half[(axis + 1) % 3];
    v[(axis + 2) % 3] = half[(axis + 2) % 3] * sign;
    let centre = normal * half[axis];
    ([centre - u - v, centre + u - v, centre + u + v, centre - u + v], normal)
}

fn cuboid(cone: &BeamCone, half: &Vector3<f64>) -> Option<FormHit> {
    let sight = &cone.sight;
    let origin = sight.origin.coords;
    let closest = origin.zip_map(half, |x, h| x.clamp(-h.max(0.0), h.max(0.0))) - origin;
    let least = closest.norm();
    if least > sight.far {
        return None;
    }
    // From outside, the nearest point overall is on a front face.
    if least > 0.0 && sight.faces.front && least >= sight.near && cone.contains(&closest) {
        let seen = |i: &usize| closest[*i] != 0.0 && closest[*i].abs() >= sight.cos_incidence * least;
        if let Some(axis) = (0..3).find(seen) {
            let side = if origin[axis] > 0.0 { 1.0 } else { -1.0 };
            let mut normal = Vector3::zeros();
            normal[axis] = side;
            let primitive = 2 * axis as u32 + u32::from(side > 0.0);
            return Some(FormHit { distance: least, point: closest, normal, primitive });
        }
    }
    let skip_back = back_faces_hidden(cone, least);
    let mut best = None;
    for index in 0..6 {
        let (corners, normal) = face(half, index);
        let corners = corners.map(|corner| corner - origin);
        if skip_back && normal.dot(&corners[0]) > 0.0 {
            continue;
        }
        if let Some((distance, point)) = polygon(cone, &corners, &normal) {
            best = FormHit::nearer(best, Some(FormHit { distance, point, normal, primitive: index as u32 }));
        }
    }
    best
}

fn cylinder(cone: &BeamCone, radius: f64, half_length: f64) -> Option<FormHit> {
    let sight = &cone.sight;
    let origin = sight.origin.coords;
    let away = crate::length(origin.x, origin.y);
    let (beside, above) = (away - radius, origin.z.abs() - half_length);
    let least = crate::length(beside.max(0.0), above.max(0.0));
    if least > sight.far {
        return None;
    }
    let end = if origin.z > 0.0 { 1 } else { 2 };

    // From outside, the nearest point overall is on the side, on an end or on the rim between them.
    if least > 0.0 && sight.faces.front && least >= sight.near {
        let inward = Vector3::new(-origin.x, -origin.y, 0.0) * (beside.max(0.0) / away.max(f64::MIN_POSITIVE));
        let point = inward - Vector3::new(0.0, 0.0, above.max(0.0).copysign(origin.z));
        if cone.contains(&point) {
            let enough = sight.cos_incidence * least;
            if beside > 0.0 && beside >= enough {
                return Some(FormHit { distance: least, point, normal: unit(&-inward), primitive: 0 });
            }
            if above > 0.0 && above >= enough {
                let normal = Vector3::new(0.0, 0.0, 1.0_f64.copysign(origin.z));
                return Some(FormHit { distance: least, point, normal, primitive: end });
            }
        }
    }

    let mut best = None;
    for (primitive, sign) in [(1, 1.0), (2, -1.0)] {
        let normal = Vector3::new(0.0, 0.0, sign);
        if let Some((distance, point)) = disc(cone, &(normal * half_length - origin), &normal, radius) {
            best = FormHit::nearer(best, Some(FormHit { distance, point, normal, primitive }));
        }
    }
    with_side(cone, radius, half_length, least, best)
}

fn capsule(cone: &BeamCone, radius: f64, half_length: f64) -> Option<FormHit> {
    let sight = &cone.sight;
    let origin = sight.origin.coords;
    let core = Vector3::new(0.0, 0.0, origin.z.clamp(-half_length.max(0.0), half_length.max(0.0))) - origin;
    let least = core.norm() - radius;
    if least > sight.far {
        return None;
    }
    // From outside, the surface is perpendicular to the line of sight at the nearest point overall.
    if least > 0.0 && sight.faces.front && least >= sight.near && cone.contains(&core) {
        let toward = unit(&core);
        let primitive = match origin.z {
            z if z > half_length => 1,
            z if z < -half_length => 2,
            _ => 0,
        };
        return Some(FormHit { distance: least, point: toward * least, normal: -toward, primitive });
    }

    let mut best = None;
    for (primitive, sign) in [(1, 1.0), (2, -1.0)] {
        let up = Vector3::new(0.0, 0.0, sign);
        let centre = up * half_length - origin;
        if let Some((distance, point)) = sphere(cone, &centre, radius, Some(&up)) {
            let normal = unit(&(point - centre));
            best = FormHit::nearer(best, Some(FormHit { distance, point, normal, primitive }));
        }
    }
    with_side(cone, radius, half_length, least, best)
}

/// Returns the nearer of `ends`, the nearest admissible point on the ends of a cylinder or capsule, and the nearest
/// admissible point on its side. `least` is the distance of the solid from the apex.
fn with_side(cone: &BeamCone, radius: f64, half_length: f64, least: f64, ends: Option<FormHit>) -> Option<FormHit> {
    let on_side = |(distance, point, normal): CylinderSidePoint| FormHit { distance, point, normal, primitive: 0 };
    let covered = back_faces_hidden(cone, least);
    let side = CylinderSide::new(cone, radius, half_length, covered);
    if covered && !cone.is_wide() {
        // The solid is behind its tangent plane at the point found. If that point is the nearest point of the plane, it
        // is also the nearest point of the solid.
        if let Some(found) = &ends {
            let h = found.normal.dot(&found.point);
            let bound = plane(cone, h, &found.normal);
            if h < 0.0 && bound.is_some_and(|(distance, _)| distance >= found.distance) {
                return ends;
            }
        }
        match side.prove_nearest() {
            TangentProof::Nothing => return None,
            TangentProof::Nearest(nearest) if nearest.0 <= cone.sight.far => {
                return FormHit::nearer(Some(on_side(nearest)), ends);
            }
            TangentProof::Nearest(_) => return ends,
            TangentProof::Unproven => {}
        }
    }
    FormHit::nearer(side.nearest().map(on_side), ends)
}

/// Returns whether each surface point that faces away from the apex is hidden by a nearer admissible point on the same
/// line of sight.
///
/// This holds for a solid at distance `least` > 0, unless a limit may exclude the nearer point.
fn back_faces_hidden(cone: &BeamCone, least: f64) -> bool {
    let sight = &cone.sight;
    least > 0.0 && sight.faces.front && sight.cos_incidence == 0.0 && sight.near <= least
}

/// Returns the unit vector in the direction of `v`, or zero if `v` is zero.
pub(super) fn unit(v: &Vector3<f64>) -> Vector3<f64> {
    v.try_normalize(0.0).unwrap_or_default()
}
