//! Tests of trees that move slowly, and of scenes in which only trees move: the number of sub-steps, and contacts that
//! are found without rapier.

use nalgebra::{Isometry3, Vector3};
use tatu_geometry::Form;

use super::{G, at, body, engine, fixed, floor, mass, part, tower};
use crate::{BodyContact, BodyDesc, BodyId, CollisionMask, Engine, Rapier};

fn contacts(engine: &Rapier) -> Vec<BodyContact> {
    let mut found = Vec::new();
    engine.contacts(&mut found);
    found
}

/// Returns whether rapier's narrow phase contains pairs of colliders.
fn rapier_has_pairs(engine: &Rapier) -> bool {
    engine.state.bodies.world.narrow_phase.contact_pairs().next().is_some()
}

fn calm_s(engine: &Rapier) -> f64 {
    engine.state.forms.trees.mechanisms[0].calm_s
}

#[test]
fn calm_tree_rests_with_one_sub_step_until_an_impact() {
    let mut engine = engine(0.005);
    floor(&mut engine);
    let low = tower(&mut engine, at(0.0, 0.0, 0.05), 1);
    // It lands after 0.101 s.
    engine.advance(19);
    assert!(calm_s(&engine) > 0.09);
    engine.advance(3);
    assert!(calm_s(&engine) < 0.01);
    engine.advance(178);
    assert!(calm_s(&engine) >= 0.1);
    let start = engine.pose(low).translation.vector;
    engine.advance(400);
    assert!((engine.pose(low).translation.vector - start).norm() < 1e-9);
    let carried: f64 = contacts(&engine).iter().map(|c| c.force).sum();
    assert!((carried - 3.0 * G).abs() < 1e-6, "{carried}");
    // A push of 3 m/s.
    engine.push(low, Vector3::x() * 1800.0, Vector3::zeros());
    engine.advance(2);
    assert_eq!(calm_s(&engine), 0.0);
}

/// Sliding needs all sub-steps, at any speed that matters; the deceleration is that of Coulomb's law.
#[test]
fn sliding_tree_is_not_calm() {
    let mut engine = engine(0.005);
    let ground = engine.add_body(&fixed(Isometry3::identity(), part(Form::Plane)));
    let low = tower(&mut engine, Isometry3::identity(), 1);
    engine.advance(100);
    assert!(calm_s(&engine) >= 0.1);
    let friction = Some(0.3);
    engine.set_pair(
        ground,
        low,
        Some(crate::PairRule { responds: true, friction, restitution: None, ..crate::PairRule::default() }),
    );
    let twist = crate::Twist { linear: Vector3::x() * 0.5, ..crate::Twist::default() };
    engine.set_twist(low, &twist);
    engine.advance(20);
    assert_eq!(calm_s(&engine), 0.0);
    let speed = engine.twist(low).linear.x;
    assert!((speed - (0.5 - 0.3 * G * 0.1)).abs() < 2e-3, "{speed}");
}

/// A tree is found on planes, boxes and other trees without rapier, and with rapier as soon as something else moves.
#[test]
fn rapier_is_called_only_while_something_else_moves() {
    let mut engine = engine(0.005);
    engine.add_body(&fixed(at(0.0, 0.0, -0.1), part(Form::Box { half: Vector3::new(1.0, 1.0, 0.1) })));
    let low = tower(&mut engine, Isometry3::identity(), 1);
    let above = tower(&mut engine, at(0.0, 0.0, 0.4), 2);
    let carried = |engine: &Rapier, below: BodyId| -> f64 {
        contacts(engine).iter().filter(|c| c.bodies.0 == below).map(|c| c.force).sum()
    };
    engine.advance(300);
    assert!(!rapier_has_pairs(&engine));
    assert!((carried(&engine, BodyId(0)) - 6.0 * G).abs() < 1e-3, "{}", carried(&engine, BodyId(0)));
    let pose = [engine.pose(low), engine.pose(above)];
    let ball = engine.add_body(&body(at(0.6, 0.0, 0.5), mass(1.0, [0.001; 3]), part(Form::Sphere { radius: 0.05 })));
    engine.advance(100);
    assert!(rapier_has_pairs(&engine));
    assert!((engine.pose(ball).translation.z - 0.05).abs() < 1e-3);
    engine.remove_body(ball);
    engine.advance(300);
    assert!((carried(&engine, BodyId(0)) - 6.0 * G).abs() < 1e-3, "{}", carried(&engine, BodyId(0)));
    for (body, before) in [low, above].into_iter().zip(pose) {
        assert!((engine.pose(body).translation.vector - before.translation.vector).norm() < 1e-4);
    }
}

/// The sub-steps of trees are independent: the motion of one tree does not change the bits of another that it does not
/// touch.
#[test]
fn busy_trees_leave_the_bits_of_a_calm_one() {
    let run = |busy: u32| {
        let mut engine = engine(0.005);
        floor(&mut engine);
        let low = tower(&mut engine, at(0.0, 0.0, 0.01), 1);
        for i in 0..busy {
            let fast = tower(&mut engine, at(f64::from(i + 1) * 2.0, 0.0, 0.3), i + 2);
            let twist = crate::Twist { angular: Vector3::new(3.0, 2.0, 1.0), ..crate::Twist::default() };
            engine.set_twist(fast, &twist);
        }
        engine.advance(300);
        engine.pose(low)
    };
    let alone = run(0);
    assert_eq!(alone, run(1));
    assert_eq!(alone, run(20));
}

#[test]
fn snapshots_continue_bit_for_bit_without_rapier() {
    let mut one = engine(0.005);
    one.add_body(&fixed(at(0.0, 0.0, -0.1), part(Form::Box { half: Vector3::new(1.0, 1.0, 0.1) })));
    let low = tower(&mut one, at(0.0, 0.0, 0.01), 1);
    for steps in [3, 15, 25, 100] {
        one.advance(steps);
        let bytes = one.snapshot();
        let mut two = engine(0.02);
        two.restore(&bytes).unwrap();
        assert!(two.snapshot() == bytes);
        for _ in 0..30 {
            one.advance(1);
            two.advance(1);
            assert_eq!(one.pose(low), two.pose(low));
        }
        assert!(one.snapshot() == two.snapshot());
    }
}

/// A box that is created where a tree has moved to while rapier was not called overlaps the tree at its new position.
#[test]
fn new_body_meets_a_tree_where_it_is() {
    for (x, deepest) in [(0.0, 0.0), (1.15, 0.05)] {
        let mut engine = engine(0.005);
        engine.configure(crate::EngineSettings { gravity: Vector3::zeros(), step: 0.005, ..Default::default() });
        let low = tower(&mut engine, Isometry3::identity(), 1);
        engine.set_twist(low, &crate::Twist { linear: Vector3::x(), ..crate::Twist::default() });
        engine.advance(200);
        engine.set_twist(low, &crate::Twist::default());
        assert!(!rapier_has_pairs(&engine) && (engine.pose(low).translation.x - 1.0).abs() < 1e-6);
        let cube = part(Form::Box { half: Vector3::repeat(0.1) });
        let desc = body(at(x, 0.0, 0.1), mass(1.0, [1.0 / 150.0; 3]), cube);
        let collision_mask = CollisionMask { mask: 0xffff, tree: 2 };
        let cube = engine.add_body(&BodyDesc { collision_mask, ..desc });
        engine.advance(2);
        let moved = engine.pose(cube).translation.x - x;
        assert!(if deepest > 0.0 { moved > 1e-4 && moved < 4e-3 } else { moved == 0.0 }, "{x}: {moved}");
    }
}
