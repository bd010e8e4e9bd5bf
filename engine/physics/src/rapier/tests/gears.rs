//! Gears of trees: on one static body, with gaps, changed during a run, and compared with those in reduced form.

use super::*;
use crate::{Gear, JointDrive, JointId};

/// Two bars on hinges of one static body, 1 m apart, of which the second follows the first.
struct Pair {
    engine: Rapier,
    joints: [JointId; 2],
}

fn pair(form: JointForm, start: f64) -> Pair {
    let mut engine = engine(0.005);
    let base = engine.add_body(&fixed(at(0.0, 0.0, 1.0), vec![]));
    let joints = [(0.0, 0.0), (1.0, start)].map(|(x, angle)| {
        let hinge = turned(Vector3::new(x, 0.0, 0.0), Vector3::x(), -std::f64::consts::FRAC_PI_2);
        let bar = at(x, 0.0, 1.0) * turned(Vector3::zeros(), Vector3::y(), angle) * at(0.0, 0.0, -0.2);
        let bar = engine.add_body(&body(bar, mass(1.0, [0.02; 3]), vec![]));
        let in_bar = turned(Vector3::new(0.0, 0.0, 0.2), Vector3::x(), -std::f64::consts::FRAC_PI_2);
        let desc = JointDesc { form, geared: true, ..tree_joint(base, bar, JointKind::Revolute, hinge, in_bar) };
        engine.add_joint(&desc).unwrap()
    });
    Pair { engine, joints }
}

impl Pair {
    fn gear(&mut self, ratio: f64, offset: f64) {
        self.engine.set_gears(&[Gear { joint: self.joints[1], leader: self.joints[0], ratio, offset }]);
    }
    fn positions(&self) -> [f64; 2] {
        self.joints.map(|joint| self.engine.joint_state(joint).position)
    }
}

#[test]
fn geared_joints_of_a_static_body_move_together() {
    let mut pair = pair(JointForm::Tree, 0.0);
    pair.gear(-2.0, 0.0);
    pair.engine.drive(pair.joints[0], JointDrive::Velocity { target: 0.5, max_force: 20.0, slip: 0.0 });
    for _ in 0..200 {
        pair.engine.advance(1);
        let [first, second] = pair.positions();
        assert!((second + 2.0 * first).abs() < 1e-12, "{first} {second}");
    }
    // Until it has this speed, it lags behind.
    assert!((pair.positions()[0] - 0.5).abs() < 5e-3, "{:?}", pair.positions());
    // The motor carries the weight of both bars: m g l (sin q1 - 2 sin q2 ...), at a constant speed.
    let [first, second] = pair.positions();
    let expected = G * 0.2 * (first.sin() - 2.0 * second.sin());
    let effort = pair.engine.joint_state(pair.joints[0]).effort;
    assert!((effort - expected).abs() < 0.02 * expected.abs(), "{effort} {expected}");
}

#[test]
fn trees_and_reduced_form_agree_about_gears() {
    let [tree, reduced] = [JointForm::Tree, JointForm::Reduced].map(|form| {
        let mut pair = pair(form, 0.3);
        pair.gear(1.5, 0.3);
        pair.engine.drive(pair.joints[1], JointDrive::Force(1.0));
        pair.engine.advance(100);
        pair.positions()
    });
    assert!((tree[1] - 1.5 * tree[0] - 0.3).abs() < 1e-12);
    assert!(tree[0].abs() > 0.05 && (tree[0] - reduced[0]).abs() < 0.01, "{tree:?} {reduced:?}");
}

#[test]
fn gap_of_a_gear_closes_within_the_speed_of_a_return_to_limits() {
    let mut pair = pair(JointForm::Tree, 0.4);
    pair.gear(1.0, 0.0);
    let hold = JointDrive::Velocity { target: 0.0, max_force: 100.0, slip: 0.0 };
    pair.engine.drive(pair.joints[0], hold);
    let mut last = 0.4;
    for step in 0..700 {
        pair.engine.advance(1);
        let [first, second] = pair.positions();
        assert!(first.abs() < 1e-9 && second <= last + 1e-12 && last - second <= 0.005 + 1e-9, "{step}: {second}");
        last = second;
        if step == 50 {
            let bytes = pair.engine.snapshot();
            let mut other = engine(0.005);
            other.restore(&bytes).unwrap();
            pair.engine.advance(1);
            other.advance(1);
            assert!(pair.engine.snapshot() == other.snapshot());
            last = pair.positions()[1];
        }
    }
    assert!(last.abs() < 1e-12, "{last}");
}

#[test]
fn removed_gear_leaves_both_joints_where_they_are() {
    let mut pair = pair(JointForm::Tree, 0.0);
    pair.gear(2.0, 0.0);
    pair.engine.drive(pair.joints[0], JointDrive::Velocity { target: 0.5, max_force: 50.0, slip: 0.0 });
    pair.engine.advance(100);
    let before = pair.positions();
    pair.engine.set_gears(&[]);
    pair.engine.drive(pair.joints[1], JointDrive::Velocity { target: 1.0, max_force: 50.0, slip: 0.0 });
    pair.engine.advance(1);
    let after = pair.positions();
    assert!((after[0] - before[0] - 0.0025).abs() < 1e-9 && (after[1] - before[1] - 0.005).abs() < 1e-9, "{after:?}");
}

#[test]
fn gears_in_a_circle_and_to_other_mechanisms_are_ignored() {
    let mut pair = pair(JointForm::Tree, 0.0);
    let [first, second] = pair.joints;
    pair.engine.set_gears(&[
        Gear { joint: second, leader: first, ratio: 2.0, offset: 0.0 },
        Gear { joint: first, leader: second, ratio: 3.0, offset: 0.0 },
        Gear { joint: first, leader: JointId(77), ratio: 3.0, offset: 0.0 },
    ]);
    pair.engine.drive(first, JointDrive::Velocity { target: 0.5, max_force: 50.0, slip: 0.0 });
    pair.engine.advance(10);
    let [first, second] = pair.positions();
    assert!(first > 0.02 && (second - 2.0 * first).abs() < 1e-12, "{first} {second}");
}

/// A geared body that is moved alone opens a gap, also if the mechanism is at rest; the gap closes exactly.
#[test]
fn follower_that_is_moved_while_at_rest_returns() {
    let mut pair = pair(JointForm::Tree, 0.0);
    pair.gear(1.0, 0.0);
    pair.engine.drive(pair.joints[0], JointDrive::Velocity { target: 0.0, max_force: 100.0, slip: 0.0 });
    pair.engine.advance(400);
    let follower = BodyId(2);
    let pose = pair.engine.pose(follower);
    let raised = at(1.0, 0.0, 1.0) * turned(Vector3::zeros(), Vector3::y(), 0.2) * at(0.0, 0.0, -0.2);
    pair.engine.set_pose(follower, &raised);
    pair.engine.advance(1);
    assert!((pair.positions()[1] - 0.195).abs() < 1e-6, "{:?}", pair.positions());
    pair.engine.advance(700);
    assert!((pair.engine.pose(follower).translation.vector - pose.translation.vector).norm() < 1e-12);
}
