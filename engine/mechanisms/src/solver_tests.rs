//! Tests of steps in which the search for velocities reaches its limit of solves.

use nalgebra::{Isometry3, Matrix3};

use super::*;
use crate::{
    drive::{DofDrive, ForceBound},
    link::{Joint, Link},
};

/// Forces must be within their bounds even if too few solves are allowed to satisfy all laws.
#[test]
fn search_that_is_cut_short_stays_within_bounds() {
    let links = (0..12usize).map(|i| Link {
        limits: Some([-0.5, 0.5]),
        friction: 0.1,
        ..Link::new(
            i.checked_sub(1),
            Isometry3::translation(0.0, 0.0, -0.1),
            Joint::Revolute(if i % 2 == 0 { Vector3::x() } else { Vector3::y() }),
            1.0,
            Vector3::new(0.02, 0.0, -0.05),
            Matrix3::identity() * 1e-3,
        )
    });
    let tree = Tree::new(links.collect()).unwrap();
    let mut drives = TreeDrives::new(&tree);
    let mut solver = TreeSolver::new(&tree);
    solver.step.pivot.max_solves = 1;
    let mut state = TreeState::new(&tree);
    state.q.fill(0.4);
    let mut missed = 0;
    for k in 0..4000 {
        let target = if k / 100 % 2 == 0 { 2.0 } else { -2.0 };
        drives.drive.fill(DofDrive::Velocity { target, bound: ForceBound::force(0.5) });
        let report = solver.step(&mut state, &tree, &drives, Vector3::new(0.0, 0.0, -9.81), 1.25e-3).unwrap();
        missed += usize::from(!report.satisfied);
        assert!(solver.step.efforts.drive.iter().all(|f| f.abs() <= 0.5));
        assert!(solver.step.efforts.friction.iter().all(|f| f.abs() <= 0.1));
        assert!(state.q.iter().all(|q| q.abs() <= 0.5) && state.v.iter().all(|v| v.abs() < 1e3));
    }
    assert!(missed > 100, "{missed}");
}
