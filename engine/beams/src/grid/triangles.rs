//! Triangles of meshes, rasterised 16 at a time.
//!
//! Corners are projected to the image and rounded to 1/256 of a pixel. Edge functions of small triangles are then exact
//! in single precision, and those of large ones in double precision, so each pixel belongs to exactly one of two
//! neighbours, regardless of their sizes. Triangles that extend behind the camera are rasterised by homogeneous edges.

use std::ops::Range;

use fearless_simd::{Level, f64x8, mask64x8, prelude::*};
use nalgebra::Vector3;

use super::{
    bands::RowBands,
    camera::{GridCamera, LinearFunction},
    clusters::{GROUPS_PER_ROW, GroupRow, MeshClusters, TriangleVector},
    polygon::ViewTransform,
    raster::{FloatLanes, LANES, MaskLanes, Raster, UintLanes},
    small_triangles::{ImageCorners, STEPS_PER_PIXEL, SmallTriangles, to_array},
    span::{SpanEdge, SpanFace},
};
use crate::{
    Faces,
    simd::{dispatch, greatest, least},
};

/// One value for each group of a row of groups.
type DoubleLanes<S> = f64x8<S>;

/// A constant whose addition and subsequent subtraction round to an integer.
const ROUNDING_BIAS: f32 = 12_582_912.0;
/// Maximum distance of a corner from the image centre at which it is rounded, in sub-pixel steps.
const MAX_CORNER_STEPS: f32 = 4_194_304.0;
/// Minimum depth of a corner, in metres. Nearer corners are treated as behind the camera.
const MIN_CORNER_DEPTH_M: f32 = 1e-6;
/// Extent below which a triangle is small, in sub-pixel steps.
const MAX_SMALL_STEPS: f32 = 8.0 * STEPS_PER_PIXEL;

/// A mesh prepared for rasterisation.
pub(super) struct PreparedMesh<'a> {
    camera: &'a GridCamera,
    mesh: &'a MeshClusters,
    /// Transform from the frame at the centre of the mesh to the view.
    view_from_mesh: ViewTransform,
    /// Coefficients for the column, the row (both in sub-pixel steps from the image centre) and the depth of a corner.
    projection_rows: [[f32; 4]; 3],
    faces: Faces,
    id: u32,
    /// The position of the camera in the frame of the mesh; for an orthographic view, the direction of its rays.
    eye: Vector3<f64>,
}

impl<'a> PreparedMesh<'a> {
    pub fn new(
        camera: &'a GridCamera,
        mesh: &'a MeshClusters,
        view_from_mesh: ViewTransform,
        faces: Faces,
        id: u32,
    ) -> Option<Self> {
        if mesh.half.min() < 0.0 {
            return None;
        }
        let bounds = camera.bounds(&view_from_mesh.corners(&Vector3::zeros(), &mesh.half))?;
        let hides = mesh.closed && faces.front && view_from_mesh.is_unclipped(camera, &mesh.half, &bounds);
        let faces = Faces { back: faces.back && !hides, ..faces };
        let parts = camera.scale * f64::from(STEPS_PER_PIXEL);
        let ViewTransform { rotation: r, translation: t } = &view_from_mesh;
        let row = |i: usize, scale: f64| [r[(i, 0)], r[(i, 1)], r[(i, 2)], t[i]].map(|x| (x * scale) as f32);
        let moves = [row(0, parts), row(1, parts), row(2, 1.0)];
        let back = r.transpose();
        let eye = if camera.perspective { -(back * t) } else { back * Vector3::z() };
        Some(Self { camera, mesh, view_from_mesh, projection_rows: moves, faces, id, eye })
    }

    /// Returns the number of rows of groups to test.
    pub fn group_row_count(&self) -> usize {
        self.mesh.groups.len()
    }

    /// Returns, for each band, the given groups that may be visible in it, as ranges of vectors (first, end).
    pub fn find_visible(&self, level: Level, groups: Range<usize>, bands: RowBands) -> Vec<Vec<(u32, u32)>> {
        let mut seen = vec![Vec::with_capacity(groups.len() * GROUPS_PER_ROW / bands.count()); bands.count()];
        dispatch!(level, simd => self.find_visible_with(simd, &self.mesh.groups[groups], bands, &mut seen));
        seen
    }

