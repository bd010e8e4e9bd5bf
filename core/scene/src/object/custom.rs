//! Conversion of values that are lists or maps: surfaces, parts of shapes, custom data.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};
use tatu_errors::Refusal;
use tatu_geometry::Mesh;
use tatu_plugin_api::{abi::*, safe::Value};

use super::{Primitive, parts::ShapePart};
use crate::{from_euler, pose_from_array, property::refuse, texture::ShapeTexture};

/// Builds a mesh from lists: coordinates of points, indices of points, and optionally texture coordinates.
pub fn mesh_from_lists(value: &Value) -> Result<Mesh, Refusal> {
    let Value::List(lists) = value else { return refuse(TATU_ERR_ARGUMENT, "a surface must be a list of lists") };
    let numbers = |v: Option<&Value>| -> Option<Vec<f64>> {
        match v? {
            Value::Floats(f) => Some(f.clone()),
            Value::Ints(i) => Some(i.iter().map(|x| *x as f64).collect()),
            _ => None,
        }
    };
    let (Some(points), Some(places)) = (numbers(lists.first()), numbers(lists.get(1))) else {
        return refuse(TATU_ERR_ARGUMENT, "a surface must be a list of coordinates and a list of point indices");
    };
    let count = points.len() / 3;
    let whole = points.len() % 3 == 0 && places.len() % 3 == 0 && count >= 3 && places.len() >= 3;
    if !whole || !points.iter().all(|x| x.is_finite()) {
        return refuse(
            TATU_ERR_ARGUMENT,
            "a surface must have three finite numbers per point and three indices per triangle",
        );
    }
    if places.iter().any(|i| !(0.0..count as f64).contains(i)) {
        return refuse(
            TATU_ERR_ARGUMENT,
            format!("a triangle refers to a point that does not exist: expected indices from 0 to below {count}"),
        );
    }
    let coordinates = match lists.get(2) {
        None => Vec::new(),
        given => numbers(given).unwrap_or_default(),
    };
    if lists.len() > 2 && (coordinates.len() != 2 * count || !coordinates.iter().all(|x| x.is_finite())) {
        return refuse(
            TATU_ERR_ARGUMENT,
            format!("texture coordinates of a surface must be two finite numbers for each of its {count} points"),
        );
    }
    Ok(Mesh {
        coordinates: coordinates.chunks_exact(2).map(|c| [c[0] as f32, c[1] as f32]).collect(),
        vertices: points.chunks_exact(3).map(|p| Point3::new(p[0], p[1], p[2])).collect(),
        triangles: places.chunks_exact(3).map(|t| [t[0] as u32, t[1] as u32, t[2] as u32]).collect(),
    })
}

/// Returns the points and triangles of a mesh as lists, for [`surface`].
pub fn surface_value(mesh: Option<&Mesh>) -> Value {
    let empty = Mesh::default();
    let mesh = mesh.unwrap_or(&empty);
    let mut lists = vec![
        Value::Floats(mesh.vertices.iter().flat_map(|p| [p.x, p.y, p.z]).collect()),
        Value::Ints(mesh.triangles.iter().flatten().map(|i| i64::from(*i)).collect()),
    ];
    if !mesh.coordinates.is_empty() {
        lists.push(Value::Floats(mesh.coordinates.iter().flatten().map(|x| f64::from(*x)).collect()));
    }
    Value::List(lists)
}

/// Converts a map from tags to strings to custom data.
pub fn notes(value: &Value) -> Result<BTreeMap<Vec<u8>, Vec<u8>>, Refusal> {
    let Value::Map(pairs) = value else {
        return refuse(TATU_ERR_ARGUMENT, "custom data must be a map from tags to strings");
    };
    pairs
        .iter()
        .map(|(k, v)| match (k, v) {
            (Value::Text(k) | Value::Bytes(k), Value::Text(v) | Value::Bytes(v)) => Ok((k.clone(), v.clone())),
            _ => refuse(TATU_ERR_ARGUMENT, "custom data must be a map from tags to strings"),
        })
        .collect()
}

/// Returns custom data as a map, in ascending order of tags.
pub fn notes_value(notes: &BTreeMap<Vec<u8>, Vec<u8>>) -> Value {
    Value::Map(notes.iter().map(|(k, v)| (Value::Text(k.clone()), Value::Text(v.clone()))).collect())
}

