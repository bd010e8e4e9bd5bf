//! Asks for goals that cannot be reached, by kind, and counts how often the reason is the right one. What is right
//! follows from closed forms of a planar arm with links of 0.5 and 0.4 m; for the arm with seven joints, from the
//! positions that the goal was computed from.
//!
//! ```sh
//! cargo run --release -p tatu-kinematics --example reasons
//! ```

#![allow(clippy::disallowed_methods, reason = "expected values do not affect results")]

use std::{f64::consts::FRAC_PI_2, time::Instant};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use tatu_kinematics::{Constraints, FrameId, Goal, JointType, Linkage, ReachSettings, ReachSolver, Reached, Refusal};

const GOALS: usize = 2000;
const LINKS: [f64; 2] = [0.5, 0.4];
/// Limit of the elbow, rad, where it has one.
const ELBOW: f64 = 1.0;

/// Random numbers, SplitMix64.
struct Numbers(u64);

impl Numbers {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn planar(elbow_limit: Option<f64>) -> (Linkage, Vec<FrameId>, FrameId) {
    let mut arm = Linkage::default();
    let shoulder = arm.add_joint(None, Isometry3::identity(), JointType::Revolute);
    let elbow = arm.add_joint(Some(shoulder), Isometry3::translation(LINKS[0], 0.0, 0.0), JointType::Revolute);
    let tip = arm.add_frame(Some(elbow), Isometry3::translation(LINKS[1], 0.0, 0.0));
    if let Some(joint) = arm.joint_mut(elbow) {
        joint.limits = elbow_limit.map(|limit| [-limit, limit]);
    }
    (arm, vec![shoulder, elbow], tip)
}

/// An arm with seven joints, with lengths and limits of the Panda.
fn seven() -> (Linkage, FrameId) {
    let table = [
        (0.0, 0.333, 0.0, [-2.8973, 2.8973]),
        (0.0, 0.0, -FRAC_PI_2, [-1.7628, 1.7628]),
        (0.0, 0.316, FRAC_PI_2, [-2.8973, 2.8973]),
        (0.0825, 0.0, FRAC_PI_2, [-3.0718, -0.0698]),
        (-0.0825, 0.384, -FRAC_PI_2, [-2.8973, 2.8973]),
        (0.0, 0.0, FRAC_PI_2, [-0.0175, 3.7525]),
        (0.088, 0.0, FRAC_PI_2, [-2.8973, 2.8973]),
    ];
    let (mut arm, mut last) = (Linkage::default(), None);
    for (a, d, alpha, limits) in table {
        let turn = UnitQuaternion::from_euler_angles(alpha, 0.0, 0.0);
        let place = Vector3::new(a, 0.0, 0.0) + turn * Vector3::new(0.0, 0.0, d);
        let joint = arm.add_joint(last, Isometry3::from_parts(Translation3::from(place), turn), JointType::Revolute);
        if let Some(joint) = arm.joint_mut(joint) {
            joint.limits = Some(limits);
        }
        last = Some(joint);
    }
    let tip = arm.add_frame(last, Isometry3::translation(0.0, 0.0, 0.107));
    (arm, tip)
}

fn position(radius: f64, angle: f64) -> Goal {
    Goal::position(Vector3::new(radius * angle.cos(), radius * angle.sin(), 0.0))
}

/// Returns the tip's distance from the shoulder for an angle of the elbow.
fn radius(elbow: f64) -> f64 {
    let [a, b] = LINKS;
    (a * a + b * b + 2.0 * a * b * elbow.cos()).sqrt()
}

type Outcome = Result<Reached, Refusal>;

/// Counts the right reasons for goals that `ask` draws and solves for.
fn count(kind: &str, mut ask: impl FnMut(&mut Numbers) -> Option<(Outcome, bool)>) {
    let (mut random, mut right, mut asked, mut wrong) = (Numbers(3), 0, 0, None);
    let begin = Instant::now();
    while asked < GOALS {
        let Some((outcome, is_right)) = ask(&mut random) else { continue };
        asked += 1;
        right += usize::from(is_right);
        if !is_right && wrong.is_none() {
            wrong = Some(outcome);
        }
    }
    let each = begin.elapsed().as_secs_f64() / asked as f64 * 1e6;
    println!(
        "{kind:44} {right:5} of {asked} {each:8.0} us{}",
        wrong.map_or(String::new(), |w| format!("  such as {w:?}"))
    );
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (arm, joints, tip) = planar(None);
    let mut solver = ReachSolver::new(&arm, &[tip])?;
    let start = [0.3, 0.8];
    let mut none = |_: &[f64]| None;
    let close = |a: f64, b: f64| (a - b).abs() < 1e-4;
    count("too far, by the right distance", |random| {
        let goal = position(random.between(0.91, 3.0), random.between(-3.1, 3.1));
        let missing = goal.pose.translation.vector.norm() - LINKS[0] - LINKS[1];
        let outcome = solver.solve(&[goal], &ReachSettings::from(&start), &mut none);
        let right = matches!(outcome, Err(Refusal::OutOfReach { by, inside: false, .. }) if close(by, missing));
        Some((outcome, right))
    });
    count("inside the dead zone, by the right distance", |random| {
        let goal = position(random.between(0.001, 0.099), random.between(-3.1, 3.1));
        let missing = LINKS[0] - LINKS[1] - goal.pose.translation.vector.norm();
        let outcome = solver.solve(&[goal], &ReachSettings::from(&start), &mut none);
        let right = matches!(outcome, Err(Refusal::OutOfReach { by, inside: true, .. }) if close(by, missing));
        Some((outcome, right))
    });
    count("orientation, by the right angle", |random| {
        let (q, tilt) = ([random.between(-3.1, 3.1), random.between(0.2, 2.9)], random.between(0.01, 1.5));
        let mut chain = solver.chain().clone();
        chain.place(&q);
        let mut pose = chain.pose(0)?;
        pose.rotation *= UnitQuaternion::from_euler_angles(tilt, 0.0, 0.0);
        let goal = Goal { constraints: Constraints::POSITION | Constraints::ALPHA_BETA, ..Goal::new(pose) };
        let outcome = solver.solve(&[goal], &ReachSettings::from(&start), &mut none);
        let right = matches!(outcome, Err(Refusal::Orientation { by }) if close(by, tilt));
        Some((outcome, right))
    });
    count("singular, in the right direction", |random| {
        let (angle, pull) = (random.between(-3.1, 3.1), random.between(0.05, 0.7));
        let straight = [angle, 0.0];
        let settings = ReachSettings { restarts: 0, ..ReachSettings::from(&straight) };
        let outcome = solver.solve(&[position(0.9 - pull, angle)], &settings, &mut none);
        let inward = [-angle.cos(), -angle.sin()];
        let right = matches!(outcome, Err(Refusal::Singular { direction })
            if close(direction[0], inward[0]) && close(direction[1], inward[1]));
        // Rounding of the angle may be enough to leave the singular position.
        outcome.is_err().then_some((outcome, right))
    });
    count("collision, with the right object", |random| {
        let goal = position(random.between(0.2, 0.85), random.between(-3.1, 3.1));
        let object = random.between(0.0, 1e6) as u64;
        let outcome = solver.solve(&[goal], &ReachSettings::from(&start), &mut |_| Some(object));
        let right = outcome == Err(Refusal::Collision(object));
        Some((outcome, right))
    });
    let (limited, _, limited_tip) = planar(Some(ELBOW));
    let mut limited = ReachSolver::new(&limited, &[limited_tip])?;
    count("limit of the elbow, by the right angle", |random| {
        let elbow = random.between(ELBOW + 0.01, 3.0);
        let goal = position(radius(elbow), random.between(-3.1, 3.1));
        let outcome = limited.solve(&[goal], &ReachSettings::from(&start), &mut none);
        let right = matches!(outcome, Err(Refusal::Limit { joint, by })
            if joint == joints[1] && close(by.abs(), elbow - ELBOW));
        Some((outcome, right))
    });
    let (seven, seven_tip) = seven();
    let mut seven = ReachSolver::new(&seven, &[seven_tip])?;
    let middle: Vec<f64> = seven.chain().limits().iter().map(|[low, high]| 0.5 * (low + high)).collect();
    count("limit of any of seven joints", |random| {
        let mut chain = seven.chain().clone();
        let mut q: Vec<f64> = chain.limits().iter().map(|[low, high]| random.between(*low, *high)).collect();
        let beyond = random.between(0.0, 7.0) as usize;
        q[beyond] = chain.limits()[beyond][1] + random.between(0.05, 0.8);
        chain.place(&q);
        let outcome = seven.solve(&[Goal::new(chain.pose(0)?)], &ReachSettings::from(&middle), &mut none);
        let right = matches!(outcome, Err(Refusal::Limit { .. }));
        // Most such poses can also be reached within the limits.
        outcome.is_err().then_some((outcome, right))
    });
    count("seven joints, too far", |random| {
        let direction = Vector3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(-0.5, 1.0));
        let reach = 0.333 + 0.316 + 0.384 + 2.0 * 0.0825 + 0.088 + 0.107;
        let at = direction.normalize() * random.between(reach + 0.05, 3.0);
        let turn = UnitQuaternion::from_euler_angles(random.between(-3.0, 3.0), random.between(-1.5, 1.5), 0.0);
        let goal = Goal::new(Isometry3::from_parts(Translation3::from(at), turn));
        let outcome = seven.solve(&[goal], &ReachSettings::from(&middle), &mut none);
        let right = matches!(outcome, Err(Refusal::OutOfReach { inside: false, oriented: false, .. }));
        Some((outcome, right))
    });
    Ok(())
}
