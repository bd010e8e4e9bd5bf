//! Tests of a robot with two driven wheels and a caster. Masses and positions are from a model of V-REP's library; the
//! wheels collide as balls.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Isometry3, Vector3};

use super::*;
use crate::{JointDesc, JointDrive, JointForm, JointId, JointKind, PassiveForces};

const WHEEL_RADIUS: f64 = 0.0975;
const TRACK_WIDTH: f64 = 0.331;
const BASE_HEIGHT: f64 = 0.1388;

pub(super) struct TwoWheels {
    pub base: BodyId,
    pub wheels: [BodyId; 2],
    pub caster: [BodyId; 2],
    /// Joints of the left wheel, the right wheel, the caster link and the caster wheel.
    pub joints: [JointId; 4],
}

/// Adds the robot. `tree` distinguishes robots. Within a tree, neither the base (as in V-REP's model) nor the wheels
/// collide with anything.
pub(super) fn two_wheels(engine: &mut Rapier, base_pose: Isometry3<f64>, tree: u32) -> TwoWheels {
    let respond = |mask| CollisionMask { mask, tree };
    let across = turned(Vector3::zeros(), Vector3::x(), -FRAC_PI_2);
    let base = engine.add_body(&BodyDesc {
        collision_mask: respond(0xff01),
        friction: 0.0,
        ..body(
            base_pose,
            mass(16.0, [1.92, 1.939, 2.09]),
            vec![SolidPart {
                pose: at(-0.03, 0.0, 0.03),
                form: Form::Box { half: Vector3::new(0.2, 0.14, 0.1) },
                friction: None,
                color: None,
                opacity: None,
                texture: None,
            }],
        )
    });
    let link_in_base = at(-0.149, 0.0, -0.0778);
    let wheel_in_link = at(0.0212, 0.0064, -0.0311) * across;
    let mut add = |in_world, m, parts, friction, mask| {
        engine.add_body(&BodyDesc { friction, collision_mask: respond(mask), ..body(in_world, m, parts) })
    };
    let [left_in_base, right_in_base] = [0.1655, -0.1655].map(|y| at(0.0445, y, -0.0413) * across);
    let wheel = || mass(1.5, [0.03, 0.03, 0.06]);
    let left = add(base_pose * left_in_base, wheel(), sphere(WHEEL_RADIUS), 1.0, 0xff02);
    let right = add(base_pose * right_in_base, wheel(), sphere(WHEEL_RADIUS), 1.0, 0xff04);
    let link = add(base_pose * link_in_base, mass(1.0, [0.016, 0.016, 0.02]), vec![], 0.0, 0);
    let caster = add(
        base_pose * link_in_base * wheel_in_link,
        mass(0.25, [0.00102, 0.00102, 0.00701]),
        sphere(0.0296),
        0.0,
        0xff08,
    );
    let mut join = |a, b, frame_in_a| {
        engine
            .add_joint(&JointDesc {
                a,
                b,
                frame_in_a,
                frame_in_b: Isometry3::identity(),
                kind: JointKind::Revolute,
                form: JointForm::Impulse,
                passive: PassiveForces::default(),
                geared: false,
                limits: None,
                position: 0.0,
            })
            .unwrap()
    };
    let joints = [
        join(base, left, left_in_base),
        join(base, right, right_in_base),
        join(base, link, link_in_base),
        join(link, caster, wheel_in_link),
    ];
    TwoWheels { base, wheels: [left, right], caster: [link, caster], joints }
}

impl TwoWheels {
    pub(super) fn drive(&self, engine: &mut Rapier, left: f64, right: f64) {
        for (joint, target) in self.joints.into_iter().zip([left, right]) {
            engine.drive(joint, JointDrive::Velocity { target, max_force: 3.0, slip: 0.0 });
        }
    }

    /// Returns the largest distance between the two sides of a joint, m.
    fn largest_joint_gap(&self, engine: &Rapier) -> f64 {
        let [left, right] = self.wheels;
        let base = engine.pose(self.base);
        let anchor = |b, in_base: [f64; 3]| {
            (engine.pose(b).translation.vector - (base * nalgebra::Point3::from(in_base)).coords).norm()
        };
        let link = engine.pose(self.caster[0]);
        let caster = engine.pose(self.caster[1]).translation.vector;
        let at_caster = (link * nalgebra::Point3::new(0.0212, 0.0064, -0.0311)).coords;
        [
            anchor(left, [0.0445, 0.1655, -0.0413]),
            anchor(right, [0.0445, -0.1655, -0.0413]),
            anchor(self.caster[0], [-0.149, 0.0, -0.0778]),
            (caster - at_caster).norm(),
        ]
        .into_iter()
        .fold(0.0, f64::max)
    }
}

fn tilt(pose: &Isometry3<f64>) -> f64 {
    (pose * Vector3::z()).z.clamp(-1.0, 1.0).acos()
}

fn yaw(pose: &Isometry3<f64>) -> f64 {
    let x = pose * Vector3::x();
    x.y.atan2(x.x)
}

/// Advances by `seconds` in intervals of 50 ms, and calls `each` after each interval. `step` is the physics step, s.
fn run(engine: &mut Rapier, step: f64, seconds: f64, mut each: impl FnMut(&Rapier)) {
    for _ in 0..(seconds / 0.05).round() as u32 {
        engine.advance((0.05 / step).round() as u32);
        each(engine);
    }
}

