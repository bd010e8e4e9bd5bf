//! Tests of geared joints, against closed-form solutions and against the same tree without gears, whose equations are
//! projected onto the velocities that gears allow: M_r = G'MG.

use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, Vector3};
use tatu_mechanisms::{
    ContactPoint, ContactSide, DofDrive, Dynamics, ForceBound, Island, IslandTree, Joint, JointGear, JointSpring,
    Kinematics, Link, Tree, TreeDrives, TreeError, TreeSolver, TreeState,
};

use super::{
    joints::{pendulum, single},
    random::TestRng,
    robots::gravity,
};

const H: f64 = 1e-3;

fn wheel(gear: Option<JointGear>) -> Link {
    Link { gear, ..single(Joint::Revolute(Vector3::z())) }
}

fn follow(leader: usize, ratio: f64, offset: f64) -> Option<JointGear> {
    Some(JointGear { leader, ratio, offset })
}

/// Steps a tree without gravity, from rest.
fn run(tree: &Tree, drives: &TreeDrives, steps: usize) -> (TreeState, TreeSolver) {
    let (mut state, mut solver) = (TreeState::new(tree), TreeSolver::new(tree));
    for _ in 0..steps {
        assert!(solver.step(&mut state, tree, drives, Vector3::zeros(), H).unwrap().satisfied);
    }
    (state, solver)
}

#[test]
fn geared_wheel_adds_its_inertia_times_the_squared_ratio() {
    // Wheels of 0.5 kg m²; torques on the first, on the second, and on both.
    let tree = Tree::new(vec![wheel(None), wheel(follow(0, -3.0, 0.4))]).unwrap();
    assert_eq!((tree.positions(), tree.velocities(), tree.axes()), (1, 1, 2));
    for [first, second] in [[2.0, 0.0], [0.0, 2.0], [1.0, 0.5]] {
        let mut drives = TreeDrives::new(&tree);
        for (drive, force) in drives.drive.iter_mut().zip([first, second]) {
            *drive = DofDrive::Force { force, bound: ForceBound::NONE };
        }
        let (state, solver) = run(&tree, &drives, 100);
        let expected = (first - 3.0 * second) / (0.5 + 9.0 * 0.5) * 0.1;
        assert!((state.v[0] - expected).abs() < 1e-14, "{} {expected}", state.v[0]);
        assert!(
            (solver.efforts().drive[0] - first).abs() < 1e-14 && (solver.efforts().drive[1] - second).abs() < 1e-14
        );
        let mut kinematics = Kinematics::new(&tree);
        kinematics.update(&tree, &state).unwrap();
        let angle = kinematics.pose(1).unwrap().rotation.euler_angles().2;
        assert!((angle - (0.4 - 3.0 * state.q[0])).abs() < 1e-14);
        assert!((kinematics.velocity(1, Vector3::zeros()).unwrap().0.z + 3.0 * state.v[0]).abs() < 1e-14);
    }
}

#[test]
fn gears_of_gears_multiply() {
    // The third joint follows the second, which follows the first; the leader is the last link.
    let links = vec![wheel(follow(1, 0.5, 0.1)), wheel(follow(2, 4.0, -0.2)), wheel(None)];
    let tree = Tree::new(links).unwrap();
    assert_eq!(tree.gear(0), Some((2.0, 0.0)));
    assert_eq!((tree.gear(1), tree.gear(2)), (Some((4.0, -0.2)), None));
    let mut drives = TreeDrives::new(&tree);
    drives.drive[0] = DofDrive::Force { force: 1.0, bound: ForceBound::NONE };
    let (state, _) = run(&tree, &drives, 100);
    let expected = 2.0 / (0.5 * (1.0 + 4.0 + 16.0)) * 0.1;
    assert!((state.v[0] - expected).abs() < 1e-14, "{} {expected}", state.v[0]);
}

