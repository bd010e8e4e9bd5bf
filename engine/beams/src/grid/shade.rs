//! Shading: converts the surface numbers in the buffer to tags, normals and colours, pixel by pixel.
//!
//! The lighting model is simple: ambient light, a headlight and a sun on matt surfaces. It needs no graphics hardware
//! and gives the same bytes on all machines.

use std::ops::Range;

use nalgebra::Vector3;
use tatu_geometry::Form;

use super::{
    GridCast,
    camera::GridCamera,
    image::ImageBand,
    light::{brightness, to_byte},
    polygon::ViewTransform,
    raster::{NO_SURFACE, Raster},
};
use crate::{BeamScene, BeamTarget};

/// A target and the first of its primitive numbers.
#[derive(Debug, Clone, Copy)]
pub(super) struct TargetSurface {
    pub first: u32,
    pub target: u32,
}

/// Converts surface numbers to the requested outputs.
pub(super) struct Shader<'a> {
    pub(super) cast: &'a GridCast<'a>,
    pub(super) camera: &'a GridCamera,
    pub(super) scene: &'a BeamScene,
    surfaces: &'a [TargetSurface],
    /// Transform of each surface to the view.
    views: Vec<ViewTransform>,
    /// Direction towards the sun, in the view frame.
    sun: Vector3<f32>,
}

/// A row of pixels: outward normals in the view frame, surface colours, and 1 where a surface is visible, 0 elsewhere.
struct PixelRow {
    normal: [Vec<f32>; 3],
    color: [Vec<f32>; 3],
    visible: Vec<f32>,
}

/// The primitive at the previous pixel, which is cached because most pixels show the same one as their neighbour.
pub(super) struct CachedPrimitive<'a> {
    id: u32,
    /// Index of the surface.
    pub(super) at: usize,
    pub(super) target: &'a BeamTarget,
    primitive: u32,
    view_from_form: &'a ViewTransform,
    /// Outward normal of a flat primitive, in the view frame.
    normal: Vector3<f32>,
}

impl<'a> Shader<'a> {
    pub fn new(
        cast: &'a GridCast<'a>,
        camera: &'a GridCamera,
        scene: &'a BeamScene,
        surfaces: &'a [TargetSurface],
    ) -> Self {
        let sun = camera.rotation.map(|x| x as f32) * Vector3::from(cast.light.sun_direction);
        let shaded = if cast.outputs.needs_surface_ids() { surfaces } else { &[] };
        let view = |surface: &TargetSurface| {
            ViewTransform::new(camera, &scene.targets()[surface.target as usize].world_from_target)
        };
        Self { cast, camera, scene, surfaces, views: shaded.iter().map(view).collect(), sun }
    }

    /// Computes the requested outputs of a band.
    pub fn shade<const ID: bool>(&self, raster: &Raster<'_, ID>, part: &mut ImageBand<'_>) {
        let want = self.cast.outputs;
        let columns = raster.columns;
        let some = || [0; 3].map(|_| vec![0.0; columns]);
        let mut line = PixelRow { normal: some(), color: some(), visible: vec![0.0; columns] };
        let mut seen = None;
        for row in raster.first..raster.end {
            let first = (row - raster.first) * columns;
            let ids = &raster.id[(row - raster.first) * raster.stride..][..columns];
            self.look_up(ids, row, first, part, &mut line, &mut seen);
            if want.cosine || want.normal || want.color {
                self.shade_row(row, first..first + columns, &line, part);
            }
        }
    }

