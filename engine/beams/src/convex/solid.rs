//! Intersection of a convex volume with each form other than meshes.

use nalgebra::Vector3;
use tatu_geometry::Form;

use super::{
    ConvexVolume,
    ball::sphere,
    flat::{DiscRim, nearest_on_face},
    strip::SideInVolume,
};
use crate::{
    planar::any_perpendicular,
    sight::FormHit,
    solid::{face, unit},
};

/// Returns the nearest admissible point of a form other than a mesh; the volume is given in the frame of the form.
pub(crate) fn cast(space: &ConvexVolume, form: &Form) -> Option<FormHit> {
    let origin = space.sight.origin.coords;
    match form {
        Form::Plane => {
            let normal = Vector3::z();
            // The half size of a square that contains all points of the plane that may be in the volume.
            let size = 2.0 * space.size.min(1e6) + 1.0;
            let foot = normal * -origin.z;
            let (u, v) = (Vector3::x() * size, Vector3::y() * size);
            let (distance, point) =
                nearest_on_face(space, &[foot - u - v, foot + u - v, foot + u + v, foot - u + v], &normal, None)?;
            Some(FormHit { distance, point, normal, primitive: 0 })
        }
        Form::Box { half } => {
            if space.misses_ball(&-origin, half.norm()) {
                return None;
            }
            let faces = (0..6).map(|index| {
                let (corners, normal) = face(half, index);
                let corners = corners.map(|corner| corner - origin);
                let (distance, point) = nearest_on_face(space, &corners, &normal, None)?;
                Some(FormHit { distance, point, normal, primitive: index as u32 })
            });
            faces.fold(None, FormHit::nearer)
        }
        Form::Sphere { radius } => {
            let (distance, point) = sphere(space, &-origin, *radius, None)?;
            Some(FormHit { distance, point, normal: unit(&(point + origin)), primitive: 0 })
        }
        Form::Cylinder { radius, half_length } => {
            if space.misses_ball(&-origin, crate::length(*radius, *half_length)) {
                return None;
            }
            let ends = [(1, 1.0), (2, -1.0)].map(|(primitive, sign)| {
                let normal = Vector3::new(0.0, 0.0, sign);
                let (distance, point) = disc(space, &(normal * *half_length - origin), &normal, *radius)?;
                Some(FormHit { distance, point, normal, primitive })
            });
            FormHit::nearer(side(space, *radius, *half_length), FormHit::nearer(ends[0], ends[1]))
        }
        Form::Capsule { radius, half_length } => {
            if space.misses_ball(&-origin, radius + half_length) {
                return None;
            }
            let ends = [(1, 1.0), (2, -1.0)].map(|(primitive, sign)| {
                let up = Vector3::new(0.0, 0.0, sign);
                let centre = up * *half_length - origin;
                let (distance, point) = sphere(space, &centre, *radius, Some(&up))?;
                Some(FormHit { distance, point, normal: unit(&(point - centre)), primitive })
            });
            FormHit::nearer(side(space, *radius, *half_length), FormHit::nearer(ends[0], ends[1]))
        }
        Form::Mesh { .. } => None,
    }
}

/// Returns the nearest admissible point of a disc.
fn disc(
    space: &ConvexVolume,
    centre: &Vector3<f64>,
    normal: &Vector3<f64>,
    radius: f64,
) -> Option<(f64, Vector3<f64>)> {
    if radius.is_nan() || radius < 0.0 {
        return None;
    }
    let u = any_perpendicular(normal);
    let (u, v) = (u * radius, normal.cross(&u) * radius);
    let corners = [centre - u - v, centre + u - v, centre + u + v, centre - u + v];
    nearest_on_face(space, &corners, normal, Some(DiscRim { centre: *centre, radius }))
}

fn side(space: &ConvexVolume, radius: f64, half_length: f64) -> Option<FormHit> {
    let (distance, point, normal) = SideInVolume { space, radius, half_length }.nearest()?;
    Some(FormHit { distance, point, normal, primitive: 0 })
}