/// Returns the numbers of the meshes that a list of parts uses.
pub fn part_meshes(parts: &Value) -> Vec<u32> {
    parts_of(parts).unwrap_or_default().iter().map(|p| p.mesh_number).filter(|n| *n > 0).collect()
}

/// Returns the numbers of the images that a list of parts uses.
pub fn part_images(parts: &Value) -> Vec<u32> {
    parts_of(parts).unwrap_or_default().iter().filter_map(|p| p.texture.as_ref()).map(|t| t.image_number).collect()
}

/// Converts the list of parts of a compound.
pub fn parts_of(value: &Value) -> Result<Vec<ShapePart>, Refusal> {
    let Value::List(parts) = value else { return refuse(TATU_ERR_ARGUMENT, "parts must be a list of tables") };
    parts.iter().map(part_of).collect()
}

fn part_of(value: &Value) -> Result<ShapePart, Refusal> {
    let Value::Map(entries) = value else { return refuse(TATU_ERR_ARGUMENT, "a part must be a table") };
    let mut part = ShapePart {
        primitive: Primitive::Box,
        size: Vector3::repeat(0.1),
        pose: nalgebra::Isometry3::identity(),
        color: None,
        opacity: None,
        texture: None,
        friction: None,
        mesh_number: 0,
        mesh: None,
        convex: false,
    };
    for (key, v) in entries {
        let Value::Text(key) = key else { continue };
        let three = || match v {
            Value::Floats(f) if f.len() == 3 => Ok([f[0], f[1], f[2]]),
            _ => refuse(TATU_ERR_ARGUMENT, format!("part: `{}` must be 3 numbers", String::from_utf8_lossy(key))),
        };
        match key.as_slice() {
            b"primitive" => {
                let name = match v {
                    Value::Text(t) => String::from_utf8_lossy(t).into_owned(),
                    _ => String::new(),
                };
                part.primitive = Primitive::parse(&name)
                    .filter(|p| *p != Primitive::Compound)
                    .ok_or_else(|| Refusal(TATU_ERR_ARGUMENT, format!("a part cannot be a `{name}`")))?;
            }
            b"size" => part.size = Vector3::from(three()?),
            b"position" => part.pose.translation.vector = Vector3::from(three()?),
            b"orientation" => part.pose.rotation = from_euler(three()?),
            b"quaternion" => {
                let pose = match v {
                    Value::Floats(q) if q.len() == 4 => pose_from_array(&[0.0, 0.0, 0.0, q[0], q[1], q[2], q[3]]),
                    _ => None,
                };
                let wrong = || Refusal(TATU_ERR_ARGUMENT, "part: `quaternion` must be x y z w, not all 0".into());
                part.pose.rotation = pose.ok_or_else(wrong)?.rotation;
            }
            b"color" => part.color = Some(three()?),
            b"opacity" => match v {
                Value::Float(f) if (0.0..=1.0).contains(f) => part.opacity = Some(*f),
                Value::Int(i) if (0..=1).contains(i) => part.opacity = Some(*i as f64),
                _ => return refuse(TATU_ERR_ARGUMENT, "part: `opacity` must be a number from 0 to 1"),
            },
            b"texture" => part.texture = ShapeTexture::from_value(v)?,
            b"friction" => match v {
                Value::Float(f) if *f >= 0.0 => part.friction = Some(*f),
                Value::Int(i) if *i >= 0 => part.friction = Some(*i as f64),
                _ => return refuse(TATU_ERR_ARGUMENT, "part: `friction` must be a number of at least 0"),
            },
            b"mesh" => match v {
                Value::Int(i) if (1..=i64::from(u32::MAX)).contains(i) => part.mesh_number = *i as u32,
                _ => return refuse(TATU_ERR_ARGUMENT, "part: `mesh` must be the number of a mesh, from 1"),
            },
            b"convex" => match v {
                Value::Bool(b) => part.convex = *b,
                _ => return refuse(TATU_ERR_ARGUMENT, "part: `convex` must be true or false"),
            },
            other => {
                let key = String::from_utf8_lossy(other).into_owned();
                return refuse(
                    TATU_ERR_ARGUMENT,
                    format!(
                        "a part has no key `{key}`; expected primitive, size, position, orientation, quaternion, \
                         color, opacity, texture, friction, mesh, convex"
                    ),
                );
            }
        }
    }
    match part.primitive == Primitive::Mesh && part.mesh_number == 0 {
        true => refuse(TATU_ERR_ARGUMENT, "a part with the primitive `mesh` must specify `mesh`"),
        false => Ok(part),
    }
}
