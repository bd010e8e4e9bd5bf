//! The solver that keeps limits: what it finds, and the reasons that it returns.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use tatu_kinematics::*;

use crate::arms::{Arm, near, unit};

fn free(_: &[f64]) -> Option<u64> {
    None
}

/// Solves for a position of a planar arm from some positions, with no other starts if `here`.
fn plan(arm: &Arm, start: &[f64], at: [f64; 2], here: bool) -> Result<Vec<f64>, Refusal> {
    let mut solver = ReachSolver::new(&arm.linkage, &[arm.tip]).unwrap();
    let mut settings = ReachSettings::from(start);
    if here {
        settings.restarts = 0;
    }
    let goal = Goal::position(Vector3::new(at[0], at[1], 0.0));
    solver.solve(&[goal], &settings, &mut free)?;
    Ok(solver.positions().to_vec())
}

/// Returns the share of random poses that are reached from the middle of the limits.
fn share_reached(arm: &Arm, n: usize) -> f64 {
    let mut solver = ReachSolver::new(&arm.linkage, &[arm.tip]).unwrap();
    let mut chain = solver.chain().clone();
    let limits = chain.limits().to_vec();
    let middle: Vec<f64> = limits.iter().map(|[low, high]| 0.5 * (low + high)).collect();
    let (mut random, mut reached) = (7, 0);
    for _ in 0..n {
        let q: Vec<f64> = limits.iter().map(|[low, high]| low + (high - low) * unit(&mut random)).collect();
        chain.place(&q);
        let goal = Goal::new(chain.pose(0).unwrap());
        if solver.solve(&[goal], &ReachSettings::from(&middle), &mut free).is_err() {
            continue;
        }
        reached += 1;
        assert!(solver.positions().iter().zip(&limits).all(|(q, [low, high])| (*low..=*high).contains(q)));
        let mut copy = arm.linkage.clone();
        for (joint, q) in solver.joints().iter().zip(solver.positions()) {
            copy.set_position(*joint, *q);
        }
        let pose = copy.pose(arm.tip);
        assert!((pose.translation.vector - goal.pose.translation.vector).norm() < 1.001e-6);
        assert!(pose.rotation.angle_to(&goal.pose.rotation) < 1.01e-6);
    }
    reached as f64 / n as f64
}

#[test]
fn random_poses_are_reached_within_limits() {
    for arm in [Arm::ur5(), Arm::panda(), Arm::iiwa()] {
        let share = share_reached(&arm, 400);
        assert!(share >= 0.995, "{share}");
    }
}

/// Facts: the nearest point of the arm's circle is 0.336932 away, and its hole has a radius of 0.5 - 0.4.
#[test]
fn distance_of_a_goal_out_of_reach_is_returned() {
    let arm = Arm::planar(&[0.5, 0.4]);
    let outside = plan(&arm, &[0.5, 0.5], [1.2, 0.3], false).unwrap_err();
    let Refusal::OutOfReach { by, inside: false, oriented: false } = outside else { panic!("{outside:?}") };
    assert!((by - 0.336932).abs() < 1e-5, "{by}");
    let inside = plan(&arm, &[0.5, 0.5], [0.03, 0.04], false).unwrap_err();
    let Refusal::OutOfReach { by, inside: true, oriented: false } = inside else { panic!("{inside:?}") };
    assert!((by - 0.05).abs() < 1e-5, "{by}");
}

#[test]
fn joint_that_must_exceed_its_limit_is_named() {
    let mut arm = Arm::planar(&[0.5, 0.4]);
    arm.set(&[0.2, 0.9]);
    let at = arm.linkage.pose(arm.tip).translation.vector;
    arm.linkage.joint_mut(arm.joints[1]).unwrap().limits = Some([-0.5, 0.5]);
    let reason = plan(&arm, &[0.0, 0.0], [at.x, at.y], false).unwrap_err();
    let Refusal::Limit { joint, by } = reason else { panic!("{reason:?}") };
    assert_eq!(joint, arm.joints[1]);
    assert!((by.abs() - 0.4).abs() < 1e-5, "{by}");
}

