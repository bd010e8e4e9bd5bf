//! Tests of properties that all trees must have, with random trees.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use tatu_mechanisms::{Dynamics, Kinematics, Tree, TreeDrives, TreeSolver, TreeState};

use super::{
    random::TestRng,
    robots::{ROBOTS, gravity, load},
};

fn mass_matrix(tree: &Tree, state: &TreeState) -> DMatrix<f64> {
    let n = tree.velocities();
    let mut dynamics = Dynamics::new(tree);
    dynamics.update(tree, state).unwrap();
    let mut out = vec![0.0; n * n];
    dynamics.mass_matrix(tree, &mut out).unwrap();
    DMatrix::from_row_slice(n, n, &out)
}

/// Computes the mass matrix as the sum of J' I J over all links, with the Jacobians at the centres of mass, plus the
/// armatures of the joints.
fn mass_by_jacobians(tree: &Tree, state: &TreeState) -> DMatrix<f64> {
    let n = tree.velocities();
    let mut kinematics = Kinematics::new(tree);
    kinematics.update(tree, state).unwrap();
    let mut sum = DMatrix::zeros(n, n);
    for (i, link) in tree.links().iter().enumerate() {
        let pose = kinematics.pose(i).unwrap();
        let mut jacobian = vec![0.0; 6 * n];
        let center = pose * nalgebra::Point3::from(link.center);
        kinematics.jacobian(tree, i, center.coords, &mut jacobian).unwrap();
        let j = DMatrix::from_row_slice(6, n, &jacobian);
        let turned: Matrix3<f64> = pose.rotation.to_rotation_matrix().into_inner();
        let inertia = turned * link.inertia * turned.transpose();
        let (linear, angular) = (j.rows(0, 3), j.rows(3, 3));
        sum += linear.transpose() * linear * link.mass + angular.transpose() * inertia * angular;
        let at = tree.offsets(i).unwrap().1;
        for d in at..at + link.joint.velocities() {
            sum[(d, d)] += link.armature;
        }
    }
    sum
}

#[test]
fn mass_matrix_is_positive_definite_and_the_sum_over_links() {
    let mut random = TestRng::new(1);
    for _ in 0..300 {
        let tree = random.tree();
        let state = random.state(&tree, 1.0);
        let mass = mass_matrix(&tree, &state);
        assert_eq!(mass, mass.transpose());
        let other = mass_by_jacobians(&tree, &state);
        assert!((&mass - &other).amax() <= 1e-13 * (1.0 + mass.amax()), "{}", (&mass - &other).amax());
        assert!(tree.velocities() == 0 || mass.cholesky().is_some());
    }
}

#[test]
fn factorisation_solves_for_accelerations() {
    let mut random = TestRng::new(2);
    for _ in 0..300 {
        let tree = random.tree();
        let state = random.state(&tree, 1.0);
        let n = tree.velocities();
        let mut dynamics = Dynamics::new(&tree);
        dynamics.update(&tree, &state).unwrap();
        let wanted: Vec<f64> = (0..n).map(|_| random.within(-1.0, 1.0)).collect();
        let mut x = wanted.clone();
        dynamics.solve(&tree, &mut x).unwrap();
        // Backward error: the residual, relative to the terms of the right-hand side.
        let mass = mass_matrix(&tree, &state);
        let left = &mass * DVector::from_vec(x.clone()) - DVector::from_vec(wanted);
        let size = mass.abs() * DVector::from_vec(x).abs();
        assert!(left.amax() <= 1e-12 * (1.0 + size.amax()), "{}", left.amax());
    }
}

#[test]
fn inverse_dynamics_undoes_forward_dynamics() {
    let mut random = TestRng::new(3);
    let mut worst = 0.0f64;
    let robots = ROBOTS.map(|name| load(name).tree);
    let trees = robots.into_iter().chain((0..200).map(|_| random.tree())).collect::<Vec<_>>();
    for tree in trees {
        let state = random.state(&tree, 2.0);
        let n = tree.velocities();
        let force: Vec<f64> = (0..n).map(|_| random.within(-10.0, 10.0)).collect();
        let (mut acceleration, mut again) = (vec![0.0; n], vec![0.0; n]);
        let mut dynamics = Dynamics::new(&tree);
        dynamics.update(&tree, &state).unwrap();
        dynamics.forward(&tree, &force, gravity(), &mut acceleration).unwrap();
        dynamics.inverse(&tree, &acceleration, gravity(), &mut again).unwrap();
        let mass = mass_matrix(&tree, &state);
        let size = (mass.abs() * DVector::from_vec(acceleration).abs()).iter().fold(10.0f64, |m, x| m.max(*x));
        for (a, b) in force.iter().zip(&again) {
            worst = worst.max((a - b).abs() / size);
        }
    }
    println!("inverse of forward dynamics: {worst:.1e}");
    assert!(worst < 1e-12, "{worst}");
}

