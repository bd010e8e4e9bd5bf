//! The working image and the filter operations on it. Colours range from 0 to 1; rows are stored bottom row first.

use serde::{Deserialize, Serialize};

/// The projection of an image: the intrinsics of the camera and its clipping planes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct ImageProjection {
    /// fx, fy, cx, cy, as in the schema `depth_image/1`.
    pub intrinsics: [f64; 4],
    /// Whether the projection is orthographic.
    pub parallel: bool,
    /// Distances of the near and the far plane, m.
    pub planes: [f64; 2],
}

/// A working image and its two buffers.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct WorkingImage {
    pub columns: usize,
    pub rows: usize,
    pub image: Vec<[f32; 3]>,
    pub buffers: [Vec<[f32; 3]>; 2],
}

type Pixel = [f32; 3];

pub(super) fn intensity(p: &Pixel) -> f32 {
    (p[0] + p[1] + p[2]) / 3.0
}

impl WorkingImage {
    pub fn new(columns: usize, rows: usize) -> Self {
        let black = vec![[0.0; 3]; columns * rows];
        WorkingImage { columns, rows, image: black.clone(), buffers: [black.clone(), black] }
    }

    pub fn set_rgb(&mut self, rgb: &[u8]) {
        self.image.clear();
        self.image.extend(rgb.as_chunks::<3>().0.iter().map(|p| p.map(|x| f32::from(x) / 255.0)));
        self.image.resize(self.columns * self.rows, [0.0; 3]);
    }
    pub fn rgb(&self) -> Vec<u8> {
        self.image.iter().flat_map(|p| p.map(|x| (x.clamp(0.0, 1.0) * 255.0).round() as u8)).collect()
    }
    pub fn set_depth(&mut self, depth: &[f32]) {
        self.image.clear();
        self.image.extend(depth.iter().map(|z| [*z; 3]));
        self.image.resize(self.columns * self.rows, [0.0; 3]);
    }
    pub fn depth(&self) -> Vec<f32> {
        self.image.iter().map(|p| intensity(p).clamp(0.0, 1.0)).collect()
    }

