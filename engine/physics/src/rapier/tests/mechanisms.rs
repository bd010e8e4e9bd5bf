//! Tests of mechanisms that are solved as trees.

use nalgebra::Vector3;

use super::*;
use crate::{BodyId, JointDesc, JointDrive, JointForm, JointId, JointKind, PassiveForces, Twist};

/// A block that a drive moves along x at a constant speed, and a free cube in front of it.
struct Pusher {
    engine: Rapier,
    joint: JointId,
    block: BodyId,
    cube: BodyId,
}

fn slide(a: BodyId, b: BodyId) -> JointDesc {
    let along_x = turned(Vector3::zeros(), Vector3::y(), std::f64::consts::FRAC_PI_2);
    JointDesc {
        a,
        b,
        frame_in_a: along_x,
        frame_in_b: along_x,
        kind: JointKind::Prismatic,
        limits: None,
        position: 0.0,
        form: JointForm::Tree,
        passive: PassiveForces::default(),
        geared: false,
    }
}

fn cube_at(engine: &mut Rapier, x: f64, z: f64, tree: u32) -> BodyId {
    let desc = body(at(x, 0.0, z), mass(1.0, [1.0 / 150.0; 3]), part(Form::Box { half: Vector3::repeat(0.1) }));
    engine.add_body(&BodyDesc { collision_mask: CollisionMask { mask: 0xffff, tree }, ..desc })
}

fn pusher() -> Pusher {
    let mut engine = engine(0.005);
    floor(&mut engine);
    let post = engine.add_body(&fixed(at(0.0, 0.0, 0.1), vec![]));
    // The block has no friction, and thus does not carry a part of the weight of the cube that it pushes.
    let desc = body(at(0.0, 0.0, 0.1), mass(1.0, [1.0 / 150.0; 3]), part(Form::Box { half: Vector3::repeat(0.1) }));
    let block = engine.add_body(&BodyDesc { friction: 0.0, ..desc });
    let cube = cube_at(&mut engine, 0.3, 0.1, 2);
    let joint = engine.add_joint(&slide(post, block)).unwrap();
    engine.drive(joint, JointDrive::Velocity { target: 0.2, max_force: 100.0, slip: 0.0 });
    Pusher { engine, joint, block, cube }
}

fn is_in_tree(engine: &Rapier, body: BodyId) -> bool {
    engine.state.bodies.record(body).is_some_and(|r| r.in_tree)
}

fn is_solved_as_tree(engine: &Rapier, joint: JointId) -> bool {
    engine.state.joints.get(joint).unwrap().is_in_tree()
}

#[test]
fn touched_body_is_adopted_and_later_released() {
    let Pusher { mut engine, joint, block, cube } = pusher();
    assert!(is_in_tree(&engine, block) && !is_in_tree(&engine, cube));
    engine.advance(200);
    assert!(is_in_tree(&engine, cube));
    let x = engine.pose(cube).translation.x;
    // The cube lags slightly, because the drive's 100 N need some time to accelerate it.
    assert!((x - 0.4).abs() < 5e-4, "{x}");
    assert!((engine.joint_state(joint).effort - G).abs() < 1e-3, "{}", engine.joint_state(joint).effort);
    engine.drive(joint, JointDrive::Velocity { target: -0.2, max_force: 100.0, slip: 0.0 });
    engine.advance(200);
    assert!(!is_in_tree(&engine, cube) && is_in_tree(&engine, block));
    // A cube on top of the pushed cube is also adopted.
    let x = engine.pose(cube).translation.x;
    let top = cube_at(&mut engine, x, 0.3, 3);
    engine.drive(joint, JointDrive::Velocity { target: 0.2, max_force: 100.0, slip: 0.0 });
    engine.advance(300);
    assert!(is_in_tree(&engine, cube) && is_in_tree(&engine, top));
    let apart = engine.pose(top).translation.x - engine.pose(cube).translation.x;
    assert!(apart.abs() < 1e-4, "{apart}");
}