#[test]
fn motors_of_geared_joints_share_a_load_by_their_bounds() {
    // A load of 5 N m on the first wheel is held by motors of 4 N m and, through a ratio of 2, 1 N m.
    let tree = Tree::new(vec![wheel(None), wheel(follow(0, 2.0, 0.0))]).unwrap();
    let mut drives = TreeDrives::new(&tree);
    let hold = |force| DofDrive::Velocity { target: 0.0, bound: ForceBound::force(force) };
    (drives.drive[0], drives.drive[1], drives.force[0]) = (hold(4.0), hold(1.0), 5.0);
    let (state, solver) = run(&tree, &drives, 10);
    assert_eq!(state.v[0], 0.0);
    let drive = &solver.efforts().drive;
    assert!((drive[0] + 4.0 * 5.0 / 6.0).abs() < 1e-12 && (drive[1] + 5.0 / 6.0).abs() < 1e-12, "{drive:?}");
    // With 7 N m, both are at their bounds, and the rest accelerates the wheels.
    drives.force[0] = 7.0;
    let (state, solver) = run(&tree, &drives, 100);
    assert_eq!(solver.efforts().drive, [-4.0, -1.0]);
    assert!((state.v[0] - 1.0 / (0.5 + 4.0 * 0.5) * 0.1).abs() < 1e-12);
}

#[test]
fn drives_with_different_targets_settle_where_their_sum_is_zero() {
    // The stronger motor wins; the weaker one exerts its bound against it.
    let tree = Tree::new(vec![wheel(None), wheel(follow(0, 1.0, 0.0))]).unwrap();
    let mut drives = TreeDrives::new(&tree);
    drives.drive[0] = DofDrive::Velocity { target: 1.0, bound: ForceBound::force(5.0) };
    drives.drive[1] = DofDrive::Velocity { target: -2.0, bound: ForceBound::force(3.0) };
    let (state, solver) = run(&tree, &drives, 2000);
    assert_eq!(state.v[0], 1.0);
    assert!((solver.efforts().drive[0] - 3.0).abs() < 1e-12 && solver.efforts().drive[1] == -3.0);
    // Two motors whose torque falls with speed: 6 (1 - v / 4) = 2 (2 v / 4) at v = 2.4, with ratio 1 and braking at full
    // torque of 2 for the second: 6 (1 - v / 4) = 2.
    drives.drive[0] = DofDrive::Velocity { target: 100.0, bound: ForceBound::motor(6.0, 4.0) };
    drives.drive[1] = DofDrive::Velocity { target: -100.0, bound: ForceBound::motor(2.0, 4.0) };
    let (state, solver) = run(&tree, &drives, 20_000);
    assert!((state.v[0] - 8.0 / 3.0).abs() < 1e-9, "{}", state.v[0]);
    assert!((solver.efforts().drive[0] - 2.0).abs() < 1e-8 && (solver.efforts().drive[1] + 2.0).abs() < 1e-8);
}

#[test]
fn springs_of_both_joints_add_through_the_gear() {
    // 10 (0.6 - q) + 2 * 5 (0.8 - (2 q + 0.2)) = 0.
    let tree = Tree::new(vec![wheel(None), wheel(follow(0, 2.0, 0.2))]).unwrap();
    let mut drives = TreeDrives::new(&tree);
    drives.spring[0] = JointSpring { rest: 0.6, stiffness: 10.0, damping: 4.0 };
    drives.spring[1] = JointSpring { rest: 0.8, stiffness: 5.0, damping: 4.0 };
    let (state, _) = run(&tree, &drives, 20_000);
    let expected = (10.0 * 0.6 + 2.0 * 5.0 * 0.6) / (10.0 + 4.0 * 5.0);
    assert!((state.q[0] - expected).abs() < 1e-9, "{} {expected}", state.q[0]);
}

#[test]
fn position_drive_of_a_geared_joint_reaches_its_target() {
    let tree = Tree::new(vec![wheel(None), wheel(follow(0, -0.5, 0.2))]).unwrap();
    let mut drives = TreeDrives::new(&tree);
    let bound = ForceBound::force(50.0);
    drives.drive[1] = DofDrive::Position { target: 0.7, velocity: 0.0, stiffness: 40.0, damping: 20.0, bound };
    let (state, _) = run(&tree, &drives, 20_000);
    assert!((state.q[0] + 1.0).abs() < 1e-9, "{}", state.q[0]);
}

