//! Trees at rest: what they are like, and that everything that can move them does.

use super::*;
use crate::{JointDrive, JointId, PassiveForces, Twist};

/// An arm of one link on a static body, which a drive holds level, and a tower on the floor.
fn still() -> (Rapier, JointId, BodyId, BodyId) {
    let mut engine = engine(0.005);
    floor(&mut engine);
    let base = engine.add_body(&fixed(at(3.0, 0.0, 1.0), vec![]));
    let link = engine.add_body(&body(at(3.4, 0.0, 1.0), mass(1.0, [0.01; 3]), sphere(0.1)));
    let hinge = turned(Vector3::zeros(), Vector3::x(), std::f64::consts::FRAC_PI_2);
    let in_link = turned(Vector3::new(-0.4, 0.0, 0.0), Vector3::x(), std::f64::consts::FRAC_PI_2);
    let joint = engine.add_joint(&tree_joint(base, link, JointKind::Revolute, hinge, in_link)).unwrap();
    engine.drive(joint, JointDrive::Position { target: 0.0, max_force: 50.0, max_velocity: 1.0, tracking: None });
    let low = tower(&mut engine, Isometry3::identity(), 5);
    engine.advance(1000);
    (engine, joint, link, low)
}

fn moving(linear: Vector3<f64>) -> Twist {
    Twist { linear, angular: Vector3::zeros() }
}

/// Returns whether each mechanism did nothing in the last step.
fn resting(engine: &Rapier) -> Vec<bool> {
    engine.state.forms.trees.mechanisms.iter().map(|m| m.built.as_ref().unwrap().at_rest).collect()
}

#[test]
fn still_trees_rest_and_still_report_efforts_and_contacts() {
    let (engine, joint, _, low) = still();
    assert_eq!(resting(&engine), [true, true]);
    let effort = engine.joint_state(joint).effort;
    assert!((effort.abs() - G * 0.4).abs() < 1e-6, "{effort}");
    let mut contacts = Vec::new();
    engine.contacts(&mut contacts);
    let force: f64 = contacts.iter().filter(|c| c.bodies.0 == low || c.bodies.1 == low).map(|c| c.force).sum();
    assert!((force - 3.0 * G).abs() < 1e-6, "{force}");
}

#[test]
fn everything_that_acts_on_a_resting_tree_moves_it() {
    let moves = |name: &str, act: &dyn Fn(&mut Rapier, JointId, BodyId, BodyId)| {
        let (mut engine, joint, link, low) = still();
        let poses = |engine: &Rapier| [link, low].map(|body| engine.pose(body));
        let before = poses(&engine);
        act(&mut engine, joint, link, low);
        engine.advance(40);
        let after = poses(&engine);
        let moved = before.iter().zip(&after).any(|(a, b)| (a.translation.vector - b.translation.vector).norm() > 1e-4);
        assert!(moved, "{name}");
    };
    moves("target", &|engine, joint, _, _| {
        engine.drive(joint, JointDrive::Position { target: 0.3, max_force: 50.0, max_velocity: 1.0, tracking: None });
    });
    moves("released drive", &|engine, joint, _, _| engine.drive(joint, JointDrive::Free));
    moves("weaker drive", &|engine, joint, _, _| {
        engine.drive(joint, JointDrive::Position { target: 0.0, max_force: 2.0, max_velocity: 1.0, tracking: None });
    });
    moves("push", &|engine, _, _, low| {
        for _ in 0..40 {
            engine.push(low, Vector3::x() * 60.0, Vector3::zeros());
            engine.advance(1);
        }
    });
    moves("velocity", &|engine, _, _, low| {
        engine.set_twist(low, &moving(Vector3::x()));
    });
    moves("pose", &|engine, _, _, low| engine.set_pose(low, &at(0.3, 0.0, 0.1)));
    moves("hit", &|engine, _, _, _| {
        let ball = body(at(-0.6, 0.0, 0.3), mass(3.0, [0.012; 3]), sphere(0.1));
        let ball = engine.add_body(&ball);
        engine.set_twist(ball, &moving(Vector3::new(5.0, 0.0, 0.5)));
        engine.advance(60);
    });
    moves("gravity", &|engine, _, _, _| {
        let tilted = Vector3::new(9.0, 0.0, -4.0);
        engine.configure(EngineSettings { gravity: tilted, step: 0.005, ..EngineSettings::default() });
    });
    moves("removed floor", &|engine, _, _, _| engine.remove_body(BodyId(0)));
}

