//! From where a picture is taken.

use nalgebra::{Point3, Unit, Vector3};

/// A camera that sees in perspective. The picture's upright is the world's z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Where it stands, m.
    pub from: Point3<f64>,
    /// The point in the middle of the picture, m; another one than `from`.
    pub to: Point3<f64>,
    /// The angle between the left and right edge, rad; more than 0, less than pi.
    pub fov: f64,
    /// Pixels in a row.
    pub columns: u32,
    /// Rows of pixels.
    pub rows: u32,
}

/// A camera's axes, ready to look.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lens {
    pub eye: Point3<f64>,
    ahead: Vector3<f64>,
    /// To the next pixel in a row, and to the next row below, at distance 1.
    pub across: Vector3<f64>,
    pub down: Vector3<f64>,
    middle: [f64; 2],
}

impl Camera {
    pub(super) fn lens(&self) -> Lens {
        let forward = self.to - self.from;
        let ahead = forward.try_normalize(0.0).unwrap_or_else(Vector3::x);
        // Straight up or down, y is the picture's upright.
        let right = ahead.cross(&Vector3::z()).try_normalize(1e-9).unwrap_or_else(Vector3::x);
        let pixel = 2.0 * libm::tan(self.fov / 2.0) / f64::from(self.columns);
        Lens {
            eye: self.from,
            ahead,
            across: right * pixel,
            down: ahead.cross(&right) * pixel,
            middle: [f64::from(self.columns) / 2.0, f64::from(self.rows) / 2.0],
        }
    }

    /// How wide a pixel is at distance 1, m.
    pub(super) fn pixel(&self) -> f64 {
        2.0 * libm::tan(self.fov / 2.0) / f64::from(self.columns)
    }
}

impl Lens {
    /// The direction of a place in the picture, counted in pixels from its upper left corner.
    pub fn direction(&self, x: f64, y: f64) -> Unit<Vector3<f64>> {
        let [mx, my] = self.middle;
        Unit::new_normalize(self.ahead + self.across * (x - mx) + self.down * (y - my))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn left_is_left_and_up_is_up() {
        let camera =
            Camera { from: Point3::origin(), to: Point3::new(2.0, 0.0, 0.0), fov: 1.0, columns: 200, rows: 100 };
        let lens = camera.lens();
        assert!((*lens.direction(100.0, 50.0) - Vector3::x()).norm() < 1e-12);
        let left = lens.direction(0.0, 50.0);
        // The left edge lies half the angle to the left, which is +y when one looks along +x.
        assert!((left.y.atan2(left.x) - 0.5).abs() < 1e-12 && left.z.abs() < 1e-12);
        assert!(lens.direction(100.0, 0.0).z > 0.2);
        let above = Camera { to: Point3::new(0.0, 0.0, -1.0), ..camera }.lens();
        assert!(above.direction(200.0, 50.0).x > 0.4 && above.direction(100.0, 0.0).y > 0.2);
    }
}
