//! Cameras, lights and paths. Physics and sensors ignore these objects; views and scripts use them.

use serde::{Deserialize, Serialize};

/// A camera, which is the viewpoint of a view or picture. It looks along its z axis; y is up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "`rows.rs` describes each property")]
pub struct Camera {
    pub angle: f64,
    pub ortho_size: f64,
    pub near: f64,
    pub far: f64,
}

impl Default for Camera {
    fn default() -> Self {
        Camera { angle: std::f64::consts::FRAC_PI_3, ortho_size: 0.0, near: 0.05, far: 1000.0 }
    }
}

/// A light source of a view.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "`rows.rs` describes each property")]
pub struct Light {
    pub form: LightForm,
    pub on: bool,
    pub color: [f64; 3],
    pub angle: f64,
}

/// The directions in which a light shines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "named after what they are")]
pub enum LightForm {
    Omni,
    Spot,
    Directional,
}

/// Names of the light forms, in the order of [`LightForm`].
pub const LIGHT_FORMS: &[&str] = &["omni", "spot", "directional"];

impl Default for Light {
    fn default() -> Self {
        Light { form: LightForm::Omni, on: true, color: [0.5; 3], angle: std::f64::consts::FRAC_PI_2 }
    }
}

/// A path through space.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[allow(missing_docs, reason = "`rows.rs` describes each property")]
pub struct Path {
    pub points: Vec<f64>,
    pub rounding: Vec<f64>,
    pub closed: bool,
}
