//! The camera of a picture.

use nalgebra::{Point3, Unit, Vector3};

/// A perspective camera. The z axis of the world points up in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Position of the eye in the world frame, in metres.
    pub from: Point3<f64>,
    /// Point in the centre of the picture, in the world frame, in metres; must differ from `from`.
    pub to: Point3<f64>,
    /// Horizontal field of view, in radians; above 0 and below pi.
    pub fov: f64,
    /// Number of pixels per row.
    pub columns: u32,
    /// Number of rows.
    pub rows: u32,
}

/// The axes of a camera, from which directions are computed.
#[derive(Debug, Clone, Copy)]
pub(super) struct CameraAxes {
    pub eye: Point3<f64>,
    ahead: Vector3<f64>,
    /// Offset from a pixel to its right neighbour, on the image plane at distance 1.
    pub across: Vector3<f64>,
    /// Offset from a pixel to the one below, on the same plane.
    pub down: Vector3<f64>,
    middle: [f64; 2],
}

impl Camera {
    pub(super) fn axes(&self) -> CameraAxes {
        let forward = self.to - self.from;
        let ahead = forward.try_normalize(0.0).unwrap_or_else(Vector3::x);
        // If the camera looks straight down, the y axis of the world points up in the picture; straight up, down.
        let right = ahead.cross(&Vector3::z()).try_normalize(1e-9).unwrap_or_else(Vector3::x);
        let pixel = 2.0 * libm::tan(self.fov / 2.0) / f64::from(self.columns);
        CameraAxes {
            eye: self.from,
            ahead,
            across: right * pixel,
            down: ahead.cross(&right) * pixel,
            middle: [f64::from(self.columns) / 2.0, f64::from(self.rows) / 2.0],
        }
    }

    /// Returns the width of a pixel at distance 1, in metres.
    pub(super) fn pixel(&self) -> f64 {
        2.0 * libm::tan(self.fov / 2.0) / f64::from(self.columns)
    }
}

impl CameraAxes {
    /// Returns whether a point of the world is in the picture, which has this many columns and rows.
    pub fn shows(&self, point: &Point3<f64>, [columns, rows]: [u32; 2]) -> bool {
        let to = point - self.eye;
        let depth = to.dot(&self.ahead);
        let at = |side: &Vector3<f64>, middle: f64, count: u32| {
            let pixel = middle + to.dot(side) / depth / side.norm_squared();
            (0.0..=f64::from(count)).contains(&pixel)
        };
        depth > 0.0 && at(&self.across, self.middle[0], columns) && at(&self.down, self.middle[1], rows)
    }
    /// Returns the direction, in the world frame, of the ray through a position in the picture, given in pixels from
    /// the upper left corner.
    pub fn direction(&self, x: f64, y: f64) -> Unit<Vector3<f64>> {
        let [mx, my] = self.middle;
        Unit::new_normalize(self.ahead + self.across * (x - mx) + self.down * (y - my))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ray_directions_match_the_sides_of_the_picture() {
        let camera =
            Camera { from: Point3::origin(), to: Point3::new(2.0, 0.0, 0.0), fov: 1.0, columns: 200, rows: 100 };
        let lens = camera.axes();
        assert!((*lens.direction(100.0, 50.0) - Vector3::x()).norm() < 1e-12);
        let left = lens.direction(0.0, 50.0);
        // The left edge is half the field of view to the left, which is +y if the camera looks along +x.
        assert!((left.y.atan2(left.x) - 0.5).abs() < 1e-12 && left.z.abs() < 1e-12);
        assert!(lens.direction(100.0, 0.0).z > 0.2);
        let above = Camera { to: Point3::new(0.0, 0.0, -1.0), ..camera }.axes();
        assert!(above.direction(200.0, 50.0).x > 0.4 && above.direction(100.0, 0.0).y > 0.2);
    }
}
