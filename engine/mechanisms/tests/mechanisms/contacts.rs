//! Tests of contacts of trees with the ground and with each other.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use tatu_mechanisms::{
    ContactPoint, ContactSide, DofDrive, ForceBound, Island, IslandTree, Joint, Kinematics, Link, Tree, TreeDrives,
    TreeSolver, TreeState,
};

use super::robots::{gravity, load};

const H: f64 = 1.25e-3;

/// Trees with the states, drives, solvers and contacts of their steps.
struct ContactWorld {
    trees: Vec<Tree>,
    states: Vec<TreeState>,
    drives: Vec<TreeDrives>,
    solvers: Vec<TreeSolver>,
    carried: Vec<Vec<f64>>,
    contacts: Vec<ContactPoint>,
    /// The point of each side of a contact: in the frame of its link, or in the world frame if the side has no link.
    points: Vec<[Vector3<f64>; 2]>,
    island: Island,
    gravity: Vector3<f64>,
    rounds: usize,
}

impl ContactWorld {
    fn new(trees: Vec<Tree>) -> Self {
        ContactWorld {
            states: trees.iter().map(TreeState::new).collect(),
            drives: trees.iter().map(TreeDrives::new).collect(),
            solvers: trees.iter().map(TreeSolver::new).collect(),
            carried: trees.iter().map(|t| vec![0.0; t.velocities()]).collect(),
            contacts: vec![],
            points: vec![],
            island: Island::new(),
            gravity: gravity(),
            rounds: 0,
            trees,
        }
    }

    fn touch(&mut self, (contact, points): (ContactPoint, [Vector3<f64>; 2])) {
        self.contacts.push(contact);
        self.points.push(points);
    }

    /// Updates arms and distances of the contacts, as collision detection does.
    fn detect(&mut self) {
        let mut kinematics: Vec<Kinematics> = self.trees.iter().map(Kinematics::new).collect();
        for (k, (tree, state)) in kinematics.iter_mut().zip(self.trees.iter().zip(&self.states)) {
            k.update(tree, state).unwrap();
        }
        for (contact, points) in self.contacts.iter_mut().zip(&self.points) {
            let places = [0, 1].map(|i| match contact.sides[i] {
                Some(side) => {
                    let pose = kinematics[side.member].pose(side.link).unwrap();
                    let place = (pose * Point3::from(points[i])).coords;
                    contact.arms[i] = place - pose.translation.vector;
                    place
                }
                None => points[i],
            });
            contact.distance = (places[1] - places[0]).dot(&contact.normal);
        }
    }

    fn step(&mut self) {
        self.detect();
        let ContactWorld { trees, states, drives, solvers, carried, .. } = self;
        let parts = trees.iter().zip(states).zip(drives.iter()).zip(solvers).zip(carried);
        let mut members: Vec<IslandTree<'_>> = parts
            .map(|((((tree, state), drives), solver), carried)| IslandTree { tree, state, drives, solver, carried })
            .collect();
        let report = self.island.step(&mut members, &mut self.contacts, self.gravity, H).unwrap();
        self.rounds = self.rounds.max(report.rounds);
    }

    fn steps(&mut self, seconds: f64) {
        (0..(seconds / H).round() as usize).for_each(|_| self.step());
    }

    /// Returns the sum of the contact forces on the second sides in the last step, N.
    fn force(&self) -> Vector3<f64> {
        self.contacts.iter().map(|c| c.impulse).sum::<Vector3<f64>>() / H
    }
}

/// Returns a contact between a point of a link and a plane through a point of the world.
fn on_plane(
    member: usize,
    link: usize,
    own: Vector3<f64>,
    plane: Vector3<f64>,
    normal: Vector3<f64>,
) -> (ContactPoint, [Vector3<f64>; 2]) {
    let contact = ContactPoint {
        sides: [None, Some(ContactSide { member, link })],
        arms: [Vector3::zeros(); 2],
        distance: 0.0,
        drift: Vector3::zeros(),
        normal,
        slide: Vector3::zeros(),
        friction: 1.0,
        restitution: 0.0,
        recovery: 100.0,
        impulse: Vector3::zeros(),
    };
    (contact, [plane, own])
}

