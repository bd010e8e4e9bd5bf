//! Images on surfaces: how an image is projected onto a form, and the resulting colour of a point of the surface.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_64_with_seed;

use crate::form::{Form, Mesh};

/// Maximum number of pixels in an image, which occupy 64 MiB at 4 bytes per pixel.
pub const MAX_IMAGE_PIXELS: usize = 16 << 20;

/// Offset added to projected positions in an image, as a fraction of the image's size. It prevents rounding errors from
/// mixing two pixels on a surface that follows the border between them exactly. Texture coordinates are not offset.
const PIXEL_BORDER_OFFSET: f64 = 1e-6;

/// An RGBA image, with 8 bits per channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    columns: u32,
    rows: u32,
    rgba: Vec<u8>,
    hash: u64,
}

impl Image {
    /// Creates an image from pixels of 4 bytes, top row first. Returns `None` if it would have no pixels or more than
    /// [`MAX_IMAGE_PIXELS`], or if the number of bytes does not match.
    pub fn new(columns: u32, rows: u32, rgba: Vec<u8>) -> Option<Self> {
        let pixels = (columns as usize).checked_mul(rows as usize)?;
        let fits = pixels > 0 && pixels <= MAX_IMAGE_PIXELS && rgba.len() == 4 * pixels;
        let hash = xxh3_64_with_seed(&rgba, columns.into());
        fits.then_some(Image { columns, rows, rgba, hash })
    }
    /// Returns the number of columns.
    pub fn columns(&self) -> u32 {
        self.columns
    }
    /// Returns the number of rows.
    pub fn rows(&self) -> u32 {
        self.rows
    }
    /// Returns a hash of the width and the pixels, by which images are distinguished.
    pub fn hash(&self) -> u64 {
        self.hash
    }
    /// Returns red, green, blue and opacity of all pixels, top row first.
    pub fn rgba(&self) -> &[u8] {
        &self.rgba
    }
    /// Returns red, green, blue and opacity of a pixel, each 0 to 1. Outside the image, `repeat` selects per axis
    /// whether the image repeats; otherwise the pixel at the edge is used.
    fn at(&self, column: f64, row: f64, repeat: [bool; 2]) -> [f32; 4] {
        let place = |x: f64, count: u32, repeats: bool| {
            let last = f64::from(count - 1);
            let x = if repeats { x.rem_euclid(f64::from(count)) } else { x };
            x.clamp(0.0, last) as usize
        };
        let (x, y) = (place(column, self.columns, repeat[0]), place(row, self.rows, repeat[1]));
        let first = 4 * (y * self.columns as usize + x);
        [0, 1, 2, 3].map(|i| f32::from(self.rgba[first + i]) / 255.0)
    }
}

/// How points of a surface are mapped to an image. All but `Box` and `Mesh` depend on the position of the point alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum TextureMapping {
    /// Along the z axis: x is mapped to the right, y upwards.
    #[default]
    Plane,
    /// Around the z axis: the angle about z is mapped to the right, z upwards.
    Cylinder,
    /// Around the origin: the angle about z is mapped to the right, the angle from -z upwards.
    Sphere,
    /// As `Plane`, along the axis that is closest to the surface's normal.
    Box,
    /// By the texture coordinates of a mesh, [`Mesh::coordinates`]; without them, the surface keeps its colour.
    Mesh,
}

/// Names of mappings, in the order of [`TextureMapping`].
pub const MAPPING_NAMES: &[&str] = &["plane", "cylinder", "sphere", "box", "mesh"];

impl TextureMapping {
    /// Returns the mapping with a name in [`MAPPING_NAMES`].
    pub fn parse(name: &str) -> Option<Self> {
        let all = [Self::Plane, Self::Cylinder, Self::Sphere, Self::Box, Self::Mesh];
        MAPPING_NAMES.iter().position(|m| *m == name).map(|i| all[i])
    }
    /// Returns the mapping's name.
    pub fn name(self) -> &'static str {
        MAPPING_NAMES[self as usize]
    }
}

/// How an image is combined with the colour of the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum TextureBlend {
    /// The colours of the image and the surface are multiplied.
    #[default]
    Modulate,
    /// The image covers the surface's colour in proportion to the image's opacity.
    Decal,
    /// The colours of the image and the surface are added, and each channel is limited to 1.
    Add,
}

/// Names of blends, in the order of [`TextureBlend`].
pub const BLEND_NAMES: &[&str] = &["modulate", "decal", "add"];

impl TextureBlend {
    /// Returns the blend with a name in [`BLEND_NAMES`].
    pub fn parse(name: &str) -> Option<Self> {
        let all = [Self::Modulate, Self::Decal, Self::Add];
        BLEND_NAMES.iter().position(|m| *m == name).map(|i| all[i])
    }
    /// Returns the blend's name.
    pub fn name(self) -> &'static str {
        BLEND_NAMES[self as usize]
    }
}

