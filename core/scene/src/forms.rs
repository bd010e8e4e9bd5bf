//! The solids of a shape: those that are rendered and detected by beams, and those that collide. Also computes default
//! masses and inertias.

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use tatu_geometry::{Form, Mesh, Part};

use super::{Primitive, Shape};

/// Returns the form of a primitive with the full extents `size`, or `None` for a missing mesh and for a compound.
fn form(primitive: Primitive, size: Vector3<f64>, (mesh, convex): (Option<&Arc<Mesh>>, bool)) -> Option<Form> {
    Some(match primitive {
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
pub fn visible_parts(shape: &Shape) -> Vec<Part> {
    if shape.primitive == Primitive::Compound {
        let part = |p: &super::ShapePart| {
            let form = form(p.primitive, p.size, (p.mesh.as_ref(), p.convex))?;
            let texture = p.texture.as_ref().or(shape.texture.as_ref()).and_then(|t| t.on(&p.pose));
            Some(Part { pose: p.pose, form, friction: p.friction, color: p.color, texture })
        };
        return shape.parts.iter().filter_map(part).collect();
    }
    let texture = shape.texture.as_ref().and_then(|t| t.on(&Isometry3::identity()));
    let form = form(shape.primitive, shape.size, (shape.mesh.as_ref(), shape.convex));
    form.map(|form| Part { texture, ..whole(form) }).into_iter().collect()
}

/// Returns a part that consists of the whole shape.
fn whole(form: Form) -> Part {
    Part { pose: Isometry3::identity(), form, friction: None, color: None, texture: None }
}

/// Returns the parts of a shape that collide.
pub fn collision_parts(shape: &Shape) -> Vec<Part> {
    match shape.collide_as {
        None => visible_parts(shape),
        Some(primitive) => {
            let size = if shape.collide_size == Vector3::zeros() { shape.size } else { shape.collide_size };
            form(primitive, size, (shape.mesh.as_ref(), shape.convex)).map(whole).into_iter().collect()
        }
    }
}

/// Returns whether the collision form of a shape is infinite.
pub fn is_endless(shape: &Shape) -> bool {
    let plane = |primitive| primitive == Primitive::Plane;
    match (shape.collide_as, shape.primitive) {
        (None, Primitive::Compound) => shape.parts.iter().any(|part| plane(part.primitive)),
        (own, seen) => plane(own.unwrap_or(seen)),
    }
}

/// Density of shapes without a given mass, kg/m^3: that of water.
const DENSITY: f64 = 1000.0;

/// Returns the mass of a shape at the default density, kg; at least 1e-6 kg.
pub fn default_mass(shape: &Shape) -> f64 {
    visible_parts(shape).iter().map(|p| volume(&p.form) * DENSITY).sum::<f64>().max(1e-6)
}

fn volume(form: &Form) -> f64 {
    use std::f64::consts::PI;
    match form {
        Form::Plane => 0.0,
        Form::Box { half } => 8.0 * half.x * half.y * half.z,
        Form::Sphere { radius } => 4.0 / 3.0 * PI * radius.powi(3),
        Form::Cylinder { radius, half_length } => PI * radius * radius * 2.0 * half_length,
        Form::Capsule { radius, half_length } => {
            PI * radius * radius * 2.0 * half_length + 4.0 / 3.0 * PI * radius.powi(3)
        }
        Form::Mesh { mesh, .. } => mesh_volume(mesh).abs(),
    }
}

fn mesh_volume(mesh: &Mesh) -> f64 {
    let point = |i: u32| mesh.vertices.get(i as usize).map_or(Vector3::zeros(), |p| p.coords);
    mesh.triangles.iter().map(|[a, b, c]| point(*a).dot(&point(*b).cross(&point(*c))) / 6.0).sum()
}

/// Returns the approximate inertia of a shape with a given mass and uniform density, about its centre of mass, kg m^2.
/// If an axis has no inertia, returns a small multiple of the identity instead, which the engine can invert.
pub fn default_inertia(shape: &Shape, mass: f64) -> Matrix3<f64> {
    let parts = visible_parts(shape);
    let total: f64 = parts.iter().map(|p| volume(&p.form)).sum::<f64>().max(1e-12);
    let com = shape.com;
    let mut sum = Matrix3::zeros();
    for p in &parts {
        let m = mass * volume(&p.form) / total;
        let r = p.pose.rotation.to_rotation_matrix();
        let own = r.matrix() * part_inertia(&p.form, m) * r.matrix().transpose();
        let d = p.pose.translation.vector - com;
        sum += own + m * (Matrix3::identity() * d.norm_squared() - d * d.transpose());
    }
    if sum.diagonal().min() > 0.0 { sum } else { Matrix3::identity() * (mass * 1e-3) }
}

fn part_inertia(form: &Form, m: f64) -> Matrix3<f64> {
    let diagonal = |x: f64, y: f64, z: f64| Matrix3::from_diagonal(&Vector3::new(x, y, z));
    let solid_box = |s: Vector3<f64>| {
        let (x, y, z) = (s.x * s.x, s.y * s.y, s.z * s.z);
        diagonal(m * (y + z) / 12.0, m * (x + z) / 12.0, m * (x + y) / 12.0)
    };
    match form {
        Form::Plane => Matrix3::identity(),
        Form::Box { half } => solid_box(half * 2.0),
        Form::Sphere { radius } => Matrix3::identity() * (0.4 * m * radius * radius),
        Form::Cylinder { radius, half_length } => {
            let (r2, l) = (radius * radius, 2.0 * half_length);
            let side = m * (3.0 * r2 + l * l) / 12.0;
            diagonal(side, side, m * r2 / 2.0)
        }
        Form::Capsule { radius, half_length } => {
            // The capsule is approximated by a cylinder of the full length, with an error of a few percent. The result
            // is used only if the shape does not specify its inertia.
            let (r2, l) = (radius * radius, 2.0 * (half_length + radius));
            let side = m * (3.0 * r2 + l * l) / 12.0;
            diagonal(side, side, m * r2 / 2.0)
        }
        Form::Mesh { mesh, .. } => {
            // The mesh is approximated by its bounding box. The result is used only if the shape does not specify its
            // inertia.
            let (mut low, mut high) =
                (Point3::from(Vector3::repeat(f64::MAX)), Point3::from(Vector3::repeat(f64::MIN)));
            for v in &mesh.vertices {
                low = low.inf(v);
                high = high.sup(v);
            }
            solid_box(high - low)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_of_water_weighs_what_it_should() {
        let shape = Shape { size: Vector3::new(1.0, 0.5, 0.2), ..Default::default() };
        let mass = default_mass(&shape);
        assert!((mass - 100.0).abs() < 1e-9);
        let inertia = default_inertia(&shape, mass);
        assert!((inertia[(2, 2)] - 100.0 * (1.0 + 0.25) / 12.0).abs() < 1e-9);
    }

    #[test]
    fn two_half_boxes_weigh_as_one() {
        let part = |x: f64| crate::ShapePart {
            primitive: Primitive::Box,
            size: Vector3::new(0.5, 0.5, 0.2),
            pose: Isometry3::translation(x, 0.0, 0.0),
            color: None,
            friction: None,
            texture: None,
            mesh_number: 0,
            mesh: None,
            convex: false,
        };
        let halves =
            Shape { primitive: Primitive::Compound, parts: vec![part(-0.25), part(0.25)], ..Default::default() };
        let whole = Shape { size: Vector3::new(1.0, 0.5, 0.2), ..Default::default() };
        let m = default_mass(&halves);
        assert!((m - default_mass(&whole)).abs() < 1e-9);
        assert!((default_inertia(&halves, m) - default_inertia(&whole, m)).norm() < 1e-9);
    }
}
