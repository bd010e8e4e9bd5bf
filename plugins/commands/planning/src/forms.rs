//! Reads the forms of shapes.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};
use tatu_geometry::{Form, Mesh, SolidPart};
use tatu_kinematics_common::pose_of;
use tatu_plugin_api::{
    abi::tatu_object,
    safe::{Result, ValueRef, World},
};

use crate::state::Planning;

/// Returns the form of a name with its full extents, m.
fn primitive(name: &str, size: [f64; 3]) -> Option<Form> {
    Some(match name {
        "plane" => Form::Plane,
        "box" => Form::Box { half: Vector3::from(size) * 0.5 },
        "sphere" => Form::Sphere { radius: 0.5 * size[0] },
        "cylinder" => Form::Cylinder { radius: 0.5 * size[0], half_length: 0.5 * size[2] },
        "capsule" => Form::Capsule { radius: 0.5 * size[0], half_length: (0.5 * (size[2] - size[0])).max(0.0) },
        _ => return None,
    })
}

fn mesh(part: ValueRef<'_>, convex: bool) -> Option<Form> {
    let (points, triangles) = (part.get("points")?.numbers()?, part.get("triangles")?.numbers()?);
    let vertices = points.as_chunks::<3>().0.iter().map(|p| Point3::from(*p)).collect();
    let triangles = triangles.as_chunks::<3>().0.iter().map(|t| t.map(|i| i as u32)).collect();
    Some(Form::Mesh { mesh: Arc::new(Mesh { vertices, triangles, coordinates: Vec::new() }), convex })
}

/// Returns the forms with which a shape collides, in its frame.
pub fn forms_of(world: &World<'_>, props: &Planning, shape: tatu_object) -> Result<Vec<(Isometry3<f64>, Form)>> {
    let convex = world.get(shape, props.convex)?.as_bool().unwrap_or(false);
    let other = world.get(shape, props.collide_as)?.as_str().unwrap_or_default().into_owned();
    let mut size = world.f64s::<3>(shape, props.collide_size).unwrap_or([0.0; 3]);
    let mut forms = Vec::new();
    for index in 0.. {
        let Some(part) = world.part(shape, index)? else { break };
        let of = |key: &str| part.get(key).unwrap_or(ValueRef::NIL);
        let own = of("size").array::<3>().unwrap_or([0.0; 3]);
        if size == [0.0; 3] {
            size = own;
        }
        let name = of("form").as_str().unwrap_or_default().into_owned();
        let form = if name == "mesh" { mesh(part, convex) } else { primitive(&name, own) };
        let pose = of("pose").array::<7>().map_or_else(Isometry3::identity, pose_of);
        forms.extend(form.map(|form| (pose, form)));
    }
    if other.is_empty() || other == "same" {
        return Ok(forms);
    }
    if size == [0.0; 3] {
        size = extents(&forms);
    }
    let replaced = primitive(&other, size).map(|form| (Isometry3::identity(), form));
    let mesh = forms.into_iter().find(|(_, form)| matches!(form, Form::Mesh { .. }));
    Ok(replaced.or(mesh).into_iter().collect())
}

/// Returns the full extents of meshes.
fn extents(forms: &[(Isometry3<f64>, Form)]) -> [f64; 3] {
    let mut size = Vector3::zeros();
    for (_, form) in forms {
        if let Form::Mesh { mesh, .. } = form {
            let half = mesh.vertices.iter().fold(Vector3::zeros(), |h: Vector3<f64>, v| h.sup(&v.coords.abs()));
            size = size.sup(&(2.0 * half));
        }
    }
    size.into()
}

/// Returns forms as the parts of a solid at a pose.
pub fn parts_of(forms: &[(Isometry3<f64>, Form)]) -> Vec<SolidPart> {
    forms.iter().map(|(pose, form)| SolidPart { pose: *pose, ..SolidPart::from(form.clone()) }).collect()
}
