//! Images: the nearest visible surface per pixel.
//!
//! A ray per pixel would yield the same result, but the pixels of an image are on a regular grid, on which the inverse
//! depth of a plane is a linear function of column and row. Surfaces are therefore rasterised one after another into a
//! depth buffer: boxes, planes and triangles by spans, small triangles by blocks of 4 x 4 pixels, and round forms by
//! their equations. The index of the visible surface is stored for each pixel, and colours, normals and tags are
//! computed from it afterwards, once per pixel.
//!
//! Start with [`GridCast`], then read `render`, which renders a frame: `surfaces` prepares the visible surfaces and
//! sorts them into `bands` of rows, and each band is rasterised by one task (`draw`). Where the nearest surface is
//! translucent, `blend` adds the colours of those behind it.

mod bands;
mod blend;
mod camera;
mod clusters;
mod draw;
mod image;
mod light;
mod polygon;
mod query;
mod raster;
mod render;
mod round;
mod shade;
mod small_triangles;
mod span;
mod surfaces;
mod triangles;

#[cfg(test)]
mod tests;

pub use image::GridImage;
pub use light::{ImageLighting, shaded_color};
pub use query::{Grid, GridCast, ImageOutputs, ImageProjection};

pub(super) use clusters::MeshClusters;
