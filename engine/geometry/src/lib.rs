//! Solid forms, shared by physics, beams and the scene.
//!
//! Lengths are in metres, in the frame of the form. V-REP's conventions apply: z is up, and the axis of a cylinder is
//! z.

mod form;
mod moments;
mod texture;

use std::sync::Arc;

use nalgebra::Isometry3;

pub use form::{Form, Mesh};
pub use moments::{Moments, steiner};
pub use texture::{
    BLEND_NAMES, Image, MAPPING_NAMES, MAX_IMAGE_PIXELS, Texture, TextureBlend, TextureMapping, TextureProjection,
};

/// A form and its pose in the frame of the object to which it belongs.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidPart {
    /// Transform from the frame of the part to that of the object.
    pub pose: Isometry3<f64>,
    /// Form of the part, in its own frame.
    pub form: Form,
    /// Friction coefficient, or `None` to use the object's.
    pub friction: Option<f64>,
    /// Red, green and blue, each 0 to 1, or `None` to use the object's colour.
    pub color: Option<[f64; 3]>,
    /// Opacity, from 0 (invisible) to 1, or `None` to use the object's.
    pub opacity: Option<f64>,
    /// Image on the surface of the part, projected in the part's frame.
    pub texture: Option<Arc<Texture>>,
}

/// Returns an angle wrapped to (-pi, pi], in radians.
pub fn wrap_angle(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let wrapped = angle % TAU;
    match wrapped {
        w if w > PI => w - TAU,
        w if w <= -PI => w + TAU,
        w => w,
    }
}
