//! The classic methods on arms whose positions are known: planar ones by closed forms, UR5 and Panda by their Denavit-Hartenberg tables.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use tatu_kinematics::*;

use crate::arms::{Arm, near, unit};

#[test]
fn poses_equal_those_of_the_tables() {
    let cases: [(&[f64], [f64; 3], [f64; 4]); 3] = [
        (
            &[0.3, -1.2, 1.5, -0.8, 0.9, -0.4],
            [-0.555143169, -0.339529086, 0.317202133],
            [0.556206770, 0.053484256, -0.489597551, 0.669378593],
        ),
        (
            &[2.5, -2.0, 0.6, 0.4, -1.7, 3.0],
            [-0.000823313, 0.123621815, 0.742337625],
            [-0.814281338, -0.504157202, 0.165006867, 0.235678067],
        ),
        (
            &[0.4, -0.6, 0.2, -2.2, 0.5, 1.8, -0.9],
            [0.286864454, 0.269278801, 0.624551483],
            [-0.744570150, -0.632816250, -0.124330784, 0.172339034],
        ),
    ];
    for (q, place, [x, y, z, w]) in cases {
        let mut arm = if q.len() == 6 { Arm::ur5() } else { Arm::panda() };
        arm.set(q);
        let pose = arm.linkage.pose(arm.tip);
        near(pose.translation.vector.as_slice(), &place, 1e-9);
        let expected = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        assert!(pose.rotation.angle_to(&expected) < 1e-8);
    }
}

#[test]
fn jacobian_determinant_of_a_planar_arm_is_that_of_the_closed_form() {
    let mut arm = Arm::planar(&[0.5, 0.4]);
    for (q, expected) in [([0.3, 0.8], 0.143471218), ([-0.7, 1.9], 0.189260018), ([2.6, -0.05], -0.009995834)] {
        arm.set(&q);
        let j = group_jacobian(&arm.linkage, &[arm.task(Constraints::X | Constraints::Y)]).matrix;
        near(&[j[(0, 0)] * j[(1, 1)] - j[(0, 1)] * j[(1, 0)]], &[expected], 1e-9);
    }
}

#[test]
fn jacobian_equals_differences() {
    let mut arm = Arm::ur5();
    arm.set(&[0.3, -1.2, 1.5, -0.8, 0.9, -0.4]);
    let j = group_jacobian(&arm.linkage, &[arm.task(Constraints::POSE)]).matrix;
    for (c, joint) in arm.joints.clone().into_iter().enumerate() {
        let h = 1e-6;
        let mut poses = [h, -h].map(|d| {
            let mut moved = arm.linkage.clone();
            moved.set_position(joint, moved.position(joint) + d);
            moved.pose(arm.tip)
        });
        let linear = (poses[0].translation.vector - poses[1].translation.vector) / (2.0 * h);
        poses[0].rotation *= poses[1].rotation.inverse();
        let angular = poses[0].rotation.scaled_axis() / (2.0 * h);
        near(j.column(c).as_slice(), &[linear.as_slice(), angular.as_slice()].concat(), 1e-8);
    }
}

// Expected errors: computed with NumPy from the formulas of Buss (2009) for full steps.
#[test]
fn methods_converge_as_computed() {
    let cases: [(IkMethod, f64, &[f64]); 4] = [
        (IkMethod::PseudoInverse, 0.0, &[3.557e-1, 5.110e-1, 1.525e-1, 2.386e-2, 5.659e-4, 4.044e-7]),
        (IkMethod::DampedLeastSquares, 0.1, &[3.557e-1, 1.049e-1, 1.552e-2, 1.760e-3, 2.109e-4]),
        (IkMethod::DampedLeastSquares, 0.02, &[3.557e-1, 4.752e-1, 1.207e-1, 1.607e-2, 3.022e-4]),
        (IkMethod::JacobianTranspose, 0.0, &[3.557e-1, 1.943e-1, 1.756e-1, 1.404e-1]),
    ];
    for (method, damping, expected) in cases {
        let mut arm = Arm::planar(&[0.5, 0.4]);
        arm.set(&[0.5, 0.5]);
        arm.aim(0.3, 0.6);
        let found = arm.distances(method, damping, expected.len() - 1);
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 6e-4 * b.max(1e-3), "{method:?} {damping}: {found:?}");
        }
    }
}

