//! An arm of two links falls from the horizontal, then a drive at its shoulder holds it. Prints the angles of both
//! joints, the effort of the drive, and the energy.
//!
//! Run it with `cargo run -p tatu-mechanisms --example arm`.

use std::error::Error;

use nalgebra::{Isometry3, Matrix3, Vector3};
use tatu_mechanisms::{DofDrive, Dynamics, ForceBound, Joint, Link, Tree, TreeDrives, TreeSolver, TreeState};

/// Returns a rod of 0.4 m and 1 kg along x, on a hinge about y at one of its ends.
fn rod(parent: Option<usize>, x: f64) -> Link {
    let inertia = Matrix3::from_diagonal(&Vector3::new(1e-4, 0.4 * 0.4 / 12.0, 0.4 * 0.4 / 12.0));
    let hinge = Joint::Revolute(Vector3::y());
    Link::new(parent, Isometry3::translation(x, 0.0, 0.0), hinge, 1.0, Vector3::new(0.2, 0.0, 0.0), inertia)
}

fn main() -> Result<(), Box<dyn Error>> {
    let tree = Tree::new(vec![rod(None, 0.0), rod(Some(0), 0.4)])?;
    let (mut state, mut drives) = (TreeState::new(&tree), TreeDrives::new(&tree));
    let (mut solver, mut dynamics) = (TreeSolver::new(&tree), Dynamics::new(&tree));
    let (gravity, h) = (Vector3::new(0.0, 0.0, -9.81), 1e-3);
    println!("time    shoulder  elbow     effort    energy");
    for step in 0..=1000 {
        if step == 500 {
            drives.drive[0] = DofDrive::Velocity { target: 0.0, bound: ForceBound::force(50.0) };
        }
        if step % 100 == 0 {
            dynamics.update(&tree, &state)?;
            let (kinetic, potential) = dynamics.energy(&tree, gravity)?;
            let effort = solver.efforts().drive[0];
            let [shoulder, elbow] = [state.q[0], state.q[1]];
            let time = f64::from(step) * h;
            // Adding 0 turns -0 into 0.
            let energy = ((kinetic + potential) * 1e3).round() / 1e3 + 0.0;
            println!("{time:.1} s  {shoulder:5.2} rad {elbow:5.2} rad {effort:6.2} Nm {energy:6.3} J");
        }
        solver.step(&mut state, &tree, &drives, gravity, h)?;
    }
    Ok(())
}
