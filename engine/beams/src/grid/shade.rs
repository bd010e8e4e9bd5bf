//! Shading: converts the surface numbers in the buffer to tags, normals and colours, pixel by pixel.
//!
//! The lighting model is simple: ambient light, a headlight and a sun on matt surfaces. It needs no graphics hardware
//! and gives the same bytes on all machines.

use std::ops::Range;

use fearless_simd::Level;
use nalgebra::Vector3;
use tatu_geometry::{Form, TexturedSurface};

use super::{
    GridCast,
    camera::GridCamera,
    image::ImageBand,
    light::{brightness, to_byte},
    polygon::ViewTransform,
    raster::{NO_SURFACE, Raster},
};
use crate::{BeamScene, BeamTarget, simd::dispatch};

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
    /// Buffers: the cosines of the normals, or the sums of the lamps; one channel of the picture.
    cosine: Vec<f32>,
    bytes: Vec<u8>,
}

impl PixelRow {
    fn new(columns: usize) -> Self {
        let some = || vec![0.0; columns];
        Self {
            normal: [some(), some(), some()],
            color: [some(), some(), some()],
            visible: some(),
            cosine: some(),
            bytes: vec![0; columns],
        }
    }
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
    /// Whether the outward normal varies.
    round: bool,
    /// The texture, if the primitive has one.
    texture: Option<TexturedSurface<'a>>,
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
    pub fn shade<const ID: bool>(&self, level: Level, raster: &Raster<'_, ID>, part: &mut ImageBand<'_>) {
        let want = self.cast.outputs;
        let columns = raster.columns;
        let mut line = PixelRow::new(columns);
        let mut seen = None;
        for row in raster.first..raster.end {
            let first = (row - raster.first) * columns;
            let ids = &raster.id[(row - raster.first) * raster.stride..][..columns];
            let mut begin = 0;
            // Neighbouring pixels that show the same primitive are processed together.
            for run in ids.chunk_by(|a, b| a == b) {
                let (id, columns) = (run[0], begin..begin + run.len());
                begin = columns.end;
                if id != NO_SURFACE && seen.as_ref().is_none_or(|seen: &CachedPrimitive<'_>| seen.id != id) {
                    seen = self.find_primitive(id, seen.as_ref().map_or(0, |seen| seen.at));
                }
                let here = seen.as_ref().filter(|_| id != NO_SURFACE);
                let pixels = first + columns.start..first + columns.end;
                if want.object {
                    part.object[pixels.clone()].fill(here.map_or(0, |seen| seen.target.object));
                }
                if want.primitive {
                    part.primitive[pixels.clone()].fill(here.map_or(0, |seen| seen.primitive));
                }
                if want.cosine || want.normal || want.color {
                    self.look_up(here, row, columns, &part.depth[pixels], &mut line);
                }
            }
            if want.cosine || want.normal || want.color {
                dispatch!(level, _simd => self.shade_row(row, first..first + columns, &mut line, part));
            }
        }
    }

    /// Collects the inputs of the shading of pixels of a row that show the same primitive, or none.
    fn look_up(
        &self,
        seen: Option<&CachedPrimitive<'_>>,
        row: usize,
        columns: Range<usize>,
        depths: &[f32],
        line: &mut PixelRow,
    ) {
        let fill = |channels: &mut [Vec<f32>; 3], values: [f32; 3]| {
            for (channel, value) in channels.iter_mut().zip(values) {
                channel[columns.clone()].fill(value);
            }
        };
        line.visible[columns.clone()].fill(if seen.is_some() { 1.0 } else { 0.0 });
        let Some(seen) = seen else {
            fill(&mut line.normal, [0.0; 3]);
            fill(&mut line.color, self.cast.light.sky);
            return;
        };
        if seen.round {
            for (column, depth) in columns.clone().zip(depths) {
                let normal = self.normal(seen, column, row, *depth);
                for i in 0..3 {
                    line.normal[i][column] = normal[i];
                }
            }
        } else {
            fill(&mut line.normal, seen.normal.into());
        }
        let Some(texture) = &seen.texture else {
            fill(&mut line.color, seen.target.color);
            return;
        };
        let form_from_view = seen.view_from_form.rotation.transpose();
        for (column, depth) in columns.zip(depths) {
            let point = self.local(seen, column, row, *depth).into();
            let normal =
                || form_from_view * Vector3::from(line.normal.each_ref().map(|channel| f64::from(channel[column])));
            let color = texture.color(&point, normal, seen.target.color);
            for (channel, value) in line.color.iter_mut().zip(color) {
                channel[column] = value;
            }
        }
    }