#[test]
fn all_methods_end_at_the_same_positions() {
    for (method, damping, iterations) in [
        (IkMethod::PseudoInverse, 0.0, 8),
        (IkMethod::DampedLeastSquares, 0.1, 20),
        (IkMethod::DampedLeastSquares, 1.0, 400),
        (IkMethod::JacobianTranspose, 0.0, 100),
    ] {
        let mut arm = Arm::planar(&[0.5, 0.4]);
        arm.set(&[0.5, 0.5]);
        arm.aim(0.3, 0.6);
        let mut group = arm.group(method, damping, iterations);
        group.tasks[0].precision = [1e-9, 1e-9];
        assert_eq!(solve(&mut arm.linkage, &[&group]).result, IkResult::Success, "{method:?} {damping}");
        near(&arm.q(), &[0.472001686, 1.470628906], 1e-8);
    }
}

#[test]
fn target_out_of_reach_fails_and_restores() {
    let mut arm = Arm::planar(&[0.5, 0.4]);
    arm.set(&[0.5, 0.5]);
    arm.aim(1.2, 0.3);
    let mut group = arm.group(IkMethod::DampedLeastSquares, 1.0, 100);
    let outcome = solve(&mut arm.linkage, &[&group]);
    assert_eq!((outcome.result, outcome.iterations), (IkResult::Fail, 100));
    near(&outcome.precision, &[0.336932, 0.0], 1e-6);
    arm.set(&[0.5, 0.5]);
    group.restores = [true, false];
    solve(&mut arm.linkage, &[&group]);
    near(&arm.q(), &[0.5, 0.5], 0.0);
}

#[test]
fn straight_arm_pulled_inward_fails() {
    let mut arm = Arm::planar(&[0.5, 0.4]);
    arm.aim(0.85, 0.0);
    let group = arm.group(IkMethod::PseudoInverse, 0.0, 50);
    assert_eq!(solve(&mut arm.linkage, &[&group]).result, IkResult::Fail);
    near(&arm.q(), &[0.0, 0.0], 1e-15);
}

#[test]
fn group_without_enabled_tasks_is_not_performed() {
    let mut arm = Arm::planar(&[0.5, 0.4]);
    let mut group = arm.group(IkMethod::PseudoInverse, 0.0, 3);
    group.tasks[0].enabled = false;
    assert_eq!(solve(&mut arm.linkage, &[&group]).result, IkResult::NotPerformed);
}

#[test]
fn joint_at_its_limit_is_compensated_by_the_others() {
    let mut arm = Arm::planar(&[0.5, 0.4, 0.3]);
    arm.set(&[0.2, 0.3, 0.4]);
    arm.aim(0.3, 0.7);
    arm.linkage.joint_mut(arm.joints[1]).unwrap().limits = Some([-0.5, 0.5]);
    let group = IkGroup { keeps_limits: true, ..arm.group(IkMethod::DampedLeastSquares, 0.1, 200) };
    assert_eq!(solve(&mut arm.linkage, &[&group]).result, IkResult::Success);
    assert!(arm.q()[1].abs() <= 0.5);
}

#[test]
fn second_group_uses_only_motions_that_leave_the_first() {
    let mut arm = Arm::planar(&[0.5, 0.4, 0.3]);
    arm.set(&[0.2, 0.6, 0.4]);
    let elbow = arm.linkage.add_frame(Some(arm.joints[0]), Isometry3::translation(0.5, 0.0, 0.0));
    let far = arm.linkage.add_frame(None, Isometry3::translation(0.0, 5.0, 0.0));
    arm.aim(0.7, 0.5);
    let first = arm.group(IkMethod::PseudoInverse, 0.0, 40);
    let wish = IkTask { constraints: Constraints::Y, ..IkTask::new(elbow, far) };
    let second =
        IkGroup { tasks: vec![wish], method: IkMethod::DampedLeastSquares, damping: 2.0, ..IkGroup::default() };
    let before = arm.linkage.pose(elbow).translation.y;
    solve(&mut arm.linkage, &[&first, &second]);
    let error = first.tasks[0].error(&arm.linkage).distance();
    let raised = arm.linkage.pose(elbow).translation.y - before;
    assert!(error < 0.01 && raised > 0.05, "error {error}, elbow raised by {raised}");
}

#[test]
fn tip_may_turn_about_its_own_axis_if_only_the_direction_counts() {
    let mut arm = Arm::ur5();
    arm.set(&[0.3, -1.2, 1.5, -0.8, 0.9, -0.4]);
    // Along x and along z of the world: in either case, all directions count.
    for direction in [Vector3::x(), Vector3::z(), -Vector3::z()] {
        let turn = UnitQuaternion::rotation_between(&Vector3::z(), &direction)
            .unwrap_or_else(|| UnitQuaternion::from_euler_angles(PI, 0.0, 0.0));
        arm.linkage.set_pose(arm.target, &Isometry3::from_parts(Translation3::new(-0.4, -0.3, 0.4), turn));
        let mut task = arm.task(Constraints::POSITION | Constraints::ALPHA_BETA);
        task.precision = [1e-7, 1e-7];
        assert_eq!(find_configuration(&mut arm.linkage, &[task], &SearchSettings::default()), Ok(()));
        let axis = arm.linkage.pose(arm.tip).rotation * Vector3::z();
        assert!((axis - direction).norm() < 1e-6);
    }
}

