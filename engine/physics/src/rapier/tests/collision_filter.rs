use nalgebra::Vector3;

use super::*;
use crate::{JointDesc, JointDrive, JointForm, JointKind, PassiveForces};

/// Returns whether a ball that falls on a fixed box stays on top.
fn collide(lower: CollisionMask, upper: CollisionMask) -> bool {
    let mut engine = engine(0.01);
    let half = Vector3::repeat(0.5);
    engine.add_body(&BodyDesc { collision_mask: lower, ..fixed(at(0.0, 0.0, 0.0), part(Form::Box { half })) });
    let ball = body(at(0.0, 0.0, 0.7), mass(1.0, [0.004; 3]), sphere(0.1));
    let ball = engine.add_body(&BodyDesc { collision_mask: upper, ..ball });
    engine.advance(100);
    engine.pose(ball).translation.z > 0.0
}

/// V-REP's rule in all cases: low bytes decide within a tree, high bytes between trees.
#[test]
fn masks_decide_which_bodies_collide() {
    let masks = [0x0000, 0x0001, 0x0002, 0x0100, 0x0101, 0x0102, 0x0201, 0xff01, 0xff02, 0xffff];
    for a in masks {
        for b in masks {
            for same in [true, false] {
                let tree = if same { 1 } else { 2 };
                let wanted = a & b & (if same { 0x00ff } else { 0xff00 }) != 0;
                let got = collide(CollisionMask { mask: a, tree: 1 }, CollisionMask { mask: b, tree });
                assert_eq!(got, wanted, "{a:#x} and {b:#x}, same tree: {same}");
            }
        }
    }
}

/// The filter that a tree needs for its own pairs does not affect other pairs.
#[test]
fn filter_of_a_tree_does_not_affect_other_pairs() {
    for (mask, on_floor) in [(0xff01, true), (0x0001, false)] {
        let mut engine = engine(0.01);
        floor(&mut engine);
        let low = |other| CollisionMask { mask: other, tree: 7 };
        // All bodies overlap, so only the filter can decide which of them collide.
        let ids = [mask, 0xff02, 0x0003].map(|m| {
            let desc = body(at(0.0, 0.0, 0.1), mass_of_ball(), sphere(0.1));
            engine.add_body(&BodyDesc { collision_mask: low(m), ..desc })
        });
        engine.advance(100);
        let z = ids.map(|id| engine.pose(id).translation.z);
        assert_eq!(z[0] > -1.0, on_floor, "{z:?}");
        assert!((z[1] - 0.1).abs() < 0.15, "{z:?}");
    }
}

fn mass_of_ball() -> MassProps {
    mass(1.0, [0.004; 3])
}

/// Static and kinematic bodies do not collide with each other, with or without a filter.
#[test]
fn static_and_kinematic_bodies_do_not_collide() {
    let mut engine = engine(0.01);
    let half = Vector3::repeat(0.5);
    for mask in [0xff01, 0xff02, 0x00ff] {
        let desc = fixed(at(0.0, 0.0, 0.0), part(Form::Box { half }));
        engine.add_body(&BodyDesc { collision_mask: CollisionMask { mask, tree: 3 }, ..desc.clone() });
        engine.add_body(&BodyDesc {
            motion: MotionType::Kinematic,
            collision_mask: CollisionMask { mask, tree: 3 },
            ..desc
        });
    }
    engine.advance(2);
    let mut contacts = Vec::new();
    engine.contacts(&mut contacts);
    assert!(contacts.is_empty(), "{contacts:?}");
}

/// A joint does not keep its bodies from colliding; only their masks do.
#[test]
fn jointed_bodies_collide() {
    for (mask, stopped) in [(0xffff, true), (0xff00, false)] {
        let mut engine = engine(0.01);
        engine.configure(EngineSettings { gravity: Vector3::zeros(), step: 0.01, ..EngineSettings::default() });
        let half = Vector3::repeat(0.1);
        let respond = CollisionMask { mask, tree: 4 };
        let base = fixed(at(0.0, 0.0, 0.0), part(Form::Box { half }));
        let base = engine.add_body(&BodyDesc { collision_mask: respond, ..base });
        let car = body(at(0.0, 0.0, 0.5), mass_of_ball(), part(Form::Box { half }));
        let car = engine.add_body(&BodyDesc { collision_mask: respond, ..car });
        let (frame_in_a, frame_in_b) = (at(0.0, 0.0, 0.5), Isometry3::identity());
        let desc = JointDesc {
            a: base,
            b: car,
            frame_in_a,
            frame_in_b,
            kind: JointKind::Prismatic,
            limits: None,
            position: 0.0,
            form: JointForm::Impulse,
            passive: PassiveForces::default(),
            geared: false,
        };
        let joint = engine.add_joint(&desc).unwrap();
        engine.drive(joint, JointDrive::Velocity { target: -0.5, max_force: 5.0, slip: 0.0 });
        engine.advance(200);
        let z = engine.pose(car).translation.z;
        assert_eq!(stopped, z > 0.19, "{z}");
    }
}
