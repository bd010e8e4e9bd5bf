//! What is asked for: the pixels of an image, and what is computed of them.

use nalgebra::Isometry3;

use super::light::Light;
use crate::Faces;

/// The pixels of an image.
///
/// The camera looks along +z of its frame, y is up and x points to the left. Rows run from bottom to top, columns from left
/// to right as seen; pixels are square, and the axis goes through the middle of the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Number of columns, from 1 to 16,384.
    pub columns: u32,
    /// Number of rows, from 1 to 16,384.
    pub rows: u32,
    /// How rays go.
    pub view: View,
    /// Surfaces nearer than the plane `z = near` are cut away, in metres; 0 or more in perspective.
    pub near: f64,
    /// The plane `z = far`, beyond which nothing is seen, in metres; may be infinite.
    pub far: f64,
}

/// How the rays of an image go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum View {
    /// All from the sensor's origin.
    Perspective {
        /// Between the left and the right border of the image, in radians; more than 0, less than pi.
        angle: f64,
    },
    /// All along +z.
    Orthographic {
        /// From the left to the right border of the image, in metres; more than 0.
        width: f64,
    },
}

/// What is computed beside the depth. Each costs time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Want {
    /// Red, green and blue.
    pub color: bool,
    /// The cosine of the angle between the surface normal and the ray.
    pub cosine: bool,
    /// The surface normal.
    pub normal: bool,
    /// The tag of the target.
    pub object: bool,
    /// The place on the form.
    pub primitive: bool,
}

impl Want {
    /// Only the depth.
    pub const DEPTH: Self = Self { color: false, cosine: false, normal: false, object: false, primitive: false };
    /// All there is.
    pub const ALL: Self = Self { color: true, cosine: true, normal: true, object: true, primitive: true };

    /// Whether it must be noted what is seen where.
    pub(super) fn visibility(&self) -> bool {
        *self != Self::DEPTH
    }
}

/// One image to be taken of a [`BeamScene`](crate::BeamScene).
///
/// A pixel shows the nearest surface on the ray through its middle that lies between the planes `near` and `far` and shows
/// a side in `faces`. Of surfaces at exactly the same depth, the one of the lowest tag, then of the lowest primitive.
#[derive(Debug, Clone, Copy)]
pub struct GridCast<'a> {
    /// The pixels.
    pub grid: &'a Grid,
    /// Place of the camera.
    pub world_from_sensor: Isometry3<f64>,
    /// Sides seen.
    pub faces: Faces,
    /// A group that is passed over, such as the model that carries the sensor.
    pub skip_group: Option<u32>,
    /// The one object that is looked for; the others neither count nor hide it.
    pub only_object: Option<u64>,
    /// What is computed beside the depth.
    pub want: Want,
    /// Lamps and sky, for colours.
    pub light: &'a Light,
}
