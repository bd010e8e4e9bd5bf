//! Tests of invalid arguments, which must return an error and leave the state unchanged.

use nalgebra::{Isometry3, Matrix3, Vector3};
use tatu_mechanisms::{
    DofDrive, Dynamics, DynamicsError, ForceBound, Joint, Link, Tree, TreeDrives, TreeError, TreeSolver, TreeState,
};

use super::{
    joints::{pendulum, single},
    random::TestRng,
    robots::{gravity, load},
};

fn refused(change: impl Fn(&mut Link)) -> TreeError {
    let mut link = pendulum();
    change(&mut link);
    Tree::new(vec![link]).unwrap_err()
}

#[test]
fn invalid_trees_are_refused() {
    assert_eq!(Tree::new(vec![]).unwrap_err(), TreeError::Empty);
    assert_eq!(refused(|l| l.parent = Some(0)), TreeError::Parent { link: 0, parent: 0 });
    assert!(matches!(refused(|l| l.mass = f64::NAN), TreeError::NotFinite { what: "mass", .. }));
    assert!(matches!(refused(|l| l.inertia[(0, 1)] = f64::INFINITY), TreeError::NotFinite { what: "inertia", .. }));
    assert!(matches!(refused(|l| l.mass = -1.0), TreeError::Negative { what: "mass", .. }));
    assert!(matches!(refused(|l| l.friction = -1.0), TreeError::Negative { what: "friction", .. }));
    assert!(matches!(refused(|l| l.joint = Joint::Revolute(Vector3::new(0.0, 0.0, 2.0))), TreeError::Axis { .. }));
    assert!(matches!(refused(|l| l.inertia[(0, 1)] = 0.1), TreeError::Inertia { .. }));
    let flat = |x, y, z| refused(move |l| l.inertia = Matrix3::from_diagonal(&Vector3::new(x, y, z)));
    assert!(matches!(flat(1.0, 1.0, 2.1), TreeError::Inertia { .. }));
    assert!(matches!(flat(1.0, -1.0, 1.0), TreeError::Inertia { .. }));
    assert!(matches!(refused(|l| l.limits = Some([1.0, 0.0])), TreeError::Limits { .. }));
    assert!(matches!(refused(|l| (l.joint, l.limits) = (Joint::Spherical, Some([0.0, 1.0]))), TreeError::Joint { .. }));
    assert!(matches!(refused(|l| (l.mass, l.inertia) = (0.0, Matrix3::zeros())), TreeError::Massless { link: 0 }));
    // A thin plate, whose largest moment is the sum of the others, is valid.
    let plate = Link { inertia: Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 3.0)), ..pendulum() };
    assert!(Tree::new(vec![plate]).is_ok());
    // A massless rotor with an armature is valid.
    let rotor = Link { mass: 0.0, inertia: Matrix3::zeros(), armature: 0.1, ..pendulum() };
    assert!(Tree::new(vec![rotor]).is_ok());
    let free = Link { parent: Some(0), ..single(Joint::Free) };
    assert!(matches!(Tree::new(vec![pendulum(), free]).unwrap_err(), TreeError::Joint { link: 1, .. }));
}

#[test]
fn refused_steps_leave_the_state_unchanged() {
    let tree = Tree::new(vec![pendulum()]).unwrap();
    let other = load("ur5").tree;
    let mut solver = TreeSolver::new(&tree);
    let mut state = TreeState::new(&tree);
    let good = TreeDrives::new(&tree);
    let before = state.clone();
    let mut refused = |tree: &Tree, drives: &TreeDrives, h: f64| {
        let error = solver.step(&mut state, tree, drives, gravity(), h).unwrap_err();
        assert_eq!(state, before);
        error
    };
    assert!(matches!(refused(&other, &good, 1e-3), DynamicsError::Length { .. }));
    assert!(matches!(refused(&tree, &TreeDrives::new(&other), 1e-3), DynamicsError::Length { .. }));
    for h in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(refused(&tree, &good, h), DynamicsError::Step { .. }));
    }
    let mut drives = good.clone();
    drives.force[0] = f64::NAN;
    assert!(matches!(refused(&tree, &drives, 1e-3), DynamicsError::NotFinite { what: "force" }));
    drives.force[0] = 1e308;
    assert_eq!(refused(&tree, &drives, 1e10), DynamicsError::Diverged);
    let mut drives = good.clone();
    for bound in [
        ForceBound::force(-1.0),
        ForceBound::force(f64::NAN),
        ForceBound::motor(1.0, 0.0),
        ForceBound::motor(f64::INFINITY, 1.0),
    ] {
        drives.drive[0] = DofDrive::Velocity { target: 0.0, bound };
        assert!(matches!(refused(&tree, &drives, 1e-3), DynamicsError::Drive { dof: 0, .. }), "{bound:?}");
    }
}

