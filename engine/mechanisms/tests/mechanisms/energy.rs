//! Tests of the energy of freely swinging robots, and of the order of convergence.

use tatu_mechanisms::{Dynamics, IntegrationScheme, Tree, TreeDrives, TreeSolver, TreeState};

use super::robots::{gravity, load};

/// Lets a robot swing for 5 s; returns the maximum error of its energy, relative to its maximum kinetic energy.
fn swing(tree: &Tree, start: &TreeState, h: f64, scheme: IntegrationScheme) -> f64 {
    let mut state = start.clone();
    let (mut solver, mut dynamics, drives) =
        (TreeSolver::with_scheme(tree, scheme), Dynamics::new(tree), TreeDrives::new(tree));
    let (mut error, mut greatest, mut first) = (0.0f64, 0.0f64, None);
    for _ in 0..(5.0 / h) as usize {
        dynamics.update(tree, &state).unwrap();
        let (kinetic, potential) = dynamics.energy(tree, gravity()).unwrap();
        let first = *first.get_or_insert(kinetic + potential);
        error = error.max((kinetic + potential - first).abs());
        greatest = greatest.max(kinetic);
        solver.step(&mut state, tree, &drives, gravity(), h).unwrap();
    }
    error / greatest
}

#[test]
fn free_swing_conserves_energy() {
    // Allowed errors of both schemes at 1.25 ms.
    for (name, allowed) in [("ur5", [1e-6, 1e-5]), ("xarm7", [4e-3, 2e-2]), ("chain20", [0.005, 0.1])] {
        let robot = load(name);
        let mut start = robot.state.clone();
        start.v.fill(0.0);
        if name == "chain20" {
            start.q[0] = 1.5;
        } else {
            start.q[1] += 0.8;
        }
        for (scheme, allowed) in [IntegrationScheme::Midpoint, IntegrationScheme::Leapfrog].into_iter().zip(allowed) {
            let error = [1.25e-3, 0.625e-3].map(|h| swing(&robot.tree, &start, h, scheme));
            println!("{name:8} {scheme:?} energy error at 1.25 ms {:.2e}, at 0.625 ms {:.2e}", error[0], error[1]);
            assert!(error[0] < allowed && error[1] < 0.5 * error[0], "{name}: {error:?}");
        }
    }
}

#[test]
fn free_robot_conserves_energy_and_momentum() {
    for name in ["go1", "talos"] {
        let robot = load(name);
        let error = swing(&robot.tree, &robot.state, 1.25e-3, IntegrationScheme::Midpoint);
        println!("{name:8} energy error {error:.2e}");
        assert!(error < 1e-4, "{name}: {error}");
    }
}
