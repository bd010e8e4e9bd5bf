//! Projection from the world to pixels.
//!
//! The view frame is the sensor's frame with x to the right. In a perspective image, x and y are also multiplied by the
//! focal length in pixels, so a point (x, y, z) of this frame appears (x/z, y/z) pixels from the centre of the image.
//! In an orthographic image, x and y are themselves pixels. Depth is stored as `w`, which is greater for nearer points:
//! 1/z, or -z in an orthographic image. On any plane, both are linear functions of column and row.

use nalgebra::{Isometry3, Matrix3, Vector3};

use super::{Grid, ImageProjection};

/// A linear function of column and row: `a column + b row + c`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LinearFunction {
    pub a: f64,
    pub b: f64,
    pub c: f64,
}

/// A camera prepared for rasterisation.
#[derive(Debug, Clone, Copy)]
pub(super) struct GridCamera {
    pub columns: usize,
    pub rows: usize,
    pub perspective: bool,
    /// Focal length in pixels, or pixels per metre if orthographic.
    pub scale: f64,
    pub near: f64,
    pub far: f64,
    /// Maximum visible `w`.
    pub w_near: f32,
    /// Value of a pixel without a visible surface: just below the minimum visible `w`.
    pub w_empty: f32,
    /// Transform from the world to the view frame, before x and y are multiplied by the focal length.
    pub rotation: Matrix3<f64>,
    pub translation: Vector3<f64>,
    /// Length of the longest ray (that of a corner pixel) per metre of depth.
    pub slant: f64,
}

/// Maximum number of columns and of rows.
pub(super) const MAX_SIDE_PIXELS: u32 = 16_384;

impl GridCamera {
    /// Creates a camera, or returns `None` if it cannot show any surface because it has no pixels, an empty range, an
    /// invalid angle, or a pose that is not finite.
    pub fn new(grid: &Grid, world_from_sensor: &Isometry3<f64>) -> Option<Self> {
        let half = 0.5 * f64::from(grid.columns);
        let (perspective, scale) = match grid.projection {
            ImageProjection::Perspective { angle } if angle > 0.0 && angle < std::f64::consts::PI => {
                (true, half / libm::tan(0.5 * angle))
            }
            ImageProjection::Orthographic { width } if width > 0.0 => (false, 2.0 * half / width),
            _ => return None,
        };
        let pixels = (1..=MAX_SIDE_PIXELS).contains(&grid.columns) && (1..=MAX_SIDE_PIXELS).contains(&grid.rows);
        let near = if perspective { grid.near.max(1e-9) } else { grid.near };
        let sensor_from_world = world_from_sensor.inverse();
        let mut rotation = *sensor_from_world.rotation.to_rotation_matrix().matrix();
        let mut translation = sensor_from_world.translation.vector;
        rotation.row_mut(0).neg_mut();
        translation.x = -translation.x;
        let placed = rotation.iter().chain(translation.iter()).all(|x| x.is_finite());
        if !(pixels && scale.is_finite() && scale > 0.0 && near.is_finite() && near <= grid.far && placed) {
            return None;
        }
        let (w_near, w_far) = if perspective { (1.0 / near, 1.0 / grid.far) } else { (-near, -grid.far) };
        let slant = (half.powi(2) + (0.5 * f64::from(grid.rows)).powi(2)).sqrt() / scale;
        Some(Self {
            columns: grid.columns as usize,
            rows: grid.rows as usize,
            perspective,
            scale,
            near,
            far: grid.far,
            w_near: w_near as f32,
            w_empty: if w_far == 0.0 { 0.0 } else { (w_far as f32).next_down() },
            rotation,
            translation,
            slant: crate::length(slant, 1.0),
        })
    }

    /// Returns the column and row of the centre of the image.
    pub fn middle(&self) -> (f64, f64) {
        (0.5 * self.columns as f64 - 0.5, 0.5 * self.rows as f64 - 0.5)
    }

    /// Projects a point of the view frame to homogeneous image coordinates: x and y in pixels from the centre,
    /// multiplied by the third value.
    pub fn homogeneous(&self, point: &Vector3<f64>) -> Vector3<f64> {
        let divisor = if self.perspective { point.z } else { 1.0 };
        Vector3::new(point.x * self.scale, point.y * self.scale, divisor)
    }

