//! Reads the arguments of commands, and converts poses to and from lists of numbers.

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};
use tatu_kinematics::{FrameId, Joint};
use tatu_plugin_api::safe::{Command, Fail, Param, Result, ValueRef};

use crate::environment::{Ctx, Environment, Ik};

/// Handle that stands for the world frame.
pub const HANDLE_WORLD: i64 = -1;
/// Handle that stands for the parent of an object.
pub const HANDLE_PARENT: i64 = -11;

/// Builds a command whose first parameter is an environment.
pub fn command(name: &str, run: impl Fn(&mut Ctx<'_>) -> Result + Send + Sync + 'static) -> Command<Ik> {
    Command::new(format!("simIK.{name}"), run).param(Param::int("environment"))
}

/// Returns the handle by which scripts refer to a frame.
pub fn handle_of(frame: FrameId) -> i64 {
    i64::from(frame.0) + 1
}
/// Returns the handle of a frame, or [`HANDLE_WORLD`] for `None`.
pub fn handle_or_world(frame: Option<FrameId>) -> i64 {
    frame.map_or(HANDLE_WORLD, handle_of)
}

fn no_object(i: usize, handle: i64) -> Fail {
    Fail::argument(format!("argument {}: there is no object with handle {handle} in this environment", i + 1))
}

/// Returns the frame whose handle is argument `i`.
pub fn frame(c: &Ctx<'_>, environment: &Environment, i: usize) -> Result<FrameId> {
    let handle = c.i64(i)?;
    found(environment, handle).ok_or_else(|| no_object(i, handle))
}
fn found(environment: &Environment, handle: i64) -> Option<FrameId> {
    let id = FrameId(u32::try_from(handle.checked_sub(1)?).ok()?);
    environment.copy.linkage.contains(id).then_some(id)
}
/// Returns the frame whose handle is argument `i`, or `None` if the argument is missing or denotes the world.
pub fn frame_or_world(c: &Ctx<'_>, environment: &Environment, i: usize) -> Result<Option<FrameId>> {
    match c.has(i).then(|| c.i64(i)).transpose()? {
        None | Some(HANDLE_WORLD) => Ok(None),
        Some(_) => frame(c, environment, i).map(Some),
    }
}
/// Returns the frame, given by argument `i`, to which a pose of `of` is relative: a frame, the parent of `of`, or
/// `None` for the world.
pub fn reference(c: &Ctx<'_>, environment: &Environment, i: usize, of: FrameId) -> Result<Option<FrameId>> {
    match c.has(i).then(|| c.i64(i)).transpose()? {
        Some(HANDLE_PARENT) => Ok(environment.copy.linkage.parent(of)),
        _ => frame_or_world(c, environment, i),
    }
}

/// Returns the joint whose handle is argument `i`.
pub fn joint<'e>(c: &Ctx<'_>, environment: &'e mut Environment, i: usize) -> Result<(FrameId, &'e mut Joint)> {
    let id = frame(c, environment, i)?;
    let wrong = || Fail::argument(format!("argument {}: object {} is not a joint", i + 1, handle_of(id)));
    Ok((id, environment.copy.linkage.joint_mut(id).ok_or_else(wrong)?))
}

/// Returns the joints whose handles are listed in argument `i`.
pub fn joints(c: &Ctx<'_>, environment: &Environment, i: usize) -> Result<Vec<FrameId>> {
    let wrong = || Fail::argument(format!("argument {}: expected a table with the handles of joints", i + 1));
    let handles = c.arg(i).numbers().ok_or_else(wrong)?;
    let joint = |handle: f64| {
        let id = found(environment, handle as i64).ok_or_else(|| no_object(i, handle as i64))?;
        let wrong = || Fail::argument(format!("argument {}: object {handle} is not a joint", i + 1));
        environment.copy.linkage.joint(id).map(|_| id).ok_or_else(wrong)
    };
    handles.into_iter().map(joint).collect()
}

