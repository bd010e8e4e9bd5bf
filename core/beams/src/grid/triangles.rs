//! Triangles of meshes, rasterised 16 at a time.
//!
//! Corners are projected to the image and rounded to 1/256 of a pixel. Edge functions of small triangles are then exact
//! in single precision, and those of large ones in double precision, so each pixel belongs to exactly one of two
//! neighbours, regardless of their sizes. Triangles that extend behind the camera are rasterised by homogeneous edges.

use std::ops::Range;

use fearless_simd::{Level, f64x8, mask64x8, prelude::*};
use nalgebra::Vector3;

use super::{
    bands::Bands,
    camera::{Camera, Line},
    clusters::{Clusters, Groups, ROW, Sixteen},
    polygon::ViewFrom,
    raster::{F, M, Raster, U, WIDE},
    small::{PARTS, Placed, Small, stored},
    span::{Edge, Face},
};
use crate::{
    Faces,
    simd::{dispatch, greatest, least},
};

/// One value for each group of a row of groups.
type D<S> = f64x8<S>;

/// A constant whose addition and subsequent subtraction round to an integer.
const ROUND: f32 = 12_582_912.0;
/// Maximum distance of a corner from the image centre at which it is rounded, in sub-pixel steps.
const FURTHEST: f32 = 4_194_304.0;
/// Minimum depth of a corner, in metres. Nearer corners are treated as behind the camera.
const NEAREST: f32 = 1e-6;
/// Extent below which a triangle is small, in sub-pixel steps.
const SMALL: f32 = 8.0 * PARTS;

/// A mesh prepared for rasterisation.
pub(super) struct Triangles<'a> {
    camera: &'a Camera,
    mesh: &'a Clusters,
    /// Transform from the frame at the centre of the mesh to the view.
    view_from_mesh: ViewFrom,
    /// Coefficients for the column, the row (both in sub-pixel steps from the image centre) and the depth of a corner.
    moves: [[f32; 4]; 3],
    faces: Faces,
    id: u32,
    /// The position of the camera in the frame of the mesh; for an orthographic view, the direction of its rays.
    eye: Vector3<f64>,
}

impl<'a> Triangles<'a> {
    pub fn new(
        camera: &'a Camera,
        mesh: &'a Clusters,
        view_from_mesh: ViewFrom,
        faces: Faces,
        id: u32,
    ) -> Option<Self> {
        if mesh.half.min() < 0.0 {
            return None;
        }
        let bounds = camera.bounds(&view_from_mesh.corners(&Vector3::zeros(), &mesh.half))?;
        let hides = mesh.closed && faces.front && view_from_mesh.clear(camera, &mesh.half, &bounds);
        let faces = Faces { back: faces.back && !hides, ..faces };
        let parts = camera.scale * f64::from(PARTS);
        let ViewFrom { rotation: r, translation: t } = &view_from_mesh;
        let row = |i: usize, scale: f64| [r[(i, 0)], r[(i, 1)], r[(i, 2)], t[i]].map(|x| (x * scale) as f32);
        let moves = [row(0, parts), row(1, parts), row(2, 1.0)];
        let back = r.transpose();
        let eye = if camera.perspective { -(back * t) } else { back * Vector3::z() };
        Some(Self { camera, mesh, view_from_mesh, moves, faces, id, eye })
    }

    /// Returns the number of rows of groups to test.
    pub fn groups(&self) -> usize {
        self.mesh.groups.len()
    }

    /// Returns, for each band, the given groups that may be visible in it, as ranges of vectors (first, end).
    pub fn look(&self, level: Level, groups: Range<usize>, bands: Bands) -> Vec<Vec<(u32, u32)>> {
        let mut seen = vec![Vec::with_capacity(groups.len() * ROW / bands.count()); bands.count()];
        dispatch!(level, simd => self.look_with(simd, &self.mesh.groups[groups], bands, &mut seen));
        seen
    }