#[test]
fn direction_in_which_a_straight_arm_cannot_move_is_returned() {
    let arm = Arm::planar(&[0.5, 0.4]);
    let reason = plan(&arm, &[0.0, 0.0], [0.85, 0.0], true).unwrap_err();
    let Refusal::Singular { direction } = reason else { panic!("{reason:?}") };
    near(&direction, &[-1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 1e-9);
    // From other positions, the arm reaches the goal.
    assert!(plan(&arm, &[0.0, 0.0], [0.85, 0.0], false).is_ok());
}

#[test]
fn impossible_orientation_is_refused_with_its_angle() {
    let mut arm = Arm::planar(&[0.5, 0.4]);
    arm.set(&[0.3, 0.8]);
    let tilt = UnitQuaternion::from_euler_angles(0.3, 0.0, 0.0);
    let pose = Isometry3::from_parts(arm.linkage.pose(arm.tip).translation, tilt);
    let constraints = Constraints::POSITION | Constraints::ALPHA_BETA;
    let mut solver = ReachSolver::new(&arm.linkage, &[arm.tip]).unwrap();
    let goal = Goal { constraints, ..Goal::new(pose) };
    let reason = solver.solve(&[goal], &ReachSettings::from(&[0.1, 0.5]), &mut free).unwrap_err();
    let Refusal::Orientation { by } = reason else { panic!("{reason:?}") };
    assert!((by - 0.3).abs() < 1e-6, "{by}");
}

#[test]
fn positions_change_by_at_most_the_given_amount() {
    let arm = Arm::planar(&[0.5, 0.4]);
    let mut solver = ReachSolver::new(&arm.linkage, &[arm.tip]).unwrap();
    let goal = Goal::position(Vector3::new(0.3, 0.6, 0.0));
    let start = [0.5, 0.5];
    let settings = ReachSettings { max_change: Some(&[0.1, 0.1]), ..ReachSettings::from(&start) };
    let reason = solver.solve(&[goal], &settings, &mut free).unwrap_err();
    // The elbow must turn by 0.970628906 (facts), of which 0.1 are permitted.
    let Refusal::Change { joint, by } = reason else { panic!("{reason:?}") };
    assert_eq!(joint, arm.joints[1]);
    assert!((by - 0.870628906).abs() < 1e-5, "{by}");
    assert!(solver.positions().iter().zip(start).all(|(q, from)| (q - from).abs() <= 0.1 + 1e-15));
    // A target is followed in steps, as a robot with velocity limits does.
    let mut q = start.to_vec();
    for _ in 0..20 {
        let settings = ReachSettings { max_change: Some(&[0.1, 0.1]), ..ReachSettings::from(&q) };
        let done = solver.solve(&[goal], &settings, &mut free).is_ok();
        q = solver.positions().to_vec();
        if done {
            near(&q, &[0.472001686, 1.470628906], 1e-5);
            return;
        }
    }
    panic!("the goal was not reached: {q:?}");
}

#[test]
fn solution_that_collides_is_replaced_by_another_or_refused() {
    let arm = Arm::planar(&[0.5, 0.4]);
    let mut solver = ReachSolver::new(&arm.linkage, &[arm.tip]).unwrap();
    let goal = Goal::position(Vector3::new(0.659106693, 0.504243047, 0.0));
    let settings = ReachSettings::from(&[0.3, 0.7]);
    let mut elbow_down = |q: &[f64]| (q[1] > 0.0).then_some(7);
    solver.solve(&[goal], &settings, &mut elbow_down).unwrap();
    near(solver.positions(), &[1.006114974, -0.8], 1e-5);
    let refused = solver.solve(&[goal], &settings, &mut |_| Some(7));
    assert_eq!(refused, Err(Refusal::Collision(7)));
}

#[test]
fn posture_is_taken_by_joints_that_the_goal_leaves_free() {
    let arm = Arm::planar(&[0.5, 0.4, 0.3]);
    let mut solver = ReachSolver::new(&arm.linkage, &[arm.tip]).unwrap();
    let goal = Goal::position(Vector3::new(0.6, 0.5, 0.0));
    let posture = [0.2, 0.3, 1.4];
    let settings = ReachSettings { posture: Some(&posture), iterations: 200, ..ReachSettings::from(&[0.1, 0.5, 0.5]) };
    let reached = solver.solve(&[goal], &settings, &mut free).unwrap();
    assert!(reached.distance.distance <= 1e-6);
    // At the nearest point, the way to the posture is perpendicular to the motion that leaves the tip in place.
    let q = solver.positions();
    let [x, y] = [q[0], q[0] + q[1]].map(|a| Vector3::new(a.cos(), a.sin(), 0.0));
    let z = Vector3::new((q[0] + q[1] + q[2]).cos(), (q[0] + q[1] + q[2]).sin(), 0.0);
    let columns = [x * 0.5 + y * 0.4 + z * 0.3, y * 0.4 + z * 0.3, z * 0.3];
    let minor = |a: usize, b: usize| columns[a].x * columns[b].y - columns[a].y * columns[b].x;
    let null = Vector3::new(minor(1, 2), -minor(0, 2), minor(0, 1)).normalize();
    let way = Vector3::new(posture[0] - q[0], posture[1] - q[1], posture[2] - q[2]);
    assert!(way.dot(&null).abs() < 1e-5, "{}", way.dot(&null));
}

/// A joint that carries two branches.
#[test]
fn several_tips_reach_their_goals_together() {
    let mut all = Linkage::default();
    let turn = all.add_joint(None, Isometry3::identity(), JointType::Revolute);
    let mut tips = Vec::new();
    for side in [-1.0, 1.0] {
        let shoulder = all.add_joint(Some(turn), Isometry3::translation(0.0, 0.2 * side, 0.0), JointType::Revolute);
        let elbow = all.add_joint(Some(shoulder), Isometry3::translation(0.5, 0.0, 0.0), JointType::Revolute);
        tips.push(all.add_frame(Some(elbow), Isometry3::translation(0.4, 0.0, 0.0)));
    }
    let mut solver = ReachSolver::new(&all, &tips).unwrap();
    assert_eq!(solver.joints().len(), 5);
    let goals = [[0.6, -0.3], [0.4, 0.6]].map(|[x, y]| Goal::position(Vector3::new(x, y, 0.0)));
    solver.solve(&goals, &ReachSettings::from(&[0.0, 0.1, 0.2, 0.1, 0.2]), &mut free).unwrap();
    let mut chain = solver.chain().clone();
    chain.place(solver.positions());
    for (tip, goal) in goals.iter().enumerate() {
        let missing = chain.pose(tip).unwrap().translation.vector - goal.pose.translation.vector;
        assert!(missing.norm() <= 1e-6);
    }
}

/// Two goals for one slide: the weighted mean is q = 100 / (1 + 100).
#[test]
fn heavier_goal_counts_more_if_not_all_can_be_reached() {
    let mut all = Linkage::default();
    let along_x = UnitQuaternion::from_euler_angles(0.0, FRAC_PI_2, 0.0);
    let slide = all.add_joint(None, Isometry3::from_parts(Default::default(), along_x), JointType::Prismatic);
    let tips = [all.add_frame(Some(slide), Isometry3::identity()), all.add_frame(Some(slide), Isometry3::identity())];
    let mut solver = ReachSolver::new(&all, &tips).unwrap();
    let goal = |x: f64, weight: f64| Goal { weights: [weight, 1.0], ..Goal::position(Vector3::new(x, 0.0, 0.0)) };
    let found = solver.solve(&[goal(0.0, 1.0), goal(1.0, 10.0)], &ReachSettings::from(&[0.5]), &mut free);
    assert!(found.is_err());
    assert!((solver.positions()[0] - 100.0 / 101.0).abs() < 1e-3, "{:?}", solver.positions());
}

#[test]
fn equal_seeds_find_equal_bits() {
    let arm = Arm::panda();
    let goal = Goal::new(Isometry3::translation(0.4, 0.2, 0.5));
    let start = [0.0; 7];
    let find = || {
        let mut solver = ReachSolver::new(&arm.linkage, &[arm.tip]).unwrap();
        let found = solver.solve(&[goal], &ReachSettings::from(&start), &mut free);
        (found, solver.positions().to_vec())
    };
    assert_eq!(find(), find());
}

#[test]
fn invalid_arguments_are_refused_by_name() {
    let arm = Arm::planar(&[0.5, 0.4]);
    let mut solver = ReachSolver::new(&arm.linkage, &[arm.tip]).unwrap();
    let goal = Goal::position(Vector3::new(0.5, 0.5, 0.0));
    let mut refused = |goals: &[Goal], start: &[f64]| {
        let result = solver.solve(goals, &ReachSettings::from(start), &mut free);
        let Err(Refusal::Invalid(what)) = result else { panic!("{result:?}") };
        what
    };
    assert!(refused(&[goal], &[0.0]).starts_with("start:"));
    assert!(refused(&[goal], &[0.0, f64::NAN]).starts_with("start:"));
    assert!(refused(&[], &[0.0, 0.0]).starts_with("goals:"));
    assert!(refused(&[Goal::position(Vector3::repeat(f64::NAN))], &[0.0, 0.0]).starts_with("goals:"));
    let mut broken = Linkage::default();
    let joint = broken.add_joint(None, Isometry3::identity(), JointType::Spherical);
    let tip = broken.add_frame(Some(joint), Isometry3::identity());
    assert_eq!(ReachSolver::new(&broken, &[tip]).unwrap_err(), ChainError::Spherical(joint));
}

#[test]
fn dependent_joints_move_with_their_master() {
    let mut arm = Arm::planar(&[0.5, 0.4]);
    let [master, follower] = [arm.joints[0], arm.joints[1]];
    arm.linkage.joint_mut(follower).unwrap().role = JointRole::Dependent { master, factor: 2.0, offset: 0.1 };
    let mut solver = ReachSolver::new(&arm.linkage, &[arm.tip]).unwrap();
    assert_eq!(solver.joints(), [master]);
    arm.set(&[0.4]);
    let goal = Goal::position(arm.linkage.pose(arm.tip).translation.vector);
    solver.solve(&[goal], &ReachSettings::from(&[0.2]), &mut free).unwrap();
    near(solver.positions(), &[0.4], 1e-5);
}