#[test]
fn limits_of_either_joint_stop_both() {
    let push = |tree: &Tree, force: f64| {
        let mut drives = TreeDrives::new(tree);
        drives.drive[0] = DofDrive::Force { force, bound: ForceBound::NONE };
        let (state, solver) = run(tree, &drives, 3000);
        assert_eq!(state.v[0], 0.0);
        assert!((solver.efforts().limit[0] + force).abs() < 1e-12);
        state.q[0]
    };
    // The second joint is at -2 q + 0.1, from -0.9 to 0.5: q from -0.2 to 0.5.
    let second = Link { limits: Some([-0.9, 0.5]), ..wheel(follow(0, -2.0, 0.1)) };
    let tree = Tree::new(vec![wheel(None), second.clone()]).unwrap();
    assert!((push(&tree, 3.0) - 0.5).abs() < 1e-15 && (push(&tree, -3.0) + 0.2).abs() < 1e-15);
    let tree = Tree::new(vec![Link { limits: Some([-1.0, 0.3]), ..wheel(None) }, second.clone()]).unwrap();
    assert_eq!(push(&tree, 3.0), 0.3);
    assert!((push(&tree, -3.0) + 0.2).abs() < 1e-15);
    // Limits that exclude each other: those of the geared joint are ignored.
    let tree = Tree::new(vec![Link { limits: Some([0.6, 0.7]), ..wheel(None) }, second]).unwrap();
    assert_eq!(push(&tree, 3.0), 0.7);
}

#[test]
fn friction_and_damping_of_a_geared_joint_act_through_the_gear() {
    let second = Link { friction: 0.5, damping: 0.1, ..wheel(follow(0, -2.0, 0.0)) };
    let tree = Tree::new(vec![wheel(None), second]).unwrap();
    let mut drives = TreeDrives::new(&tree);
    drives.drive[0] = DofDrive::Force { force: 0.999, bound: ForceBound::NONE };
    assert_eq!(run(&tree, &drives, 100).0.q[0], 0.0);
    // Beyond the friction of 1 N m, the speed at which damping of 0.4 N m s/rad carries the rest.
    drives.drive[0] = DofDrive::Force { force: 3.0, bound: ForceBound::NONE };
    assert!((run(&tree, &drives, 200_000).0.v[0] - 2.0 / 0.4).abs() < 1e-9);
}

#[test]
fn geared_pendulums_swing_like_the_closed_form() {
    // J q'' = -m g l (sin q + n sin(n q)) with J = (1 + n²) (0.5 + 2 * 0.3²), integrated with tiny steps of order 4.
    let n = -1.5;
    let tree = Tree::new(vec![pendulum(), Link { gear: follow(0, n, 0.0), ..pendulum() }]).unwrap();
    let mut start = TreeState::new(&tree);
    start.q[0] = 0.9;
    let inertia = (1.0 + n * n) * 0.68;
    let turn = |q: f64| -2.0 * 9.81 * 0.3 * (libm::sin(q) + n * libm::sin(n * q)) / inertia;
    let (mut q, mut v, h) = (0.9, 0.0, 1e-4);
    for _ in 0..20_000 {
        let (a, b) = (turn(q), turn(q + 0.5 * h * v));
        let c = turn(q + 0.5 * h * (v + 0.5 * h * a));
        let d = turn(q + h * (v + 0.5 * h * b));
        q += h * v + h * h / 6.0 * (a + b + c);
        v += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
    }
    let end = |h: f64| {
        let (mut state, mut solver) = (start.clone(), TreeSolver::new(&tree));
        for _ in 0..(2.0 / h) as usize {
            solver.step(&mut state, &tree, &TreeDrives::new(&tree), gravity(), h).unwrap();
        }
        (state.q[0] - q).abs()
    };
    let [coarse, fine] = [2e-3, 1e-3].map(end);
    assert!(coarse < 1e-4 && fine < 0.3 * coarse, "{coarse} {fine}");
}

/// Returns a random tree with gears of either kind (within a branch, across branches, chains), and the same tree
/// without them.
fn random_pair(random: &mut TestRng) -> Option<(Tree, Tree)> {
    let plain = random.tree();
    let mut links = plain.links().to_vec();
    let mut single: Vec<usize> = (0..links.len()).filter(|i| links[*i].joint.positions() == 1).collect();
    if single.len() < 2 {
        return None;
    }
    // Each follows one that comes later in a random order, so there are no cycles.
    for i in (1..single.len()).rev() {
        let other = random.below(i + 1);
        single.swap(i, other);
    }
    for k in 0..single.len() - 1 {
        if random.below(2) == 0 {
            let leader = single[k + 1 + random.below(single.len() - k - 1)];
            links[single[k]].gear = follow(leader, random.within(-2.0, 2.0), random.within(-1.0, 1.0));
        }
    }
    let geared = links.iter().any(|l| l.gear.is_some());
    geared.then(|| (Tree::new(links).unwrap(), plain))
}

