//! Tests of joint limits.

use nalgebra::Vector3;
use tatu_mechanisms::{DofDrive, Dynamics, ForceBound, Joint, Link, Tree, TreeDrives, TreeSolver, TreeState};

use super::{
    joints::{pendulum, single},
    robots::{ROBOTS, gravity, load_fixed},
};

const H: f64 = 1.25e-3;

#[test]
fn falling_joint_stops_at_its_limit_and_rests_there() {
    let link = Link { limits: Some([-0.5, 0.5]), ..single(Joint::Prismatic(Vector3::z())) };
    let tree = Tree::new(vec![link]).unwrap();
    let (mut state, mut solver) = (TreeState::new(&tree), TreeSolver::new(&tree));
    let drives = TreeDrives::new(&tree);
    let mut energy = 0.5 * 9.81 * 2.0;
    for _ in 0..2000 {
        solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
        assert!(state.q[0] >= -0.5);
        let now = 0.5 * 2.0 * state.v[0] * state.v[0] + 2.0 * 9.81 * (state.q[0] + 0.5);
        // Moving the joint to its limit lifts the mass by at most the distance that it falls in half a step.
        assert!(now <= energy + 2.0 * 9.81 * 0.5 * H * 3.2, "{now} {energy}");
        energy = now;
    }
    assert_eq!((state.q[0], state.v[0]), (-0.5, 0.0));
    assert!((solver.efforts().limit[0] - 2.0 * 9.81).abs() < 1e-12);
    assert_eq!(solver.efforts().drive[0], 0.0);
    // A force away from the limit moves the joint at once.
    let mut drives = TreeDrives::new(&tree);
    drives.force[0] = 2.0 * 9.81 + 2.0;
    solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
    assert!((state.v[0] - H).abs() < 1e-12);
    assert_eq!(solver.efforts().limit[0], 0.0);
}

#[test]
fn drive_pushes_against_a_limit_without_dither() {
    for bound in [ForceBound::force(5.0), ForceBound::NONE] {
        let link = Link { limits: Some([-0.2, 0.3]), ..single(Joint::Revolute(Vector3::z())) };
        let tree = Tree::new(vec![link]).unwrap();
        let mut drives = TreeDrives::new(&tree);
        drives.drive[0] = DofDrive::Velocity { target: 1.0, bound };
        let (mut state, mut solver) = (TreeState::new(&tree), TreeSolver::new(&tree));
        for _ in 0..1000 {
            solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
            assert!(state.q[0] <= 0.3);
        }
        assert_eq!((state.q[0], state.v[0]), (0.3, 0.0));
        let (drive, limit) = (solver.efforts().drive[0], solver.efforts().limit[0]);
        assert!((drive + limit).abs() < 1e-12);
        assert!((drive - if bound == ForceBound::NONE { 0.0 } else { 5.0 }).abs() < 1e-12, "{drive}");
    }
}

#[test]
fn joint_beyond_its_limit_returns_slowly() {
    let link = Link { limits: Some([0.4, 1.0]), ..pendulum() };
    let tree = Tree::new(vec![link]).unwrap();
    let (mut state, mut solver) = (TreeState::new(&tree), TreeSolver::new(&tree));
    let drives = TreeDrives::new(&tree);
    for _ in 0..1600 {
        let before = state.q[0];
        solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
        assert!(state.v[0] == 0.0 && state.q[0] >= before && state.q[0] <= before + H, "{state:?} {before}");
    }
    assert!((state.q[0] - 0.4).abs() < 1e-3, "{}", state.q[0]);
}

#[test]
fn robots_fall_against_all_their_limits() {
    for name in ROBOTS {
        let mut links = load_fixed(name).links().to_vec();
        for link in &mut links {
            if link.joint.velocities() == 1 {
                link.limits = Some([-0.6, 0.6]);
            }
        }
        let tree = Tree::new(links).unwrap();
        let mut state = TreeState::new(&tree);
        state.q.fill(0.3);
        let drives = TreeDrives::new(&tree);
        let (mut solver, mut dynamics) = (TreeSolver::new(&tree), Dynamics::new(&tree));
        let mut most = 0;
        for _ in 0..2400 {
            let report = solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
            assert!(report.satisfied, "{name}");
            most = most.max(report.solutions);
            assert!(state.q.iter().all(|q| q.abs() <= 0.6));
        }
        dynamics.update(&tree, &state).unwrap();
        let (kinetic, _) = dynamics.energy(&tree, gravity()).unwrap();
        println!(
            "{name:8} fell against limits: at most {most} solutions a step, kinetic energy {kinetic:.1e} J after 3 s"
        );
        assert!(kinetic.is_finite());
    }
}
