//! Images: what a camera sees of the scene, one surface per pixel.
//!
//! A ray per pixel would give the same; but the pixels of an image lie on a regular grid, and on such a grid the
//! inverse of the depth of a plane is a linear function of column and row. So surfaces are drawn one after the other
//! into a buffer that keeps, for each pixel, the nearest: boxes, planes and triangles by spans, small triangles by
//! blocks of 4 x 4 pixels, round forms exactly by their equation. What was seen where is noted as one number per pixel;
//! colours, normals and names are computed from it afterwards, once per pixel.
//!
//! Begin with [`GridCast`]; then `render`, a frame: `ready` makes ready what is in sight and sorts it into `bands` of
//! rows, and each band is drawn by one task (`draw`).

mod bands;
mod camera;
mod clusters;
mod draw;
mod image;
mod light;
mod polygon;
mod query;
mod raster;
mod ready;
mod render;
mod round;
mod shade;
mod small;
mod span;
mod triangles;

#[cfg(test)]
mod tests;

pub use image::GridImage;
pub use light::{Light, color_of};
pub use query::{Grid, GridCast, View, Want};

pub(super) use clusters::Clusters;
