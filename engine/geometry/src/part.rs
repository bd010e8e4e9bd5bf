//! Parts: forms with a pose and an appearance.

use std::sync::Arc;

use nalgebra::Isometry3;

use crate::{Form, Texture};

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

impl From<Form> for SolidPart {
    /// Returns a part at the origin of the object's frame, with the object's friction and colour.
    fn from(form: Form) -> Self {
        SolidPart { pose: Isometry3::identity(), form, friction: None, color: None, opacity: None, texture: None }
    }
}