/// Returns a free cube with a mass in kg and an edge length in m.
fn cube(mass: f64, size: f64) -> Tree {
    let inertia = Matrix3::identity() * (mass * size * size / 6.0);
    Tree::new(vec![Link::new(None, Isometry3::identity(), Joint::Free, mass, Vector3::zeros(), inertia)]).unwrap()
}

/// Returns the lower corners of a cube.
fn corners(size: f64) -> Vec<Vector3<f64>> {
    let half = 0.5 * size;
    [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(x, y)| Vector3::new(x * half, y * half, -half)).into()
}

/// Returns a world with a cube on a slope, which is a horizontal plane at the origin with gravity rotated about y.
fn sloped(degrees: f64, friction: f64) -> ContactWorld {
    let mut world = ContactWorld::new(vec![cube(2.0, 0.2)]);
    world.states[0].q[2] = 0.1;
    let (sine, cosine) = libm::sincos(degrees.to_radians());
    world.gravity = Vector3::new(9.81 * sine, 0.0, -9.81 * cosine);
    for corner in corners(0.2) {
        let (contact, points) = on_plane(0, 0, corner, Vector3::zeros(), Vector3::z());
        world.touch((ContactPoint { friction, ..contact }, points));
    }
    world
}

#[test]
fn block_sticks_on_a_slope_and_slides_at_the_acceleration_of_coulomb() {
    let mut world = sloped(25.0, 0.5);
    world.steps(10.0);
    assert!(world.states[0].q[0].abs() < 1e-6, "{}", world.states[0].q[0]);
    assert!((world.force() + 2.0 * world.gravity).norm() < 1e-6);
    let mut world = sloped(30.0, 0.3);
    world.steps(1.0);
    let (sine, cosine) = libm::sincos(30f64.to_radians());
    let expected = 9.81 * (sine - 0.3 * cosine);
    assert!((world.states[0].v[0] / expected - 1.0).abs() < 1e-4, "{} {expected}", world.states[0].v[0]);
    // The friction cone is isotropic: a block that slides diagonally does not change its direction.
    let mut world = sloped(0.0, 0.3);
    (world.states[0].v[0], world.states[0].v[1]) = (3.0, 4.0);
    world.steps(1.0);
    let v = &world.states[0].v;
    assert!((libm::hypot(v[0], v[1]) - (5.0 - 0.3 * 9.81)).abs() < 1e-3 && (v[1] / v[0] - 4.0 / 3.0).abs() < 1e-3);
}

#[test]
fn ball_bounces_to_the_square_of_its_restitution_then_rests() {
    let mut world = ContactWorld::new(vec![cube(1.0, 0.2)]);
    world.states[0].q[2] = 1.1;
    let (contact, points) = on_plane(0, 0, Vector3::new(0.0, 0.0, -0.1), Vector3::zeros(), Vector3::z());
    world.touch((ContactPoint { restitution: 0.5, ..contact }, points));
    let mut apex = 0.0f64;
    for k in 0..1600 {
        world.step();
        if k > 400 {
            apex = apex.max(world.states[0].q[2] - 0.1);
        }
    }
    assert!((apex / 0.25 - 1.0).abs() < 0.02, "{apex}");
    world.steps(4.0);
    assert!((world.states[0].q[2] - 0.1).abs() < 1e-6 && world.states[0].v[2].abs() < 1e-9);
}