/// The projection of an image onto a surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TextureProjection {
    /// How points of the surface are mapped to the image.
    pub mapping: TextureMapping,
    /// Width and height of the image on the surface, m. For `Cylinder` and `Sphere`, the width is in turns; for
    /// `Sphere`, the height is in half turns; for `Mesh`, both are in texture coordinates.
    pub size: [f64; 2],
    /// Pose of the projection in the frame of the form. Its origin is the centre of the image.
    pub pose: Isometry3<f64>,
    /// Whether the image repeats horizontally and vertically; otherwise its edge pixels extend outwards.
    pub repeat: [bool; 2],
    /// Whether colours between pixels are interpolated.
    pub smooth: bool,
    /// How the image is combined with the colour of the surface.
    pub blend: TextureBlend,
}

impl Default for TextureProjection {
    fn default() -> Self {
        TextureProjection {
            mapping: TextureMapping::Plane,
            size: [1.0; 2],
            pose: Isometry3::identity(),
            repeat: [true; 2],
            smooth: true,
            blend: TextureBlend::Modulate,
        }
    }
}

/// An image projected onto a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Pixels of the image, shared between surfaces.
    pub image: Arc<Image>,
    /// Projection of the image onto the surface.
    pub projection: TextureProjection,
}

impl Texture {
    /// Returns the colour at a point on the surface of a form whose untextured colour is `base`. The point and the
    /// outward normal at the point are in the frame of the form. The primitive is the index of the triangle if the form
    /// is a mesh, and is ignored otherwise.
    pub fn color(
        &self,
        (form, primitive): (&Form, u32),
        point: &Point3<f64>,
        normal: &Vector3<f64>,
        base: [f32; 3],
    ) -> [f32; 3] {
        let place = match (self.projection.mapping, form) {
            (TextureMapping::Mesh, Form::Mesh { mesh, .. }) => {
                mesh.texture_coordinates_at(primitive, point).map(|[right, up]| {
                    let [width, height] = self.projection.size;
                    [right / width, up / height]
                })
            }
            (TextureMapping::Mesh, _) => None,
            _ => Some(self.image_position(point, normal)),
        };
        let Some(place) = place else { return base };
        let [r, g, b, opacity] = self.sample(place);
        let image = [r, g, b];
        [0, 1, 2].map(|i| match self.projection.blend {
            TextureBlend::Modulate => base[i] * image[i],
            TextureBlend::Decal => base[i] + (image[i] - base[i]) * opacity,
            TextureBlend::Add => (base[i] + image[i]).min(1.0),
        })
    }

    /// Returns the position in the image of a point on the surface: right and up, each 0 to 1 inside the image.
    fn image_position(&self, point: &Point3<f64>, normal: &Vector3<f64>) -> [f64; 2] {
        use std::f64::consts::{PI, TAU};
        let TextureProjection { mapping, size, pose, .. } = &self.projection;
        let p = pose.inverse_transform_point(point);
        let [right, up] = match mapping {
            TextureMapping::Plane | TextureMapping::Mesh => [p.x, p.y],
            TextureMapping::Cylinder => [libm::atan2(p.y, p.x) / TAU, p.z],
            TextureMapping::Sphere => {
                [libm::atan2(p.y, p.x) / TAU, libm::atan2(p.z, libm::sqrt(p.x * p.x + p.y * p.y)) / PI]
            }
            TextureMapping::Box => {
                let n = pose.rotation.inverse_transform_vector(normal);
                match (n.x.abs(), n.y.abs(), n.z.abs()) {
                    (x, y, z) if z >= x && z >= y => [p.x, p.y],
                    (x, y, _) if y >= x => [p.x, p.z],
                    _ => [p.y, p.z],
                }
            }
        };
        [right / size[0] + 0.5 + PIXEL_BORDER_OFFSET, up / size[1] + 0.5 + PIXEL_BORDER_OFFSET]
    }

    fn sample(&self, [right, up]: [f64; 2]) -> [f32; 4] {
        let (image, TextureProjection { repeat, smooth, .. }) = (&*self.image, &self.projection);
        let (x, y) = (right * f64::from(image.columns), (1.0 - up) * f64::from(image.rows));
        if !smooth {
            return image.at(x.floor(), y.floor(), *repeat);
        }
        let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
        let (a, b) = ((x - 0.5 - left) as f32, (y - 0.5 - top) as f32);
        let pixel = |dx: f64, dy: f64| image.at(left + dx, top + dy, *repeat);
        let (p, q, r, s) = (pixel(0.0, 0.0), pixel(1.0, 0.0), pixel(0.0, 1.0), pixel(1.0, 1.0));
        [0, 1, 2, 3].map(|i| {
            let (above, below) = (p[i] + (q[i] - p[i]) * a, r[i] + (s[i] - r[i]) * a);
            above + (below - above) * b
        })
    }
}

