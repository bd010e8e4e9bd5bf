//! Objects of a scene.

use serde::Serialize;

/// An object of the scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields, rename = "SceneObject"))]
pub(crate) struct Object {
    /// The handle of the object.
    pub(crate) id: u32,
    /// The handle of the parent; 0 if there is none. Children of a joint are attached to its moved frame.
    pub(crate) parent: u32,
    pub(crate) alias: String,
    pub(crate) kind: String,
    /// Position and quaternion (x y z w) in the parent's frame.
    pub(crate) pose: [f64; 7],
    pub(crate) visible: bool,
    #[cfg_attr(test, ts(type = "number"))]
    pub(crate) layer: i64,
    /// Whether the object is the base of a model.
    pub(crate) model: bool,
    /// The parts of a shape.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) parts: Option<Vec<Part>>,
    /// Whether a shape collides; false if it is missing.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[cfg_attr(test, ts(optional, as = "Option<bool>"))]
    pub(crate) collides: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) joint: Option<Joint>,
    /// The kind of a sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) sensor: Option<String>,
    /// The schema of a sensor's readings, if the page shows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) schema: Option<Schema>,
    /// The detection volume of a sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) volume: Option<Volume>,
    /// The poses of a path, seven numbers each: position (m) and quaternion (x y z w).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) points: Option<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) closed: Option<bool>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(test, ts(optional, as = "Option<Vec<Script>>"))]
    pub(crate) scripts: Vec<Script>,
}

/// A texture: an image on a part, and its projection.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields))]
pub(crate) struct Texture {
    /// The hash of the image, which is sent as a separate message.
    pub(crate) image: String,
    /// plane, cylinder, sphere or box.
    pub(crate) mapping: String,
    /// Width and height of the image on the surface, m.
    #[cfg_attr(test, ts(as = "[f64; 2]"))]
    pub(crate) size: Vec<f64>,
    /// Pose of the projection in the frame of the part.
    #[cfg_attr(test, ts(as = "[f64; 7]"))]
    pub(crate) pose: Vec<f64>,
    /// Whether the image repeats to the right, and upwards.
    pub(crate) repeat: [bool; 2],
    /// Whether colors between pixels are interpolated.
    pub(crate) smooth: bool,
    /// modulate, decal or add.
    pub(crate) blend: String,
}

/// A visible part of a shape.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields))]
pub(crate) struct Part {
    /// plane, box, sphere, cylinder, capsule or mesh.
    pub(crate) form: String,
    /// Pose of the part in the frame of its object.
    #[cfg_attr(test, ts(as = "[f64; 7]"))]
    pub(crate) pose: Vec<f64>,
    /// Red, green and blue, 0 to 1.
    #[cfg_attr(test, ts(as = "[f64; 3]"))]
    pub(crate) color: Vec<f64>,
    /// Size of the part along its axes, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) size: Option<Vec<f64>>,
    /// The texture of the part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) texture: Option<Texture>,
    /// The hash of the mesh, which is sent as a separate message.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) mesh: Option<String>,
}

/// The type, lead and limits of a joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields))]
pub(crate) struct Joint {
    /// revolute, prismatic or spherical.
    #[serde(rename = "type")]
    pub(crate) form: String,
    /// Translation of a screw joint per turn, m.
    pub(crate) lead: f64,
    /// Minimum and maximum position, rad or m, if the joint has limits.
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
    /// A number that differs for different texts of the script.
    pub(crate) version: u32,
}

/// A schema of readings that the page shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub(crate) enum Schema {
    Proximity,
    RangeScan,
    Image,
    Gps,
    Fields,
}

/// The detection volume of a sensor; lengths in m, angles in rad. Infinite values are omitted.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields))]
pub(crate) struct Volume {
    /// ray, cone, pyramid, cylinder or disc.
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
