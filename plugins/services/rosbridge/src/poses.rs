//! Poses as numbers: place x y z, quaternion x y z w; and as fields of messages.

use tatu_plugin_api::safe::{Value, keys};

/// Place and quaternion.
pub type Pose = [f64; 7];

/// From a sensor's frame (+z ahead, +y up, +x to the left) to that of ROS: x ahead, y to the left, z up.
pub const AHEAD: Pose = [0.0, 0.0, 0.0, -0.5, -0.5, -0.5, 0.5];
/// And to that of cameras in ROS: z ahead, x to the right, y down.
pub const OPTICAL: Pose = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// A pose on the floor.
pub fn planar(x: f64, y: f64, heading: f64) -> Pose {
    let (s, c) = libm::sincos(heading / 2.0);
    [x, y, 0.0, 0.0, 0.0, s, c]
}

/// A vector, turned by the quaternion of a pose.
pub fn turned(by: &Pose, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let [.., a, b, c, w] = *by;
    // v + 2 w (q x v) + 2 q x (q x v)
    let t = [2.0 * (b * z - c * y), 2.0 * (c * x - a * z), 2.0 * (a * y - b * x)];
    [x + w * t[0] + b * t[2] - c * t[1], y + w * t[1] + c * t[0] - a * t[2], z + w * t[2] + a * t[1] - b * t[0]]
}

/// First `b`, seen in the frame `a`.
pub fn then(a: &Pose, b: &Pose) -> Pose {
    let [x, y, z] = turned(a, [b[0], b[1], b[2]]);
    let [ax, ay, az, aw] = [a[3], a[4], a[5], a[6]];
    let [bx, by, bz, bw] = [b[3], b[4], b[5], b[6]];
    [
        a[0] + x,
        a[1] + y,
        a[2] + z,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

/// The way back.
pub fn inverse(a: &Pose) -> Pose {
    let back = [0.0, 0.0, 0.0, -a[3], -a[4], -a[5], a[6]];
    let [x, y, z] = turned(&back, [-a[0], -a[1], -a[2]]);
    [x, y, z, back[3], back[4], back[5], back[6]]
}

/// `geometry_msgs/Vector3` or `Point`.
pub fn vector([x, y, z]: [f64; 3]) -> Value {
    keys([("x", Value::Float(x)), ("y", Value::Float(y)), ("z", Value::Float(z))])
}

fn quaternion(pose: &Pose) -> Value {
    let [x, y, z, w] = [pose[3], pose[4], pose[5], pose[6]].map(Value::Float);
    keys([("x", x), ("y", y), ("z", z), ("w", w)])
}

/// `geometry_msgs/Pose`
pub fn pose(p: &Pose) -> Value {
    keys([("position", vector([p[0], p[1], p[2]])), ("orientation", quaternion(p))])
}

/// `geometry_msgs/Transform`
pub fn transform(p: &Pose) -> Value {
    keys([("translation", vector([p[0], p[1], p[2]])), ("rotation", quaternion(p))])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: &[f64], b: &[f64]) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?} {b:?}");
    }

    #[test]
    fn frames_of_sensors_are_turned_to_those_of_ros() {
        // x ahead is the sensor's z, y to the left its x, z up its y.
        near(&turned(&AHEAD, [1.0, 0.0, 0.0]), &[0.0, 0.0, 1.0]);
        near(&turned(&AHEAD, [0.0, 1.0, 0.0]), &[1.0, 0.0, 0.0]);
        near(&turned(&AHEAD, [0.0, 0.0, 1.0]), &[0.0, 1.0, 0.0]);
        // A camera's x points right, its y down.
        near(&turned(&OPTICAL, [1.0, 2.0, 3.0]), &[-1.0, -2.0, 3.0]);
    }

    #[test]
    fn there_and_back_is_nowhere() {
        let a = then(&planar(1.0, 2.0, 0.7), &AHEAD);
        near(&then(&a, &inverse(&a)), &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        near(&then(&planar(1.0, 0.0, std::f64::consts::FRAC_PI_2), &planar(1.0, 0.0, 0.0))[..2], &[1.0, 1.0]);
    }
}
