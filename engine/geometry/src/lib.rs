//! Solid forms, which physics, beams and the scene share: their descriptions, their volumes and moments, and the images
//! on their surfaces.
//!
//! Lengths are in metres, in the frame of the form. V-REP's conventions apply: z is up, and the axis of a cylinder is
//! z.
//!
//! ```
//! use nalgebra::Vector3;
//! use tatu_geometry::Mesh;
//!
//! // A faceted ball of diameter 2 m: its volume is somewhat less than 4/3 pi.
//! let ball = Mesh::ellipsoid(Vector3::repeat(2.0));
//! assert_eq!(ball.open_edges(), 0);
//! let moments = ball.moments().expect("a closed mesh");
//! assert!(moments.measure > 4.0 && moments.measure < 4.19);
//! assert!(moments.centre.coords.norm() < 1e-9);
//! ```

mod angle;
mod form;
mod image;
mod moments;
mod part;
mod texture;

pub use angle::wrap_angle;
pub use form::{Form, Mesh};
pub use image::{Image, MAX_IMAGE_PIXELS};
pub use moments::{Moments, steiner};
pub use part::SolidPart;
pub use texture::{
    BLEND_NAMES, MAPPING_NAMES, Texture, TextureBlend, TextureMapping, TextureProjection, TexturedSurface,
};
