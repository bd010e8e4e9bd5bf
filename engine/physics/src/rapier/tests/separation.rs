//! Tests of pairs that overlap when they are created.

use super::*;
use crate::{JointDesc, JointForm, JointKind, PassiveForces};

fn cube() -> Vec<SolidPart> {
    part(Form::Box { half: Vector3::repeat(0.1) })
}

fn cubes(engine: &mut Rapier, apart: f64) -> [BodyId; 2] {
    let one = |x| BodyDesc {
        collision_mask: CollisionMask { mask: 0xffff, tree: 1 + u32::from(x > 0.0) },
        ..body(at(x, 0.0, 0.1), mass(1.0, [0.007; 3]), cube())
    };
    [0.0, apart].map(|x| engine.add_body(&one(x)))
}

fn run(engine: &mut Rapier, steps: u32) {
    for _ in 0..steps {
        engine.advance(1);
    }
}

/// Once the bodies have separated, they are an ordinary pair.
#[test]
fn separated_pairs_become_ordinary_pairs() {
    let mut engine = engine(0.005);
    floor(&mut engine);
    cubes(&mut engine, 0.1);
    run(&mut engine, 1);
    assert_eq!(engine.state.contacts.separations.len(), 1);
    run(&mut engine, 400);
    assert!(engine.state.contacts.separations.is_empty());
    let hooks = engine.state.bodies.world.colliders.iter().map(|(_, c)| c.active_hooks());
    assert!(hooks.into_iter().all(|h| h.is_empty()));
}

/// A pair is not considered to overlap if it only touches, or penetrates by so little that the engine corrects it
/// slowly anyway.
#[test]
fn touching_bodies_do_not_count_as_overlapping() {
    let mut engine = engine(0.005);
    engine.add_body(&fixed(at(0.0, 0.0, -0.999), part(Form::Box { half: Vector3::repeat(1.0) })));
    cubes(&mut engine, 0.2);
    run(&mut engine, 1);
    assert!(engine.state.contacts.separations.is_empty());
}

/// Overlapping bodies that a joint connects are not separated.
#[test]
fn jointed_overlapping_bodies_are_not_separated() {
    for form in [JointForm::Reduced, JointForm::Impulse] {
        let mut engine = engine(0.005);
        floor(&mut engine);
        let [a, b] = cubes(&mut engine, 0.15);
        let desc = JointDesc {
            a,
            b,
            frame_in_a: at(0.15, 0.0, 0.0),
            frame_in_b: Isometry3::identity(),
            kind: JointKind::Fixed,
            limits: None,
            position: 0.0,
            form,
            passive: PassiveForces::default(),
            geared: false,
        };
        engine.add_joint(&desc).unwrap();
        run(&mut engine, 400);
        let way = engine.pose(b).translation.vector - engine.pose(a).translation.vector;
        assert!((way - Vector3::new(0.15, 0.0, 0.0)).norm() < 1e-3, "{form:?}: {way}");
        assert!(engine.twist(b).linear.norm() < 1e-3);
    }
}

/// A run restored from a snapshot in between continues like the original.
#[test]
fn separation_continues_from_a_snapshot() {
    let mut first = engine(0.005);
    floor(&mut first);
    let [_, b] = cubes(&mut first, 0.1);
    run(&mut first, 20);
    let mut second = engine(0.005);
    second.restore(&first.snapshot()).unwrap();
    run(&mut first, 100);
    run(&mut second, 100);
    assert_eq!(first.pose(b), second.pose(b));
}
