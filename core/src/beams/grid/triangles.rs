//! Triangles of meshes.
//!
//! Vertices are moved to the image and rounded to 1/256 of a pixel. From there on small triangles need whole numbers
//! only, small enough to be exact in single precision, and large ones are exact in double precision: each pixel belongs to
//! exactly one of two neighbours, whatever their size. What reaches behind the camera is drawn by homogeneous edges.

use nalgebra::Vector3;

use super::camera::{Camera, Line};
use super::clusters::{Clusters, Group, MOST_VERTICES};
use super::polygon::ViewFrom;
use super::raster::{Raster, WIDE};
use super::span::{Edge, Face};
use crate::beams::Faces;

/// Parts of a pixel.
const PARTS: f32 = 256.0;
/// Adding and subtracting this rounds to whole numbers.
const ROUND: f32 = 12_582_912.0;
/// Up to here vertices, in parts of a pixel from the middle, are rounded.
const FURTHEST: f32 = 4_194_304.0;
/// Nearer vertices are treated as behind the camera, in metres.
const NEAREST: f32 = 1e-6;
/// Extents of small triangles, in parts of a pixel.
const SMALL: f32 = 8.0 * PARTS;

/// A mesh made ready.
pub(super) struct Triangles<'a> {
    camera: &'a Camera,
    mesh: &'a Clusters,
    /// From the middle of the mesh.
    view_from_mesh: ViewFrom,
    /// The camera in the mesh: its place, or the way its rays go.
    eye: Vector3<f64>,
    faces: Faces,
    id: u32,
}

/// Vertices of a group in the image: column and row in parts of a pixel, `w`. Not a number where they cannot be rounded.
struct Placed {
    x: [f32; MOST_VERTICES],
    y: [f32; MOST_VERTICES],
    w: [f32; MOST_VERTICES],
    /// Whether all could be rounded.
    all: bool,
}

impl<'a> Triangles<'a> {
    pub fn new(
        camera: &'a Camera,
        mesh: &'a Clusters,
        view_from_form: &ViewFrom,
        faces: Faces,
        id: u32,
    ) -> Option<Self> {
        let view_from_mesh = ViewFrom { translation: view_from_form.point(&mesh.centre), ..*view_from_form };
        let bounds = camera.bounds(&view_from_mesh.corners(&Vector3::zeros(), &mesh.half))?;
        let hides = mesh.closed && faces.front && view_from_mesh.clear(camera, &mesh.half, &bounds);
        let back = view_from_mesh.rotation.transpose();
        let eye = if camera.perspective { -(back * view_from_mesh.translation) } else { back * Vector3::z() };
        let faces = Faces { back: faces.back && !hides, ..faces };
        (mesh.half.min() >= 0.0).then_some(Self { camera, mesh, view_from_mesh, eye, faces, id })
    }

    #[inline(always)]
    pub fn draw<const ID: bool>(&self, raster: &mut Raster<'_, ID>) {
        let mut placed =
            Placed { x: [0.0; MOST_VERTICES], y: [0.0; MOST_VERTICES], w: [0.0; MOST_VERTICES], all: true };
        for group in &self.mesh.groups {
            if self.unseen(group, raster.first, raster.end) {
                continue;
            }
            self.place(group, &mut placed);
            let mut at = 0;
            while at < group.triangles {
                self.sixteen(group, at, &placed, raster);
                at += WIDE;
            }
            if !placed.all {
                self.wild(group, &placed, raster);
            }
        }
    }