#[test]
fn jacobians_are_derivatives() {
    let mut random = TestRng::new(4);
    let mut worst = 0.0f64;
    for _ in 0..200 {
        let tree = random.tree();
        let state = random.state(&tree, 1.0);
        let n = tree.velocities();
        let link = random.below(tree.links().len());
        let local = random.vector(0.3);
        let mut kinematics = Kinematics::new(&tree);
        kinematics.update(&tree, &state).unwrap();
        let point = kinematics.pose(link).unwrap() * nalgebra::Point3::from(local);
        let mut jacobian = vec![0.0; 6 * n];
        kinematics.jacobian(&tree, link, point.coords, &mut jacobian).unwrap();
        let j = DMatrix::from_row_slice(6, n, &jacobian);
        // The Jacobian must yield the velocity of the point.
        let product = &j * DVector::from_row_slice(&state.v);
        let (angular, linear) = kinematics.velocity(link, point.coords).unwrap();
        assert!((product.rows(0, 3) - linear).amax() < 1e-12 && (product.rows(3, 3) - angular).amax() < 1e-12);
        // Its transpose must yield the generalised forces.
        let (force, torque) = (random.vector(5.0), random.vector(5.0));
        let mut out = vec![0.0; n];
        kinematics.add_force(&tree, link, point.coords, force, torque, &mut out).unwrap();
        let wrench = DVector::from_iterator(6, force.iter().chain(torque.iter()).copied());
        assert!(n == 0 || (j.transpose() * wrench - DVector::from_vec(out)).amax() < 1e-12);
        // Compare with a central difference along one velocity.
        for d in 0..n {
            let e = 1e-5;
            let place = |sign: f64| {
                let moved = moved(&tree, &state, d, sign * e);
                let mut kinematics = Kinematics::new(&tree);
                kinematics.update(&tree, &moved).unwrap();
                (kinematics.pose(link).unwrap() * nalgebra::Point3::from(local), kinematics.pose(link).unwrap())
            };
            let ((a, pose_a), (b, pose_b)) = (place(1.0), place(-1.0));
            let linear = (a - b) / (2.0 * e);
            let turned = (pose_a.rotation * pose_b.rotation.inverse()).scaled_axis() / (2.0 * e);
            let error = (linear - j.column(d).rows(0, 3)).amax().max((turned - j.column(d).rows(3, 3)).amax());
            worst = worst.max(error);
        }
    }
    println!("Jacobians against differences: {worst:.1e}");
    assert!(worst < 1e-8, "{worst}");
}

/// Returns the state after a time `e` in which only velocity `d` is 1, and all others are 0.
fn moved(tree: &Tree, state: &TreeState, d: usize, e: f64) -> TreeState {
    let mut out = state.clone();
    for (i, link) in tree.links().iter().enumerate() {
        let (p, v) = tree.offsets(i).unwrap();
        let k = d.wrapping_sub(v);
        if k >= link.joint.velocities() {
            continue;
        }
        let (at, turn) = match link.joint {
            tatu_mechanisms::Joint::Free => (p + 3, k.checked_sub(3)),
            tatu_mechanisms::Joint::Spherical => (p, Some(k)),
            _ => (p, None),
        };
        match turn {
            None => out.q[p + k] += e,
            Some(k) => {
                let q = &state.q[at..at + 4];
                let mut axis = Vector3::zeros();
                axis[k] = e;
                let q = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q[0], q[1], q[2], q[3]))
                    * nalgebra::UnitQuaternion::from_scaled_axis(axis);
                out.q[at..at + 4].copy_from_slice(&[q.w, q.i, q.j, q.k]);
            }
        }
    }
    out
}

#[test]
fn random_trees_conserve_energy() {
    let mut random = TestRng::new(5);
    let mut worst = 0.0f64;
    for _ in 0..60 {
        let tree = random.tree();
        let mut state = random.state(&tree, 0.5);
        let (mut solver, mut dynamics, drives) = (TreeSolver::new(&tree), Dynamics::new(&tree), TreeDrives::new(&tree));
        let mut first = None;
        for _ in 0..200 {
            dynamics.update(&tree, &state).unwrap();
            let (kinetic, potential) = dynamics.energy(&tree, gravity()).unwrap();
            let first = *first.get_or_insert(kinetic + potential);
            worst = worst.max((kinetic + potential - first).abs() / (1.0 + kinetic));
            solver.step(&mut state, &tree, &drives, gravity(), 2e-4).unwrap();
        }
    }
    println!("energy of random trees over 40 ms: {worst:.1e}");
    assert!(worst < 1e-4, "{worst}");
}
