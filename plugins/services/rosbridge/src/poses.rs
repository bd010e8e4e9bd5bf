//! Calculates with poses, and converts them to ROS messages.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use tatu_plugin_api::safe::{Value, keys};

/// A position (m) and a quaternion (x y z w).
pub type Pose = [f64; 7];

/// The identity pose.
pub const IDENTITY: Pose = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
/// The standard ROS frame (x ahead, y left, z up) in the frame of a sensor (+z ahead, +y up, +x left).
pub const ROS_AXES: Pose = [0.0, 0.0, 0.0, -0.5, -0.5, -0.5, 0.5];
/// The optical frame of ROS (z ahead, x right, y down) in the frame of a sensor.
pub const OPTICAL_AXES: Pose = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// Returns a pose on the floor from its coordinates, m, and heading, rad.
pub fn planar(x: f64, y: f64, heading: f64) -> Pose {
    let (s, c) = libm::sincos(heading / 2.0);
    [x, y, 0.0, 0.0, 0.0, s, c]
}

/// Projects a pose onto the floor. The result has the same x, y and heading of the x axis.
pub fn project_to_floor(at: &Pose) -> Pose {
    let ahead = isometry(*at).rotation * nalgebra::Vector3::x();
    planar(at[0], at[1], libm::atan2(ahead.y, ahead.x))
}

/// Converts a pose to an isometry.
fn isometry([x, y, z, a, b, c, w]: Pose) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_quaternion(Quaternion::new(w, a, b, c)))
}

/// Converts an isometry to a pose.
fn from_isometry(at: &Isometry3<f64>) -> Pose {
    let (p, q) = (at.translation.vector, at.rotation.coords);
    [p.x, p.y, p.z, q.x, q.y, q.z, q.w]
}

/// Composes two poses, where `b` is relative to `a`.
pub fn compose(a: &Pose, b: &Pose) -> Pose {
    from_isometry(&(isometry(*a) * isometry(*b)))
}

/// Returns the pose of `b` relative to `a`.
pub fn relative_pose(a: &Pose, b: &Pose) -> Pose {
    from_isometry(&isometry(*a).inv_mul(&isometry(*b)))
}

/// Returns a `geometry_msgs/Vector3` or `Point`.
pub fn vector([x, y, z]: [f64; 3]) -> Value {
    keys([("x", Value::Float(x)), ("y", Value::Float(y)), ("z", Value::Float(z))])
}

/// Returns a `geometry_msgs/Quaternion`.
pub fn quaternion(pose: &Pose) -> Value {
    let [x, y, z, w] = [pose[3], pose[4], pose[5], pose[6]].map(Value::Float);
    keys([("x", x), ("y", y), ("z", z), ("w", w)])
}

/// Returns a `geometry_msgs/Pose`.
pub fn pose(p: &Pose) -> Value {
    keys([("position", vector([p[0], p[1], p[2]])), ("orientation", quaternion(p))])
}

/// Returns a `geometry_msgs/Transform`.
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
    fn sensor_frames_are_rotated_to_ros_axes() {
        let point = |by: &Pose, [x, y, z]: [f64; 3]| compose(by, &[x, y, z, 0.0, 0.0, 0.0, 1.0]);
        // The ROS axes x (ahead), y (left) and z (up) are the axes z, x and y of the sensor.
        near(&point(&ROS_AXES, [1.0, 0.0, 0.0])[..3], &[0.0, 0.0, 1.0]);
        near(&point(&ROS_AXES, [0.0, 1.0, 0.0])[..3], &[1.0, 0.0, 0.0]);
        near(&point(&ROS_AXES, [0.0, 0.0, 1.0])[..3], &[0.0, 1.0, 0.0]);
        // In the optical frame, x points right and y points down, so both are opposite to those of the sensor.
        near(&point(&OPTICAL_AXES, [1.0, 2.0, 3.0])[..3], &[-1.0, -2.0, 3.0]);
    }

    #[test]
    fn relative_pose_inverts_composition() {
        let (a, b) = (planar(1.0, 2.0, 0.7), planar(-3.0, 0.5, 2.0));
        near(&compose(&a, &relative_pose(&a, &b)), &b);
        near(&compose(&planar(1.0, 0.0, std::f64::consts::FRAC_PI_2), &planar(1.0, 0.0, 0.0))[..2], &[1.0, 1.0]);
    }

    #[test]
    fn floor_projection_removes_height_and_tilt() {
        let heading = planar(3.0, 4.0, 0.5);
        let tilted =
            compose(&compose(&heading, &[0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0]), &[0.0, 0.0, 0.0, 0.2, 0.0, 0.0, 0.9798]);
        near(&project_to_floor(&tilted), &heading);
    }
}