    /// Whether no triangle of a group is seen in some rows.
    fn unseen(&self, group: &Group, first: usize, end: usize) -> bool {
        let camera = self.camera;
        let (c, r) = (self.view_from_mesh.point(&group.centre), group.radius);
        if c.z + r < camera.near || c.z - r > camera.far {
            return true;
        }
        let (right, (_, middle)) = (0.5 * camera.columns as f64, camera.middle());
        // Half a pixel beyond the middles of the outermost pixels, which is enough for rounding.
        let (low, high) = (first as f64 - 0.5 - middle, end as f64 - 0.5 - middle);
        let depth = if camera.perspective { c.z } else { 1.0 };
        let beyond = |x: f64, border: f64| {
            let over = x * camera.scale - border * depth;
            over > r * if camera.perspective { camera.scale.hypot(border) } else { camera.scale }
        };
        if beyond(c.x, right) || beyond(-c.x, right) || beyond(c.y, high) || beyond(-c.y, -low) {
            return true;
        }
        let toward = if camera.perspective { group.centre - self.eye } else { self.eye };
        let (slack, length) = if camera.perspective { (r, toward.norm()) } else { (0.0, 1.0) };
        let turn = group.axis.dot(&toward);
        let limit = group.sine * length + slack;
        (!self.faces.back && turn > limit) || (!self.faces.front && -turn > limit)
    }

    /// Moves the vertices of a group to the image.
    #[inline(always)]
    fn place(&self, group: &Group, placed: &mut Placed) {
        let camera = self.camera;
        let parts = camera.scale * f64::from(PARTS);
        let ViewFrom { rotation: r, translation: t } = &self.view_from_mesh;
        let row = |i: usize, scale: f64| [r[(i, 0)], r[(i, 1)], r[(i, 2)], t[i]].map(|x| (x * scale) as f32);
        let (mx, my, mz) = (row(0, parts), row(1, parts), row(2, 1.0));
        let middle = camera.middle();
        let (middle_x, middle_y) = (middle.0 as f32 * PARTS, middle.1 as f32 * PARTS);
        let perspective = camera.perspective;
        let mut all = true;
        for from in (0..group.vertices).step_by(WIDE) {
            let at = group.first_vertex + from;
            let [xs, ys, zs] = &self.mesh.vertices;
            let (Some(x), Some(y), Some(z)) =
                (xs[at..].first_chunk::<WIDE>(), ys[at..].first_chunk::<WIDE>(), zs[at..].first_chunk::<WIDE>())
            else {
                return;
            };
            let Some(px) = placed.x[from..].first_chunk_mut::<WIDE>() else { return };
            let Some(py) = placed.y[from..].first_chunk_mut::<WIDE>() else { return };
            let Some(pw) = placed.w[from..].first_chunk_mut::<WIDE>() else { return };
            let mut good = [true; WIDE];
            for i in 0..WIDE {
                let hx = mx[0] * x[i] + mx[1] * y[i] + mx[2] * z[i] + mx[3];
                let hy = my[0] * x[i] + my[1] * y[i] + my[2] * z[i] + my[3];
                let hz = mz[0] * x[i] + mz[1] * y[i] + mz[2] * z[i] + mz[3];
                let inverse = if perspective { 1.0 / hz } else { 1.0 };
                let (sx, sy) = (hx * inverse, hy * inverse);
                let (ax, ay) = (sx.abs(), sy.abs());
                good[i] = (ax < FURTHEST) & (ay < FURTHEST) & (!perspective | (hz > NEAREST));
                px[i] = if good[i] { (sx + ROUND) - ROUND + middle_x } else { f32::NAN };
                py[i] = if good[i] { (sy + ROUND) - ROUND + middle_y } else { f32::NAN };
                pw[i] = if perspective { inverse } else { -hz };
            }
            all &= good.iter().fold(true, |all, good| all & good);
        }
        placed.all = all;
    }