#[test]
fn contacts_of_mechanisms_are_reported_like_others() {
    let Pusher { mut engine, block, cube, .. } = pusher();
    engine.advance(200);
    let mut contacts = Vec::new();
    engine.contacts(&mut contacts);
    let of = |a: BodyId, b: BodyId| contacts.iter().filter(move |c| c.bodies == (a, b));
    let pushed: f64 = of(block, cube).map(|c| c.force).sum();
    assert!((pushed - G).abs() < 0.01, "{pushed}");
    assert!(of(block, cube).all(|c| (c.normal - Vector3::x()).norm() < 1e-6));
    let floor = BodyId(0);
    let borne: f64 = of(floor, cube).map(|c| c.force).sum();
    let rubbed: f64 = of(floor, cube).map(|c| c.friction.x).sum();
    assert!((borne - G).abs() < 0.01 && (rubbed + G).abs() < 0.01, "{borne} {rubbed}");
}

#[test]
fn adopted_bodies_continue_from_a_snapshot() {
    let Pusher { engine: mut one, .. } = pusher();
    for steps in [90, 60, 100] {
        one.advance(steps);
        let bytes = one.snapshot();
        let mut two = engine(0.02);
        two.restore(&bytes).unwrap();
        assert!(two.snapshot() == bytes);
        for step in 0..50 {
            one.advance(1);
            two.advance(1);
            assert!(one.snapshot() == two.snapshot(), "differs after step {step}");
        }
    }
}

#[test]
fn adopted_bodies_can_be_removed_or_jointed() {
    let Pusher { mut engine, cube, .. } = pusher();
    engine.advance(200);
    let rider = cube_at(&mut engine, 0.4, 0.4, 3);
    let joint = engine.add_joint(&JointDesc { a: cube, b: rider, ..slide(cube, rider) }).unwrap();
    engine.advance(50);
    assert!(is_in_tree(&engine, cube) && is_in_tree(&engine, rider));
    assert!((engine.pose(rider).translation.z - engine.pose(cube).translation.z).abs() < 1e-9);
    engine.remove_joint(joint);
    engine.advance(50);
    assert!(engine.pose(rider).translation.z < 0.36);
    engine.remove_body(cube);
    engine.advance(50);
    assert!(engine.quarantined().is_empty());
}

#[test]
fn setting_a_link_pose_or_velocity_moves_its_joint() {
    let Pusher { mut engine, joint, block, .. } = pusher();
    engine.drive(joint, JointDrive::Free);
    engine.advance(1);
    engine.set_pose(block, &at(-0.5, 0.2, 0.1));
    engine.set_twist(block, &Twist { linear: Vector3::new(-1.0, 5.0, 0.0), angular: Vector3::zeros() });
    engine.advance(1);
    let state = engine.joint_state(joint);
    // The joint permits only motion along x.
    assert!((state.velocity + 1.0).abs() < 1e-9 && (state.position + 0.505).abs() < 1e-9, "{state:?}");
    assert!(engine.pose(block).translation.y.abs() < 1e-12);
}

#[test]
fn forces_act_on_links_for_an_advance() {
    let Pusher { mut engine, joint, block, .. } = pusher();
    engine.drive(joint, JointDrive::Free);
    // Without the floor, there is no friction.
    engine.remove_body(BodyId(0));
    engine.push(block, Vector3::new(-2.0, 0.0, 3.0), Vector3::zeros());
    engine.advance(100);
    assert!((engine.joint_state(joint).velocity + 1.0).abs() < 1e-9);
    engine.advance(100);
    assert!((engine.joint_state(joint).velocity + 1.0).abs() < 1e-9);
}

#[test]
fn nan_freezes_only_its_own_mechanism() {
    let Pusher { mut engine, block, cube, .. } = pusher();
    let other = cube_at(&mut engine, 5.0, 0.5, 4);
    engine.advance(10);
    engine.push(block, Vector3::new(f64::NAN, 0.0, 0.0), Vector3::zeros());
    engine.advance(100);
    assert_eq!(engine.quarantined(), [block]);
    assert!((engine.pose(other).translation.z - 0.1).abs() < 1e-3);
    assert!((engine.pose(cube).translation.x - 0.3).abs() < 1e-3);
}

#[test]
fn loops_and_second_parents_are_not_joined_to_a_tree() {
    let Pusher { mut engine, block, cube, .. } = pusher();
    let held = |engine: &mut Rapier, a, b| {
        let id = engine.add_joint(&slide(a, b)).unwrap();
        is_solved_as_tree(engine, id)
    };
    assert!(held(&mut engine, block, cube));
    assert!(!held(&mut engine, cube, block));
    let other = cube_at(&mut engine, 2.0, 0.1, 5);
    assert!(!held(&mut engine, other, cube));
}