    fn each(&mut self, f: impl Fn(Pixel) -> Pixel) {
        self.image.iter_mut().for_each(|p| *p = f(*p));
    }
    pub fn uniform(&mut self, color: Pixel) {
        self.image.fill(color);
    }
    /// Combines the image with a buffer, value by value; results are clamped to 0..1.
    pub fn with_buffer(&mut self, which: usize, f: impl Fn(f32, f32) -> f32) {
        for (p, b) in self.image.iter_mut().zip(&self.buffers[which]) {
            for (x, y) in p.iter_mut().zip(b) {
                *x = f(*x, *y).clamp(0.0, 1.0);
            }
        }
    }
    /// Combines a buffer with the image, value by value, and stores the results, clamped to 0..1, in the buffer.
    pub fn write_buffer(&mut self, which: usize, f: impl Fn(f32, f32) -> f32) {
        for (p, b) in self.image.iter().zip(&mut self.buffers[which]) {
            for (x, y) in p.iter().zip(b) {
                *y = f(*y, *x).clamp(0.0, 1.0);
            }
        }
    }
    pub fn flip(&mut self, horizontal: bool, vertical: bool) {
        let all = self.image.clone();
        for (i, p) in self.image.iter_mut().enumerate() {
            let (c, r) = (i % self.columns, i / self.columns);
            let c = if horizontal { self.columns - 1 - c } else { c };
            let r = if vertical { self.rows - 1 - r } else { r };
            *p = all[r * self.columns + c];
        }
    }
    /// Stretches the values so that the smallest one becomes 0 and the greatest one 1; a uniform image remains
    /// unchanged.
    pub fn normalize(&mut self) {
        let all = self.image.as_flattened();
        let (least, most) = all.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
        if most > least {
            self.each(|p| p.map(|x| (x - least) / (most - least)));
        }
    }
    /// Maps values from 0..1 to `least`..`most`, either each colour component separately, or all by intensity (`grey`).
    pub fn intensity_scale(&mut self, least: f32, most: f32, grey: bool) {
        let scaled = |x: f32| (least + (most - least) * x).clamp(0.0, 1.0);
        self.each(|p| if grey { [scaled(intensity(&p)); 3] } else { p.map(scaled) });
    }
    /// Adds `before`, multiplies by `scale` and adds `after`, for each colour component.
    pub fn scale_and_offset(&mut self, before: Pixel, scale: Pixel, after: Pixel) {
        self.each(|p| [0, 1, 2].map(|k| ((p[k] + before[k]) * scale[k] + after[k]).clamp(0.0, 1.0)));
    }
    /// Blackens the pixels for which `kept` returns false. If requested, copies these pixels to the first buffer.
    pub fn keep_pixels(&mut self, removed_to_buffer: bool, kept: impl Fn(usize, usize, &Pixel) -> bool) {
        if removed_to_buffer {
            self.buffers[0].fill([0.0; 3]);
        }
        let columns = self.columns.max(1);
        for (i, (p, b)) in self.image.iter_mut().zip(&mut self.buffers[0]).enumerate() {
            if !kept(i % columns, i / columns, p) {
                if removed_to_buffer {
                    *b = *p;
                }
                *p = [0.0; 3];
            }
        }
    }
    /// Marks changes: pixels whose intensity differs from the first buffer by more than the threshold become white, all
    /// others black. Returns the fraction of white pixels.
    pub fn mark_changed(&mut self, threshold: f32) -> f64 {
        let mut n = 0;
        for (p, b) in self.image.iter_mut().zip(&self.buffers[0]) {
            let changed = (intensity(p) - intensity(b)).abs() > threshold;
            n += usize::from(changed);
            *p = [if changed { 1.0 } else { 0.0 }; 3];
        }
        n as f64 / self.image.len().max(1) as f64
    }
    /// Returns the fraction of pixels that are white, their centre x and y as fractions of the image's sides, their
    /// orientation, rad, and their roundness, 0 to 1.
    pub fn moments(&self) -> [f64; 5] {
        let spot: Vec<usize> = (0..self.image.len()).filter(|i| intensity(&self.image[*i]) > 0.5).collect();
        if spot.is_empty() {
            return [0.0, 0.5, 0.5, 0.0, 0.0];
        }
        let [angle, x, y, width, height] = box_of(&spot, self.columns, self.rows);
        let (w, h) = (width * self.columns as f64, height * self.rows as f64);
        [spot.len() as f64 / self.image.len() as f64, x, y, angle, w.min(h) / w.max(h).max(1e-9)]
    }
    /// Thresholds the image: pixels brighter than the threshold become white, all others black.
    pub fn binary(&mut self, threshold: f32) {
        self.each(|p| [if intensity(&p) > threshold { 1.0 } else { 0.0 }; 3]);
    }
    /// Returns the pixel in column `c` and row `r`, or the nearest pixel if this one is outside the image.
    fn at(&self, c: isize, r: isize) -> Pixel {
        let (c, r) = (c.clamp(0, self.columns as isize - 1), r.clamp(0, self.rows as isize - 1));
        self.image[r as usize * self.columns + c as usize]
    }
    /// Convolves the image with a square kernel, whose rows are listed from the top, and multiplies it by a factor.
    pub fn kernel(&mut self, side: usize, weights: &[f64], factor: f64) {
        let half = (side / 2) as isize;
        let mut out = Vec::with_capacity(self.image.len());
        for r in 0..self.rows as isize {
            for c in 0..self.columns as isize {
                let mut sum = [0.0_f64; 3];
                for (k, w) in weights.iter().take(side * side).enumerate() {
                    let (dc, dr) = ((k % side) as isize - half, half - (k / side) as isize);
                    let p = self.at(c + dc, r + dr);
                    for (s, x) in sum.iter_mut().zip(p) {
                        *s += w * f64::from(x);
                    }
                }
                out.push(sum.map(|x| (x * factor).clamp(0.0, 1.0) as f32));
            }
        }
        self.image = out;
    }
    /// Marks edges: pixels whose intensity differs from that of a neighbour by more than the threshold become white,
    /// all others black.
    pub fn edges(&mut self, threshold: f32) {
        let mut out = Vec::with_capacity(self.image.len());
        for r in 0..self.rows as isize {
            for c in 0..self.columns as isize {
                let here = intensity(&self.at(c, r));
                let differs = |dc, dr| (intensity(&self.at(c + dc, r + dr)) - here).abs() > threshold;
                let edge = differs(1, 0) || differs(-1, 0) || differs(0, 1) || differs(0, -1);
                out.push([if edge { 1.0 } else { 0.0 }; 3]);
            }
        }
        self.image = out;
    }
}