    /// Draws 16 triangles whose vertices could all be rounded.
    #[inline(always)]
    fn sixteen<const ID: bool>(&self, group: &Group, at: usize, placed: &Placed, raster: &mut Raster<'_, ID>) {
        let first = group.first_triangle + at;
        let mut x = [[0.0; WIDE]; 3];
        let mut y = [[0.0; WIDE]; 3];
        for corner in 0..3 {
            let Some(places) = self.mesh.corners[corner][first..].first_chunk::<WIDE>() else { return };
            for i in 0..WIDE {
                x[corner][i] = placed.x[usize::from(places[i]) % MOST_VERTICES];
                y[corner][i] = placed.y[usize::from(places[i]) % MOST_VERTICES];
            }
        }
        let (last_column, low_row) = ((raster.columns - 1) as f32, raster.first as f32);
        let last_row = (raster.end - 1) as f32;
        let mut columns = [[0.0; WIDE]; 2];
        let mut rows = [[0.0; WIDE]; 2];
        let mut small = [false; WIDE];
        let mut large = [false; WIDE];
        for i in 0..WIDE {
            let (x0, x1, x2) = (x[0][i], x[1][i], x[2][i]);
            let (y0, y1, y2) = (y[0][i], y[1][i], y[2][i]);
            let area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0);
            let (low_x, high_x) = (least(least(x0, x1), x2), most(most(x0, x1), x2));
            let (low_y, high_y) = (least(least(y0, y1), y2), most(most(y0, y1), y2));
            let tiny = (high_x - low_x <= SMALL) & (high_y - low_y <= SMALL);
            // The pixels whose middles are in the box around it.
            let column = most((low_x * (1.0 / PARTS)).ceil(), 0.0);
            let column_end = least((high_x * (1.0 / PARTS)).floor(), last_column);
            let row = most((low_y * (1.0 / PARTS)).ceil(), low_row);
            let row_end = least((high_y * (1.0 / PARTS)).floor(), last_row);
            columns[0][i] = column;
            columns[1][i] = column_end;
            rows[0][i] = row;
            rows[1][i] = row_end;
            let covers = (column <= column_end) & (row <= row_end) & (area == area);
            let shown = ((area > 0.0) & self.faces.front) | ((area < 0.0) & self.faces.back);
            small[i] = covers & tiny & shown;
            // Where the area's sign may be rounding, it is looked at again.
            large[i] = covers & !tiny;
        }
        for i in 0..WIDE {
            let corners = || self.mesh.corners.each_ref().map(|c| usize::from(c[first + i]) % MOST_VERTICES);
            let id = self.id + self.mesh.primitive[first + i];
            if small[i] {
                let [a, b, c] = corners();
                let place = |k: usize| [placed.x[k], placed.y[k], placed.w[k]];
                let from = (columns[0][i], rows[0][i]);
                let to = (columns[1][i], rows[1][i]);
                small_triangle(raster, [place(a), place(b), place(c)], from, to, id);
            } else if large[i] {
                self.large(group, corners(), placed, id, raster);
            }
        }
    }

    /// Draws those triangles of a group of which a vertex could not be rounded.
    #[inline(never)]
    fn wild<const ID: bool>(&self, group: &Group, placed: &Placed, raster: &mut Raster<'_, ID>) {
        for at in group.first_triangle..group.first_triangle + group.triangles {
            let corners = self.mesh.corners.each_ref().map(|c| usize::from(c[at]));
            if corners.iter().any(|c| placed.x[*c].is_nan()) {
                self.large(group, corners, placed, self.id + self.mesh.primitive[at], raster);
            }
        }
    }

    /// Draws a triangle of any size and place.
    #[inline(never)]
    fn large<const ID: bool>(
        &self,
        group: &Group,
        corners: [usize; 3],
        placed: &Placed,
        id: u32,
        raster: &mut Raster<'_, ID>,
    ) {
        let camera = self.camera;
        let parts = f64::from(PARTS);
        let middle = camera.middle();
        let points = corners.map(|c| self.view_from_mesh.point(&self.mesh.vertex(group.first_vertex + c)));
        let rounded = corners.map(|c| !placed.x[c].is_nan());
        // Relative to the first pixel, in parts of a pixel.
        let place: [Vector3<f64>; 3] = std::array::from_fn(|k| {
            if rounded[k] {
                return Vector3::new(f64::from(placed.x[corners[k]]), f64::from(placed.y[corners[k]]), 1.0);
            }
            let h = camera.homogeneous(&points[k]);
            Vector3::new((h.x + middle.0 * h.z) * parts, (h.y + middle.1 * h.z) * parts, h.z)
        });
        let all = rounded.iter().all(|r| *r);
        let area = if all {
            let (u, v) = (place[1] - place[0], place[2] - place[0]);
            u.x * v.y - u.y * v.x
        } else {
            place[0].cross(&place[1]).dot(&place[2])
        };
        let front = area > 0.0;
        if !(area != 0.0 && area.is_finite()) || !(if front { self.faces.front } else { self.faces.back }) {
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
            let [a, b, c] = corners.map(|c| placed.w[c]);
            limits = (least(least(a, b), c), most(most(a, b), c));
            let y = place.map(|p| p.y / parts);
            let (low, high) = (y[0].min(y[1]).min(y[2]), y[0].max(y[1]).max(y[2]));
            rows = (low.ceil().max(0.0) as usize, (high.floor() + 1.0).max(0.0) as usize);
        }
        if ![w.a, w.b, w.c].iter().all(|x| x.is_finite()) {
            // Seen exactly from the side.
            w = Line { a: 0.0, b: 0.0, c: f64::from(limits.1) };
        }
        Face { edges: &edges, w, limits, id }.draw(raster, rows);
    }
}

