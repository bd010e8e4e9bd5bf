//! The efforts that are assumed for joints whose file states none.

use nalgebra::{Isometry3, Point3, Vector3};
use tatu_importers_common::Mass;

use crate::{
    robot::{JointKind, Robot},
    tree::{BodyTree, LinkGroup},
};

/// Acceleration of gravity, m/s^2.
const GRAVITY: f64 = 9.81;
/// Factor between the effort that lifts a load and the one that is assumed, so that the load can be accelerated.
const MARGIN: f64 = 2.0;
/// Effort of joints of a robot whose file states no masses, N m or N.
const WEIGHTLESS_EFFORT: f64 = 1.0;
/// Smallest lever that is assumed, m.
const MIN_LEVER: f64 = 1e-3;

/// What the effort of a joint depends on.
pub struct Load {
    /// Distance of the farthest point that the joint moves from its axis, m, in the pose of the file.
    pub lever: f64,
    /// Sum of mass times the greatest distance from the joint that other joints allow, kg m, of what the joint moves.
    reach: f64,
}

/// Returns an effort for the joint above each body, N m or N; that of the root is 0.
///
/// Revolute and prismatic joints can lift the whole robot with what they move, as legs must and as arms can. Continuous
/// joints can hold what they move, stretched out, and together push the robot with its weight, as wheels do.
pub fn assumed_efforts(robot: &Robot, tree: &BodyTree, masses: &[Mass], loads: &[Load], fixed_base: bool) -> Vec<f64> {
    let moving = &masses[usize::from(fixed_base).min(masses.len())..];
    let weight = GRAVITY * moving.iter().map(|m| m.mass).sum::<f64>();
    let kind = |body: usize| tree.bodies[body].joint.as_ref().map(|(j, ..)| robot.joints[*j].kind);
    let turning = (0..tree.bodies.len()).filter(|b| kind(*b) == Some(JointKind::Continuous)).count().max(1);
    let effort = |body: usize| {
        let Load { lever, reach } = loads[body];
        match kind(body) {
            None => 0.0,
            Some(_) if weight <= 0.0 => WEIGHTLESS_EFFORT,
            Some(JointKind::Prismatic) => MARGIN * weight,
            Some(JointKind::Continuous) => {
                (weight * lever.max(MIN_LEVER) / turning as f64).max(MARGIN * GRAVITY * reach)
            }
            Some(_) => MARGIN * weight * lever.max(MIN_LEVER),
        }
    };
    (0..tree.bodies.len()).map(|body| rounded(effort(body))).collect()
}

/// Vertical component of the axis from which on a joint is taken for the swivel of a castor.
const SWIVEL_VERTICAL: f64 = 0.99;

/// Returns for each body whether the joint above it belongs to a castor, which has no motor: a continuous joint about a
/// vertical axis that carries nothing but wheels on continuous joints, or one of these.
pub fn castors(robot: &Robot, tree: &BodyTree, poses: &[Isometry3<f64>]) -> Vec<bool> {
    let bodies = &tree.bodies;
    let is_continuous = |body: usize| {
        let joint = bodies[body].joint.as_ref();
        joint.is_some_and(|(j, ..)| robot.joints[*j].kind == JointKind::Continuous)
    };
    let vertical = |body: usize| {
        let joint = poses[body] * bodies[body].below.inverse();
        (joint * Vector3::z()).z.abs()
    };
    let children = |body: usize| {
        let is_child = move |b: &usize| bodies[*b].joint.as_ref().is_some_and(|(_, above, _)| *above == body);
        (0..bodies.len()).filter(is_child)
    };
    let is_wheel =
        |body: usize| is_continuous(body) && vertical(body) < 1.0 - SWIVEL_VERTICAL && children(body).next().is_none();
    let mut found = vec![false; bodies.len()];
    for body in 0..bodies.len() {
        let is_swivel = is_continuous(body) && vertical(body) > SWIVEL_VERTICAL;
        if is_swivel && children(body).next().is_some() && children(body).all(is_wheel) {
            found[body] = true;
            children(body).for_each(|wheel| found[wheel] = true);
        }
    }
    found
}

/// Returns the load of the joint above each body; `points` are those of the surfaces of each body, in its frame, and
/// `poses` the poses of bodies.
pub fn loads(tree: &BodyTree, masses: &[Mass], points: &[Vec<Vector3<f64>>], poses: &[Isometry3<f64>]) -> Vec<Load> {
    let axis = |(body, pose): (&LinkGroup, &Isometry3<f64>)| {
        let joint = pose * body.below.inverse();
        (Point3::from(joint.translation.vector), joint * Vector3::z())
    };
    let axes: Vec<(Point3<f64>, Vector3<f64>)> = tree.bodies.iter().zip(poses).map(axis).collect();
    let mut loads: Vec<Load> = tree.bodies.iter().map(|_| Load { lever: 0.0, reach: 0.0 }).collect();
    for (body, pose) in poses.iter().enumerate() {
        let centre = pose * Point3::from(masses[body].com);
        let hull: Vec<Point3<f64>> = points[body].iter().map(|p| pose * Point3::from(*p)).collect();
        let mut length = (centre - axes[body].0).norm();
        let mut at = Some(body);
        while let Some(joint) = at {
            let (origin, axis) = axes[joint];
            let distance = |p: &Point3<f64>| (p - origin).cross(&axis).norm();
            let lever = hull.iter().chain([&centre]).map(distance).fold(0.0, f64::max);
            loads[joint].lever = loads[joint].lever.max(lever);
            loads[joint].reach += masses[body].mass * length;
            at = tree.bodies[joint].joint.as_ref().map(|(_, above, _)| *above);
            if let Some(above) = at {
                length += (origin - axes[above].0).norm();
            }
        }
    }
    loads
}

/// Rounds to two digits, since an assumed value should not look exact.
fn rounded(x: f64) -> f64 {
    if x <= 0.0 || !x.is_finite() {
        return 0.0;
    }
    format!("{x:.1e}").parse().unwrap_or(x)
}
