//! Tests of velocity drives, springs and gains, friction, and motors whose force depends on their speed.

use nalgebra::Vector3;
use tatu_mechanisms::{DofDrive, Dynamics, ForceBound, Joint, Link, Tree, TreeDrives, TreeSolver, TreeState};

use super::{
    joints::{pendulum, single},
    robots::{ROBOTS, gravity, load, load_fixed},
};

const H: f64 = 1.25e-3;

#[test]
fn velocity_drives_hold_robots_without_sag() {
    for name in ROBOTS {
        let tree = load_fixed(name);
        let n = tree.velocities();
        let mut state = TreeState::new(&tree);
        for (i, q) in state.q.iter_mut().enumerate() {
            *q = 0.3 - 0.1 * (i % 5) as f64;
        }
        let start = state.clone();
        let mut drives = TreeDrives::new(&tree);
        drives.drive.fill(DofDrive::Velocity { target: 0.0, bound: ForceBound::force(1e4) });
        let mut solver = TreeSolver::new(&tree);
        for _ in 0..4000 {
            let report = solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
            assert!(report.satisfied && report.solutions == 1);
        }
        let sag = state.q.iter().zip(&start.q).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        let mut dynamics = Dynamics::new(&tree);
        dynamics.update(&tree, &state).unwrap();
        let mut bias = vec![0.0; n];
        dynamics.bias(&tree, gravity(), &mut bias).unwrap();
        let error = bias.iter().zip(&solver.efforts().drive).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        println!("{name:8} sag {sag:.1e} rad, torques differ from gravity's by {error:.1e} Nm");
        assert!(sag <= 1e-12 && error <= 1e-10, "{name}");
    }
}

#[test]
fn velocity_drives_move_exactly_with_the_torques_of_inverse_dynamics() {
    let robot = load("xarm7");
    let tree = &robot.tree;
    let n = tree.velocities();
    let mut state = TreeState::new(tree);
    let mut drives = TreeDrives::new(tree);
    for d in 0..n {
        drives.drive[d] = DofDrive::Velocity { target: 0.2 + 0.05 * d as f64, bound: ForceBound::force(1e6) };
    }
    let mut solver = TreeSolver::new(tree);
    for _ in 0..800 {
        solver.step(&mut state, tree, &drives, gravity(), H).unwrap();
    }
    for d in 0..n {
        let speed = 0.2 + 0.05 * d as f64;
        assert_eq!(state.v[d], speed);
        // The first step accelerates from rest, so its mean speed is half of the target.
        assert!((state.q[d] - speed * (800.0 - 0.5) * H).abs() < 1e-12);
    }
    let mut middle = state.clone();
    for (q, v) in middle.q.iter_mut().zip(&state.v) {
        *q -= 0.5 * H * v;
    }
    let mut dynamics = Dynamics::new(tree);
    dynamics.update(tree, &middle).unwrap();
    let mut force = vec![0.0; n];
    dynamics.inverse(tree, &vec![0.0; n], gravity(), &mut force).unwrap();
    for (a, b) in force.iter().zip(&solver.efforts().drive) {
        assert!((a - b).abs() < 1e-10, "{a} {b}");
    }
}

#[test]
fn position_drive_is_a_second_order_system() {
    // The inertia is 0.5 kg m², and the natural frequency 12 rad/s; damping ratios are below and above 1.
    for ratio in [0.1, 0.7, 2.0] {
        let (inertia, frequency) = (0.5, 12.0);
        let tree = Tree::new(vec![single(Joint::Revolute(Vector3::z()))]).unwrap();
        let mut drives = TreeDrives::new(&tree);
        let (stiffness, damping) = (inertia * frequency * frequency, 2.0 * ratio * inertia * frequency);
        let bound = ForceBound::force(1e3);
        drives.drive[0] = DofDrive::Position { target: 1.0, velocity: 0.0, stiffness, damping, bound };
        let (mut state, mut solver) = (TreeState::new(&tree), TreeSolver::new(&tree));
        let mut worst = 0.0f64;
        for k in 1..=1600 {
            solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
            let t = H * k as f64;
            let decay = ratio * frequency;
            let expected = if ratio < 1.0 {
                let w = frequency * (1.0 - ratio * ratio).sqrt();
                1.0 - libm::exp(-decay * t) * (libm::cos(w * t) + decay / w * libm::sin(w * t))
            } else {
                let w = frequency * (ratio * ratio - 1.0).sqrt();
                let (a, b) = (decay - w, decay + w);
                1.0 - (b * libm::exp(-a * t) - a * libm::exp(-b * t)) / (b - a)
            };
            worst = worst.max((state.q[0] - expected).abs());
        }
        println!("gains, damping ratio {ratio}: {worst:.1e} of 1");
        assert!(worst < 2e-4, "{worst}");
    }
}

#[test]
fn position_drive_stays_within_its_bound() {
    // At the bound, the acceleration is constant.
    let tree = Tree::new(vec![single(Joint::Revolute(Vector3::z()))]).unwrap();
    let mut drives = TreeDrives::new(&tree);
    let bound = ForceBound::force(3.0);
    drives.drive[0] = DofDrive::Position { target: 5.0, velocity: 0.0, stiffness: 1e4, damping: 10.0, bound };
    let (mut state, mut solver) = (TreeState::new(&tree), TreeSolver::new(&tree));
    for _ in 0..400 {
        solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
        assert_eq!(solver.efforts().drive[0], 3.0);
    }
    assert!((state.v[0] - 3.0 / 0.5 * 0.5).abs() < 1e-12 && (state.q[0] - 0.75).abs() < 1e-12);
}