/// Draws a triangle of at most 8 x 8 pixels by blocks of 4 x 4; corners hold column and row in parts of a pixel, and `w`.
#[inline(always)]
fn small_triangle<const ID: bool>(
    raster: &mut Raster<'_, ID>,
    [a, b, c]: [[f32; 3]; 3],
    from: (f32, f32),
    to: (f32, f32),
    id: u32,
) {
    // Relative to the first pixel all numbers are whole and small: sums and products are exact.
    let near = |p: [f32; 3]| [p[0] - from.0 * PARTS, p[1] - from.1 * PARTS];
    let ([ax, ay], [mut bx, mut by], [mut cx, mut cy]) = (near(a), near(b), near(c));
    let (aw, mut bw, mut cw) = (a[2], b[2], c[2]);
    let mut area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
    if area < 0.0 {
        ((bx, by, bw), (cx, cy, cw)) = ((cx, cy, cw), (bx, by, bw));
        area = -area;
    }
    // The three borders, opposite of corners a, b and c: x and y times these, and the value at the first pixel.
    let border = |x0: f32, y0: f32, x1: f32, y1: f32| {
        let (u, v) = (y0 - y1, x1 - x0);
        // A pixel on a border belongs to the area on its right, or above.
        let mine = (u > 0.0) | ((u == 0.0) & (v > 0.0));
        (u * PARTS, v * PARTS, -(u * x0 + v * y0) - if mine { 0.0 } else { 1.0 })
    };
    let (e0, e1, e2) = (border(bx, by, cx, cy), border(cx, cy, ax, ay), border(ax, ay, bx, by));
    let (k1, k2) = ((bw - aw) / area, (cw - aw) / area);
    let (column, row) = (from.0 as usize, from.1 as usize);
    let (last_x, last_y) = (to.0 as usize - column, to.1 as usize - row);
    let mut y = 0;
    while y <= last_y {
        let mut x = 0;
        while x <= last_x {
            let place = (row + y - raster.first) * raster.stride + column + x;
            let start = |e: (f32, f32, f32)| e.2 + e.0 * x as f32 + e.1 * y as f32;
            let (s0, s1, s2) = (start(e0), start(e1), start(e2));
            let mut w = [0.0; WIDE];
            let mut inside = [false; WIDE];
            for i in 0..WIDE {
                let (u, v) = ((i % 4) as f32, (i / 4) as f32);
                let v0 = s0 + e0.0 * u + e0.1 * v;
                let v1 = s1 + e1.0 * u + e1.1 * v;
                let v2 = s2 + e2.0 * u + e2.1 * v;
                inside[i] = (v0 >= 0.0) & (v1 >= 0.0) & (v2 >= 0.0);
                w[i] = aw + (v1 * k1 + v2 * k2);
            }
            raster.offer_block(place, &w, &inside, id);
            x += 4;
        }
        y += 4;
    }
}

/// The lesser of two numbers as processors compute it.
#[inline(always)]
fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The greater.
#[inline(always)]
fn most(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