    #[inline(always)]
    fn look_with<S: Simd>(&self, simd: S, groups: &[Groups], bands: Bands, seen: &mut [Vec<(u32, u32)>]) {
        let (camera, eye) = (self.camera, &self.eye);
        let ViewFrom { rotation: m, translation: t } = &self.view_from_mesh;
        let number = |x: f64| D::splat(simd, x);
        let (one, nothing) = (number(1.0), number(0.0));
        let middle = camera.middle();
        for groups in groups {
            let [x, y, z] = groups.centre.each_ref().map(|v| D::load_array_ref(simd, v));
            let r = D::load_array_ref(simd, &groups.radius);
            let placed = |i: usize| x * m[(i, 0)] + y * m[(i, 1)] + z * m[(i, 2)] + t[i];
            let (cx, cy, cz) = (placed(0), placed(1), placed(2));
            let mut out = (cz + r).simd_lt(camera.near) | (cz - r).simd_gt(camera.far);
            // Determine which sides of each group face the camera.
            let toward =
                if camera.perspective { [x - eye.x, y - eye.y, z - eye.z] } else { [eye.x, eye.y, eye.z].map(number) };
            let [tx, ty, tz] = toward;
            let (slack, length) =
                if camera.perspective { (r, (tx * tx + ty * ty + tz * tz).sqrt()) } else { (nothing, one) };
            let [ax, ay, az] = groups.axis.each_ref().map(|v| D::load_array_ref(simd, v));
            let turn = ax * tx + ay * ty + az * tz;
            let limit = D::load_array_ref(simd, &groups.sine) * length + slack;
            if !self.faces.back {
                out |= turn.simd_gt(limit);
            }
            if !self.faces.front {
                out |= (-turn).simd_gt(limit);
            }
            // Compute the bounding box of the sphere, in pixels.
            let whole = (cz - r).simd_lt(1e-6) & mask64x8::splat(simd, camera.perspective);
            let (front, behind) = if camera.perspective { (one / (cz - r), one / (cz + r)) } else { (one, one) };
            let range = |c: D<S>, middle: f64, count: usize| {
                let (low, high) = ((c - r) * camera.scale, (c + r) * camera.scale);
                let (near, far) = (low * front, low * behind);
                let low = least(near, far) + (middle - 1.0);
                let (near, far) = (high * front, high * behind);
                let high = greatest(near, far) + (middle + 2.0);
                let count = number(count as f64);
                let clamped = |v: D<S>| least(greatest(v, nothing), count);
                (whole.select(nothing, clamped(low)), whole.select(count, clamped(high)))
            };
            let (columns, rows) = (range(cx, middle.0, camera.columns), range(cy, middle.1, camera.rows));
            // Compare whole pixels.
            let empty = |(low, high): (D<S>, D<S>)| low.trunc().simd_ge(high.trunc());
            out |= empty(columns) | empty(rows);
            let mut left = !out.to_bitmask() & 0xff;
            let (low, high) = (rows.0.as_array(), rows.1.as_array());
            while left != 0 {
                let lane = left.trailing_zeros() as usize % ROW;
                left &= left - 1;
                let sixteens = groups.sixteens[lane];
                if sixteens.0 < sixteens.1 {
                    for band in bands.reached((low[lane] as u32, high[lane] as u32)) {
                        seen[band].push(sixteens);
                    }
                }
            }
        }
    }

    /// Rasterises a range of vectors, given as (first, end).
    #[inline(always)]
    pub fn draw<S: Simd, const ID: bool>(&self, simd: S, sixteens: (u32, u32), raster: &mut Raster<'_, ID>) {
        let sixteens = sixteens.0 as usize..sixteens.1 as usize;
        for (sixteen, primitive) in self.mesh.sixteens[sixteens.clone()].iter().zip(&self.mesh.primitives[sixteens]) {
            self.draw_sixteen(simd, sixteen, primitive, raster);
        }
    }

    /// Projects 16 corners to the image.
    #[inline(always)]
    fn place<S: Simd>(&self, simd: S, corner: &[[f32; WIDE]; 3]) -> Placed<S> {
        let (x, y) = (F::load_array_ref(simd, &corner[0]), F::load_array_ref(simd, &corner[1]));
        let point = (x, y, F::load_array_ref(simd, &corner[2]));
        let (hx, hy) = (moved(point, &self.moves[0]), moved(point, &self.moves[1]));
        let hz = moved(point, &self.moves[2]);
        let middle = self.camera.middle();
        let (x, y, w, ahead) = if self.camera.perspective {
            let w = F::splat(simd, 1.0) / hz;
            (hx * w, hy * w, w, hz.simd_gt(NEAREST))
        } else {
            (hx, hy, -hz, M::splat(simd, true))
        };
        let good = x.abs().simd_lt(FURTHEST) & y.abs().simd_lt(FURTHEST) & ahead;
        let nan = F::splat(simd, f32::NAN);
        let x = good.select((x + ROUND) - ROUND + middle.0 as f32 * PARTS, nan);
        let y = good.select((y + ROUND) - ROUND + middle.1 as f32 * PARTS, nan);
        Placed { x, y, w }
    }