/// The weight of a block on its four corners is distributed so that the sum of the squares of the forces is least: with
/// the centre of mass at (x, y) from the middle, the force on a corner at (X, Y) is W (1 / 4 + x X / S + y Y / S),
/// where S is the sum of X^2. On three corners, statics determines the forces: they are W times the barycentric
/// coordinates.
#[test]
fn weight_is_distributed_with_the_least_norm() {
    let (mass, size, x, y) = (2.0, 0.2, 0.03, -0.02);
    let centre = Vector3::new(x, y, 0.01);
    let inertia = Matrix3::identity() * (mass * size * size / 6.0);
    let block = Link::new(None, Isometry3::identity(), Joint::Free, mass, centre, inertia);
    let weight = 9.81 * mass;
    for count in [4, 3] {
        let mut world = ContactWorld::new(vec![Tree::new(vec![block.clone()]).unwrap()]);
        world.states[0].q[2] = 0.1;
        for corner in corners(size).into_iter().take(count) {
            world.touch(on_plane(0, 0, corner, Vector3::zeros(), Vector3::z()));
        }
        world.steps(1.0);
        for (contact, corner) in world.contacts.iter().zip(corners(size)) {
            let expected = if count == 4 {
                weight * (0.25 + (x * corner.x + y * corner.y) / (size * size))
            } else {
                // Corners (+, +), (+, -), (-, +), each h from the middle: a + b + c = 1, a + b - c = x / h, a - b + c =
                // y / h.
                let (u, v) = (x / (0.5 * size), y / (0.5 * size));
                let share = [0.5 * (u + v), 0.5 * (1.0 - v), 0.5 * (1.0 - u)];
                weight * share[if corner.x < 0.0 { 2 } else { usize::from(corner.y < 0.0) }]
            };
            let force = contact.impulse.z / H;
            assert!((force - expected).abs() < 1e-6 * weight, "{count} corners: {force}, expected {expected}");
        }
        assert!(world.states[0].v.iter().all(|v| v.abs() < 1e-12));
    }
}

/// A cube hits a free chain of two links. Momentum must not change; what remains in the step of the impact is of second
/// order in the angle by which the chain turns in it, so it is 16 times as much at four times the speed.
#[test]
fn impact_preserves_momentum() {
    let beam = |parent, joint, mass: f64, frame: Isometry3<f64>, centre| {
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.002, 0.02, 0.02)) * mass;
        Link::new(parent, frame, joint, mass, centre, inertia)
    };
    let hinge = Isometry3::translation(0.25, 0.0, 0.0);
    let chain = Tree::new(vec![
        beam(None, Joint::Free, 2.0, Isometry3::identity(), Vector3::zeros()),
        beam(Some(0), Joint::Revolute(Vector3::z()), 1.0, hinge, Vector3::new(0.25, 0.0, 0.0)),
    ])
    .unwrap();
    let lost = |speed: f64, restitution: f64| {
        let mut world = ContactWorld::new(vec![chain.clone(), cube(1.0, 0.1)]);
        world.gravity = Vector3::zeros();
        world.states[1].q[..3].copy_from_slice(&[0.65, -0.1 - 0.5 * H * speed, 0.02]);
        world.states[1].v[1] = speed;
        let (mut contact, mut points) = on_plane(1, 0, Vector3::new(0.0, 0.05, 0.0), Vector3::zeros(), -Vector3::y());
        contact.sides[0] = Some(ContactSide { member: 0, link: 1 });
        contact.restitution = restitution;
        points[0] = Vector3::new(0.4, -0.05, 0.0);
        world.touch((contact, points));
        let momentum = |world: &ContactWorld| {
            let mut sum = Vector3::zeros();
            for (tree, state) in world.trees.iter().zip(&world.states) {
                let mut kinematics = Kinematics::new(tree);
                kinematics.update(tree, state).unwrap();
                for (i, link) in tree.links().iter().enumerate() {
                    let centre = kinematics.pose(i).unwrap() * Point3::from(link.center);
                    sum += kinematics.velocity(i, centre.coords).unwrap().1 * link.mass;
                }
            }
            sum
        };
        let before = momentum(&world);
        // The bodies touch after half of the step, so there is no overlap, whose removal would turn the links.
        world.step();
        assert!(world.states[1].v[1] < 0.8 * speed, "the cube hits the chain");
        (momentum(&world) - before).norm() / before.norm()
    };
    for restitution in [0.0, 0.5, 1.0] {
        let [fast, slow] = [20.0, 5.0].map(|speed| lost(speed, restitution));
        println!("restitution {restitution}: {fast:.1e} {slow:.1e}");
        assert!(fast < 5e-3 && fast > 12.0 * slow, "restitution {restitution}: {fast} {slow}");
    }
}