    /// Returns `w` on the plane of all points `p` of the view frame with `normal . p = height`.
    pub fn plane(&self, normal: &Vector3<f64>, height: f64) -> LinearFunction {
        let divisor = if self.perspective { height } else { normal.z };
        let (a, b) = (normal.x / (self.scale * divisor), normal.y / (self.scale * divisor));
        self.line_from_middle(a, b, if self.perspective { normal.z / divisor } else { -height / divisor })
    }

    /// Converts a linear function of the position in pixels from the centre of the image to one of column and row.
    pub fn line_from_middle(&self, a: f64, b: f64, c: f64) -> LinearFunction {
        let (column, row) = self.middle();
        LinearFunction { a, b, c: c - a * column - b * row }
    }

    /// Returns whether the front of a plane faces the camera.
    pub fn sees_front(&self, normal: &Vector3<f64>, height: f64) -> bool {
        if self.perspective { height < 0.0 } else { normal.z < 0.0 }
    }

    /// Returns the ray of a pixel in the view frame: its point at z = 0, and its direction per metre of z.
    pub fn ray(&self, column: f64, row: f64) -> (Vector3<f64>, Vector3<f64>) {
        let middle = self.middle();
        let (x, y) = ((column - middle.0) / self.scale, (row - middle.1) / self.scale);
        if self.perspective {
            (Vector3::zeros(), Vector3::new(x, y, 1.0))
        } else {
            (Vector3::new(x, y, 0.0), Vector3::z())
        }
    }

    /// Returns whether a sphere in the view frame is certainly outside the image. `false` does not imply that it is
    /// visible.
    pub fn misses(&self, centre: &Vector3<f64>, radius: f64) -> bool {
        let r = radius * (1.0 + 1e-9);
        let h = self.homogeneous(centre);
        let (right, up) = (0.5 * self.columns as f64, 0.5 * self.rows as f64);
        // Lengths of the normals of the side planes, which scale the distances below.
        let (across, along) = if self.perspective {
            (crate::length(self.scale, right), crate::length(self.scale, up))
        } else {
            (self.scale, self.scale)
        };
        h.x.abs() - right * h.z > r * across
            || h.y.abs() - up * h.z > r * along
            || centre.z + r < self.near
            || centre.z - r > self.far
    }

    /// Returns a part of the image that contains the convex hull of points of the view frame, or `None` if that part is
    /// empty.
    pub fn bounds(&self, points: &[Vector3<f64>]) -> Option<PixelBounds> {
        let (mut z_low, mut z_high) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        // One bit for each side plane, which is set if all points are beyond that plane.
        let mut beyond = 15;
        let (right, up) = (0.5 * self.columns as f64, 0.5 * self.rows as f64);
        for point in points {
            if !point.iter().all(|x| x.is_finite()) {
                return None;
            }
            let h = self.homogeneous(point);
            z_low = z_low.min(point.z);
            z_high = z_high.max(point.z);
            let sides = [h.x > right * h.z, h.x < -right * h.z, h.y > up * h.z, h.y < -up * h.z];
            beyond &= sides.iter().enumerate().fold(0, |bits, (i, side)| bits | u32::from(*side) << i);
            for (i, x) in [h.x / h.z, h.y / h.z].into_iter().enumerate() {
                low[i] = low[i].min(x);
                high[i] = high[i].max(x);
            }
        }
        if beyond != 0 || z_high < self.near || z_low > self.far {
            return None;
        }
        let middle = self.middle();
        let whole = self.perspective && z_low < 1e-6;
        // One more pixel on each side allows for rounding.
        let part = |low: f64, high: f64, middle: f64, count: usize| {
            if whole {
                return (0, count);
            }
            let first = (low + middle).ceil() - 1.0;
            let last = (high + middle).floor() + 2.0;
            (first.clamp(0.0, count as f64) as usize, last.clamp(0.0, count as f64) as usize)
        };
        Some(PixelBounds {
            columns: part(low[0], high[0], middle.0, self.columns),
            rows: part(low[1], high[1], middle.1, self.rows),
            beyond_near: z_low > self.near * (1.0 + 1e-6),
        })
    }
}

/// A rectangular part of the image.
#[derive(Debug, Clone, Copy)]
pub(super) struct PixelBounds {
    /// First column, and the column after the last one.
    pub columns: (usize, usize),
    /// First row, and the row after the last one.
    pub rows: (usize, usize),
    /// Whether all points are beyond the near plane.
    pub beyond_near: bool,
}
