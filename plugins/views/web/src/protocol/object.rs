//! Objects of a scene.

use std::collections::BTreeMap;

use serde::Serialize;

/// An object, or a model that equals an earlier one.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(untagged)]
#[allow(clippy::large_enum_variant, reason = "nearly all entries are objects")]
pub(crate) enum SceneEntry {
    Object(SceneObject),
    Copy(ModelCopy),
}

/// A model without a parent that equals an earlier one in the message, apart from what is stated here.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct ModelCopy {
    /// The handle of the root of the earlier model.
    pub(crate) copy_of: u32,
    /// The alias of the root.
    pub(crate) alias: String,
    /// The handles of all objects, in the order of those of the earlier model.
    pub(crate) ids: Vec<u32>,
    /// The poses that differ from those of the earlier model, by the index of the object.
    pub(crate) poses: BTreeMap<u32, [f64; 7]>,
    /// The scripts of all objects, in their order.
    pub(crate) scripts: Vec<Script>,
}

/// An object of the scene, as the page shows it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields, rename = "SceneObject"))]
pub(crate) struct SceneObject {
    /// The handle of the object.
    pub(crate) id: u32,
    /// The handle of the parent, or 0. Children of a joint are attached to the frame that the joint moves.
    pub(crate) parent: u32,
    pub(crate) alias: String,
    pub(crate) kind: String,
    /// Position (m) and quaternion (x y z w) in the parent's frame.
    pub(crate) pose: [f64; 7],
    pub(crate) visible: bool,
    #[cfg_attr(test, ts(type = "number"))]
    pub(crate) layer: i64,
    /// Whether the object is the base of a model.
    pub(crate) model: bool,
    /// The visible parts of a shape.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) parts: Option<Vec<VisiblePart>>,
    /// Whether a shape is respondable, that is, collides with others. Omitted if false.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[cfg_attr(test, ts(optional, as = "Option<bool>"))]
    pub(crate) collides: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) joint: Option<Joint>,
    /// The kind of a sensor, such as `proximity`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) sensor: Option<String>,
    /// The schema of a sensor's readings; omitted if the readings have no fields.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) schema: Option<ReadingSchema>,
    /// Whether a sensor with images measures both colors and depths. Omitted if false.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[cfg_attr(test, ts(optional, as = "Option<bool>"))]
    pub(crate) depth: bool,
    /// The detection volume of a sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) volume: Option<SensorVolume>,
    /// The poses of a path, seven values each: position (m) and quaternion (x y z w).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) points: Option<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) closed: Option<bool>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(test, ts(optional, as = "Option<Vec<Script>>"))]
    pub(crate) scripts: Vec<Script>,
}

/// A texture: an image, and its projection onto a part.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields))]
pub(crate) struct Texture {
    /// The hash of the image, which is sent in a separate message.
    pub(crate) image: String,
    /// The kind of projection: `plane`, `cylinder`, `sphere`, `box`, or `mesh` for the texture coordinates of a mesh.
    pub(crate) mapping: String,
    /// Width and height of the image on the surface, m. For `cylinder` and `sphere`, the width is in revolutions; for
    /// `sphere`, the height is in half revolutions; for `mesh`, both are in texture coordinates.
    #[cfg_attr(test, ts(as = "[f64; 2]"))]
    pub(crate) size: Vec<f64>,
    /// Pose of the projection in the frame of the part: position (m) and quaternion (x y z w).
    #[cfg_attr(test, ts(as = "[f64; 7]"))]
    pub(crate) pose: Vec<f64>,
    /// Whether the image is repeated horizontally, and vertically.
    pub(crate) repeat: [bool; 2],
    /// Whether colors are interpolated between pixels.
    pub(crate) smooth: bool,
    /// How the image is combined with the color of the part: `modulate`, `decal` or `add`.
    pub(crate) blend: String,
}

/// A visible part of a shape.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields))]
pub(crate) struct VisiblePart {
    /// The form: `plane`, `box`, `sphere`, `cylinder`, `capsule` or `mesh`.
    pub(crate) form: String,
    /// Pose of the part in the frame of its object: position (m) and quaternion (x y z w).
    #[cfg_attr(test, ts(as = "[f64; 7]"))]
    pub(crate) pose: Vec<f64>,
    /// Red, green and blue components, 0 to 1.
    #[cfg_attr(test, ts(as = "[f64; 3]"))]
    pub(crate) color: Vec<f64>,
    /// Opacity, from 0 (invisible) to 1; omitted if 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) opacity: Option<f64>,
    /// Size of the part along its axes, m; omitted for a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) size: Option<Vec<f64>>,
    /// The texture of the part, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) texture: Option<Texture>,
    /// The hash of the mesh, which is sent in a separate message; omitted for other forms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) mesh: Option<String>,
}

/// The type, lead and limits of a joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields))]
pub(crate) struct Joint {
    /// The type: `revolute`, `prismatic` or `spherical`.
    #[serde(rename = "type")]
    pub(crate) form: String,
    /// Translation of a screw joint per revolution, m.
    pub(crate) lead: f64,
    /// Minimum and maximum position, rad or m; omitted if the joint has no limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) limits: Option<[f64; 2]>,
}

/// A script of an object or of the scene.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct Script {
    pub(crate) id: u32,
    pub(crate) name: String,
    pub(crate) kind: String,
    pub(crate) language: String,
    /// A hash of the script's source.
    pub(crate) version: u32,
}

/// A schema of sensor readings that the page can show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub(crate) enum ReadingSchema {
    Proximity,
    RangeScan,
    Image,
    Gps,
    Fields,
}

/// The detection volume of a sensor; lengths in m, angles in rad. Infinite values, and values that do not exist for the
/// kind of sensor, are omitted.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields))]
pub(crate) struct SensorVolume {
    /// The form of the volume: `ray`, `cone`, `pyramid`, `cylinder` or `disc`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) volume: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) range: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) near: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) angle: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) height: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) radius_near: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) radius_far: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) size_near: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) size_far: Option<[f64; 2]>,
}
