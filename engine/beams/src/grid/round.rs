//! Spheres, cylinders and capsules, intersected pixel by pixel.

use fearless_simd::prelude::*;
use nalgebra::Vector3;

use super::{
    camera::{GridCamera, PixelBounds},
    polygon::ViewTransform,
    raster::{FloatLanes, LANES, NO_SURFACE, Raster, SurfaceFragments, UintLanes},
};
use crate::Faces;

/// A round form prepared for rasterisation; its axis is z.
#[derive(Debug, Clone)]
pub(super) struct RoundForm {
    radius: f64,
    half_length: f64,
    ends: RoundEnds,
    faces: Faces,
    bounds: PixelBounds,
    /// Origin (where depth is 0) and direction (per metre of depth) of the rays in the form's frame: the value for
    /// column 0 and row 0, and the increments per column and per row.
    origin: [Vector3<f64>; 3],
    along: [Vector3<f64>; 3],
    perspective: bool,
    near: f64,
    far: f64,
    id: u32,
}

/// The ends of a round form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RoundEnds {
    Flat,
    Round,
    /// The ends are hemispheres with nothing between them.
    Sphere,
}

impl RoundForm {
    pub fn new(
        camera: &GridCamera,
        view_from_form: &ViewTransform,
        (radius, half_length, ends): (f64, f64, RoundEnds),
        faces: Faces,
        id: u32,
    ) -> Option<Self> {
        if !(radius > 0.0 && half_length >= 0.0) {
            return None;
        }
        let tip = half_length + if ends == RoundEnds::Flat { 0.0 } else { radius };
        let half = Vector3::new(radius, radius, tip);
        let bounds = camera.bounds(&view_from_form.corners(&Vector3::zeros(), &half))?;
        let faces = Faces {
            back: faces.back && !(faces.front && view_from_form.is_unclipped(camera, &half, &bounds)),
            ..faces
        };
        let back = view_from_form.rotation.transpose();
        let ray = |column: f64, row: f64| camera.ray(column, row);
        let (o, d) = ray(0.0, 0.0);
        let ((ox, dx), (oy, dy)) = (ray(1.0, 0.0), ray(0.0, 1.0));
        Some(Self {
            radius,
            half_length,
            ends,
            faces,
            bounds,
            origin: [back * (o - view_from_form.translation), back * (ox - o), back * (oy - o)],
            along: [back * d, back * (dx - d), back * (dy - d)],
            perspective: camera.perspective,
            near: camera.near,
            far: camera.far,
            id,
        })
    }

    #[inline(always)]
    pub fn draw<S: Simd, const ID: bool>(&self, simd: S, raster: &mut Raster<'_, ID>) {
        let (first, end) = self.bounds.columns;
        for row in self.bounds.rows.0.max(raster.first)..self.bounds.rows.1.min(raster.end) {
            let place = (row - raster.first) * raster.stride;
            let mut column = first;
            while column < end {
                self.block(simd, raster, place, column, row);
                column += LANES;
            }
        }
    }

    /// Rasterises 16 pixels of a row.
    #[inline(always)]
    fn block<S: Simd, const ID: bool>(
        &self,
        simd: S,
        raster: &mut Raster<'_, ID>,
        place: usize,
        column: usize,
        row: usize,
    ) {
        let [o, ox, oy] = &self.origin;
        let [d, dx, dy] = &self.along;
        let (o, d) = (o + oy * row as f64, d + dy * row as f64);
        let mut z = [f64::INFINITY; LANES];
        let mut part = [NO_SURFACE; LANES];
        for i in 0..LANES {
            let x = (column + i) as f64;
            let ray = PixelRay {
                o: [o.x + ox.x * x, o.y + ox.y * x, o.z + ox.z * x],
                d: [d.x + dx.x * x, d.y + dx.y * x, d.z + dx.z * x],
                best: f64::INFINITY,
                part: NO_SURFACE,
            };
            let ray = self.first_crossing(ray);
            z[i] = ray.best;
            part[i] = ray.part;
        }
        let mut w = [0.0; LANES];
        for i in 0..LANES {
            let value = if self.perspective { 1.0 / z[i] } else { -z[i] };
            w[i] = if part[i] == NO_SURFACE { f64::NEG_INFINITY } else { value } as f32;
        }
        let (w, part) = (FloatLanes::load_array(simd, w), UintLanes::load_array(simd, part));
        let inside = part.simd_ne(UintLanes::splat(simd, NO_SURFACE));
        raster.offer(simd, place + column, SurfaceFragments { w, inside, id: part + self.id });
    }

    /// Returns the ray with its first admissible crossing.
    #[inline(always)]
    fn first_crossing(&self, mut ray: PixelRay) -> PixelRay {
        let Self { radius, half_length, .. } = *self;
        let r2 = radius * radius;
        if self.ends != RoundEnds::Sphere {
            let ([ox, oy, oz], [dx, dy, dz]) = (ray.o, ray.d);
            // Computing from the point nearest to the axis avoids cancellation.
            let dd = dx * dx + dy * dy;
            let middle = -(ox * dx + oy * dy) / dd;
            let (qx, qy) = (ox + dx * middle, oy + dy * middle);
            let way = ((r2 - (qx * qx + qy * qy)) / dd).sqrt();
            for (t, wanted) in [(middle - way, self.faces.front), (middle + way, self.faces.back)] {
                let height = oz + dz * t;
                ray.offer(t, wanted & (height <= half_length) & (height >= -half_length), 0, self);
            }
        }
        for (part, up) in [(1, 1.0), (2, -1.0)] {
            let ([ox, oy, oz], [dx, dy, dz]) = (ray.o, ray.d);
            let end = half_length * up;
            if self.ends == RoundEnds::Flat {
                let t = (end - oz) / dz;
                let (x, y) = (ox + dx * t, oy + dy * t);
                let front = dz * up < 0.0;
                let wanted = (front & self.faces.front) | (!front & self.faces.back);
                ray.offer(t, wanted & (x * x + y * y <= r2), part, self);
                continue;
            }
            let sphere = self.ends == RoundEnds::Sphere;
            let oz = oz - end;
            let dd = dx * dx + dy * dy + dz * dz;
            let middle = -(ox * dx + oy * dy + oz * dz) / dd;
            let (qx, qy, qz) = (ox + dx * middle, oy + dy * middle, oz + dz * middle);
            let way = ((r2 - (qx * qx + qy * qy + qz * qz)) / dd).sqrt();
            for (t, wanted) in [(middle - way, self.faces.front), (middle + way, self.faces.back)] {
                let beyond = (oz + dz * t) * up >= 0.0;
                ray.offer(t, wanted & (beyond | sphere), if sphere { 0 } else { part }, self);
            }
            if sphere {
                break;
            }
        }
        ray
    }
}

/// A ray in the form's frame, and its nearest crossing so far.
struct PixelRay {
    o: [f64; 3],
    d: [f64; 3],
    best: f64,
    part: u32,
}

impl PixelRay {
    /// Stores a crossing at depth `t` if it is wanted, within the limits, and nearer than the best so far. A NaN fails
    /// every comparison.
    #[inline(always)]
    fn offer(&mut self, t: f64, wanted: bool, part: u32, round: &RoundForm) {
        let take = wanted & (t < self.best) & (t >= round.near) & (t <= round.far);
        self.best = if take { t } else { self.best };
        self.part = if take { part } else { self.part };
    }
}