#[test]
fn point_on_its_axis_is_singular() {
    let point = Link::new(
        None,
        Isometry3::identity(),
        Joint::Revolute(Vector3::z()),
        1.0,
        Vector3::new(0.0, 0.0, 0.3),
        Matrix3::zeros(),
    );
    let tree = Tree::new(vec![point]).unwrap();
    let mut dynamics = Dynamics::new(&tree);
    let mut out = [0.0];
    let error = dynamics.forward(&tree, &[0.0], gravity(), &mut out).unwrap_err();
    assert_eq!(error, DynamicsError::Singular { dof: 0 });
    let mut state = TreeState::new(&tree);
    let error = TreeSolver::new(&tree).step(&mut state, &tree, &TreeDrives::new(&tree), gravity(), 1e-3).unwrap_err();
    assert_eq!(error, DynamicsError::Singular { dof: 0 });
}

#[test]
fn unknown_links_are_refused() {
    let tree = Tree::new(vec![pendulum()]).unwrap();
    let kinematics = tatu_mechanisms::Kinematics::new(&tree);
    assert!(kinematics.pose(1).is_none() && tree.offsets(1).is_none());
    let error = kinematics.jacobian(&tree, 1, Vector3::zeros(), &mut [0.0; 6]).unwrap_err();
    assert_eq!(error, DynamicsError::NoLink { link: 1, links: 1 });
}

#[test]
fn extreme_numbers_are_refused_or_result_in_finite_states() {
    let mut random = TestRng::new(11);
    let mut taken = 0;
    for k in 0..30_000 {
        // In a quarter of the rounds, about half of the values are arbitrary; in the others, about one in twelve.
        let share = if k % 4 == 0 { 2 } else { 12 };
        let mut number = |ordinary: f64| if random.below(share) == 0 { random.any() } else { ordinary };
        let mut links =
            vec![pendulum(), Link { parent: Some(0), ..pendulum() }, Link { parent: Some(1), ..pendulum() }];
        for link in &mut links {
            link.mass = number(2.0);
            link.center.x = number(0.1);
            link.armature = number(0.01);
            link.friction = number(1.0);
            link.damping = number(0.1);
            link.limits = Some([number(-1.0), number(1.0)]);
            link.frame.translation.x = number(0.2);
        }
        let Ok(tree) = Tree::new(links) else { continue };
        let mut state = TreeState {
            q: vec![number(0.1), number(0.2), number(-0.3)],
            v: vec![number(1.0), number(0.0), number(2.0)],
        };
        let mut drives = TreeDrives::new(&tree);
        for d in 0..3 {
            let bound = match k % 3 {
                0 => ForceBound::force(number(5.0)),
                1 => ForceBound::motor(number(5.0), number(3.0)),
                _ => ForceBound { force: number(5.0), full_speed: number(1.0), no_load_speed: number(2.0) },
            };
            drives.drive[d] = match (k + d) % 4 {
                0 => DofDrive::Velocity { target: number(1.0), bound },
                1 => DofDrive::Force { force: number(1.0), bound },
                2 => {
                    let (stiffness, damping) = (number(100.0), number(10.0));
                    DofDrive::Position { target: number(0.5), velocity: number(0.0), stiffness, damping, bound }
                }
                _ => DofDrive::Off,
            };
            drives.force[d] = number(0.0);
            drives.spring[d] =
                tatu_mechanisms::JointSpring { rest: number(0.0), stiffness: number(1.0), damping: number(0.0) };
        }
        let (gravity, h) = (Vector3::new(number(0.0), 0.0, number(-9.81)), number(1e-3));
        let before = state.clone();
        let mut solver = TreeSolver::new(&tree);
        match solver.step(&mut state, &tree, &drives, gravity, h) {
            Ok(_) => {
                taken += 1;
                assert!(state.q.iter().chain(&state.v).all(|x| x.is_finite()));
            }
            Err(_) => {
                let bits = |s: &TreeState| s.q.iter().chain(&s.v).map(|x| x.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(&state), bits(&before));
            }
        }
        let mut dynamics = Dynamics::new(&tree);
        if dynamics.update(&tree, &state).is_ok() {
            let mut out = [0.0; 3];
            let _ = dynamics.forward(&tree, &[0.0; 3], gravity, &mut out);
            let _ = dynamics.energy(&tree, gravity);
        }
    }
    println!("{taken} steps of 30000 were taken");
    assert!(taken > 1000);
}
