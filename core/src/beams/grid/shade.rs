//! What is seen, pixel by pixel: from the numbers in the buffer to names, normals and colours.
//!
//! Light is plain: some from everywhere, some from the camera, some from a sun; surfaces are matt. It needs no graphics
//! hardware and gives the same bytes everywhere.

use nalgebra::{Matrix3, Vector3};

use super::GridCast;
use super::camera::Camera;
use super::image::Part;
use super::polygon::ViewFrom;
use super::raster::{NOBODY, Raster};
use crate::beams::Target;
use crate::geometry::Form;

/// Lamps, and the colour where nothing is. A surface that gets 1 in sum has its own colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Light from everywhere, 0 to 1.
    pub ambient: f32,
    /// A lamp beside the camera: its part of a surface that faces the camera, 0 to 1.
    pub headlight: f32,
    /// A lamp far away: its part of a surface that faces it, 0 to 1.
    pub sun: f32,
    /// Toward that lamp, in the world; of length 1.
    pub sun_direction: [f32; 3],
    /// Red, green and blue of pixels that see nothing, 0 to 1.
    pub sky: [f32; 3],
}

impl Default for Light {
    /// Enough from everywhere to tell colours apart in the shade, a sun from above and beside.
    fn default() -> Self {
        Self {
            ambient: 0.35,
            headlight: 0.25,
            sun: 0.4,
            sun_direction: [0.267_261_24, 0.534_522_5, 0.801_783_74],
            sky: [0.55, 0.68, 0.82],
        }
    }
}

impl Light {
    /// The sky, 0 to 255.
    pub(super) fn sky_bytes(&self) -> [u8; 3] {
        self.sky.map(byte)
    }
}

fn byte(x: f32) -> u8 {
    // What is no number becomes 0.
    (x * 255.0 + 0.5) as u8
}

/// The colour of a matt surface, 0 to 255.
///
/// `normal` (on the side of the camera) and `to_camera` are of length 1, in the world. `sunlit` is 0 in a shadow, 1 in the
/// light.
pub fn color_of(
    light: &Light,
    surface: [f32; 3],
    normal: &Vector3<f32>,
    to_camera: &Vector3<f32>,
    sunlit: f32,
) -> [u8; 3] {
    let facing = |way: &Vector3<f32>| (normal.x * way.x + normal.y * way.y + normal.z * way.z).max(0.0);
    let sun = Vector3::from(light.sun_direction);
    let sum = light.ambient + light.headlight * facing(to_camera) + light.sun * sunlit * facing(&sun);
    surface.map(|x| byte(x * sum))
}

/// Numbers from `first` on are primitives of a target.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface {
    pub first: u32,
    pub target: u32,
    pub view_from_form: ViewFrom,
}

/// Turns numbers into what was asked for.
pub(super) struct Shader<'a> {
    cast: &'a GridCast<'a>,
    camera: &'a Camera,
    targets: &'a [Target],
    surfaces: &'a [Surface],
    world_from_view: Matrix3<f32>,
}

/// What the last pixel saw; most see the same as their neighbour.
struct Seen<'a> {
    id: u32,
    /// Place of the surface.
    at: usize,
    target: &'a Target,
    primitive: u32,
    view_from_form: &'a ViewFrom,
    /// Of a flat primitive, in the view frame.
    normal: Vector3<f32>,
}

impl<'a> Shader<'a> {
    pub fn new(cast: &'a GridCast<'a>, camera: &'a Camera, targets: &'a [Target], surfaces: &'a [Surface]) -> Self {
        Self { cast, camera, targets, surfaces, world_from_view: camera.rotation.transpose().map(|x| x as f32) }
    }

