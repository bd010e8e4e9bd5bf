//! Tests of drives that are too weak to hold their target.

use nalgebra::{Isometry3, Translation3, Vector3};
use tatu_mechanisms::{DofDrive, ForceBound, Joint, JointEfforts, Link, Tree, TreeDrives, TreeSolver, TreeState};

use super::{
    joints::{pendulum, single},
    random::TestRng,
    robots::{gravity, load, load_fixed},
};

const H: f64 = 1.25e-3;

#[test]
fn weak_motor_sinks_stalls_at_a_limit_and_recovers() {
    // A lift with a maximum force of 15 N carries 2 kg.
    let link = Link { limits: Some([-1.0, 1.0]), ..single(Joint::Prismatic(Vector3::z())) };
    let tree = Tree::new(vec![link]).unwrap();
    let mut drives = TreeDrives::new(&tree);
    drives.drive[0] = DofDrive::Velocity { target: 0.0, bound: ForceBound::force(15.0) };
    let (mut state, mut solver) = (TreeState::new(&tree), TreeSolver::new(&tree));
    let acceleration = 15.0 / 2.0 - 9.81;
    for k in 1..=400 {
        solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
        let t = H * k as f64;
        assert!((state.v[0] - acceleration * t).abs() < 1e-12);
        assert!((state.q[0] - 0.5 * acceleration * t * t).abs() < 1e-12);
        assert_eq!(solver.efforts().drive[0], 15.0);
    }
    for _ in 0..1600 {
        solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
    }
    assert_eq!((state.q[0], state.v[0]), (-1.0, 0.0));
    assert!((solver.efforts().drive[0] - 15.0).abs() < 1e-12);
    assert!((solver.efforts().limit[0] - (2.0 * 9.81 - 15.0)).abs() < 1e-12);
    // With an additional upward force of 10 N, the drive holds the mass, then accelerates it to the target velocity.
    drives.force[0] = 10.0;
    solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
    assert_eq!((state.q[0], state.v[0]), (-1.0, 0.0));
    drives.drive[0] = DofDrive::Velocity { target: 0.1, bound: ForceBound::force(15.0) };
    solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
    assert!((state.v[0] - (25.0 / 2.0 - 9.81) * H).abs() < 1e-12);
    for _ in 0..400 {
        solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
    }
    assert_eq!(state.v[0], 0.1);
    assert!((solver.efforts().drive[0] - (2.0 * 9.81 - 10.0)).abs() < 1e-12);
}

#[test]
fn weak_motor_in_the_middle_of_an_arm_sinks_as_the_closed_form() {
    // Two horizontal pendulums in line: the outer drive holds and the inner one is too weak, so they move as one body.
    let second = Link {
        parent: Some(0),
        frame: Isometry3::from_parts(Translation3::new(0.0, 0.0, -0.6), nalgebra::UnitQuaternion::identity()),
        ..pendulum()
    };
    let tree = Tree::new(vec![pendulum(), second]).unwrap();
    let mut state = TreeState::new(&tree);
    state.q[0] = std::f64::consts::FRAC_PI_2;
    let mut drives = TreeDrives::new(&tree);
    drives.drive[0] = DofDrive::Velocity { target: 0.0, bound: ForceBound::force(5.0) };
    drives.drive[1] = DofDrive::Velocity { target: 0.0, bound: ForceBound::force(50.0) };
    let mut solver = TreeSolver::new(&tree);
    solver.step(&mut state, &tree, &drives, gravity(), H).unwrap();
    // About the first axis, the inertia is 2 * 0.5 + 2 (0.3² + 0.9²), and the torque of gravity 2 g (0.3 + 0.9).
    let inertia = 1.0 + 2.0 * (0.09 + 0.81);
    let expected: f64 = (5.0 - 2.0 * 9.81 * 1.2) / inertia;
    assert!((solver.accelerations()[0].abs() - expected.abs()).abs() < 1e-5, "{:?}", solver.accelerations());
    assert_eq!(state.v[1], 0.0);
    assert_eq!(solver.efforts().drive[0].abs(), 5.0);
    // The torque of the outer drive is that of gravity, reduced by the acceleration of the outer pendulum.
    let outer: f64 = 2.0 * 9.81 * 0.3 - expected.abs() * (0.5 + 2.0 * 0.3 * 0.9);
    assert!((solver.efforts().drive[1].abs() - outer.abs()).abs() < 1e-5, "{:?} {outer}", solver.efforts());
}

