//! Textures of shapes, as properties and as tables in scene files.

use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};
use serde::{Deserialize, Serialize};
use tatu_errors::Refusal;
use tatu_geometry::{BLEND_NAMES, Image, MAPPING_NAMES, Texture, TextureBlend, TextureMapping, TextureProjection};
use tatu_plugin_api::safe::Value;

use crate::{
    from_euler,
    graph::{CheckedMap, map},
    pose_from_array, pose_to_array,
};

/// Keys of the table of a texture, with their units.
pub const KEYS: &[(&str, &str)] = &[
    ("image", ""),
    ("mapping", ""),
    ("size", "m"),
    ("position", "m"),
    ("orientation", "rad"),
    ("quaternion", ""),
    ("repeat", ""),
    ("smooth", ""),
    ("blend", ""),
];

/// The texture of a shape or part: an image and its projection.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShapeTexture {
    /// Number of the image in the document, from 1.
    pub image_number: u32,
    /// The image with this number; not stored in snapshots.
    #[serde(skip)]
    pub image: Option<Arc<Image>>,
    /// Projection of the image, in the frame of the shape.
    pub projection: TextureProjection,
}

impl ShapeTexture {
    /// Returns the texture in the frame of a part, given the part's pose in the shape, or `None` if the image is
    /// missing.
    pub fn on(&self, shape_from_part: &Isometry3<f64>) -> Option<Arc<Texture>> {
        let pose = shape_from_part.inverse() * self.projection.pose;
        let projection = TextureProjection { pose, ..self.projection.clone() };
        Some(Arc::new(Texture { image: self.image.clone()?, projection }))
    }

    /// Parses the table of a texture; returns `None` if the table is empty.
    pub fn from_value(value: &Value) -> Result<Option<Self>, Refusal> {
        if matches!(value, Value::Map(entries) if entries.is_empty()) {
            return Ok(None);
        }
        let known: Vec<&str> = KEYS.iter().map(|(k, _)| *k).collect();
        let keys = CheckedMap::new("a texture", value, &known)?;
        let Some(number) = keys.count("image", 1..=i64::from(u32::MAX))? else {
            return keys
                .invalid_value("image", "the number of an image, from 1, or in scene files the name of a PNG file");
        };
        let usual = TextureProjection::default();
        let mapping = match keys.text("mapping")?.as_str() {
            "" => usual.mapping,
            name => {
                TextureMapping::parse(name).map_or_else(|| keys.invalid_value("mapping", &one_of(MAPPING_NAMES)), Ok)?
            }
        };
        let blend = match keys.text("blend")?.as_str() {
            "" => usual.blend,
            name => TextureBlend::parse(name).map_or_else(|| keys.invalid_value("blend", &one_of(BLEND_NAMES)), Ok)?,
        };
        let size = match *keys.numbers("size")? {
            [] => usual.size,
            [x, y] if x > 0.0 && y > 0.0 => [x, y],
            _ => {
                return keys
                    .invalid_value("size", "the width and the height of the image on the surface, both above 0");
            }
        };
        let mut pose = Isometry3::identity();
        match *keys.numbers("position")? {
            [] => {}
            [x, y, z] => pose.translation.vector = Vector3::new(x, y, z),
            _ => return keys.invalid_value("position", "3 numbers"),
        }
        match *keys.numbers("orientation")? {
            [] => {}
            [a, b, c] => pose.rotation = from_euler([a, b, c]),
            _ => return keys.invalid_value("orientation", "3 angles"),
        }
        match *keys.numbers("quaternion")? {
            [] => {}
            [x, y, z, w] => match pose_from_array(&[0.0, 0.0, 0.0, x, y, z, w]) {
                Some(turned) => pose.rotation = turned.rotation,
                None => return keys.invalid_value("quaternion", "x y z w, not all 0"),
            },
            _ => return keys.invalid_value("quaternion", "x y z w, not all 0"),
        }
        let repeat = keys.flags("repeat")?.map_or(Ok(usual.repeat), |given| match *given {
            [right, up] => Ok([right, up]),
            _ => keys.invalid_value("repeat", "two values, true or false: repetition to the right, and upwards"),
        })?;
        let smooth = keys.flags("smooth")?.and_then(|given| given.first().copied()).unwrap_or(usual.smooth);
        let projection = TextureProjection { mapping, size, pose, repeat, smooth, blend };
        Ok(Some(ShapeTexture { image_number: number as u32, image: None, projection }))
    }

    /// Returns the table of a texture, without default values; it is empty if there is no texture.
    pub fn to_value(texture: Option<&ShapeTexture>) -> Value {
        texture.map_or(Value::Map(Vec::new()), |t| t.numbered(i64::from(t.image_number)))
    }

    /// Returns the table of the texture with `number` in place of its image's number.
    pub fn numbered(&self, number: i64) -> Value {
        let (p, usual) = (&self.projection, TextureProjection::default());
        let mut entries = vec![("image", Value::Int(number))];
        let mut put = |differs: bool, key: &'static str, value: Value| {
            if differs {
                entries.push((key, value));
            }
        };
        let pose = pose_to_array(&p.pose);
        let list = |all: [bool; 2]| Value::List(all.map(Value::Bool).to_vec());
        put(p.mapping != usual.mapping, "mapping", Value::text(p.mapping.name()));
        put(p.size != usual.size, "size", Value::Floats(p.size.to_vec()));
        put(pose[..3] != [0.0; 3], "position", Value::Floats(pose[..3].to_vec()));
        put(pose[3..] != [0.0, 0.0, 0.0, 1.0], "quaternion", Value::Floats(pose[3..].to_vec()));
        put(p.repeat != usual.repeat, "repeat", list(p.repeat));
        put(p.smooth != usual.smooth, "smooth", Value::Bool(p.smooth));
        put(p.blend != usual.blend, "blend", Value::text(p.blend.name()));
        map(entries)
    }
}

fn one_of(names: &[&str]) -> String {
    format!("one of {}", names.join(", "))
}
