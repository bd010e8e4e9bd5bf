//! The solids of a shape: those that are rendered and detected by beams, and those that collide.

use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};
use tatu_geometry::{Form, Mesh, SolidPart};

use super::{Primitive, Shape};

/// Relative difference between the extents of a sphere up to which it is treated as a ball. It allows for rounding
/// errors in files that store sizes in single precision.
const BALL_SIZE_TOLERANCE: f64 = 1e-6;

/// Returns whether the extents of a sphere differ, so that it is an ellipsoid.
fn is_ellipsoid(primitive: Primitive, size: Vector3<f64>) -> bool {
    primitive == Primitive::Sphere && size.max() - size.min() > BALL_SIZE_TOLERANCE * size.max()
}

/// Returns the extents of the spheres of a shape that are ellipsoids.
pub(crate) fn ellipsoids(shape: &Shape) -> Vec<Vector3<f64>> {
    let parts = shape.parts.iter().filter(|_| shape.primitive == Primitive::Compound).map(|p| (p.primitive, p.size));
    let own = [Some((shape.primitive, shape.size)), shape.collide_as.map(|p| (p, collide_size(shape)))];
    let mut found: Vec<Vector3<f64>> = Vec::new();
    for (_, size) in own.into_iter().flatten().chain(parts).filter(|(primitive, size)| is_ellipsoid(*primitive, *size))
    {
        if !found.contains(&size) {
            found.push(size);
        }
    }
    found
}

/// Returns the extents of the collision form of a shape, if it has one of its own.
fn collide_size(shape: &Shape) -> Vector3<f64> {
    if shape.collide_size == Vector3::zeros() { shape.size } else { shape.collide_size }
}

/// Returns the convex mesh of an ellipsoid of a shape.
fn ellipsoid(shape: &Shape, size: Vector3<f64>) -> Form {
    let made = |size: Vector3<f64>| (size, Arc::new(Mesh::ellipsoid(size)));
    let known = shape.derived.ellipsoids.get_or_init(|| ellipsoids(shape).into_iter().map(made).collect());
    let mesh = known.iter().find(|(s, _)| *s == size).map_or_else(|| made(size).1, |(_, mesh)| mesh.clone());
    Form::Mesh { mesh, convex: true }
}

/// Returns the form of a primitive with the full extents `size`, or `None` for a missing mesh and for a compound.
fn form(
    shape: &Shape,
    primitive: Primitive,
    size: Vector3<f64>,
    (mesh, convex): (Option<&Arc<Mesh>>, bool),
) -> Option<Form> {
    Some(match primitive {
        Primitive::Sphere if is_ellipsoid(primitive, size) => ellipsoid(shape, size),
        Primitive::Box => Form::Box { half: size / 2.0 },
        Primitive::Sphere => Form::Sphere { radius: size.x / 2.0 },
        Primitive::Cylinder => Form::Cylinder { radius: size.x / 2.0, half_length: size.z / 2.0 },
        Primitive::Capsule => Form::Capsule { radius: size.x / 2.0, half_length: ((size.z - size.x) / 2.0).max(0.0) },
        Primitive::Plane => Form::Plane,
        Primitive::Mesh => Form::Mesh { mesh: mesh?.clone(), convex },
        Primitive::Compound => return None,
    })
}

/// Returns the parts of a shape that are rendered and detected by beams.
pub fn visible_parts(shape: &Shape) -> Vec<SolidPart> {
    if shape.primitive == Primitive::Compound {
        let part = |p: &super::ShapePart| {
            let form = form(shape, p.primitive, p.size, (p.mesh.as_ref(), p.convex))?;
            let texture = p.texture.as_ref().or(shape.texture.as_ref()).and_then(|t| t.on(&p.pose));
            Some(SolidPart { pose: p.pose, form, friction: p.friction, color: p.color, opacity: p.opacity, texture })
        };
        return shape.parts.iter().filter_map(part).collect();
    }
    let texture = shape.texture.as_ref().and_then(|t| t.on(&Isometry3::identity()));
    let form = form(shape, shape.primitive, shape.size, (shape.mesh.as_ref(), shape.convex));
    form.map(|form| SolidPart { texture, ..whole_shape_part(form) }).into_iter().collect()
}

fn whole_shape_part(form: Form) -> SolidPart {
    SolidPart { pose: Isometry3::identity(), form, friction: None, color: None, opacity: None, texture: None }
}

/// Returns the parts of a shape that collide.
pub fn collision_parts(shape: &Shape) -> Vec<SolidPart> {
    match shape.collide_as {
        None => visible_parts(shape),
        Some(primitive) => form(shape, primitive, collide_size(shape), (shape.mesh.as_ref(), shape.convex))
            .map(whole_shape_part)
            .into_iter()
            .collect(),
    }
}

/// Returns whether the collision form of a shape is infinite.
pub fn is_infinite(shape: &Shape) -> bool {
    let plane = |primitive| primitive == Primitive::Plane;
    match (shape.collide_as, shape.primitive) {
        (None, Primitive::Compound) => shape.parts.iter().any(|part| plane(part.primitive)),
        (own, seen) => plane(own.unwrap_or(seen)),
    }
}
