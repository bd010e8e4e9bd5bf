//! State spaces of objects, and the states in which they are.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use tatu_kinematics_common::pose_of;
use tatu_planning::{CarMotion, StateSpace, Subspace};
use tatu_plugin_api::safe::{Fail, Result, World};

use crate::state::{ObjectSpace, Planning, SpaceKind};

/// Divides an orientation into the part of alpha and beta, and gamma, rad: rotations about x, y and z, each about the
/// axes that the ones before have turned.
pub fn euler_parts(rotation: &UnitQuaternion<f64>) -> (UnitQuaternion<f64>, f64) {
    let r = rotation.to_rotation_matrix();
    let r = r.matrix();
    let gamma = libm::atan2(-r[(0, 1)], r[(0, 0)]);
    (rotation * about_z(-gamma), gamma)
}

fn about_z(angle: f64) -> UnitQuaternion<f64> {
    let (sine, cosine) = libm::sincos(0.5 * angle);
    UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(cosine, 0.0, 0.0, sine))
}

/// Returns the space of the states of several objects, one after another.
pub fn state_space(spaces: &[ObjectSpace]) -> Result<StateSpace> {
    if spaces.is_empty() {
        return Err(Fail::argument("the task has no state space").help("call simOMPL.setStateSpace first"));
    }
    let mut parts = Vec::new();
    for space in spaces {
        let (low, high) = (space.low.clone(), space.high.clone());
        let place = Subspace::Reals { low: low.clone(), high: high.clone() };
        match space.kind {
            SpaceKind::Position2 | SpaceKind::Position3 | SpaceKind::Joint => parts.push((place, space.weight)),
            SpaceKind::Pose2 => parts.extend([(place, space.weight), (Subspace::Circle, 0.5 * space.weight)]),
            SpaceKind::Pose3 => parts.extend([(place, space.weight), (Subspace::Rotation, space.weight)]),
            SpaceKind::CyclicJoint => parts.push((Subspace::Circle, space.weight)),
            SpaceKind::Dubins => {
                let bound = |b: &[f64]| [b.first().copied().unwrap_or(0.0), b.get(1).copied().unwrap_or(0.0)];
                let motion = if space.symmetric { CarMotion::SymmetricDubins } else { CarMotion::Dubins };
                let car = Subspace::Car { low: bound(&low), high: bound(&high), radius: space.radius, motion };
                parts.push((car, space.weight));
            }
        }
    }
    StateSpace::new(parts).map_err(|e| Fail::argument(e.0))
}

/// Returns the state in which the objects are.
pub fn read_state(world: &World<'_>, props: &Planning, spaces: &[ObjectSpace]) -> Result<Vec<f64>> {
    let mut state = Vec::new();
    for space in spaces {
        if space.kind.is_joint() {
            state.push(world.f64(space.object, props.joint_position)?);
            continue;
        }
        let [x, y, z, qx, qy, qz, qw] = world.pose(space.object, space.reference.unwrap_or(0))?;
        let pose = pose_of([x, y, z, qx, qy, qz, qw]);
        match space.kind {
            SpaceKind::Position2 => state.extend([x, y]),
            SpaceKind::Position3 => state.extend([x, y, z]),
            SpaceKind::Pose3 => state.extend([x, y, z, qx, qy, qz, qw]),
            _ => state.extend([x, y, euler_parts(&pose.rotation).1]),
        }
    }
    Ok(state)
}

/// Moves the objects to a state.
pub fn write_state(world: &World<'_>, props: &Planning, spaces: &[ObjectSpace], state: &[f64]) -> Result {
    let mut rest = state;
    for space in spaces {
        let (own, after) = rest.split_at(space.kind.dimension());
        rest = after;
        if space.kind.is_joint() {
            world.set_f64s(space.object, props.joint_position, own)?;
            continue;
        }
        let frame = space.reference.unwrap_or(0);
        let mut pose = world.pose(space.object, frame)?;
        match space.kind {
            SpaceKind::Position2 | SpaceKind::Position3 | SpaceKind::Pose3 => pose[..own.len()].copy_from_slice(own),
            _ => {
                let (tilt, _) = euler_parts(&pose_of(pose).rotation);
                let q = (tilt * about_z(own[2])).coords;
                pose = [own[0], own[1], pose[2], q.x, q.y, q.z, q.w];
            }
        }
        world.set_pose(space.object, frame, &pose)?;
    }
    Ok(())
}

/// Returns the distance of two poses by weights for x, y, z and the angle.
pub fn weighted_distance(a: &Isometry3<f64>, b: &Isometry3<f64>, metric: &[f64; 4]) -> f64 {
    let along =
        Vector3::new(metric[0], metric[1], metric[2]).component_mul(&(a.translation.vector - b.translation.vector));
    let q = a.rotation.inverse() * b.rotation;
    let angle = 2.0 * libm::atan2(q.imag().norm(), q.w.abs());
    let turned = metric[3] * angle;
    libm::sqrt(along.norm_squared() + turned * turned)
}
