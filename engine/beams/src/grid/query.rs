//! Image queries: the pixels of an image, and the outputs to compute for them.

use nalgebra::Isometry3;

use super::light::ImageLighting;
use crate::Faces;

/// The pixels of an image.
///
/// The camera looks along +z of its frame, +y points up and +x to the left. Rows are numbered from bottom to top,
/// columns from left to right as seen by the camera. Pixels are square, and the axis passes through the centre of the
/// image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Number of columns, from 1 to 16,384.
    pub columns: u32,
    /// Number of rows, from 1 to 16,384.
    pub rows: u32,
    /// The projection.
    pub projection: ImageProjection,
    /// Depth of the near plane, in metres; surfaces nearer than `z = near` are clipped. Must be at least 0 in
    /// perspective.
    pub near: f64,
    /// Depth of the far plane, in metres; surfaces beyond `z = far` are clipped. May be infinite.
    pub far: f64,
}

/// The projection of an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ImageProjection {
    /// All rays start at the origin of the sensor.
    Perspective {
        /// Angle between the left and the right edge of the image, in radians; more than 0, less than pi.
        angle: f64,
    },
    /// All rays are parallel to +z.
    Orthographic {
        /// Width of the image, in metres; more than 0.
        width: f64,
    },
}

/// Outputs to compute in addition to the depth. Each output increases the rendering time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ImageOutputs {
    /// Whether to compute the colour.
    pub color: bool,
    /// Whether to compute the cosine of the angle between the surface normal and the ray.
    pub cosine: bool,
    /// Whether to compute the surface normal.
    pub normal: bool,
    /// Whether to store the tag of the target.
    pub object: bool,
    /// Whether to store the part of the form.
    pub primitive: bool,
}

impl ImageOutputs {
    /// Only the depth.
    pub const DEPTH: Self = Self { color: false, cosine: false, normal: false, object: false, primitive: false };
    /// All outputs.
    pub const ALL: Self = Self { color: true, cosine: true, normal: true, object: true, primitive: true };

    /// Returns whether the visible surface must be stored for each pixel.
    pub(super) fn needs_surface_ids(&self) -> bool {
        *self != Self::DEPTH
    }
}

/// A query for one image of a [`BeamScene`](crate::BeamScene).
///
/// A pixel shows the nearest surface on the ray through its centre that lies between the planes `near` and `far` and
/// shows a side in `faces`. Among surfaces at exactly the same depth, the one with the lowest tag is shown, then the
/// one with the lowest primitive.
#[derive(Debug, Clone, Copy)]
pub struct GridCast<'a> {
    /// The pixels.
    pub grid: &'a Grid,
    /// Pose of the camera.
    pub world_from_sensor: Isometry3<f64>,
    /// Sides of surfaces that are visible.
    pub faces: Faces,
    /// A group to ignore, such as the model that carries the sensor.
    pub skip_group: Option<u32>,
    /// If set, only this object is considered; other objects are neither visible nor occlude it.
    pub only_object: Option<u64>,
    /// Outputs to compute in addition to the depth.
    pub outputs: ImageOutputs,
    /// Lamps and sky, for colours.
    pub light: &'a ImageLighting,
}