    /// Fills in a band.
    pub fn shade(&self, raster: &Raster<'_, true>, part: &mut Part<'_>) {
        part.clear(self.cast.light.sky_bytes());
        let want = self.cast.want;
        let bent = want.color || want.cosine || want.normal;
        let mut seen: Option<Seen<'_>> = None;
        for row in 0..raster.end - raster.first {
            let first = row * raster.columns;
            for (column, id) in raster.id[row * raster.stride..][..raster.columns].iter().enumerate() {
                if *id == NOBODY {
                    continue;
                }
                if seen.as_ref().is_none_or(|seen| seen.id != *id) {
                    seen = self.seen(*id, seen.map_or(0, |seen| seen.at));
                }
                let Some(seen) = &seen else { continue };
                let pixel = first + column;
                if want.object {
                    part.object[pixel] = seen.target.object;
                }
                if want.primitive {
                    part.primitive[pixel] = seen.primitive;
                }
                if bent {
                    self.shade_pixel(seen, (column, row + raster.first), pixel, part);
                }
            }
        }
    }

    /// Normal, cosine and colour of a pixel.
    fn shade_pixel(&self, seen: &Seen<'_>, (column, row): (usize, usize), pixel: usize, part: &mut Part<'_>) {
        let want = self.cast.want;
        let (from, along) = self.camera.ray(column as f64, row as f64);
        let toward = -along.map(|x| x as f32);
        let toward = toward / dot(&toward, &toward).sqrt();
        let normal = self.normal(seen, &(from + along * f64::from(part.depth[pixel])));
        let cosine = dot(&normal, &toward);
        let normal = if cosine < 0.0 { -normal } else { normal };
        if want.cosine {
            part.cosine[pixel] = cosine.abs().min(1.0);
        }
        if want.normal {
            part.normal[pixel] = [-normal.x, normal.y, normal.z];
        }
        if want.color {
            let (normal, toward) = (self.world_from_view * normal, self.world_from_view * toward);
            part.color[pixel] = color_of(self.cast.light, seen.target.color, &normal, &toward, 1.0);
        }
    }

    /// What a number stands for; `at` is the place of a surface that it probably belongs to.
    fn seen(&self, id: u32, at: usize) -> Option<Seen<'a>> {
        let starts = |at: usize| self.surfaces.get(at).is_some_and(|surface| surface.first <= id);
        let at = if starts(at) && !starts(at + 1) {
            at
        } else {
            self.surfaces.partition_point(|surface| surface.first <= id).checked_sub(1)?
        };
        let Surface { first, target, view_from_form } = self.surfaces.get(at)?;
        let target = &self.targets[*target as usize];
        let primitive = id - first;
        let normal = match &target.form {
            Form::Box { .. } => {
                let mut normal = Vector3::zeros();
                normal[primitive as usize / 2 % 3] = if primitive % 2 == 1 { 1.0 } else { -1.0 };
                normal
            }
            Form::Mesh { mesh, .. } => {
                let corner = |vertex: u32| mesh.vertices.get(vertex as usize).map(|p| p.coords);
                let [a, b, c] = mesh.triangles.get(primitive as usize)?.map(corner);
                let (a, b, c) = (a?, b?, c?);
                (b - a).cross(&(c - a)).try_normalize(0.0)?
            }
            _ => Vector3::z() * if primitive == 2 { -1.0 } else { 1.0 },
        };
        let normal = (view_from_form.rotation * normal).map(|x| x as f32);
        Some(Seen { id, at, target, primitive, view_from_form, normal })
    }

    /// The outward normal at a point, in the view frame.
    fn normal(&self, seen: &Seen<'_>, point: &Vector3<f64>) -> Vector3<f32> {
        let local = || seen.view_from_form.rotation.transpose() * (point - seen.view_from_form.translation);
        let out = match (&seen.target.form, seen.primitive) {
            (Form::Sphere { .. }, _) => local(),
            (Form::Cylinder { .. } | Form::Capsule { .. }, 0) => {
                let p = local();
                Vector3::new(p.x, p.y, 0.0)
            }
            (Form::Capsule { half_length, .. }, end) => {
                local() - Vector3::z() * if end == 1 { *half_length } else { -half_length }
            }
            _ => return seen.normal,
        };
        let length = (out.x * out.x + out.y * out.y + out.z * out.z).sqrt();
        if length > 0.0 { (seen.view_from_form.rotation * (out / length)).map(|x| x as f32) } else { seen.normal }
    }
}

fn dot(a: &Vector3<f32>, b: &Vector3<f32>) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}