/// Lets a robot fall with drives of at most `most`, Nm, from velocity `first` on, and checks every step. Returns the
/// maximum and the mean number of linear solves per step.
fn fall(tree: &Tree, state: &mut TreeState, first: usize, most: f64, seconds: f64) -> (usize, f64) {
    let mut drives = TreeDrives::new(tree);
    for drive in &mut drives.drive[first..] {
        *drive = DofDrive::Velocity { target: 0.0, bound: ForceBound::force(most) };
    }
    let mut solver = TreeSolver::new(tree);
    let (mut greatest, mut sum) = (0, 0);
    let steps = (seconds / H) as usize;
    for _ in 0..steps {
        let report = solver.step(state, tree, &drives, gravity(), H).unwrap();
        assert!(report.satisfied);
        (greatest, sum) = (greatest.max(report.solutions), sum + report.solutions);
        for d in first..tree.velocities() {
            let (effort, v) = (solver.efforts().drive[d], state.v[d]);
            assert!(effort.abs() <= most, "{effort}");
            // A drive that does not exert its maximum force must hold the velocity at 0.
            assert!(v == 0.0 || (effort + most * v.signum()).abs() <= 1e-9 || v.abs() < 1e-11, "{v} {effort}");
        }
        assert!(state.q.iter().chain(&state.v).all(|x| x.is_finite()));
    }
    (greatest, sum as f64 / steps as f64)
}

#[test]
fn humanoids_with_weak_drives_fall_and_no_drive_exceeds_its_limit() {
    for name in ["g1", "talos", "go1", "chain20", "ur5"] {
        for most in [0.0, 0.1, 1.0, 4.0, 20.0] {
            let tree = load_fixed(name);
            let mut state = TreeState::new(&tree);
            for (i, q) in state.q.iter_mut().enumerate() {
                *q = 0.4 - 0.2 * (i % 5) as f64;
            }
            let start = state.clone();
            let (greatest, mean) = fall(&tree, &mut state, 0, most, 3.0);
            let way = state.q.iter().zip(&start.q).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
            println!("{name:8} {most:4} Nm: moved {way:.2} rad, solutions a step: {mean:.2}, at most {greatest}");
            if most <= 4.0 && name != "go1" {
                assert!(way > 0.1, "{name} at {most} Nm did not fall");
            }
        }
    }
}

#[test]
fn free_robots_with_weak_drives_tumble() {
    for name in ["go1", "g1", "talos"] {
        let robot = load(name);
        let mut state = robot.state.clone();
        let (greatest, mean) = fall(&robot.tree, &mut state, 6, 0.5, 2.0);
        println!("{name:8} free: solutions a step {mean:.2}, at most {greatest}");
    }
}

#[test]
fn random_trees_meet_all_their_laws() {
    let mut random = TestRng::new(7);
    let (mut greatest, mut missed) = (0, 0);
    for _ in 0..400 {
        let mut links = random.tree().links().to_vec();
        for link in &mut links {
            link.friction = if random.below(2) == 0 { random.within(0.0, 5.0) } else { 0.0 };
            link.damping = random.within(0.0, 0.5);
            if link.joint.velocities() == 1 && random.below(2) == 0 {
                link.limits = Some([random.within(-2.0, 0.0), random.within(0.0, 2.0)]);
            }
        }
        let tree = Tree::new(links).unwrap();
        let mut state = random.state(&tree, 2.0);
        let mut drives = TreeDrives::new(&tree);
        let single: Vec<bool> =
            tree.links().iter().flat_map(|l| vec![l.joint.velocities() == 1; l.joint.velocities()]).collect();
        let mut solver = TreeSolver::new(&tree);
        for _ in 0..40 {
            for (drive, single) in drives.drive.iter_mut().zip(&single) {
                let force = random.within(0.0, 30.0);
                let bound = if random.below(2) == 0 { ForceBound::force(force) } else { ForceBound::motor(force, 3.0) };
                let target = random.within(-2.0, 2.0);
                *drive = match random.below(4) {
                    0 => DofDrive::Off,
                    1 if *single => {
                        let (stiffness, damping) = (random.within(0.0, 1000.0), random.within(0.0, 50.0));
                        DofDrive::Position { target, velocity: 0.0, stiffness, damping, bound }
                    }
                    2 => DofDrive::Force { force: 20.0 * target, bound },
                    _ => DofDrive::Velocity { target, bound },
                };
            }
            let report = solver.step(&mut state, &tree, &drives, gravity(), 5e-3).unwrap();
            greatest = greatest.max(report.solutions);
            missed += usize::from(!report.satisfied);
            check_laws(&tree, &drives, &state, solver.efforts());
            assert!(state.q.iter().chain(&state.v).all(|x| x.is_finite()));
        }
    }
    println!("random trees: at most {greatest} solutions a step, {missed} of 16000 steps with a law missed");
    assert_eq!(missed, 0);
}