    #[inline(always)]
    fn draw_sixteen<S: Simd, const ID: bool>(
        &self,
        simd: S,
        sixteen: &Sixteen,
        primitive: &[u32; WIDE],
        raster: &mut Raster<'_, ID>,
    ) {
        let [a, b, c] = &sixteen.corners;
        let (a, b, c) = (self.place(simd, a), self.place(simd, b), self.place(simd, c));
        let area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
        let (low_x, high_x) = (least(least(a.x, b.x), c.x), greatest(greatest(a.x, b.x), c.x));
        let (low_y, high_y) = (least(least(a.y, b.y), c.y), greatest(greatest(a.y, b.y), c.y));
        let tiny = (high_x - low_x).simd_lt(SMALL) & (high_y - low_y).simd_lt(SMALL);
        // The pixels of the band whose centres are in the bounding box.
        let (column, row) =
            (greatest(up(low_x), F::splat(simd, 0.0)), greatest(up(low_y), F::splat(simd, raster.first as f32)));
        let column_end = least(down(high_x), F::splat(simd, (raster.columns - 1) as f32));
        let row_end = least(down(high_y), F::splat(simd, (raster.end - 1) as f32));
        // NaN areas come from corners that could not be rounded.
        let placed = area.simd_eq(area);
        let covers = column.simd_le(column_end) & row.simd_le(row_end) & placed;
        let front = area.simd_gt(0.0) & M::splat(simd, self.faces.front);
        let shown = front | (area.simd_lt(0.0) & M::splat(simd, self.faces.back));
        let small = (covers & tiny & shown).to_bitmask();
        // Large triangles, and those whose corners could not be rounded, are rasterised in double precision.
        let mut rest = ((covers & !tiny) | !placed).to_bitmask();
        if small != 0 {
            let pixels = [(column, row), (column_end, row_end)];
            let ids = U::load_array_ref(simd, primitive) + self.id;
            let small_ones = Small::new(simd, [a, b, c], area, pixels, ids);
            small_ones.draw(simd, small, raster);
        }
        if rest != 0 {
            let placed = [stored(a.x), stored(a.y), stored(a.w), stored(b.x), stored(b.y), stored(b.w)];
            let last = [stored(c.x), stored(c.y), stored(c.w)];
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize % WIDE;
                rest &= rest - 1;
                let [ax, ay, aw, bx, by, bw] = placed.each_ref().map(|v| v[lane]);
                let [cx, cy, cw] = last.each_ref().map(|v| v[lane]);
                let id = self.id.wrapping_add(primitive[lane]);
                self.draw_large(simd, (sixteen, lane, id), [[ax, ay, aw], [bx, by, bw], [cx, cy, cw]], raster);
            }
        }
    }

    /// Rasterises a triangle of any size and position.
    #[inline(always)]
    fn draw_large<S: Simd, const ID: bool>(
        &self,
        simd: S,
        (sixteen, lane, id): (&Sixteen, usize, u32),
        placed: [[f32; 3]; 3],
        raster: &mut Raster<'_, ID>,
    ) {
        let camera = self.camera;
        let parts = f64::from(PARTS);
        let middle = camera.middle();
        let points = [0, 1, 2].map(|k| self.view_from_mesh.point(&sixteen.corner(k, lane)));
        // Position of each corner in sub-pixel steps, relative to the first pixel.
        let place: [Vector3<f64>; 3] = std::array::from_fn(|k| {
            let [x, y, _] = placed[k];
            if !x.is_nan() {
                return Vector3::new(f64::from(x), f64::from(y), 1.0);
            }
            let h = camera.homogeneous(&points[k]);
            Vector3::new((h.x + middle.0 * h.z) * parts, (h.y + middle.1 * h.z) * parts, h.z)
        });
        let all = placed.iter().all(|[x, ..]| !x.is_nan());
        let area = if all {
            let (u, v) = (place[1] - place[0], place[2] - place[0]);
            u.x * v.y - u.y * v.x
        } else {
            place[0].cross(&place[1]).dot(&place[2])
        };
        let front = area > 0.0;
        let wanted = if front { self.faces.front } else { self.faces.back };
        if area == 0.0 || !area.is_finite() || !wanted {
            return;
        }
        let edges: [Edge; 3] = std::array::from_fn(|k| {
            let (a, b) = (&place[k], &place[(k + 1) % 3]);
            let line = if front { a.cross(b) } else { b.cross(a) };
            Edge(Line { a: line.x * parts, b: line.y * parts, c: line.z })
        });
        let normal = (points[1] - points[0]).cross(&(points[2] - points[0]));
        let mut w = camera.plane(&normal, normal.dot(&points[0]));
        let (mut limits, mut rows) = ((f32::NEG_INFINITY, f32::INFINITY), (raster.first, raster.end));
        if all {
            let [a, b, c] = placed.map(|[.., w]| w);
            limits = (a.min(b).min(c), a.max(b).max(c));
            let y = place.map(|p| p.y / parts);
            let (low, high) = (y[0].min(y[1]).min(y[2]), y[0].max(y[1]).max(y[2]));
            rows = (low.ceil().max(0.0) as usize, (high.floor() + 1.0).max(0.0) as usize);
        }
        if ![w.a, w.b, w.c].iter().all(|x| x.is_finite()) {
            // The camera sees the triangle exactly edge-on.
            w = Line { a: 0.0, b: 0.0, c: f64::from(limits.1) };
        }
        Face { edges: &edges, w, limits, id }.draw(simd, raster, rows);
    }
}

/// Applies one row of an affine transform to points.
#[inline(always)]
fn moved<S: Simd>((x, y, z): (F<S>, F<S>, F<S>), m: &[f32; 4]) -> F<S> {
    x * m[0] + y * m[1] + z * m[2] + m[3]
}

/// Returns the first pixel whose centre is not before a position, which is a whole number of sub-pixel steps.
#[inline(always)]
fn up<S: Simd>(place: F<S>) -> F<S> {
    ((place + (0.5 * PARTS - 0.5)) * (1.0 / PARTS) + ROUND) - ROUND
}

/// Returns the last pixel whose centre is not after a position.
#[inline(always)]
fn down<S: Simd>(place: F<S>) -> F<S> {
    ((place - (0.5 * PARTS - 0.5)) * (1.0 / PARTS) + ROUND) - ROUND
}