    #[inline(always)]
    fn find_visible_with<S: Simd>(&self, simd: S, groups: &[GroupRow], bands: RowBands, seen: &mut [Vec<(u32, u32)>]) {
        let (camera, eye) = (self.camera, &self.eye);
        let ViewTransform { rotation: m, translation: t } = &self.view_from_mesh;
        let number = |x: f64| DoubleLanes::splat(simd, x);
        let (one, nothing) = (number(1.0), number(0.0));
        let middle = camera.middle();
        for groups in groups {
            let [x, y, z] = groups.centre.each_ref().map(|v| DoubleLanes::load_array_ref(simd, v));
            let r = DoubleLanes::load_array_ref(simd, &groups.radius);
            let placed = |i: usize| x * m[(i, 0)] + y * m[(i, 1)] + z * m[(i, 2)] + t[i];
            let (cx, cy, cz) = (placed(0), placed(1), placed(2));
            let mut out = (cz + r).simd_lt(camera.near) | (cz - r).simd_gt(camera.far);
            // Determine which sides of each group face the camera.
            let toward =
                if camera.perspective { [x - eye.x, y - eye.y, z - eye.z] } else { [eye.x, eye.y, eye.z].map(number) };
            let [tx, ty, tz] = toward;
            let (slack, length) =
                if camera.perspective { (r, (tx * tx + ty * ty + tz * tz).sqrt()) } else { (nothing, one) };
            let [ax, ay, az] = groups.axis.each_ref().map(|v| DoubleLanes::load_array_ref(simd, v));
            let turn = ax * tx + ay * ty + az * tz;
            let limit = DoubleLanes::load_array_ref(simd, &groups.sine) * length + slack;
            if !self.faces.back {
                out |= turn.simd_gt(limit);
            }
            if !self.faces.front {
                out |= (-turn).simd_gt(limit);
            }
            // Compute the bounding box of the sphere, in pixels.
            let whole = (cz - r).simd_lt(1e-6) & mask64x8::splat(simd, camera.perspective);
            let (front, behind) = if camera.perspective { (one / (cz - r), one / (cz + r)) } else { (one, one) };
            let range = |c: DoubleLanes<S>, middle: f64, count: usize| {
                let (low, high) = ((c - r) * camera.scale, (c + r) * camera.scale);
                let (near, far) = (low * front, low * behind);
                let low = least(near, far) + (middle - 1.0);
                let (near, far) = (high * front, high * behind);
                let high = greatest(near, far) + (middle + 2.0);
                let count = number(count as f64);
                let clamped = |v: DoubleLanes<S>| least(greatest(v, nothing), count);
                (whole.select(nothing, clamped(low)), whole.select(count, clamped(high)))
            };
            let (columns, rows) = (range(cx, middle.0, camera.columns), range(cy, middle.1, camera.rows));
            // Compare whole pixels.
            let empty = |(low, high): (DoubleLanes<S>, DoubleLanes<S>)| low.trunc().simd_ge(high.trunc());
            out |= empty(columns) | empty(rows);
            let mut left = !out.to_bitmask() & 0xff;
            let (low, high) = (rows.0.as_array(), rows.1.as_array());
            while left != 0 {
                let lane = left.trailing_zeros() as usize % GROUPS_PER_ROW;
                left &= left - 1;
                let sixteens = groups.vectors[lane];
                if sixteens.0 < sixteens.1 {
                    for band in bands.overlapping((low[lane] as u32, high[lane] as u32)) {
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
        for (sixteen, primitive) in self.mesh.vectors[sixteens.clone()].iter().zip(&self.mesh.primitives[sixteens]) {
            self.draw_vector(simd, sixteen, primitive, raster);
        }
    }

    /// Projects 16 corners to the image.
    #[inline(always)]
    fn project_corners<S: Simd>(&self, simd: S, corner: &[[f32; LANES]; 3]) -> ImageCorners<S> {
        let (x, y) = (FloatLanes::load_array_ref(simd, &corner[0]), FloatLanes::load_array_ref(simd, &corner[1]));
        let point = (x, y, FloatLanes::load_array_ref(simd, &corner[2]));
        let (hx, hy) = (transform_row(point, &self.projection_rows[0]), transform_row(point, &self.projection_rows[1]));
        let hz = transform_row(point, &self.projection_rows[2]);
        let middle = self.camera.middle();
        let (x, y, w, ahead) = if self.camera.perspective {
            let w = FloatLanes::splat(simd, 1.0) / hz;
            (hx * w, hy * w, w, hz.simd_gt(MIN_CORNER_DEPTH_M))
        } else {
            (hx, hy, -hz, MaskLanes::splat(simd, true))
        };
        let good = x.abs().simd_lt(MAX_CORNER_STEPS) & y.abs().simd_lt(MAX_CORNER_STEPS) & ahead;
        let nan = FloatLanes::splat(simd, f32::NAN);
        let x = good.select((x + ROUNDING_BIAS) - ROUNDING_BIAS + middle.0 as f32 * STEPS_PER_PIXEL, nan);
        let y = good.select((y + ROUNDING_BIAS) - ROUNDING_BIAS + middle.1 as f32 * STEPS_PER_PIXEL, nan);
        ImageCorners { x, y, w }
    }

    #[inline(always)]
    fn draw_vector<S: Simd, const ID: bool>(
        &self,
        simd: S,
        sixteen: &TriangleVector,
        primitive: &[u32; LANES],
        raster: &mut Raster<'_, ID>,
    ) {
        let [a, b, c] = &sixteen.corners;
        let (a, b, c) = (self.project_corners(simd, a), self.project_corners(simd, b), self.project_corners(simd, c));
        let area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
        let (low_x, high_x) = (least(least(a.x, b.x), c.x), greatest(greatest(a.x, b.x), c.x));
        let (low_y, high_y) = (least(least(a.y, b.y), c.y), greatest(greatest(a.y, b.y), c.y));
        let tiny = (high_x - low_x).simd_lt(MAX_SMALL_STEPS) & (high_y - low_y).simd_lt(MAX_SMALL_STEPS);
        // The pixels of the band whose centres are in the bounding box.
        let (column, row) = (
            greatest(first_pixel(low_x), FloatLanes::splat(simd, 0.0)),
            greatest(first_pixel(low_y), FloatLanes::splat(simd, raster.first as f32)),
        );
        let column_end = least(last_pixel(high_x), FloatLanes::splat(simd, (raster.columns - 1) as f32));
        let row_end = least(last_pixel(high_y), FloatLanes::splat(simd, (raster.end - 1) as f32));
        // NaN areas come from corners that could not be rounded.
        let placed = area.simd_eq(area);
        let covers = column.simd_le(column_end) & row.simd_le(row_end) & placed;
        let front = area.simd_gt(0.0) & MaskLanes::splat(simd, self.faces.front);
        let shown = front | (area.simd_lt(0.0) & MaskLanes::splat(simd, self.faces.back));
        let small = (covers & tiny & shown).to_bitmask();
        // Large triangles, and those whose corners could not be rounded, are rasterised in double precision.
        let mut rest = ((covers & !tiny) | !placed).to_bitmask();
        if small != 0 {
            let pixels = [(column, row), (column_end, row_end)];
            let ids = UintLanes::load_array_ref(simd, primitive) + self.id;
            let small_ones = SmallTriangles::new(simd, [a, b, c], area, pixels, ids);
            small_ones.draw(simd, small, raster);
        }
        if rest != 0 {
            let placed = [to_array(a.x), to_array(a.y), to_array(a.w), to_array(b.x), to_array(b.y), to_array(b.w)];
            let last = [to_array(c.x), to_array(c.y), to_array(c.w)];
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize % LANES;
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
        (sixteen, lane, id): (&TriangleVector, usize, u32),
        placed: [[f32; 3]; 3],
        raster: &mut Raster<'_, ID>,
    ) {
        let camera = self.camera;
        let parts = f64::from(STEPS_PER_PIXEL);
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
        let edges: [SpanEdge; 3] = std::array::from_fn(|k| {
            let (a, b) = (&place[k], &place[(k + 1) % 3]);
            let line = if front { a.cross(b) } else { b.cross(a) };
            SpanEdge(LinearFunction { a: line.x * parts, b: line.y * parts, c: line.z })
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
            w = LinearFunction { a: 0.0, b: 0.0, c: f64::from(limits.1) };
        }
        SpanFace { edges: &edges, w, limits, id }.draw(simd, raster, rows);
    }
}

/// Applies one row of an affine transform to points.
#[inline(always)]
fn transform_row<S: Simd>((x, y, z): (FloatLanes<S>, FloatLanes<S>, FloatLanes<S>), m: &[f32; 4]) -> FloatLanes<S> {
    x * m[0] + y * m[1] + z * m[2] + m[3]
}

/// Returns the first pixel whose centre is not before a position, which is a whole number of sub-pixel steps.
#[inline(always)]
fn first_pixel<S: Simd>(place: FloatLanes<S>) -> FloatLanes<S> {
    ((place + (0.5 * STEPS_PER_PIXEL - 0.5)) * (1.0 / STEPS_PER_PIXEL) + ROUNDING_BIAS) - ROUNDING_BIAS
}

/// Returns the last pixel whose centre is not after a position.
#[inline(always)]
fn last_pixel<S: Simd>(place: FloatLanes<S>) -> FloatLanes<S> {
    ((place - (0.5 * STEPS_PER_PIXEL - 0.5)) * (1.0 / STEPS_PER_PIXEL) + ROUNDING_BIAS) - ROUNDING_BIAS
}
