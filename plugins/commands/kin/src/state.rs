//! Positions and velocities of a mechanism: read from the scene, given to it, and converted from those of scripts.
//!
//! Scripts have quaternions in the order x y z w, trees in the order w x y z.

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use tatu_mechanisms::{Joint, Kinematics, Link, Tree, TreeState};
use tatu_plugin_api::safe::{Fail, Result, World};

use crate::mechanism::{LinkRecord, Mechanism, MechanismProps};

/// Where the quaternion of a link is among its positions.
fn quaternion_at(joint: &Joint) -> Option<usize> {
    match joint {
        Joint::Spherical => Some(0),
        Joint::Free => Some(3),
        _ => None,
    }
}

/// Converts positions of scripts to those of a tree, and the other way with `back`.
pub fn convert(mechanism: &Mechanism, tree: &Tree, q: &mut [f64], back: bool) {
    for (i, link) in mechanism.links.iter().enumerate() {
        if let (Some(at), Some((first, _))) = (quaternion_at(&link.joint), tree.offsets(i)) {
            let quaternion = &mut q[first + at..first + at + 4];
            if back { quaternion.rotate_left(1) } else { quaternion.rotate_right(1) }
        }
    }
}

/// The velocity of a link: of a point of it, m/s, and about it, rad/s, in the world frame.
struct LinkMotion {
    point: Vector3<f64>,
    linear: Vector3<f64>,
    angular: Vector3<f64>,
}

impl LinkMotion {
    /// Returns the velocity of another point of the link, m/s.
    fn at(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(&(point - self.point))
    }
    /// Returns the velocity along or about the axis of the link's joint, against that of the link above.
    fn along(&self, link: &Link, record: &LinkRecord, above: Option<LinkMotion>) -> f64 {
        let axis = record.pose.rotation * Vector3::z();
        let joint = &record.pose.translation.vector;
        match link.joint {
            Joint::Prismatic(_) => axis.dot(&(self.at(joint) - above.map_or_else(Vector3::zeros, |a| a.at(joint)))),
            _ => axis.dot(&(self.angular - above.map_or_else(Vector3::zeros, |a| a.angular))),
        }
    }
}

/// Returns the velocity of a link, or `None` if it has no body.
fn motion(world: &World<'_>, mechanism: &Mechanism, link: usize) -> Result<Option<LinkMotion>> {
    let record = &mechanism.records[link];
    let Some(body) = record.bodies.first() else { return Ok(None) };
    let [vx, vy, vz, wx, wy, wz] = world.twist(body.object)?;
    let point = (record.pose * Point3::from(body.center)).coords;
    Ok(Some(LinkMotion { point, linear: Vector3::new(vx, vy, vz), angular: Vector3::new(wx, wy, wz) }))
}

/// Reads positions and velocities from the scene, in the layout of trees.
///
/// # Errors
///
/// Fails if a property cannot be read.
pub fn read(world: &World<'_>, p: &MechanismProps, mechanism: &Mechanism, tree: &Tree) -> Result<TreeState> {
    let mut state = TreeState::new(tree);
    let motion = |link: usize| motion(world, mechanism, link);
    for (i, (link, record)) in mechanism.links.iter().zip(&mechanism.records).enumerate() {
        let Some((at, v)) = tree.offsets(i) else { continue };
        match link.joint {
            Joint::Fixed => {}
            Joint::Revolute(_) | Joint::Prismatic(_) => {
                state.q[at] = world.f64(record.owner, p.position)?;
                state.v[v] = match (motion(i)?, link.parent.map(motion)) {
                    (Some(own), None) => own.along(link, record, None),
                    (Some(own), Some(Ok(Some(above)))) => own.along(link, record, Some(above)),
                    // The velocities of bodies are those after `tatu.setState`; without bodies, that of the last step.
                    _ => world.f64(record.owner, p.velocity)?,
                };
            }
            Joint::Spherical => {
                let [x, y, z, w] = world.f64s::<4>(record.owner, p.rotation)?;
                state.q[at..at + 4].copy_from_slice(&[w, x, y, z]);
                let above = link.parent.map_or(Ok(None), motion)?.map_or_else(Vector3::zeros, |m| m.angular);
                if let Some(own) = motion(i)? {
                    let spin = record.pose.rotation.inverse() * (own.angular - above);
                    state.v[v..v + 3].copy_from_slice(spin.as_slice());
                }
            }
            Joint::Free => {
                let [x, y, z, qx, qy, qz, qw] = world.pose(record.owner, 0)?;
                state.q[at..at + 7].copy_from_slice(&[x, y, z, qw, qx, qy, qz]);
                if let Some(own) = motion(i)? {
                    let linear = own.at(&record.pose.translation.vector);
                    let spin = record.pose.rotation.inverse() * own.angular;
                    state.v[v..v + 3].copy_from_slice(linear.as_slice());
                    state.v[v + 3..v + 6].copy_from_slice(spin.as_slice());
                }
            }
        }
    }
    Ok(state)
}