/// Returns the state without gears that corresponds to one with gears, and the matrix G that maps the velocities.
fn without_gears(tree: &Tree, plain: &Tree, state: &TreeState) -> (TreeState, DMatrix<f64>) {
    let mut out = TreeState::new(plain);
    let mut map = DMatrix::zeros(plain.velocities(), tree.velocities());
    for (i, link) in plain.links().iter().enumerate() {
        let ((p, v), (from_p, from_v)) = (plain.offsets(i).unwrap(), tree.offsets(i).unwrap());
        let (ratio, offset) = tree.gear(i).unwrap_or((1.0, 0.0));
        for k in 0..link.joint.positions() {
            out.q[p + k] = ratio * state.q[from_p + k] + offset;
        }
        for k in 0..link.joint.velocities() {
            map[(v + k, from_v + k)] = ratio;
        }
    }
    let v = &map * DVector::from_column_slice(&state.v);
    out.v.copy_from_slice(v.as_slice());
    (out, map)
}

fn mass_of(dynamics: &Dynamics, tree: &Tree) -> DMatrix<f64> {
    let n = tree.velocities();
    let mut out = vec![0.0; n * n];
    dynamics.mass_matrix(tree, &mut out).unwrap();
    DMatrix::from_row_slice(n, n, &out)
}

#[test]
fn equations_are_those_without_gears_projected_onto_the_geared_motion() {
    let mut random = TestRng::new(7);
    let mut count = 0;
    for _ in 0..400 {
        let Some((tree, plain)) = random_pair(&mut random) else { continue };
        count += 1;
        let state = random.state(&tree, 2.0);
        let (full, map) = without_gears(&tree, &plain, &state);
        let (mut own, mut other) = (Dynamics::new(&tree), Dynamics::new(&plain));
        own.update(&tree, &state).unwrap();
        other.update(&plain, &full).unwrap();
        let (mass, expected) = (mass_of(&own, &tree), map.transpose() * mass_of(&other, &plain) * &map);
        assert!((&mass - &expected).amax() <= 1e-12 * (1.0 + expected.amax()), "{}", (&mass - &expected).amax());
        let (mut bias, mut long) = (vec![0.0; tree.velocities()], vec![0.0; plain.velocities()]);
        own.bias(&tree, gravity(), &mut bias).unwrap();
        other.bias(&plain, gravity(), &mut long).unwrap();
        let expected = map.transpose() * DVector::from_vec(long);
        let error = (DVector::from_column_slice(&bias) - &expected).amax();
        assert!(error <= 1e-11 * (1.0 + expected.amax()), "{error}");
        // The factorisation has the fill-in that gears across branches require.
        let wanted: Vec<f64> = (0..tree.velocities()).map(|_| random.within(-1.0, 1.0)).collect();
        let mut x = wanted.clone();
        own.solve(&tree, &mut x).unwrap();
        let left = &mass * DVector::from_vec(x.clone()) - DVector::from_vec(wanted);
        let size = mass.abs() * DVector::from_vec(x).abs();
        assert!(left.amax() <= 1e-11 * (1.0 + size.amax()), "{}", left.amax());
        let (kinetic, potential) = own.energy(&tree, gravity()).unwrap();
        let (other_kinetic, other_potential) = other.energy(&plain, gravity()).unwrap();
        assert!((kinetic - other_kinetic).abs() <= 1e-12 * (1.0 + kinetic));
        assert!((potential - other_potential).abs() <= 1e-12 * (1.0 + potential.abs()));
        check_jacobians(&mut random, (&tree, &own), (&plain, &other), &map);
    }
    assert!(count > 200, "{count}");
}

/// Checks the Jacobians of all links, and the generalised forces of a force on each.
fn check_jacobians(
    random: &mut TestRng,
    (tree, own): (&Tree, &Dynamics),
    (plain, other): (&Tree, &Dynamics),
    map: &DMatrix<f64>,
) {
    let (n, m) = (tree.velocities(), plain.velocities());
    for link in 0..plain.links().len() {
        let (point, force) = (random.vector(1.0), random.vector(5.0));
        let (mut short, mut long) = (vec![0.0; 6 * n], vec![0.0; 6 * m]);
        own.kinematics().jacobian(tree, link, point, &mut short).unwrap();
        other.kinematics().jacobian(plain, link, point, &mut long).unwrap();
        let expected = DMatrix::from_row_slice(6, m, &long) * map;
        assert!((DMatrix::from_row_slice(6, n, &short) - &expected).amax() <= 1e-12 * (1.0 + expected.amax()));
        let (mut short, mut long) = (vec![0.0; n], vec![0.0; m]);
        own.kinematics().add_force(tree, link, point, force, force, &mut short).unwrap();
        other.kinematics().add_force(plain, link, point, force, force, &mut long).unwrap();
        let expected = map.transpose() * DVector::from_vec(long);
        assert!((DVector::from_vec(short) - &expected).amax() <= 1e-12 * (1.0 + expected.amax()));
    }
}

