//! Computes the rays of beams that were sent earlier in a scan, relative to the mount's current pose.

type Vec3 = [f64; 3];

/// The motion of a mount in its own frame, assuming constant velocities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MountMotion {
    linear: Vec3,
    angular: Vec3,
}

fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Rotates a vector from the world frame into a frame whose orientation is the quaternion x y z w.
fn rotate_inverse([x, y, z, w]: [f64; 4], v: Vec3) -> Vec3 {
    let axis = [-x, -y, -z];
    let t = cross(axis, v);
    let u = cross(axis, t);
    [0, 1, 2].map(|i| v[i] + 2.0 * (w * t[i] + u[i]))
}

impl MountMotion {
    /// Creates the motion from pose and twist in the world frame.
    pub fn of(pose: [f64; 7], t: [f64; 6]) -> Self {
        let q = [pose[3], pose[4], pose[5], pose[6]];
        MountMotion { linear: rotate_inverse(q, [t[0], t[1], t[2]]), angular: rotate_inverse(q, [t[3], t[4], t[5]]) }
    }

    /// Returns a ray (origin, direction) that the mount sent `age` seconds ago.
    pub fn earlier_ray(&self, ray: [f64; 6], age: f64) -> [f64; 6] {
        let origin = self.rotated([ray[0], ray[1], ray[2]], -age);
        let [x, y, z] = [0, 1, 2].map(|i| origin[i] - age * self.linear[i]);
        let [u, v, w] = self.rotated([ray[3], ray[4], ray[5]], -age);
        [x, y, z, u, v, w]
    }

    /// Rotates a vector by the rotation of the mount during `time` seconds, with Rodrigues' formula.
    fn rotated(&self, v: Vec3, time: f64) -> Vec3 {
        let speed = dot(self.angular, self.angular).sqrt();
        let angle = speed * time;
        if angle == 0.0 {
            return v;
        }
        let axis = self.angular.map(|x| x / speed);
        let ((s, c), side, along) = (libm::sincos(angle), cross(axis, v), dot(axis, v) * (1.0 - libm::cos(angle)));
        [0, 1, 2].map(|i| v[i] * c + side[i] * s + axis[i] * along)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

    use super::*;

    fn near(a: [f64; 6], b: [f64; 6]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    #[test]
    fn rays_of_a_mount_at_rest_are_unchanged() {
        let motion = MountMotion::of([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0], [0.0; 6]);
        let ray = [0.1, 0.2, 0.3, 0.0, 0.6, 0.8];
        assert_eq!(motion.earlier_ray(ray, 0.1), ray);
    }

    #[test]
    fn earlier_ray_of_a_mount_moving_ahead_starts_behind() {
        // The mount is rotated by 90 degrees about z: the world's y is its x.
        let pose = [0.0, 0.0, 0.0, 0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2];
        let motion = MountMotion::of(pose, [0.0, 2.0, 0.0, 0.0, 0.0, 0.0]);
        assert!(near(motion.earlier_ray([0.0, 0.0, 0.0, 1.0, 0.0, 0.0], 0.5), [-1.0, 0.0, 0.0, 1.0, 0.0, 0.0]));
    }

    #[test]
    fn earlier_ray_of_a_turning_mount_is_rotated_back() {
        // The mount turns left about z by a quarter turn per second: a second ago, ahead (x) was to the right of the
        // current heading.
        let motion = MountMotion::of([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 0.0, 0.0, FRAC_PI_2]);
        assert!(near(motion.earlier_ray([0.5, 0.0, 0.0, 1.0, 0.0, 0.0], 1.0), [0.0, -0.5, 0.0, 0.0, -1.0, 0.0]));
    }
}