#[test]
fn belt_carries_a_block() {
    let mut world = sloped(0.0, 0.5);
    for contact in &mut world.contacts {
        contact.slide = Vector3::new(0.4, 0.0, 0.0);
    }
    world.steps(1.0);
    assert!((world.states[0].v[0] - 0.4).abs() < 1e-9);
}

#[test]
fn overlapping_bodies_separate_without_momentum() {
    let mut world = sloped(0.0, 0.5);
    world.states[0].q[2] = 0.08;
    let mut fastest = 0.0f64;
    for _ in 0..800 {
        world.step();
        fastest = fastest.max(world.states[0].v[2]);
    }
    assert!((world.states[0].q[2] - 0.1).abs() < 1e-6 && fastest < 1e-6, "{fastest}");
}

#[test]
fn tower_of_cubes_is_stable_with_forces_that_add_up() {
    let mut world = ContactWorld::new((0..5).map(|_| cube(1.0, 0.2)).collect());
    for i in 0..5 {
        world.states[i].q[2] = 0.1 + 0.2 * i as f64;
        for corner in corners(0.2) {
            let (mut contact, mut points) = on_plane(i, 0, corner, Vector3::zeros(), Vector3::z());
            if i > 0 {
                contact.sides[0] = Some(ContactSide { member: i - 1, link: 0 });
                points[0] = Vector3::new(corner.x, corner.y, 0.1);
            }
            world.touch((contact, points));
        }
    }
    world.steps(5.0);
    for i in 0..5 {
        let force: f64 = world.contacts[4 * i..4 * i + 4].iter().map(|c| c.impulse.z / H).sum();
        assert!((force - 9.81 * (5 - i) as f64).abs() < 1e-4, "{i}: {force}");
        assert!((world.states[i].q[2] - (0.1 + 0.2 * i as f64)).abs() < 1e-6);
        assert!(world.states[i].q[0].abs() < 1e-6);
    }
}

/// Returns a world with a robot whose feet, which are points of its lowest links, are `height`, m, above the ground.
fn standing(name: &str, height: f64) -> ContactWorld {
    let robot = load(name);
    let mut world = ContactWorld::new(vec![robot.tree.clone()]);
    let first = 6;
    let legs: [f64; 3] = [0.0, 0.8, -1.6];
    let n = robot.tree.velocities();
    let (feet, limit): (&[[f64; 4]], f64) = match name {
        "go1" => (&[[0.0, 0.0, -0.213, 0.02]], 35.0),
        "solo12" => (&[[0.0, 0.0, -0.16, 0.017]], 3.0),
        "g1" => (
            &[
                [-0.05, 0.025, -0.03, 0.005],
                [-0.05, -0.025, -0.03, 0.005],
                [0.12, 0.03, -0.03, 0.005],
                [0.12, -0.03, -0.03, 0.005],
            ],
            150.0,
        ),
        _ => (
            &[
                [-0.1, 0.06, -0.107, 0.0],
                [-0.1, -0.06, -0.107, 0.0],
                [0.1, 0.06, -0.107, 0.0],
                [0.1, -0.06, -0.107, 0.0],
            ],
            400.0,
        ),
    };
    let state = &mut world.states[0];
    for d in first..n {
        state.q[d + 1] = if feet.len() == 1 { legs[(d - first) % 3] } else { 0.0 };
    }
    for side in [first, first + 6] {
        let set: &[(usize, f64)] = match name {
            "g1" => &[(0, -0.3), (3, 0.6), (4, -0.3)],
            "talos" => &[(2, -0.4), (3, 0.8), (4, -0.4)],
            _ => &[],
        };
        set.iter().for_each(|(joint, angle)| state.q[side + joint + 1] = *angle);
    }
    for d in first..n {
        world.drives[0].drive[d] = DofDrive::Velocity { target: 0.0, bound: ForceBound::force(limit) };
    }
    let mut kinematics = Kinematics::new(&robot.tree);
    kinematics.update(&robot.tree, state).unwrap();
    let parents: Vec<usize> = robot.links.iter().filter_map(|l| l.parent).collect();
    let mut leaves: Vec<usize> = (0..robot.links.len()).filter(|i| !parents.contains(i)).collect();
    let low = |i: &usize| kinematics.pose(*i).unwrap().translation.z;
    leaves.sort_by(|a, b| low(a).total_cmp(&low(b)));
    leaves.truncate(if feet.len() == 1 { 4 } else { 2 });
    let mut lowest = f64::INFINITY;
    for leaf in leaves {
        for [x, y, z, radius] in feet {
            let own = Vector3::new(*x, *y, *z);
            lowest = lowest.min((kinematics.pose(leaf).unwrap() * Point3::from(own)).z - radius);
            world.touch(on_plane(0, leaf, own, Vector3::new(0.0, 0.0, *radius), Vector3::z()));
        }
    }
    world.states[0].q[2] += height - lowest;
    world
}

