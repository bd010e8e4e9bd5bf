//! A Panda with its hand: the capsules of `models/panda/model.toml`, and capsules around a Franka Hand.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use nalgebra::{Isometry3, Vector3};
use tatu_geometry::Form;
use tatu_kinematics::{FrameId, JointType, Linkage};
use tatu_planning::{
    StateSpace,
    spheres::{Body, FrameMotion, FrameTree, MovingFrame},
};

/// Limits of the joints, rad.
pub const LIMITS: [[f64; 2]; 7] = [
    [-2.8973, 2.8973],
    [-1.7628, 1.7628],
    [-2.8973, 2.8973],
    [-3.0718, -0.0698],
    [-2.8973, 2.8973],
    [-0.0175, 3.7525],
    [-2.8973, 2.8973],
];
/// The ready pose, rad.
pub const READY: [f64; 7] = [0.0, -FRAC_PI_4, 0.0, -3.0 * FRAC_PI_4, 0.0, FRAC_PI_2, FRAC_PI_4];
/// Poses of the joints in their parents: the position, m, and the angle about x, rad.
const JOINTS: [([f64; 3], f64); 7] = [
    ([0.0, 0.0, 0.333], 0.0),
    ([0.0, 0.0, 0.0], -FRAC_PI_2),
    ([0.0, -0.316, 0.0], FRAC_PI_2),
    ([0.0825, 0.0, 0.0], FRAC_PI_2),
    ([-0.0825, 0.384, 0.0], -FRAC_PI_2),
    ([0.0, 0.0, 0.0], FRAC_PI_2),
    ([0.088, 0.0, 0.0], FRAC_PI_2),
];
/// From the last joint to the flange, and from there to the point between the fingers, m.
const FLANGE: f64 = 0.107;
const TOOL: f64 = 0.1034;

fn joint_pose(i: usize) -> Isometry3<f64> {
    let ([x, y, z], angle) = JOINTS[i];
    Isometry3::new(Vector3::new(x, y, z), Vector3::x() * angle)
}

/// The pose of the hand on the last link.
fn hand() -> Isometry3<f64> {
    Isometry3::new(Vector3::new(0.0, 0.0, FLANGE), Vector3::z() * -FRAC_PI_4)
}

/// Returns the state space: the positions of the joints.
pub fn space() -> StateSpace {
    match StateSpace::reals(&LIMITS.map(|l| l[0]), &LIMITS.map(|l| l[1])) {
        Ok(space) => space,
        Err(error) => unreachable!("the limits are finite: {error}"),
    }
}

/// Returns the frames of the joints.
pub fn frames() -> FrameTree {
    let mut tree = FrameTree::default();
    for i in 0..7 {
        let motion = FrameMotion::Turn { number: i, factor: 1.0, offset: 0.0, lead: 0.0 };
        tree.add(MovingFrame { parent: i.checked_sub(1), pose: joint_pose(i), motion });
    }
    tree
}

/// A capsule along z: diameter and whole length, position, and the angle about y, rad.
type Capsule = (f64, f64, [f64; 3], f64);

/// Links 0 to 7, then the hand.
const CAPSULES: [&[Capsule]; 9] = [
    &[(0.12, 0.15, [-0.075, 0.0, 0.06], FRAC_PI_2)],
    &[(0.12, 0.403, [0.0, 0.0, -0.1915], 0.0)],
    &[(0.12, 0.24, [0.0, 0.0, 0.0], 0.0)],
    &[(0.12, 0.27, [0.0, 0.0, -0.145], 0.0)],
    &[(0.12, 0.24, [0.0, 0.0, 0.0], 0.0)],
    &[(0.12, 0.22, [0.0, 0.0, -0.26], 0.0), (0.05, 0.19, [0.0, 0.08, -0.13], 0.0)],
    &[(0.10, 0.18, [0.0, 0.0, -0.03], 0.0)],
    &[(0.08, 0.22, [0.0, 0.0, 0.01], 0.0), (0.06, 0.07, [0.04243, 0.04243, 0.082], FRAC_PI_2)],
    // The hand is 204 mm wide and 63 mm thick, its fingers end 112 mm before the flange (Franka Hand, product manual).
    &[(0.075, 0.21, [0.0, 0.0, 0.035], f64::NAN), (0.05, 0.11, [0.0, 0.0, 0.085], 0.0)],
];

/// Returns the links, of which the first stays, and the hand.
pub fn bodies() -> Vec<Body> {
    let forms = |capsules: &[Capsule], frame: &Isometry3<f64>| {
        let form = |(diameter, length, [x, y, z], angle): &Capsule| {
            // Across the hand, along y.
            let turn = if angle.is_nan() { Vector3::x() * FRAC_PI_2 } else { Vector3::y() * *angle };
            let form = Form::Capsule { radius: 0.5 * diameter, half_length: 0.5 * (length - diameter) };
            (frame * Isometry3::new(Vector3::new(*x, *y, *z), turn), form)
        };
        capsules.iter().map(form).collect()
    };
    let here = Isometry3::identity();
    let mut bodies = vec![Body { frame: None, forms: forms(CAPSULES[0], &here) }];
    bodies.extend((1..8).map(|i| Body { frame: Some(i - 1), forms: forms(CAPSULES[i], &here) }));
    bodies.push(Body { frame: Some(6), forms: forms(CAPSULES[8], &hand()) });
    bodies
}

/// Pairs of links that may not touch: those that are not neighbours and do not overlap by construction.
pub const SELF_PAIRS: [[usize; 2]; 13] =
    [[0, 5], [0, 6], [0, 7], [0, 8], [1, 5], [1, 6], [1, 7], [1, 8], [2, 5], [2, 7], [2, 8], [3, 7], [3, 8]];

/// Returns the arm for inverse kinematics: its joints, the point between its fingers, and a target.
pub fn linkage() -> (Linkage, [FrameId; 7], FrameId, FrameId) {
    let mut arm = Linkage::default();
    let mut parent = None;
    let joints = std::array::from_fn(|i| {
        let id = arm.add_joint(parent, joint_pose(i), JointType::Revolute);
        if let Some(joint) = arm.joint_mut(id) {
            joint.limits = Some(LIMITS[i]);
        }
        parent = Some(id);
        id
    });
    let tip = arm.add_frame(parent, hand() * Isometry3::translation(0.0, 0.0, TOOL));
    let target = arm.add_frame(None, Isometry3::identity());
    (arm, joints, tip, target)
}