#[test]
fn restored_snapshot_of_resting_trees_continues_bit_for_bit() {
    let (mut one, joint, _, _) = still();
    let bytes = one.snapshot();
    let mut two = engine(0.005);
    two.restore(&bytes).unwrap();
    for step in 0..60 {
        if step == 20 {
            let drive = JointDrive::Velocity { target: 0.2, max_force: 50.0, slip: 0.0 };
            for engine in [&mut one, &mut two] {
                engine.drive(joint, drive);
            }
        }
        one.advance(1);
        two.advance(1);
        assert!(one.snapshot() == two.snapshot(), "differs after step {step}");
    }
}

#[test]
fn overlaps_of_slow_trees_are_corrected_before_they_rest() {
    let mut engine = engine(0.005);
    floor(&mut engine);
    let low = tower(&mut engine, at(0.0, 0.0, -0.005), 5);
    engine.advance(1000);
    assert!(engine.pose(low).translation.z > 0.1 - 1e-6, "{}", engine.pose(low).translation.z);
}

#[test]
fn slow_tree_in_space_and_spring_moves_on() {
    let mut engine =
        Rapier::new(EngineSettings { gravity: Vector3::zeros(), step: 0.005, ..EngineSettings::default() });
    let low = tower(&mut engine, at(0.0, 0.0, 1.0), 5);
    engine.set_twist(low, &moving(Vector3::x() * 1e-6));
    let base = engine.add_body(&fixed(at(5.0, 0.0, 1.0), vec![]));
    let link = engine.add_body(&body(at(5.0, 0.0, 1.0), mass(1.0, [0.1; 3]), vec![]));
    let passive = PassiveForces { stiffness: 1.0, rest: 1e-7, ..PassiveForces::default() };
    let joint = JointDesc {
        passive,
        ..tree_joint(base, link, JointKind::Revolute, Isometry3::identity(), Isometry3::identity())
    };
    let joint = engine.add_joint(&joint).unwrap();
    let start = engine.pose(low).translation.x;
    engine.advance(200);
    assert!((engine.pose(low).translation.x - start - 1e-6).abs() < 1e-8);
    assert!(engine.joint_state(joint).position > 1e-8);
}

/// Legs whose drives hold against each other through the floor.
#[test]
fn legs_that_hold_against_each_other_rest_with_steady_efforts() {
    let mut engine = engine(0.005);
    floor(&mut engine);
    let trunk = engine.add_body(&body(at(0.0, 0.0, 0.5), mass(5.0, [0.05; 3]), vec![]));
    // Too little for the feet to carry the trunk without the drives.
    let slippery =
        Some(crate::PairRule { responds: true, friction: Some(0.3), restitution: None, ..crate::PairRule::default() });
    let mut joints = Vec::new();
    for (side, y) in [(-1.0, 0.2), (-1.0, -0.2), (1.0, 0.2), (1.0, -0.2)] {
        let foot = engine.add_body(&body(at(0.35 * side, y, 0.05), mass(0.5, [0.001; 3]), sphere(0.05)));
        let hinge = turned(Vector3::new(0.1 * side, y, 0.0), Vector3::x(), std::f64::consts::FRAC_PI_2);
        let in_foot = turned(Vector3::new(-0.25 * side, 0.0, 0.45), Vector3::x(), std::f64::consts::FRAC_PI_2);
        let joint = engine.add_joint(&tree_joint(trunk, foot, JointKind::Revolute, hinge, in_foot)).unwrap();
        let hold = JointDrive::Position { target: 0.0, max_force: 80.0, max_velocity: 1.0, tracking: None };
        engine.drive(joint, hold);
        joints.push(joint);
        engine.set_pair(BodyId(0), foot, slippery);
    }
    let mut last = [f64::NAN; 4];
    for _ in 0..40 {
        engine.advance(100);
        let efforts: Vec<f64> = joints.iter().map(|joint| engine.joint_state(*joint).effort).collect();
        if resting(&engine) == [true] {
            for (before, after) in last.iter().zip(&efforts) {
                assert!(after.abs() > 0.5 && (before - after).abs() < 1e-3 * after.abs(), "{last:?} {efforts:?}");
            }
            return;
        }
        last.copy_from_slice(&efforts);
    }
    panic!("the legs move on: {last:?}");
}