#[test]
fn standing_robots_do_not_drift() {
    for name in ["go1", "solo12", "g1", "talos"] {
        let mut world = standing(name, 0.0);
        world.steps(4.0);
        let before = world.states[0].clone();
        world.steps(5.0);
        let after = &world.states[0];
        let drift = before.q.iter().zip(&after.q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let weight = 9.81 * load(name).links.iter().map(|l| l.mass).sum::<f64>();
        println!("{name}: drift {drift:.1e}, force {} of {weight}, rounds {}", world.force().z, world.rounds);
        assert!(drift < 1e-9, "{name}: {drift}");
        assert!((world.force().z / weight - 1.0).abs() < 1e-8, "{name}: {}", world.force().z);
    }
}

#[test]
fn dropped_robots_land_on_their_feet() {
    for name in ["go1", "solo12", "talos"] {
        let mut world = standing(name, 0.1);
        world.steps(4.0);
        let height = standing(name, 0.0).states[0].q[2];
        let fastest = world.states[0].v.iter().fold(0.0f64, |a, b| a.max(b.abs()));
        println!("{name}: {fastest:.1e} {}", world.states[0].q[2] - height);
        assert!(fastest < 1e-3 && (world.states[0].q[2] - height).abs() < 0.03, "{name}: {fastest}");
    }
}

/// Two fingers on slides must hold a cube of 0.1 kg (with 20 N) or 1 kg (with 200 N) while the hand is shaken.
#[test]
fn gripped_cube_does_not_slip_when_shaken() {
    for (mass, force, finger) in [(0.1, 20.0, 0.015), (1.0, 200.0, 0.1)] {
        let plain = |parent, joint, mass: f64| {
            Link::new(parent, Isometry3::identity(), joint, mass, Vector3::zeros(), Matrix3::identity() * (1e-3 * mass))
        };
        let hand = Tree::new(vec![
            plain(None, Joint::Prismatic(Vector3::z()), 1.0),
            plain(Some(0), Joint::Prismatic(Vector3::x()), finger),
            plain(Some(0), Joint::Prismatic(-Vector3::x()), finger),
        ])
        .unwrap();
        let mut world = ContactWorld::new(vec![hand, cube(mass, 0.04)]);
        let bound = ForceBound::NONE;
        world.drives[0].drive[1] = DofDrive::Force { force, bound };
        world.drives[0].drive[2] = DofDrive::Force { force, bound };
        for (link, side) in [(1, -1.0), (2, 1.0)] {
            world.states[0].q[link] = -0.03;
            for (y, z) in [(0.01, 0.01), (0.01, -0.01), (-0.01, 0.01), (-0.01, -0.01)] {
                let (mut contact, mut points) =
                    on_plane(1, 0, Vector3::new(side * 0.02, y, z), Vector3::zeros(), Vector3::x() * -side);
                contact.sides[0] = Some(ContactSide { member: 0, link });
                points[0] = Vector3::new(-side * -0.01, y, z);
                world.touch((contact, points));
            }
        }
        let mut slip = 0.0f64;
        let mut start = None;
        for k in 0..8000 {
            let t = k as f64 * H;
            let speed = if t < 1.0 {
                0.0
            } else {
                0.05 * 4.0 * std::f64::consts::PI * libm::sin(4.0 * std::f64::consts::PI * t)
            };
            world.drives[0].drive[0] = DofDrive::Velocity { target: speed, bound: ForceBound::NONE };
            world.step();
            let apart = world.states[1].q[2] - world.states[0].q[0];
            if t > 0.5 {
                slip = slip.max((apart - *start.get_or_insert(apart)).abs());
            }
        }
        println!("{mass} kg: slip {slip:.1e} m, rounds {}", world.rounds);
        assert!(slip < 2e-5, "{slip}");
    }
}

#[test]
fn drive_presses_a_table_with_its_bound_and_no_more() {
    let lift = Link::new(
        None,
        Isometry3::identity(),
        Joint::Prismatic(Vector3::z()),
        1.0,
        Vector3::zeros(),
        Matrix3::identity() * 1e-3,
    );
    let mut world = ContactWorld::new(vec![Tree::new(vec![lift]).unwrap()]);
    world.states[0].q[0] = 0.01;
    world.drives[0].drive[0] = DofDrive::Velocity { target: -0.1, bound: ForceBound::force(50.0) };
    world.touch(on_plane(0, 0, Vector3::zeros(), Vector3::zeros(), Vector3::z()));
    world.steps(1.0);
    assert!((world.force().z - (50.0 + 9.81)).abs() < 1e-6, "{}", world.force().z);
    assert!(world.states[0].q[0].abs() < 1e-6);
    world.drives[0].drive[0] = DofDrive::Velocity { target: 0.1, bound: ForceBound::force(50.0) };
    world.steps(1.0);
    assert!((world.states[0].q[0] - 0.1).abs() < 1e-3 && world.force().z == 0.0);
}

/// A driven wheel rolls without slipping: the contact point does not rotate with the wheel.
#[test]
fn wheel_rolls() {
    let plain = |parent, joint, mass: f64| {
        Link::new(parent, Isometry3::identity(), joint, mass, Vector3::zeros(), Matrix3::identity() * (0.004 * mass))
    };
    let links = vec![
        plain(None, Joint::Prismatic(Vector3::x()), 5.0),
        plain(Some(0), Joint::Prismatic(Vector3::z()), 5.0),
        plain(Some(1), Joint::Revolute(Vector3::y()), 1.0),
    ];
    let mut world = ContactWorld::new(vec![Tree::new(links).unwrap()]);
    world.states[0].q[1] = 0.1;
    world.drives[0].drive[2] = DofDrive::Velocity { target: 10.0, bound: ForceBound::force(20.0) };
    world.touch(on_plane(0, 2, Vector3::new(0.0, 0.0, -0.1), Vector3::zeros(), Vector3::z()));
    world.contacts[0].friction = 0.5;
    for _ in 0..1600 {
        // The contact is at the lowest point of the wheel, whatever its angle.
        let (sine, cosine) = libm::sincos(world.states[0].q[2]);
        world.points[0][1] = Vector3::new(0.1 * sine, 0.0, -0.1 * cosine);
        world.step();
    }
    assert!((world.states[0].v[0] - 1.0).abs() < 1e-9, "{}", world.states[0].v[0]);
    assert!((world.states[0].q[1] - 0.1).abs() < 1e-6);
}

/// A sliding door that dry friction holds, and one that rests on its stop, open when a body that is not a link pushes
/// them.
#[test]
fn moving_body_pushes_joints_at_friction_and_limits() {
    for (friction, limits) in [(2.0, None), (0.0, Some([0.0, 2.0]))] {
        let door = Link {
            friction,
            limits,
            ..Link::new(
                None,
                Isometry3::identity(),
                Joint::Prismatic(Vector3::x()),
                3.0,
                Vector3::zeros(),
                Matrix3::identity() * 0.1,
            )
        };
        let mut world = ContactWorld::new(vec![Tree::new(vec![door]).unwrap()]);
        world.touch(on_plane(0, 0, Vector3::zeros(), Vector3::zeros(), Vector3::x()));
        world.contacts[0].drift = Vector3::new(-0.2, 0.0, 0.0);
        for k in 0..800 {
            world.points[0][0].x = 0.2 * H * f64::from(k);
            world.step();
        }
        assert!((world.states[0].v[0] - 0.2).abs() < 1e-6, "{}", world.states[0].v[0]);
        assert!((world.force().x - friction).abs() < 1e-6, "{}", world.force().x);
    }
}
