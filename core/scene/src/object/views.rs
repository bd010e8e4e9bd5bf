//! Cameras, lights and paths. Physics and sensors ignore these objects; views and scripts use them.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI};

use serde::{Deserialize, Serialize};
use tatu_plugin_api::safe::Value;

use super::ObjectKind;
use crate::property::{numbers_of, properties, words};

/// A camera, which is the viewpoint of a view or picture. It looks along its z axis; y is up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the table of rows describes each property")]
pub struct Camera {
    pub angle: f64,
    pub ortho_size: f64,
    pub near: f64,
    pub far: f64,
}

impl Default for Camera {
    fn default() -> Self {
        Camera { angle: FRAC_PI_3, ortho_size: 0.0, near: 0.05, far: 1000.0 }
    }
}

/// A light source of a view.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the table of rows describes each property")]
pub struct Light {
    pub form: LightForm,
    pub on: bool,
    pub color: [f64; 3],
    pub angle: f64,
}

/// The directions in which a light shines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names are self-explanatory")]
pub enum LightForm {
    Omni,
    Spot,
    Directional,
}

words! { LightForm { Omni "omni", Spot "spot", Directional "directional" } }

impl Default for Light {
    fn default() -> Self {
        Light { form: LightForm::Omni, on: true, color: [0.5; 3], angle: FRAC_PI_2 }
    }
}

/// A path through space.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the table of rows describes each property")]
pub struct ScenePath {
    pub points: Vec<f64>,
    pub rounding: Vec<f64>,
    pub closed: bool,
}

/// Sets a list that has `count` numbers for each point.
fn set_point_list(place: &mut Vec<f64>, value: &Value, count: usize) -> Result<bool, String> {
    let numbers = numbers_of(value)?;
    if numbers.len() % count != 0 {
        return Err(format!("expected {count} numbers for each point, found {} numbers", numbers.len()));
    }
    numbers.clone_into(place);
    Ok(true)
}

properties! { CAMERA: Camera, PropertyOwner::Kind(ObjectKind::Camera) =>
    "camera.angle" number in "rad" above 0.0 below PI = FRAC_PI_3, None angle: "Angle of view along the longer side of the picture.";
    "camera.ortho_size" number in "m" from 0.0 = 0.0, None ortho_size: "Width of the view in parallel projection, along the longer side; 0: perspective.";
    "camera.near" number in "m" above 0.0 = 0.05, None near: "Distance of the near clipping plane.";
    "camera.far" number in "m" above 0.0 = 1000.0, None far: "Distance of the far clipping plane.";
}

properties! { LIGHT: Light, PropertyOwner::Kind(ObjectKind::Light) =>
    "light.form" text of (LightForm::WORDS) = "omni", None form: "Directions of the light: everywhere, in a cone along its z axis, or parallel to its z axis.";
    "light.on" bool = true, None on: "Whether the light is on.";
    "light.color" numbers 3 from 0.0 to 1.0 = [0.5, 0.5, 0.5], None color: "Red, green and blue of the light.";
    "light.angle" number in "rad" above 0.0 to FRAC_PI_2 = FRAC_PI_2, None angle: "Half the angle of the cone of a spotlight.";
}

properties! { PATH: ScenePath, PropertyOwner::Kind(ObjectKind::Path) =>
    "path.points" numbers = none, None { get |p: &ScenePath| Value::Floats(p.points.clone()), set |p: &mut ScenePath, v| set_point_list(&mut p.points, v, 7) }: "Control points in the path's frame: position and quaternion x y z w, 7 numbers each.";
    "path.rounding" numbers = none, None { get |p: &ScenePath| Value::Floats(p.rounding.clone()), set |p: &mut ScenePath, v| set_point_list(&mut p.rounding, v, 3) }: "3 numbers for each point: the fraction of half the segment before it and after it that is rounded, 0 to 1, and the number of positions on the rounding; without them, segments are straight.";
    "path.closed" bool = false, None closed: "Whether the path returns to its first point.";
}