#[test]
fn stiff_position_drive_stays_within_its_bound() {
    for stiffness in [1e2, 1e5, 1e9, 1e13] {
        for damping in [0.0, 1.0, 1e4, 1e9] {
            let tree = Tree::new(vec![single(Joint::Revolute(Vector3::z()))]).unwrap();
            let mut drives = TreeDrives::new(&tree);
            let bound = ForceBound::force(3.0);
            drives.drive[0] = DofDrive::Position { target: 0.1, velocity: 0.0, stiffness, damping, bound };
            let (mut state, mut solver) = (TreeState::new(&tree), TreeSolver::new(&tree));
            for _ in 0..2000 {
                let report = solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
                assert!(report.satisfied);
                // Check the force that actually acts, not only the reported force.
                let acts = 0.5 * solver.accelerations()[0];
                assert!(acts.abs() <= 3.0 * (1.0 + 1e-8), "{stiffness} {damping}: {acts}");
                assert!((acts - solver.efforts().drive[0]).abs() <= 1e-8);
            }
        }
    }
}

#[test]
fn dry_friction_sticks_below_its_bound_and_slides_above() {
    let link = Link { friction: 2.0, ..single(Joint::Prismatic(Vector3::x())) };
    let tree = Tree::new(vec![link]).unwrap();
    let mut solver = TreeSolver::new(&tree);
    let mut drives = TreeDrives::new(&tree);
    let mut state = TreeState::new(&tree);
    drives.force[0] = 1.999;
    for _ in 0..1000 {
        solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
    }
    assert_eq!((state.q[0], state.v[0]), (0.0, 0.0));
    assert!((solver.efforts().friction[0] + 1.999).abs() < 1e-12);
    drives.force[0] = 3.0;
    for _ in 0..800 {
        solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
    }
    // A net force of 1 N accelerates 2 kg for 1 s.
    assert!((state.v[0] - 0.5).abs() < 1e-12 && (state.q[0] - 0.25).abs() < 1e-12);
    // Without the push, the mass stops after another 0.5 s and 0.125 m, and stays at rest.
    drives.force[0] = 0.0;
    for _ in 0..1000 {
        solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
    }
    assert_eq!(state.v[0], 0.0);
    assert!((state.q[0] - 0.375).abs() < 1e-12, "{}", state.q[0]);
    // A drive must also overcome friction.
    drives.drive[0] = DofDrive::Velocity { target: 0.1, bound: ForceBound::force(100.0) };
    for _ in 0..10 {
        solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
    }
    assert_eq!(state.v[0], 0.1);
    assert!((solver.efforts().drive[0] - 2.0).abs() < 1e-12);
}

#[test]
fn motor_settles_where_its_curve_meets_the_load() {
    // The motor has 6 Nm at rest and 0 at 10 rad/s; against a load of 1.5 Nm, its speed settles at 7.5 rad/s.
    let tree = Tree::new(vec![single(Joint::Revolute(Vector3::z()))]).unwrap();
    let bound = ForceBound::motor(6.0, 10.0);
    let wants = [
        DofDrive::Velocity { target: 100.0, bound },
        DofDrive::Force { force: 50.0, bound },
        DofDrive::Position { target: 1e9, velocity: 0.0, stiffness: 1.0, damping: 0.0, bound },
    ];
    for drive in wants {
        let mut drives = TreeDrives::new(&tree);
        (drives.drive[0], drives.force[0]) = (drive, -1.5);
        let (mut state, mut solver) = (TreeState::new(&tree), TreeSolver::new(&tree));
        for k in 1..=4000 {
            solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
            // First-order response, with the time constant 0.5 kg m² / 0.6 Nm s/rad.
            let expected = 7.5 * (1.0 - libm::exp(-0.6 / 0.5 * H * k as f64));
            assert!((state.v[0] - expected).abs() < 5e-3, "{drive:?}: {} {expected}", state.v[0]);
            let most = 6.0 * (1.0 - state.v[0] / 10.0);
            assert!((solver.efforts().drive[0] - most).abs() < 1e-9);
        }
        assert!((state.v[0] - 7.5).abs() < 0.02);
    }
    // If the motor is strong enough at its target velocity, it holds this velocity exactly, in both directions.
    for target in [4.0, -4.0] {
        let mut drives = TreeDrives::new(&tree);
        drives.drive[0] = DofDrive::Velocity { target, bound };
        let (mut state, mut solver) = (TreeState::new(&tree), TreeSolver::new(&tree));
        for _ in 0..800 {
            solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
        }
        assert_eq!(state.v[0], target);
    }
}

#[test]
fn armature_is_inertia() {
    let link = Link { armature: 1.5, ..single(Joint::Revolute(Vector3::z())) };
    let tree = Tree::new(vec![link]).unwrap();
    let mut drives = TreeDrives::new(&tree);
    drives.drive[0] = DofDrive::Force { force: 4.0, bound: ForceBound::NONE };
    let (mut state, mut solver) = (TreeState::new(&tree), TreeSolver::new(&tree));
    solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
    assert!((solver.accelerations()[0] - 2.0).abs() < 1e-12);
}

#[test]
fn spring_rests_where_its_force_equals_the_weight() {
    let link = Link { damping: 3.0, ..pendulum() };
    let tree = Tree::new(vec![link]).unwrap();
    let mut drives = TreeDrives::new(&tree);
    drives.spring[0] = tatu_mechanisms::JointSpring { rest: 1.0, stiffness: 20.0, damping: 0.0 };
    let (mut state, mut solver) = (TreeState::new(&tree), TreeSolver::new(&tree));
    for _ in 0..20000 {
        solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
    }
    let left = 20.0 * (1.0 - state.q[0]) - 2.0 * 9.81 * 0.3 * libm::sin(state.q[0]);
    assert!(left.abs() < 1e-9, "{left}");
}