/// Searches for random poses of an arm; returns the share that was found.
fn share_found(mut arm: Arm, n: usize) -> f64 {
    let mut task = arm.task(Constraints::POSE);
    task.precision = [1e-6, 1e-6];
    let limits: Vec<[f64; 2]> =
        arm.joints.iter().map(|j| arm.linkage.joint(*j).and_then(|j| j.limits).unwrap()).collect();
    let middle: Vec<f64> = limits.iter().map(|[low, high]| 0.5 * (low + high)).collect();
    let (mut state, mut found) = (7, 0);
    for _ in 0..n {
        let q: Vec<f64> = limits.iter().map(|[low, high]| low + (high - low) * unit(&mut state)).collect();
        arm.set(&q);
        let pose = arm.linkage.pose(arm.tip);
        arm.linkage.set_pose(arm.target, &pose);
        arm.set(&middle);
        if find_configuration(&mut arm.linkage, std::slice::from_ref(&task), &SearchSettings::default()).is_ok() {
            found += 1;
            assert!(task.error(&arm.linkage).is_within(task.precision));
            assert!(arm.q().iter().zip(&limits).all(|(q, [low, high])| (low..=high).contains(&q)));
        }
    }
    found as f64 / n as f64
}

#[test]
fn random_poses_of_arms_are_found() {
    for (name, arm) in [("UR5", Arm::ur5()), ("Panda", Arm::panda())] {
        let share = share_found(arm, 1000);
        assert!(share >= 0.99, "{name}: {share}");
    }
}

#[test]
fn reason_of_a_failure_is_returned() {
    let mut arm = Arm::planar(&[0.5, 0.4]);
    let task = arm.task(Constraints::POSITION);
    let find =
        |arm: &mut Arm| find_configuration(&mut arm.linkage, std::slice::from_ref(&task), &SearchSettings::default());
    arm.aim(1.2, 0.3);
    match find(&mut arm) {
        Err(Unreachable::OutOfReach { task: 0, by }) => near(&[by], &[0.336932], 1e-6),
        other => panic!("{other:?}"),
    }
    arm.aim(0.01, 0.0);
    match find(&mut arm) {
        Err(Unreachable::Distance([distance, _])) => near(&[distance], &[0.09], 5e-3),
        other => panic!("{other:?}"),
    }
    // Both elbows bend by 1.47 rad.
    arm.aim(0.3, 0.6);
    arm.linkage.joint_mut(arm.joints[1]).unwrap().limits = Some([-1.0, 1.0]);
    match find(&mut arm) {
        Err(Unreachable::Limit { joint, by }) => {
            assert_eq!(joint, arm.joints[1]);
            near(&[by], &[0.470628906], 1e-3);
        }
        other => panic!("{other:?}"),
    }
    arm.linkage.joint_mut(arm.joints[0]).unwrap().role = JointRole::Fixed;
    arm.linkage.joint_mut(arm.joints[1]).unwrap().role = JointRole::Fixed;
    assert_eq!(find(&mut arm), Err(Unreachable::NoMotion));
}

#[test]
fn equal_seeds_find_equal_positions() {
    let run = || {
        let mut arm = Arm::panda();
        arm.set(&[0.4, -0.6, 0.2, -2.2, 0.5, 1.8, -0.9]);
        let pose = arm.linkage.pose(arm.tip);
        arm.linkage.set_pose(arm.target, &pose);
        arm.set(&[-2.0, 1.5, 2.0, -0.1, -2.0, 0.1, 2.0]);
        let task = arm.task(Constraints::POSE);
        find_configuration(&mut arm.linkage, &[task], &SearchSettings { seed: 5, ..SearchSettings::default() })
            .unwrap();
        arm.q()
    };
    assert_eq!(run(), run());
}

#[test]
fn spherical_joint_reaches_an_orientation() {
    let mut all = Linkage::default();
    let ball = all.add_joint(None, Isometry3::identity(), JointType::Spherical);
    let tip = all.add_frame(Some(ball), Isometry3::translation(0.0, 0.0, 0.3));
    let wanted = Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_euler_angles(0.5, -0.4, 1.0));
    let target = all.add_frame(None, wanted * Isometry3::translation(0.0, 0.0, 0.3));
    let group = IkGroup { tasks: vec![IkTask::new(tip, target)], max_iterations: 20, ..IkGroup::default() };
    assert_eq!(solve(&mut all, &[&group]).result, IkResult::Success);
    assert!(all.joint(ball).unwrap().rotation.angle_to(&wanted.rotation) < 0.002);
}
