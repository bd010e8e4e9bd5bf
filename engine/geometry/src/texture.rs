//! Images on surfaces: how an image is projected onto a form, and the resulting colour of a point of the surface.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::{
    form::{Form, Mesh},
    image::Image,
};

/// Offset added to projected positions in an image, as a fraction of the image's size. It prevents rounding errors from
/// mixing two pixels on a surface that follows the border between them exactly. Texture coordinates are not offset.
const PIXEL_BORDER_OFFSET: f64 = 1e-6;

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
        self.on(form, primitive).map_or(base, |surface| surface.color(point, || *normal, base))
    }

    /// Prepares the texture for many points of one primitive of a form. Returns `None` if the surface keeps its colour
    /// because it lacks texture coordinates.
    pub fn on(&self, form: &Form, primitive: u32) -> Option<TexturedSurface<'_>> {
        let triangle = match (self.projection.mapping, form) {
            (TextureMapping::Mesh, Form::Mesh { mesh, .. }) => Some(TexturedTriangle::new(mesh, primitive)?),
            (TextureMapping::Mesh, _) => return None,
            _ => None,
        };
        Some(TexturedSurface { texture: self, triangle })
    }

    /// Returns the position in the image of a point on the surface: right and up, each 0 to 1 inside the image.
    #[inline]
    fn image_position(&self, point: &Point3<f64>, normal: impl FnOnce() -> Vector3<f64>) -> [f64; 2] {
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
                let n = pose.rotation.inverse_transform_vector(&normal());
                match (n.x.abs(), n.y.abs(), n.z.abs()) {
                    (x, y, z) if z >= x && z >= y => [p.x, p.y],
                    (x, y, _) if y >= x => [p.x, p.z],
                    _ => [p.y, p.z],
                }
            }
        };
        [right / size[0] + 0.5 + PIXEL_BORDER_OFFSET, up / size[1] + 0.5 + PIXEL_BORDER_OFFSET]
    }
}

/// A texture on one primitive of a form, for the colours of many of its points.
#[derive(Debug, Clone)]
pub struct TexturedSurface<'a> {
    texture: &'a Texture,
    /// The triangle, if the texture follows the coordinates of a mesh.
    triangle: Option<TexturedTriangle>,
}

impl TexturedSurface<'_> {
    /// Returns the colour at a point whose untextured colour is `base`. The point and the outward normal, which is
    /// requested only if the mapping depends on it, are in the frame of the form.
    #[inline]
    pub fn color(&self, point: &Point3<f64>, normal: impl FnOnce() -> Vector3<f64>, base: [f32; 3]) -> [f32; 3] {
        let TextureProjection { size, repeat, smooth, blend, .. } = &self.texture.projection;
        let place = match &self.triangle {
            Some(triangle) => {
                let [right, up] = triangle.coordinates_at(point);
                [right / size[0], up / size[1]]
            }
            None => self.texture.image_position(point, normal),
        };
        let [r, g, b, opacity] = self.texture.image.sample(place, *repeat, *smooth);
        let image = [r, g, b];
        match blend {
            TextureBlend::Modulate => [0, 1, 2].map(|i| base[i] * image[i]),
            TextureBlend::Decal => [0, 1, 2].map(|i| base[i] + (image[i] - base[i]) * opacity),
            TextureBlend::Add => [0, 1, 2].map(|i| (base[i] + image[i]).min(1.0)),
        }
    }
}

/// A triangle and the texture coordinates of its corners.
#[derive(Debug, Clone)]
struct TexturedTriangle {
    corner: Point3<f64>,
    /// From the first corner to the second and the third.
    sides: [Vector3<f64>; 2],
    normal: Vector3<f64>,
    /// Square of the length of the normal; 0 if the triangle has no area.
    size: f64,
    /// Texture coordinates of the first corner, and from there to those of the second and the third.
    first: [f64; 2],
    ways: [[f64; 2]; 2],
}

impl TexturedTriangle {
    /// Returns a triangle of a mesh, or `None` if the triangle, or a vertex or texture coordinate of a corner, does not
    /// exist.
    fn new(mesh: &Mesh, triangle: u32) -> Option<Self> {
        let corners = *mesh.triangles.get(triangle as usize)?;
        let [a, b, c] = corners.map(|i| mesh.vertices.get(i as usize));
        let [p, q, r] = corners.map(|i| mesh.coordinates.get(i as usize).map(|x| x.map(f64::from)));
        let (a, b, c, p, q, r) = (a?, b?, c?, p?, q?, r?);
        let sides = [b - a, c - a];
        let normal = sides[0].cross(&sides[1]);
        let way = |to: [f64; 2]| [to[0] - p[0], to[1] - p[1]];
        Some(Self { corner: *a, sides, normal, size: normal.norm_squared(), first: p, ways: [way(q), way(r)] })
    }

    /// Returns the texture coordinates at a point, interpolated between the corners.
    #[inline]
    fn coordinates_at(&self, point: &Point3<f64>) -> [f64; 2] {
        let Self { corner, sides: [ab, ac], normal, size, first, ways: [to_second, to_third] } = self;
        let ap = point - corner;
        let (b, c) = match *size > 0.0 {
            true => (ap.cross(ac).dot(normal) / size, ab.cross(&ap).dot(normal) / size),
            false => (0.0, 0.0),
        };
        [0, 1].map(|i| first[i] + to_second[i] * b + to_third[i] * c)
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