impl Mesh {
    /// Returns the texture coordinates at a point of a triangle, interpolated between its corners, or `None` if the
    /// triangle, or a vertex or texture coordinate of a corner, does not exist.
    fn texture_coordinates_at(&self, triangle: u32, point: &Point3<f64>) -> Option<[f64; 2]> {
        let corners = *self.triangles.get(triangle as usize)?;
        let [a, b, c] = corners.map(|i| self.vertices.get(i as usize));
        let [p, q, r] = corners.map(|i| self.coordinates.get(i as usize));
        let (a, b, c, p, q, r) = (a?, b?, c?, p?, q?, r?);
        let (ab, ac, ap) = (b - a, c - a, point - a);
        let n = ab.cross(&ac);
        let size = n.norm_squared();
        let (to_b, to_c) = match size > 0.0 {
            true => (ap.cross(&ac).dot(&n) / size, ab.cross(&ap).dot(&n) / size),
            false => (0.0, 0.0),
        };
        Some([0, 1].map(|i| {
            let [p, q, r] = [p, q, r].map(|x| f64::from(x[i]));
            p + (q - p) * to_b + (r - p) * to_c
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A form for mappings that ignore it; only `TextureMapping::Mesh` uses the form.
    const BALL: (&Form, u32) = (&Form::Sphere { radius: 1.0 }, 0);

    /// Four squares: red and green above, blue and white below.
    fn squares(projection: TextureProjection) -> Texture {
        let rgba = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]].concat();
        Texture { image: Arc::new(Image::new(2, 2, rgba).unwrap()), projection }
    }

    #[test]
    fn first_row_of_the_image_is_on_top() {
        let t = squares(TextureProjection { smooth: false, size: [2.0; 2], ..Default::default() });
        let seen = |x: f64, y: f64| t.color(BALL, &Point3::new(x, y, 7.0), &Vector3::z(), [1.0; 3]);
        assert_eq!(seen(-0.5, 0.5), [1.0, 0.0, 0.0]);
        assert_eq!(seen(0.5, 0.5), [0.0, 1.0, 0.0]);
        assert_eq!(seen(-0.5, -0.5), [0.0, 0.0, 1.0]);
        assert_eq!(seen(2.5, 0.5), [0.0, 1.0, 0.0], "the image repeats");
    }

    #[test]
    fn box_mapping_shows_the_image_on_each_side() {
        let t = squares(TextureProjection {
            mapping: TextureMapping::Box,
            smooth: false,
            size: [2.0; 2],
            ..Default::default()
        });
        let seen = |p: [f64; 3], n: [f64; 3]| t.color(BALL, &Point3::from(p), &Vector3::from(n), [1.0; 3]);
        assert_eq!(seen([1.0, 0.5, 0.5], [1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
        assert_eq!(seen([-0.5, 1.0, 0.5], [0.0, 1.0, 0.0]), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn blends_mix_image_and_surface_colors() {
        let with = |blend: TextureBlend| {
            squares(TextureProjection { blend, smooth: false, size: [2.0; 2], ..Default::default() })
        };
        let seen = |t: Texture| t.color(BALL, &Point3::new(-0.5, 0.5, 0.0), &Vector3::z(), [0.5, 0.5, 0.0]);
        assert_eq!(seen(with(TextureBlend::Modulate)), [0.5, 0.0, 0.0]);
        assert_eq!(seen(with(TextureBlend::Decal)), [1.0, 0.0, 0.0]);
        assert_eq!(seen(with(TextureBlend::Add)), [1.0, 0.5, 0.0]);
    }

    #[test]
    fn edge_pixels_extend_without_repetition() {
        let t = squares(TextureProjection { repeat: [false; 2], size: [2.0; 2], ..Default::default() });
        assert_eq!(t.color(BALL, &Point3::new(9.0, 9.0, 0.0), &Vector3::z(), [1.0; 3]), [0.0, 1.0, 0.0]);
        assert_eq!(Image::new(2, 2, vec![0; 15]), None);
        assert_eq!(Image::new(0, 2, Vec::new()), None);
    }

    #[test]
    fn coordinates_of_a_mesh_are_interpolated() {
        let vertices = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, y]| Point3::new(x, y, 5.0)).to_vec();
        // The image is rotated by a quarter turn: its right-hand side is at the top.
        let coordinates = vec![[0.0, 1.0], [0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
        let mesh = Arc::new(Mesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]], coordinates });
        let form = Form::Mesh { mesh, convex: false };
        let t = squares(TextureProjection { mapping: TextureMapping::Mesh, smooth: false, ..Default::default() });
        let seen = |triangle, x, y| t.color((&form, triangle), &Point3::new(x, y, 5.0), &Vector3::z(), [1.0; 3]);
        assert_eq!(seen(0, 0.4, 0.2), [1.0, 0.0, 0.0]);
        assert_eq!(seen(1, 0.4, 1.6), [0.0, 1.0, 0.0]);
        assert_eq!(seen(0, 1.8, 0.3), [0.0, 0.0, 1.0]);
        assert_eq!(seen(0, 1.8, 1.6), [1.0; 3]);
        assert_eq!(t.color(BALL, &Point3::origin(), &Vector3::z(), [0.2; 3]), [0.2; 3], "spheres lack coordinates");
    }
}