/// Returns a free body with two arms of two links each, geared across the arms and within one of them.
fn free_robot() -> Tree {
    let body = Link::new(
        None,
        Isometry3::identity(),
        Joint::Free,
        3.0,
        Vector3::zeros(),
        Matrix3::from_diagonal(&Vector3::new(0.03, 0.04, 0.05)),
    );
    let arm = |parent, x: f64, axis: Vector3<f64>, gear| Link {
        gear,
        ..Link::new(
            Some(parent),
            Isometry3::translation(x, 0.0, 0.0),
            Joint::Revolute(axis),
            0.5,
            Vector3::new(x, 0.02, 0.0),
            Matrix3::from_diagonal(&Vector3::new(0.001, 0.002, 0.0025)),
        )
    };
    Tree::new(vec![
        body,
        arm(0, 0.2, Vector3::y(), follow(3, 1.5, 0.1)),
        arm(1, 0.2, Vector3::z(), follow(1, -1.0, 0.0)),
        arm(0, -0.2, Vector3::y(), None),
        arm(3, -0.2, Vector3::x(), None),
    ])
    .unwrap()
}

#[test]
fn gears_preserve_momentum_and_energy_of_a_free_robot() {
    let tree = free_robot();
    let mut state = TreeState::new(&tree);
    for (i, v) in [0.3, -0.2, 0.1, 0.5, -0.4, 0.8, 1.0, -0.7].into_iter().enumerate() {
        state.v[i] = v;
    }
    let (mut dynamics, mut kinematics) = (Dynamics::new(&tree), Kinematics::new(&tree));
    let mut measure = |state: &TreeState| {
        kinematics.update(&tree, state).unwrap();
        dynamics.update(&tree, state).unwrap();
        let (mut linear, mut angular) = (Vector3::zeros(), Vector3::zeros());
        for (i, link) in tree.links().iter().enumerate() {
            let pose = kinematics.pose(i).unwrap();
            let center = (pose * nalgebra::Point3::from(link.center)).coords;
            let (w, v) = kinematics.velocity(i, center).unwrap();
            let turned = pose.rotation.to_rotation_matrix().into_inner();
            linear += v * link.mass;
            angular += center.cross(&(v * link.mass)) + turned * link.inertia * turned.transpose() * w;
        }
        (linear, angular, dynamics.energy(&tree, Vector3::zeros()).unwrap().0)
    };
    let before = measure(&state);
    let mut solver = TreeSolver::new(&tree);
    for _ in 0..2000 {
        solver.step(&mut state, &tree, &TreeDrives::new(&tree), Vector3::zeros(), H).unwrap();
    }
    let after = measure(&state);
    assert!((after.0 - before.0).norm() < 1e-6 * before.0.norm(), "{} {}", after.0, before.0);
    assert!((after.1 - before.1).norm() < 1e-5 * before.1.norm(), "{} {}", after.1, before.1);
    assert!((after.2 - before.2).abs() < 1e-5 * before.2, "{} {}", after.2, before.2);
}