/// Moves the mechanism of the scene to a state.
///
/// # Errors
///
/// Fails if a property cannot be set, or the state does not fit the tree.
pub fn write(world: &World<'_>, p: &MechanismProps, mechanism: &Mechanism, tree: &Tree, state: &TreeState) -> Result {
    let mut kinematics = Kinematics::new(tree);
    kinematics.update(tree, state).map_err(|e| Fail::argument(e.to_string()))?;
    for (i, (link, record)) in mechanism.links.iter().zip(&mechanism.records).enumerate() {
        let Some((at, _)) = tree.offsets(i) else { continue };
        match link.joint {
            Joint::Fixed => {}
            Joint::Revolute(_) | Joint::Prismatic(_) => world.set_f64s(record.owner, p.position, &state.q[at..=at])?,
            Joint::Spherical => {
                let q = &state.q[at..at + 4];
                world.set_f64s(record.owner, p.rotation, &[q[1], q[2], q[3], q[0]])?;
            }
            Joint::Free => {
                let q = &state.q[at..at + 7];
                world.set_pose(record.owner, 0, &[q[0], q[1], q[2], q[4], q[5], q[6], q[3]])?;
            }
        }
    }
    for (i, record) in mechanism.records.iter().enumerate() {
        let Some(pose) = kinematics.pose(i) else { continue };
        for body in &record.bodies {
            let center = pose * Point3::from(body.center);
            let Some((angular, linear)) = kinematics.velocity(i, center.coords) else { continue };
            world.set_twist(body.object, &[linear.x, linear.y, linear.z, angular.x, angular.y, angular.z])?;
        }
    }
    Ok(())
}

/// Moves positions by a small change of the velocities' directions: positions after a unit of time at these velocities.
pub fn advanced(mechanism: &Mechanism, tree: &Tree, state: &TreeState, velocity: usize, by: f64) -> TreeState {
    let mut moved = state.clone();
    for (i, link) in mechanism.links.iter().enumerate() {
        let Some((at, v)) = tree.offsets(i) else { continue };
        let Some(k) = velocity.checked_sub(v).filter(|k| *k < link.joint.velocities()) else { continue };
        match link.joint {
            Joint::Free if k < 3 => moved.q[at + k] += by,
            Joint::Free => turn(&mut moved.q[at + 3..at + 7], k - 3, by),
            Joint::Spherical => turn(&mut moved.q[at..at + 4], k, by),
            _ => moved.q[at] += by,
        }
    }
    moved
}

/// Turns a quaternion w x y z about one of its own axes.
fn turn(quaternion: &mut [f64], axis: usize, angle: f64) {
    let own =
        UnitQuaternion::new_normalize(Quaternion::new(quaternion[0], quaternion[1], quaternion[2], quaternion[3]));
    let (sine, cosine) = libm::sincos(0.5 * angle);
    let part = Vector3::ith(axis, sine);
    let turned = own * UnitQuaternion::new_unchecked(Quaternion::new(cosine, part.x, part.y, part.z));
    quaternion.copy_from_slice(&[turned.w, turned.i, turned.j, turned.k]);
}

/// Returns a pose from three numbers and a quaternion x y z w, or `None` if the quaternion has no direction.
pub fn pose(numbers: &[f64]) -> Option<Isometry3<f64>> {
    let [x, y, z, rest @ ..] = numbers else { return None };
    let turned = match rest {
        [] => UnitQuaternion::identity(),
        [qx, qy, qz, qw] => UnitQuaternion::try_new(Quaternion::new(*qw, *qx, *qy, *qz), 1e-9)?,
        _ => return None,
    };
    let is_finite = numbers.iter().all(|x| x.is_finite());
    is_finite.then(|| Isometry3::from_parts(Translation3::new(*x, *y, *z), turned))
}