/// Returns argument `i`, which must be a finite number.
pub fn number(c: &Ctx<'_>, i: usize) -> Result<f64> {
    let x = c.f64(i)?;
    if x.is_finite() {
        Ok(x)
    } else {
        Err(Fail::argument(format!("argument {}: expected a finite number, found {x}", i + 1)))
    }
}

/// Returns the orientation in argument `i`: a quaternion x y z w, or the angles alpha, beta and gamma, rad.
pub fn orientation(value: ValueRef<'_>, i: usize) -> Result<UnitQuaternion<f64>> {
    let wrong =
        || Fail::argument(format!("argument {}: expected a quaternion (x, y, z, w) or three angles in rad", i + 1));
    let numbers = value.numbers().filter(|n| n.iter().all(|x| x.is_finite())).ok_or_else(wrong)?;
    match numbers[..] {
        [x, y, z, w] => quaternion(x, y, z, w).ok_or_else(wrong),
        [alpha, beta, gamma] => {
            let about = |axis: Vector3<f64>, angle: f64| UnitQuaternion::from_axis_angle(&axis_of(axis), angle);
            Ok(about(Vector3::x(), alpha) * about(Vector3::y(), beta) * about(Vector3::z(), gamma))
        }
        _ => Err(wrong()),
    }
}
fn axis_of(axis: Vector3<f64>) -> nalgebra::Unit<Vector3<f64>> {
    nalgebra::Unit::new_unchecked(axis)
}
fn quaternion(x: f64, y: f64, z: f64, w: f64) -> Option<UnitQuaternion<f64>> {
    UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-9)
}

/// Returns the pose in argument `i`: position (m) and quaternion x y z w, or the 12 numbers of a matrix, row by row.
pub fn pose(c: &Ctx<'_>, i: usize) -> Result<Isometry3<f64>> {
    let wrong =
        || Fail::argument(format!("argument {}: expected a pose of 7 numbers or a matrix of 12 numbers", i + 1));
    let numbers = c.arg(i).numbers().filter(|n| n.iter().all(|x| x.is_finite())).ok_or_else(wrong)?;
    match numbers[..] {
        [x, y, z, qx, qy, qz, qw] => {
            Ok(Isometry3::from_parts(Translation3::new(x, y, z), quaternion(qx, qy, qz, qw).ok_or_else(wrong)?))
        }
        [a, b, c, x, d, e, f, y, g, h, k, z] => {
            let turned = Rotation3::from_matrix_unchecked(Matrix3::new(a, b, c, d, e, f, g, h, k));
            Ok(Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_rotation_matrix(&turned)))
        }
        _ => Err(wrong()),
    }
}

/// Returns a pose as its position, m, followed by its quaternion x y z w.
pub fn pose_numbers(pose: &Isometry3<f64>) -> [f64; 7] {
    let (p, q) = (pose.translation.vector, pose.rotation.coords);
    [p.x, p.y, p.z, q.x, q.y, q.z, q.w]
}
/// Returns a pose as a matrix of 12 numbers, row by row.
pub fn matrix_numbers(pose: &Isometry3<f64>) -> [f64; 12] {
    let (r, p) = (pose.rotation.to_rotation_matrix(), pose.translation.vector);
    let r = r.matrix();
    std::array::from_fn(|i| if i % 4 == 3 { p[i / 4] } else { r[(i / 4, i % 4)] })
}
/// Returns the angles alpha, beta and gamma of an orientation, rad: rotations about x, then the new y, then the new z.
pub fn angles(turned: &UnitQuaternion<f64>) -> [f64; 3] {
    let r = turned.to_rotation_matrix();
    let r = r.matrix();
    let beta = libm::asin(r[(0, 2)].clamp(-1.0, 1.0));
    [libm::atan2(-r[(1, 2)], r[(2, 2)]), beta, libm::atan2(-r[(0, 1)], r[(0, 0)])]
}