/// Returns a robot on a floor, after 1 s of settling.
fn settled(step: f64) -> (Rapier, TwoWheels) {
    let mut engine = engine(step);
    floor(&mut engine);
    let robot = two_wheels(&mut engine, at(0.0, 0.0, BASE_HEIGHT), 1);
    run(&mut engine, step, 1.0, |_| ());
    (engine, robot)
}

/// At equal wheel speeds, v = w r, straight ahead. The caster swings around first, so distances are measured from then
/// on.
#[test]
fn equal_wheel_speeds_drive_straight() {
    for step in [0.01, 0.005] {
        for speed in [2.0, -2.0] {
            let (mut engine, robot) = settled(step);
            robot.drive(&mut engine, speed, speed);
            run(&mut engine, step, 2.0, |_| ());
            let start = engine.pose(robot.base);
            let (mut lean, mut gap) = (0.0f64, 0.0f64);
            run(&mut engine, step, 20.5, |engine| {
                lean = lean.max(tilt(&engine.pose(robot.base)));
                gap = gap.max(robot.largest_joint_gap(engine));
            });
            let way = (start.inverse() * engine.pose(robot.base)).translation.vector;
            let wanted = speed * WHEEL_RADIUS * 20.5;
            assert!((way.x / wanted - 1.0).abs() < 0.005, "step {step}: {} m instead of {wanted}", way.x);
            // 4 m without steering: an initial yaw error of 0.1 degrees alone amounts to 7 mm.
            assert!(way.y.abs() < 0.01, "step {step}: {} m aside", way.y);
            assert!(lean.to_degrees() < 0.5, "step {step}: leans by {} degrees", lean.to_degrees());
            assert!(gap < 1e-3, "step {step}: joints open by {gap} m");
        }
    }
}

/// At different wheel speeds, the yaw rate is r (w_right - w_left) / track.
#[test]
fn unequal_wheel_speeds_yield_the_yaw_rate() {
    for step in [0.01, 0.005] {
        for (left, right) in [(1.0, 2.0), (-1.0, 1.0)] {
            let (mut engine, robot) = settled(step);
            robot.drive(&mut engine, left, right);
            run(&mut engine, step, 2.0, |_| ());
            let mut last = yaw(&engine.pose(robot.base));
            let mut turned = 0.0;
            run(&mut engine, step, 10.0, |engine| {
                let now = yaw(&engine.pose(robot.base));
                turned += (now - last).rem_euclid(std::f64::consts::TAU);
                last = now;
            });
            let wanted = WHEEL_RADIUS * (right - left) / TRACK_WIDTH * 10.0;
            assert!((turned / wanted - 1.0_f64).abs() < 0.015, "step {step}: {turned} instead of {wanted}");
        }
    }
}

#[test]
fn stopped_robot_does_not_drift() {
    for step in [0.01, 0.005] {
        let (mut engine, robot) = settled(step);
        robot.drive(&mut engine, 0.0, 0.0);
        let start = engine.pose(robot.base);
        run(&mut engine, step, 10.0, |_| ());
        let moved = (start.inverse() * engine.pose(robot.base)).translation.vector.norm();
        assert!(moved < 0.003, "step {step}: moved by {moved} m");
    }
}

/// After a fall of 0.5 m, the robot stands on its wheels again, and never rises above the height that it fell from.
#[test]
fn fallen_robot_lands_on_its_wheels() {
    for step in [0.01, 0.005] {
        let mut engine = engine(step);
        floor(&mut engine);
        let robot = two_wheels(&mut engine, at(0.0, 0.0, BASE_HEIGHT + 0.5), 1);
        robot.drive(&mut engine, 0.0, 0.0);
        let mut top = 0.0f64;
        run(&mut engine, step, 4.0, |engine| top = top.max(engine.pose(robot.base).translation.z));
        let end = engine.pose(robot.base);
        assert!(top <= BASE_HEIGHT + 0.5, "rose to {top}");
        assert!((end.translation.z - BASE_HEIGHT).abs() < 1e-3, "step {step}: stands at {}", end.translation.z);
        assert!(tilt(&end).to_degrees() < 0.5);
        assert!(robot.largest_joint_gap(&engine) < 1e-3);
        assert!(engine.quarantined().is_empty());
    }
}

/// A robot that drives against a wall at 0.2 m/s stops there upright, with slipping wheels or motors at their limit.
#[test]
fn robot_stops_upright_at_a_wall() {
    for step in [0.01, 0.005] {
        let (mut engine, robot) = settled(step);
        let half = Vector3::new(0.05, 2.0, 0.5);
        engine.add_body(&fixed(at(0.55, 0.0, 0.5), part(Form::Box { half })));
        robot.drive(&mut engine, 2.0, 2.0);
        let (mut lean, mut furthest) = (0.0f64, 0.0f64);
        run(&mut engine, step, 6.0, |engine| {
            let pose = engine.pose(robot.base);
            lean = lean.max(tilt(&pose));
            furthest = furthest.max(pose.translation.x);
        });
        let end = engine.pose(robot.base).translation.vector;
        // The front of the base is 0.17 m ahead of its origin, the wall's face at 0.5 m.
        assert!((end.x - 0.33).abs() < 0.005 && furthest < 0.335, "step {step}: at {} ({furthest})", end.x);
        assert!(lean.to_degrees() < 3.0, "step {step}: leans by {}", lean.to_degrees());
        assert!(engine.quarantined().is_empty());
    }
}