/// Returns the coordinates of points of a depth image in the sensor's frame: the number of points along x and y, then
/// x, y, z and distance of each, row by row from the lowest, from left to right.
///
/// The points divide the image, or its angles, evenly; each point has the depth of the pixel that contains it.
pub(super) fn coordinates(
    depth: &[f32],
    columns: usize,
    rows: usize,
    lens: &ImageProjection,
    count: [usize; 2],
    even_angles: bool,
) -> Vec<f64> {
    let [nx, ny] = count;
    let mut out = vec![nx as f64, ny as f64];
    let [fx, fy, cx, cy] = lens.intrinsics;
    let [near, far] = lens.planes;
    // Position of a point along one side, in pixels from the centre of the first pixel.
    let place = |i: usize, n: usize, side: usize, f: f64| {
        let part = (i as f64 + 0.5) / n as f64;
        if even_angles && !lens.parallel {
            let half = libm::atan(side as f64 / 2.0 / f);
            f * libm::tan((2.0 * part - 1.0) * half) + (side as f64 - 1.0) / 2.0
        } else {
            part * side as f64 - 0.5
        }
    };
    let pixel = |place: f64, side: usize| (place.round().max(0.0) as usize).min(side.saturating_sub(1));
    for j in 0..ny {
        let v = place(j, ny, rows, fy);
        for i in 0..nx {
            let u = place(i, nx, columns, fx);
            let z = depth
                .get(pixel(v, rows) * columns + pixel(u, columns))
                .map_or(far, |d| near + f64::from(*d) * (far - near));
            let along = if lens.parallel { 1.0 } else { z };
            let (x, y) = (-(u - cx) / fx * along, (v - cy) / fy * along);
            let distance = if lens.parallel { z } else { (x * x + y * y + z * z).sqrt() };
            out.extend([x, y, z, distance]);
        }
    }
    out
}

/// Finds blobs of pixels whose intensity exceeds a threshold. Returns their number and the number 6, then for each blob
/// its fraction of the image, orientation (rad), and centre x and y, width and height along that orientation as
/// fractions of the image's sides. Also returns the label of each pixel: the number of its blob, from 1 and counting
/// omitted blobs, or 0.
///
/// Pixels that touch at a side or corner are connected. Blobs smaller than `least` (a fraction of the image) are
/// omitted; the others are in the order of their lowest, leftmost pixel.
pub(super) fn blobs(work: &WorkingImage, threshold: f32, least: f64) -> (Vec<f64>, Vec<u32>) {
    let (w, h, n) = (work.columns, work.rows, work.image.len());
    let on: Vec<bool> = work.image.iter().map(|p| intensity(p) > threshold).collect();
    let mut label = vec![0_u32; n];
    let mut found: Vec<Vec<usize>> = Vec::new();
    for first in 0..n {
        if !on[first] || label[first] != 0 {
            continue;
        }
        let number = found.len() as u32 + 1;
        let (mut spot, mut next) = (vec![first], 0);
        label[first] = number;
        while let Some(&i) = spot.get(next) {
            next += 1;
            let (c, r) = ((i % w) as isize, (i / w) as isize);
            for (dc, dr) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
                let (c, r) = (c + dc, r + dr);
                if c < 0 || r < 0 || c >= w as isize || r >= h as isize {
                    continue;
                }
                let k = r as usize * w + c as usize;
                if on[k] && label[k] == 0 {
                    label[k] = number;
                    spot.push(k);
                }
            }
        }
        found.push(spot);
    }
    let mut out = vec![0.0, 6.0];
    for (number, spot) in found.iter().enumerate() {
        let share = spot.len() as f64 / n as f64;
        if share < least {
            label.iter_mut().filter(|l| **l == number as u32 + 1).for_each(|l| *l = 0);
            continue;
        }
        out[0] += 1.0;
        out.push(share);
        out.extend(box_of(spot, w, h));
    }
    (out, label)
}

/// Returns the orientation of a blob, rad, and its centre, width and height as fractions of the image's sides.
fn box_of(spot: &[usize], w: usize, h: usize) -> [f64; 5] {
    let places = || spot.iter().map(|i| ((i % w) as f64 + 0.5, (i / w) as f64 + 0.5));
    let n = spot.len() as f64;
    let (mx, my) = places().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
    for (x, y) in places() {
        xx += (x - mx) * (x - mx);
        yy += (y - my) * (y - my);
        xy += (x - mx) * (y - my);
    }
    // The orientation is the angle of the principal axis. A round blob has no principal axis.
    let round = (xx - yy).abs() + xy.abs() < 1e-9 * (xx + yy).max(1.0);
    let angle = if round { 0.0 } else { 0.5 * libm::atan2(2.0 * xy, xx - yy) };
    let (s, c) = libm::sincos(angle);
    let span = |f: &dyn Fn(f64, f64) -> f64| {
        let (a, b) =
            places().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (x, y)| (a.min(f(x, y)), b.max(f(x, y))));
        (a, b)
    };
    let (a, b) = span(&|x, y| x * c + y * s);
    let (d, e) = span(&|x, y| y * c - x * s);
    // The points are centres of pixels, so add the extent of one pixel along the sides of the box.
    let own = s.abs() + c.abs();
    let (along, across) = ((a + b) / 2.0, (d + e) / 2.0);
    [
        angle,
        (along * c - across * s) / w as f64,
        (along * s + across * c) / h as f64,
        (b - a + own) / w as f64,
        (e - d + own) / h as f64,
    ]
}

#[cfg(test)]
#[path = "work_tests.rs"]
mod tests;
