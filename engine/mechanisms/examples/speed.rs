//! Prints the time in microseconds of forward dynamics and of steps for the robots in `tests/data`: free swings with
//! both schemes, position gains, velocity drives, and drives that are too weak to hold.
//!
//! Run it with `cargo run --release --example speed`. Each time is the minimum over many short batches.

use std::time::Instant;

use nalgebra::Vector3;
use tatu_mechanisms::{DofDrive, Dynamics, ForceBound, IntegrationScheme, TreeDrives, TreeSolver, TreeState};

#[allow(dead_code, reason = "shared with the tests")]
#[path = "../tests/mechanisms/robots.rs"]
mod robots;

/// Returns the mean duration of a call in the fastest of 200 batches, µs.
fn least(mut call: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..200 {
        let start = Instant::now();
        for _ in 0..50 {
            call();
        }
        best = best.min(start.elapsed().as_secs_f64() / 50.0);
    }
    best * 1e6
}

fn main() {
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let h = 1e-7;
    println!(
        "            dof   forward  leapfrog  midpoint  PD gains  held, still  held, moving  at most 4 Nm (solves)"
    );
    for name in robots::ROBOTS {
        let robot = robots::load(name);
        let tree = &robot.tree;
        let n = tree.velocities();
        let first = n - tree.links().iter().filter(|l| l.joint.velocities() == 1).count();
        let (zeros, mut out) = (vec![0.0; n], vec![0.0; n]);
        let mut dynamics = Dynamics::new(tree);
        let forward = least(|| {
            dynamics.update(tree, &robot.state).expect("a state of the robot");
            dynamics.forward(tree, &zeros, gravity, &mut out).expect("forces of the robot");
        });
        let mut drives = TreeDrives::new(tree);
        let mut solutions = 0;
        let mut timed = |state: &TreeState, drives: &TreeDrives, scheme: IntegrationScheme| {
            let (mut solver, mut state) = (TreeSolver::with_scheme(tree, scheme), state.clone());
            least(|| {
                let report = solver.step(&mut state, tree, drives, gravity, h).expect("a step");
                solutions = report.solutions;
            })
        };
        let leapfrog = timed(&robot.state, &drives, IntegrationScheme::Leapfrog);
        let mut step = |state: &TreeState, drives: &TreeDrives| timed(state, drives, IntegrationScheme::Midpoint);
        let free = step(&robot.state, &drives);
        for d in first..n {
            let (stiffness, damping) = (100.0, 10.0);
            let target = 0.0;
            drives.drive[d] =
                DofDrive::Position { target, velocity: 0.0, stiffness, damping, bound: ForceBound::force(1e4) };
        }
        let gains = step(&robot.state, &drives);
        let hold = |bound, d: usize, v: f64| DofDrive::Velocity { target: if d >= first { v } else { 0.0 }, bound };
        for d in first..n {
            drives.drive[d] = hold(ForceBound::force(1e4), d, 0.0);
        }
        let mut still = robot.state.clone();
        still.v.fill(0.0);
        let held = step(&still, &drives);
        for d in first..n {
            drives.drive[d] = hold(ForceBound::force(1e4), d, robot.state.v[d]);
        }
        let moving = step(&robot.state, &drives);
        for d in first..n {
            drives.drive[d] = hold(ForceBound::force(4.0), d, 0.0);
        }
        let weak = step(&still, &drives);
        println!(
            "{name:10} {n:5}  {forward:7.2}  {leapfrog:8.2}  {free:8.2}  {gains:8.2}  {held:11.2}  {moving:12.2}  {weak:8.2} ({solutions})"
        );
    }
}