#[test]
fn geared_fingers_press_on_a_box_from_both_sides_with_the_same_force() {
    // Two sliding fingers, of which only one has a motor of 20 N; they move against each other. The box is free.
    let finger = |axis: Vector3<f64>, y: f64, gear| Link {
        gear,
        ..Link::new(
            None,
            Isometry3::translation(0.0, y, 0.0),
            Joint::Prismatic(axis),
            0.1,
            Vector3::zeros(),
            Matrix3::identity() * 1e-4,
        )
    };
    let hand = Tree::new(vec![finger(Vector3::y(), -0.05, None), finger(-Vector3::y(), 0.05, follow(0, 1.0, 0.0))]);
    let hand = hand.unwrap();
    let cube = Link::new(
        None,
        Isometry3::identity(),
        Joint::Free,
        0.2,
        Vector3::zeros(),
        Matrix3::identity() * 0.2 * 0.1 * 0.1 / 6.0,
    );
    let cube = Tree::new(vec![cube]).unwrap();
    let mut drives = [TreeDrives::new(&hand), TreeDrives::new(&cube)];
    drives[0].drive[0] = DofDrive::Velocity { target: 0.05, bound: ForceBound::force(20.0) };
    let (mut states, mut solvers) =
        ([TreeState::new(&hand), TreeState::new(&cube)], [TreeSolver::new(&hand), TreeSolver::new(&cube)]);
    let mut carried = [vec![0.0; hand.axes()], vec![0.0; cube.axes()]];
    let contact = |link: usize, x: f64, z: f64| {
        let inward = if link == 0 { Vector3::y() } else { -Vector3::y() };
        ContactPoint {
            sides: [Some(ContactSide { member: 0, link }), Some(ContactSide { member: 1, link: 0 })],
            arms: [Vector3::new(x, 0.0, z), Vector3::new(x, 0.0, z) - inward * 0.05],
            distance: 0.0,
            drift: Vector3::zeros(),
            normal: inward,
            slide: Vector3::zeros(),
            friction: 0.5,
            restitution: 0.0,
            recovery: 100.0,
            impulse: Vector3::zeros(),
        }
    };
    let corners = [(-0.04, -0.04), (0.04, -0.04), (0.04, 0.04), (-0.04, 0.04)];
    let mut contacts: Vec<ContactPoint> =
        [0, 1].into_iter().flat_map(|link| corners.map(|(x, z)| contact(link, x, z))).collect();
    let mut island = Island::new();
    for _ in 0..400 {
        let parts = states.iter_mut().zip(&drives).zip(solvers.iter_mut()).zip(carried.iter_mut());
        let mut members: Vec<IslandTree> = parts
            .zip([&hand, &cube])
            .map(|((((state, drives), solver), carried), tree)| IslandTree { tree, state, drives, solver, carried })
            .collect();
        assert!(island.step(&mut members, &mut contacts, gravity(), H).unwrap().satisfied);
    }
    let forces = [0, 4].map(|first| contacts[first..first + 4].iter().map(|c| c.impulse.y.abs()).sum::<f64>() / H);
    // The motor of 20 N presses with 10 N on either side; friction carries the box.
    assert!((forces[0] - 10.0).abs() < 1e-6 && (forces[1] - 10.0).abs() < 1e-6, "{forces:?}");
    assert!(states[1].q[2].abs() < 1e-6 && states[1].q[1].abs() < 1e-6, "{:?}", states[1].q);
    assert!((carried[0][0] - 20.0).abs() < 1e-9 && carried[0][1] == 0.0, "{:?}", carried[0]);
}

#[test]
fn gear_errors_name_the_link_and_the_leader() {
    let error = |links: Vec<Link>| Tree::new(links).unwrap_err();
    let cycle = vec![wheel(follow(1, 1.0, 0.0)), wheel(follow(0, 1.0, 0.0))];
    assert!(matches!(error(cycle), TreeError::Gear { link: 0, .. }));
    assert!(matches!(error(vec![wheel(follow(0, 1.0, 0.0))]), TreeError::Gear { link: 0, leader: 0, .. }));
    assert!(matches!(error(vec![wheel(follow(5, 1.0, 0.0))]), TreeError::Gear { link: 0, leader: 5, .. }));
    let ball = vec![single(Joint::Spherical), wheel(follow(0, 1.0, 0.0))];
    assert!(matches!(error(ball), TreeError::Gear { link: 1, leader: 0, .. }));
    let ball = vec![wheel(None), Link { gear: follow(0, 1.0, 0.0), ..single(Joint::Spherical) }];
    assert!(matches!(error(ball), TreeError::Joint { link: 1, .. }));
    assert!(matches!(error(vec![wheel(None), wheel(follow(0, f64::NAN, 0.0))]), TreeError::NotFinite { link: 1, .. }));
    // A leader without mass moves that of its follower, unless the ratio is 0.
    let light = || Link { mass: 0.0, inertia: Matrix3::zeros(), ..wheel(None) };
    assert!(Tree::new(vec![light(), wheel(follow(0, 2.0, 0.0))]).is_ok());
    assert!(matches!(error(vec![light(), wheel(follow(0, 0.0, 0.0))]), TreeError::Massless { link: 0 }));
}