/// A mechanism that reaches a heap of boxes is converted to reduced form, and back to a tree once it has withdrawn. Its
/// drive continues to act throughout.
#[test]
fn mechanism_in_a_crowd_is_solved_by_rapier_until_it_withdraws() {
    let Pusher { engine: mut one, joint, block, cube } = pusher();
    for i in 0..30u32 {
        cube_at(&mut one, 0.3 + 0.2 * f64::from(i % 10), 0.3 + 0.2 * f64::from(i / 10), 10 + i);
    }
    let far = cube_at(&mut one, 0.5, 0.1, 50);
    for i in 1..9u32 {
        cube_at(&mut one, 0.5 + 0.2 * f64::from(i), 0.1, 50 + i);
    }
    let tied = |engine: &Rapier| is_solved_as_tree(engine, joint);
    one.drive(joint, JointDrive::Velocity { target: 0.2, max_force: 1000.0, slip: 0.0 });
    assert!(tied(&one));
    one.advance(200);
    assert!(!tied(&one) && !is_in_tree(&one, block) && !is_in_tree(&one, cube) && !is_in_tree(&one, far));
    let state = one.joint_state(joint);
    assert!((state.velocity - 0.2).abs() < 1e-3 && (state.position - 0.2).abs() < 5e-3, "{state:?}");
    let bytes = one.snapshot();
    let mut two = engine(0.02);
    two.restore(&bytes).unwrap();
    for engine in [&mut one, &mut two] {
        engine.drive(joint, JointDrive::Velocity { target: -0.4, max_force: 1000.0, slip: 0.0 });
        engine.advance(400);
    }
    assert!(one.snapshot() == two.snapshot());
    assert!(tied(&one) && is_in_tree(&one, block) && !is_in_tree(&one, cube));
    let state = one.joint_state(joint);
    assert!((state.velocity + 0.4).abs() < 1e-6 && (state.position + 0.6).abs() < 0.02, "{state:?}");
}

/// Free bodies are adopted before a link or an adopted body hits them at speed, which conserves momentum.
#[test]
fn fast_hits_conserve_momentum() {
    for speed in [0.1, 1.0, 7.0] {
        let mut engine = engine(0.005);
        engine.configure(EngineSettings { gravity: Vector3::zeros(), step: 0.005, ..EngineSettings::default() });
        let post = engine.add_body(&fixed(at(0.0, 0.0, 0.5), vec![]));
        let desc = body(at(0.0, 0.0, 0.5), mass(1.0, [1.0 / 150.0; 3]), part(Form::Box { half: Vector3::repeat(0.1) }));
        let linear_velocity = Vector3::new(speed, 0.0, 0.0);
        let block = engine.add_body(&BodyDesc { linear_velocity, ..desc });
        engine.add_joint(&slide(post, block)).unwrap();
        let cubes = [0.313, 0.513, 0.725].map(|x| cube_at(&mut engine, x, 0.5, (1e3 * x) as u32));
        engine.advance((0.3 / speed / 0.005) as u32);
        let velocities = [block, cubes[0], cubes[1], cubes[2]].map(|body| engine.twist(body).linear.x);
        assert!(velocities.iter().all(|v| (v - 0.25 * speed).abs() < 0.02 * speed), "{velocities:?}");
        assert!((velocities.iter().sum::<f64>() - speed).abs() < 1e-6 * speed, "{velocities:?}");
    }
}