/// Checks that the forces of drives and friction agree with their laws at the final velocities.
fn check_laws(tree: &Tree, drives: &TreeDrives, state: &TreeState, efforts: &JointEfforts) {
    let friction = tree.links().iter().flat_map(|l| vec![l.friction; l.joint.velocities()]);
    for (d, friction) in friction.enumerate() {
        let (v, effort) = (state.v[d], efforts.drive[d]);
        let range = |bound: ForceBound| {
            let share = |v: f64| {
                let fall = (bound.no_load_speed - v) / (bound.no_load_speed - bound.full_speed);
                if bound.full_speed.is_finite() { fall.clamp(0.0, 1.0) } else { 1.0 }
            };
            (-bound.force * share(-v), bound.force * share(v))
        };
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (1.0 + b.abs());
        match drives.drive[d] {
            DofDrive::Off => assert_eq!(effort, 0.0),
            DofDrive::Velocity { target, bound } => {
                let (low, high) = range(bound);
                assert!((low..=high).contains(&effort) || near(effort, low) || near(effort, high));
                assert!(v > target - 1e-9 || near(effort, high), "{v} {target} {effort} {high}");
                assert!(v < target + 1e-9 || near(effort, low), "{v} {target} {effort} {low}");
            }
            DofDrive::Force { force, bound } => {
                let (low, high) = range(bound);
                assert!(near(effort, force.clamp(low, high)));
            }
            DofDrive::Position { bound, .. } => {
                let (low, high) = range(bound);
                assert!(effort >= low - 1e-9 && effort <= high + 1e-9);
            }
        }
        assert!(efforts.friction[d].abs() <= friction);
        assert!(v.abs() < 1e-9 || efforts.friction[d] == -friction * v.signum());
        let limit = efforts.limit[d];
        if limit != 0.0 {
            let own = |i: &usize| tree.offsets(*i).unwrap().1 == d && tree.links()[*i].limits.is_some();
            let link = (0..tree.links().len()).find(own).unwrap();
            let (q, [low, high]) = (state.q[tree.offsets(link).unwrap().0], tree.links()[link].limits.unwrap());
            assert!(if limit > 0.0 { q <= low + 1e-12 } else { q >= high - 1e-12 }, "{limit} at {q}");
        }
    }
}

#[test]
fn two_runs_are_equal_to_the_bit() {
    let run = || {
        let robot = load("talos");
        let mut state = robot.state.clone();
        fall(&robot.tree, &mut state, 6, 4.0, 1.0);
        state
    };
    let (a, b) = (run(), run());
    let bits = |s: &TreeState| s.q.iter().chain(&s.v).map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&a), bits(&b));
}

#[test]
fn step_depends_only_on_its_arguments() {
    let tree = load_fixed("g1");
    let mut drives = TreeDrives::new(&tree);
    drives.drive.fill(DofDrive::Velocity { target: 0.0, bound: ForceBound::force(4.0) });
    let mut state = TreeState::new(&tree);
    let mut used = TreeSolver::new(&tree);
    for _ in 0..200 {
        used.step(&mut state, &tree, &drives, gravity(), H).unwrap();
        let (mut a, mut b) = (state.clone(), state.clone());
        used.clone().step(&mut a, &tree, &drives, gravity(), H).unwrap();
        TreeSolver::new(&tree).step(&mut b, &tree, &drives, gravity(), H).unwrap();
        assert_eq!(a, b);
    }
}
