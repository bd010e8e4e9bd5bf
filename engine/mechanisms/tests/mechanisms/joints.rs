//! Tests of joints and steps against closed-form solutions.

use nalgebra::{Isometry3, Matrix3, Vector3};
use tatu_mechanisms::{Joint, Link, Tree, TreeDrives, TreeSolver, TreeState};

use super::robots::gravity;

/// Returns a link of 2 kg, with an inertia of 0.5 kg m² about the joint's origin.
pub fn single(joint: Joint) -> Link {
    Link::new(None, Isometry3::identity(), joint, 2.0, Vector3::zeros(), Matrix3::identity() * 0.5)
}

/// Returns a pendulum of 2 kg, 0.3 m below its axis y, with an inertia of 0.5 + 0.18 kg m² about the axis.
pub fn pendulum() -> Link {
    Link { center: Vector3::new(0.0, 0.0, -0.3), ..single(Joint::Revolute(Vector3::y())) }
}

#[test]
fn thrown_body_flies_a_parabola_and_turns_on() {
    let tree = Tree::new(vec![single(Joint::Free)]).unwrap();
    let mut state = TreeState::new(&tree);
    state.v = vec![3.0, 0.0, 4.0, 0.0, 0.0, 2.0];
    let mut solver = TreeSolver::new(&tree);
    for _ in 0..1000 {
        solver.step(&mut state, &tree, &TreeDrives::new(&tree), gravity(), 1e-3).unwrap();
    }
    assert!((state.q[0] - 3.0).abs() < 1e-12);
    assert!((state.q[2] - (4.0 - 0.5 * 9.81)).abs() < 1e-12);
    assert!((state.q[3] - libm::cos(1.0)).abs() < 1e-12 && (state.q[6] - libm::sin(1.0)).abs() < 1e-12);
}

#[test]
fn spherical_joint_conserves_angular_momentum() {
    // An asymmetric body tumbles; its angular momentum in the world is constant.
    let mut link = single(Joint::Spherical);
    link.inertia = Matrix3::from_diagonal(&Vector3::new(0.2, 0.3, 0.45));
    let tree = Tree::new(vec![link.clone()]).unwrap();
    let mut state = TreeState::new(&tree);
    state.v = vec![0.1, 3.0, 0.1];
    let mut solver = TreeSolver::new(&tree);
    let mut kinematics = tatu_mechanisms::Kinematics::new(&tree);
    let mut momentum = |state: &TreeState| {
        kinematics.update(&tree, state).unwrap();
        let turned = kinematics.pose(0).unwrap().rotation;
        turned * (link.inertia * Vector3::new(state.v[0], state.v[1], state.v[2]))
    };
    let before = momentum(&state);
    for _ in 0..2000 {
        solver.step(&mut state, &tree, &TreeDrives::new(&tree), Vector3::zeros(), 1e-3).unwrap();
    }
    let error = (momentum(&state) - before).norm() / before.norm();
    println!("angular momentum after 2 s: {error:.1e}");
    assert!(error < 1e-5, "{error}");
}

#[test]
fn pendulum_has_its_closed_form_period() {
    // Period of small oscillations: 2 pi sqrt(I / (m g r)) (1 + a² / 16).
    let tree = Tree::new(vec![pendulum()]).unwrap();
    let mut state = TreeState::new(&tree);
    let amplitude = 0.01;
    state.q[0] = amplitude;
    let expected =
        2.0 * std::f64::consts::PI * (0.68f64 / (2.0 * 9.81 * 0.3)).sqrt() * (1.0 + amplitude * amplitude / 16.0);
    let mut solver = TreeSolver::new(&tree);
    let (h, mut time, mut crossings) = (1e-3, 0.0, vec![]);
    while crossings.len() < 11 {
        let before = state.q[0];
        solver.step(&mut state, &tree, &TreeDrives::new(&tree), gravity(), h).unwrap();
        if before < 0.0 && state.q[0] >= 0.0 {
            crossings.push(time + h * before / (before - state.q[0]));
        }
        time += h;
    }
    let period = (crossings[10] - crossings[0]) / 10.0;
    println!("period {period}, expected {expected}");
    assert!((period / expected - 1.0).abs() < 2e-6);
}

#[test]
fn viscous_friction_slows_as_an_exponential() {
    for (damping, allowed) in [(0.1, 1e-6), (5.0, 1e-5)] {
        let link = Link { damping, ..single(Joint::Revolute(Vector3::z())) };
        let tree = Tree::new(vec![link]).unwrap();
        let mut state = TreeState::new(&tree);
        state.v[0] = 1.0;
        let mut solver = TreeSolver::new(&tree);
        for _ in 0..100 {
            solver.step(&mut state, &tree, &TreeDrives::new(&tree), gravity(), 1e-3).unwrap();
        }
        let expected = libm::exp(-damping / 0.5 * 0.1);
        assert!((state.v[0] - expected).abs() < allowed, "{} {expected}", state.v[0]);
    }
}

#[test]
fn stiff_damper_and_spring_are_stable() {
    for (stiffness, damping) in [(0.0, 1e9), (1e12, 0.0), (1e12, 1e9), (1e6, 1e3)] {
        let tree = Tree::new(vec![pendulum()]).unwrap();
        let mut drives = TreeDrives::new(&tree);
        drives.spring[0] = tatu_mechanisms::JointSpring { rest: 0.0, stiffness, damping };
        let mut state = TreeState::new(&tree);
        (state.q[0], state.v[0]) = (1e-3, 1.0);
        let mut solver = TreeSolver::new(&tree);
        for _ in 0..2000 {
            solver.step(&mut state, &tree, &drives, gravity(), 1e-3).unwrap();
            assert!(state.q[0].abs() < 3e-3 && state.v[0].abs() < 20.0, "{stiffness} {damping}: {state:?}");
        }
    }
}