/// A tree that touches a mechanism in reduced form, directly or through a free cube, is left to rapier, which conserves
/// momentum. It becomes a tree again after the two have been apart for a while.
#[test]
fn mechanism_touching_a_reduced_one_is_solved_by_rapier() {
    for between in [false, true] {
        let mut engine = engine(0.005);
        let post = engine.add_body(&fixed(at(0.0, 0.0, 0.5), vec![]));
        let mut block = |x: f64, tree: u32, form: JointForm, v: f64| {
            let desc =
                body(at(x, 0.0, 0.5), mass(1.0, [1.0 / 150.0; 3]), part(Form::Box { half: Vector3::repeat(0.1) }));
            let linear_velocity = Vector3::new(v, 0.0, 0.0);
            let respond = CollisionMask { mask: 0xffff, tree };
            let block = engine.add_body(&BodyDesc { friction: 0.0, linear_velocity, collision_mask: respond, ..desc });
            let frame_in_a = turned(Vector3::new(x, 0.0, 0.0), Vector3::y(), std::f64::consts::FRAC_PI_2);
            (block, engine.add_joint(&JointDesc { form, frame_in_a, ..slide(post, block) }).unwrap())
        };
        let (moving, first) = block(0.0, 2, JointForm::Tree, 1.0);
        let (resting, second) = block(0.6, 3, JointForm::Reduced, 0.0);
        if between {
            cube_at(&mut engine, 0.3, 0.5, 4);
            engine.configure(EngineSettings { gravity: Vector3::zeros(), step: 0.005, ..EngineSettings::default() });
        }
        let tied = |engine: &Rapier| is_solved_as_tree(engine, first);
        let speed = |engine: &Rapier, body: BodyId| engine.twist(body).linear.x;
        engine.advance(if between { 80 } else { 120 });
        assert!(!tied(&engine) && !is_in_tree(&engine, moving), "{between}");
        let share = if between { 1.0 / 3.0 } else { 0.5 };
        let (v1, v2) = (speed(&engine, moving), speed(&engine, resting));
        assert!((v1 - share).abs() < 0.01 && (v2 - share).abs() < 0.01, "{v1} {v2}");
        engine.drive(second, JointDrive::Velocity { target: 1.0, max_force: 100.0, slip: 0.0 });
        engine.advance(500);
        assert!(tied(&engine) && is_in_tree(&engine, moving), "{between}");
        assert!((speed(&engine, moving) - v1).abs() < 1e-9);
    }
}

/// Poses that are set right after a restore, or together with that of the base, take effect.
#[test]
fn poses_set_after_a_restore_move_the_joints() {
    let Pusher { engine: mut one, joint, block, .. } = pusher();
    one.advance(10);
    let mut two = engine(0.02);
    two.restore(&one.snapshot()).unwrap();
    for engine in [&mut one, &mut two] {
        engine.set_pose(block, &at(-0.7, 0.0, 0.1));
        engine.advance(1);
        assert!((engine.joint_state(joint).position + 0.699).abs() < 1e-6, "{:?}", engine.joint_state(joint));
    }
    assert!(one.snapshot() == two.snapshot());
    // The base and the block are moved by different displacements.
    let base = BodyId(1);
    one.set_pose(base, &at(0.0, 1.0, 0.1));
    one.set_pose(block, &at(-0.9, 1.0, 0.1));
    one.advance(1);
    assert!((one.joint_state(joint).position + 0.899).abs() < 1e-6, "{:?}", one.joint_state(joint));
    assert!((one.pose(block).translation.y - 1.0).abs() < 1e-9);
}

/// A force that acts for an advance continues to act when its body is adopted during the advance.
#[test]
fn force_of_an_advance_continues_after_adoption() {
    let Pusher { mut engine, cube, joint, .. } = pusher();
    engine.drive(joint, JointDrive::Velocity { target: 0.0, max_force: 100.0, slip: 0.0 });
    // The cube is pushed against the block, which stands still.
    engine.push(cube, Vector3::new(-30.0, 0.0, 0.0), Vector3::zeros());
    engine.advance(400);
    assert!(is_in_tree(&engine, cube));
    // The friction of the floor carries up to G newtons of the push.
    let effort = engine.joint_state(joint).effort;
    assert!(effort > 30.0 - G - 0.1 && effort < 30.1, "{effort}");
}

/// Bodies without inertia cannot be trees; rapier continues to solve them, and nothing is quarantined.
#[test]
fn body_without_inertia_is_not_adopted() {
    let Pusher { mut engine, .. } = pusher();
    let desc = body(at(0.21, 0.0, 0.35), mass(0.5, [0.0; 3]), sphere(0.05));
    let ball = engine.add_body(&BodyDesc { collision_mask: CollisionMask { mask: 0xffff, tree: 9 }, ..desc });
    engine.advance(300);
    assert!(!is_in_tree(&engine, ball) && engine.quarantined().is_empty());
}