    /// Writes the tags and primitives of a row, and collects the inputs of its shading.
    fn look_up<'b>(
        &'b self,
        ids: &[u32],
        row: usize,
        first: usize,
        part: &mut ImageBand<'_>,
        line: &mut PixelRow,
        seen: &mut Option<CachedPrimitive<'b>>,
    ) {
        let want = self.cast.outputs;
        let bent = want.cosine || want.normal || want.color;
        for (column, id) in ids.iter().enumerate() {
            let pixel = first + column;
            if *id != NO_SURFACE && seen.as_ref().is_none_or(|seen| seen.id != *id) {
                *seen = self.find_primitive(*id, seen.as_ref().map_or(0, |seen| seen.at));
            }
            let here = seen.as_ref().filter(|_| *id != NO_SURFACE);
            if want.object {
                part.object[pixel] = here.map_or(0, |seen| seen.target.object);
            }
            if want.primitive {
                part.primitive[pixel] = here.map_or(0, |seen| seen.primitive);
            }
            if bent {
                let (normal, color) = here.map_or((Vector3::zeros(), self.cast.light.sky), |seen| {
                    let depth = part.depth[pixel];
                    let normal = self.normal(seen, column, row, depth);
                    (normal, if want.color { self.color(seen, column, row, depth, &normal) } else { [0.0; 3] })
                });
                for i in 0..3 {
                    line.normal[i][column] = normal[i];
                    line.color[i][column] = color[i];
                }
                line.visible[column] = if here.is_some() { 1.0 } else { 0.0 };
            }
        }
    }

    /// Computes cosines, normals and colours of a row, in branch-free loops that compilers can vectorize.
    fn shade_row(&self, row: usize, pixels: Range<usize>, line: &PixelRow, part: &mut ImageBand<'_>) {
        let (want, light) = (self.cast.outputs, self.cast.light);
        let middle = self.camera.middle();
        let (size, perspective) = ((1.0 / self.camera.scale) as f32, self.camera.perspective);
        let y = if perspective { (row as f64 - middle.1) as f32 * size } else { 0.0 };
        let (middle, size) = (middle.0 as f32, if perspective { size } else { 0.0 });
        let [nx, ny, nz] = &line.normal;
        // Cosine of the outward normal; negative where the inside is visible.
        let cosine = |i: usize| {
            let x = (i as f32 - middle) * size;
            -(nx[i] * x + ny[i] * y + nz[i]) / (x * x + y * y + 1.0).sqrt()
        };
        let toward = |cosine: f32| if cosine < 0.0 { -1.0 } else { 1.0 };
        if want.cosine {
            for (i, out) in part.cosine[pixels.clone()].iter_mut().enumerate() {
                *out = cosine(i).abs().min(1.0);
            }
        }
        if want.normal {
            for (i, out) in part.normal[pixels.clone()].iter_mut().enumerate() {
                let side = toward(cosine(i));
                *out = [0.0 - nx[i] * side, ny[i] * side, nz[i] * side];
            }
        }
        if want.color {
            for (i, out) in part.color[pixels].iter_mut().enumerate() {
                let cosine = cosine(i);
                let sun = (nx[i] * self.sun.x + ny[i] * self.sun.y + nz[i] * self.sun.z) * toward(cosine);
                let sum = if line.visible[i] > 0.0 { brightness(light, cosine.abs(), sun, 1.0) } else { 1.0 };
                *out =
                    [to_byte(line.color[0][i] * sum), to_byte(line.color[1][i] * sum), to_byte(line.color[2][i] * sum)];
            }
        }
    }

    /// Returns the primitive with a number; `at` is the index of the surface that it probably belongs to.
    pub(super) fn find_primitive(&self, id: u32, at: usize) -> Option<CachedPrimitive<'_>> {
        let starts = |at: usize| self.surfaces.get(at).is_some_and(|surface| surface.first <= id);
        let at = if starts(at) && !starts(at + 1) {
            at
        } else {
            self.surfaces.partition_point(|surface| surface.first <= id).checked_sub(1)?
        };
        let (TargetSurface { first, target }, view_from_form) = (self.surfaces.get(at)?, self.views.get(at)?);
        let target = &self.scene.targets()[*target as usize];
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
        Some(CachedPrimitive { id, at, target, primitive, view_from_form, normal })
    }

    /// Returns the surface point at a pixel, in the frame of its form.
    fn local(&self, seen: &CachedPrimitive<'_>, column: usize, row: usize, depth: f32) -> Vector3<f64> {
        let (from, along) = self.camera.ray(column as f64, row as f64);
        let point = from + along * f64::from(depth) - seen.view_from_form.translation;
        seen.view_from_form.rotation.transpose() * point
    }

    /// Returns the colour of the surface at a pixel whose outward normal in the view frame is known.
    fn color(
        &self,
        seen: &CachedPrimitive<'_>,
        column: usize,
        row: usize,
        depth: f32,
        normal: &Vector3<f32>,
    ) -> [f32; 3] {
        let Some(texture) = &seen.target.texture else { return seen.target.color };
        let normal = seen.view_from_form.rotation.transpose() * normal.map(f64::from);
        let surface = (&seen.target.form, seen.primitive);
        texture.color(surface, &self.local(seen, column, row, depth).into(), &normal, seen.target.color)
    }

    /// Returns the outward normal at a pixel, in the view frame.
    fn normal(&self, seen: &CachedPrimitive<'_>, column: usize, row: usize, depth: f32) -> Vector3<f32> {
        let local = || self.local(seen, column, row, depth);
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