    /// Computes cosines, normals and colours of a row, in branch-free loops that compilers can vectorize.
    #[inline(always)]
    fn shade_row(&self, row: usize, pixels: Range<usize>, line: &mut PixelRow, part: &mut ImageBand<'_>) {
        let (want, light) = (self.cast.outputs, self.cast.light);
        let columns = pixels.len();
        let middle = self.camera.middle();
        let (size, perspective) = ((1.0 / self.camera.scale) as f32, self.camera.perspective);
        let y = if perspective { (row as f64 - middle.1) as f32 * size } else { 0.0 };
        let (middle, size) = (middle.0 as f32, if perspective { size } else { 0.0 });
        let [nx, ny, nz] = line.normal.each_ref().map(|channel| &channel[..columns]);
        let cosines = &mut line.cosine[..columns];
        for i in 0..columns {
            // Cosine of the outward normal; negative where the inside is visible.
            let x = (i as i32 as f32 - middle) * size;
            cosines[i] = -(nx[i] * x + ny[i] * y + nz[i]) / (x * x + y * y + 1.0).sqrt();
        }
        let toward = |cosine: f32| if cosine < 0.0 { -1.0 } else { 1.0 };
        if want.cosine {
            for (out, cosine) in part.cosine[pixels.clone()].iter_mut().zip(&*cosines) {
                *out = cosine.abs().min(1.0);
            }
        }
        if want.normal {
            for (i, out) in part.normal[pixels.clone()].iter_mut().enumerate() {
                let side = toward(cosines[i]);
                *out = [0.0 - nx[i] * side, ny[i] * side, nz[i] * side];
            }
        }
        if want.color {
            let visible = &line.visible[..columns];
            let sums = cosines;
            for i in 0..columns {
                let sun = (nx[i] * self.sun.x + ny[i] * self.sun.y + nz[i] * self.sun.z) * toward(sums[i]);
                let sum = brightness(light, sums[i].abs(), sun, 1.0);
                sums[i] = if visible[i] > 0.0 { sum } else { 1.0 };
            }
            let bytes = &mut line.bytes[..columns];
            let out = &mut part.color[pixels];
            for (i, channel) in line.color.iter().enumerate() {
                for ((byte, value), sum) in bytes.iter_mut().zip(channel).zip(&*sums) {
                    *byte = to_byte(value * sum);
                }
                for (out, byte) in out.iter_mut().zip(&*bytes) {
                    out[i] = *byte;
                }
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
        let round = match &target.form {
            Form::Sphere { .. } | Form::Capsule { .. } => true,
            Form::Cylinder { .. } => primitive == 0,
            _ => false,
        };
        let texture = target.texture.as_ref().filter(|_| self.cast.outputs.color);
        let texture = texture.and_then(|texture| texture.on(&target.form, primitive));
        Some(CachedPrimitive { id, at, target, primitive, view_from_form, normal, round, texture })
    }

    /// Returns the surface point at a pixel, in the frame of its form.
    fn local(&self, seen: &CachedPrimitive<'_>, column: usize, row: usize, depth: f32) -> Vector3<f64> {
        let (from, along) = self.camera.ray(column as f64, row as f64);
        let point = from + along * f64::from(depth) - seen.view_from_form.translation;
        seen.view_from_form.rotation.transpose() * point
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
