use nalgebra::Vector3;

use super::{two_wheels::two_wheels, *};
use crate::{JointDesc, JointDrive, JointForm, JointKind, PassiveForces, Twist};

/// Robots among boxes, with every kind of drive and a pending push.
fn busy() -> Rapier {
    let mut engine = engine(0.01);
    floor(&mut engine);
    for i in 0..6u32 {
        let robot = two_wheels(&mut engine, at(f64::from(i), 0.0, 0.14), 10 + i);
        robot.drive(&mut engine, 2.0 - f64::from(i) * 0.3, 2.0);
    }
    for i in 0..60u32 {
        let half = Vector3::repeat(0.1);
        let place = at(f64::from(i % 6) + 0.4, f64::from(i % 3) * 0.05 - 0.05, 0.1 + f64::from(i / 6) * 0.22);
        let desc = body(place, mass(0.5, [0.0033; 3]), part(Form::Box { half }));
        engine.add_body(&BodyDesc {
            friction: 0.6,
            collision_mask: CollisionMask { mask: 0xffff, tree: 100 + i },
            ..desc
        });
    }
    let base = engine.add_body(&fixed(at(0.0, 3.0, 1.0), vec![]));
    let arm = engine.add_body(&body(at(0.5, 3.0, 1.0), mass(1.0, [0.01; 3]), vec![]));
    let desc = JointDesc {
        a: base,
        b: arm,
        frame_in_a: turned(Vector3::zeros(), Vector3::x(), 1.5),
        frame_in_b: turned(Vector3::new(-0.5, 0.0, 0.0), Vector3::x(), 1.5),
        kind: JointKind::Revolute,
        form: JointForm::Impulse,
        passive: PassiveForces::default(),
        geared: false,
        limits: Some((-1.0, 1.0)),
        position: 0.0,
    };
    let joint = engine.add_joint(&desc).unwrap();
    engine.drive(joint, JointDrive::Position { target: 0.8, max_force: 20.0, max_velocity: 0.4, tracking: None });
    engine.push(arm, Vector3::x(), Vector3::zeros());
    engine
}

/// After a restore, each step is equal bit for bit, and a snapshot of the restored state equals the original.
#[test]
fn restored_snapshot_continues_bit_for_bit() {
    let mut one = busy();
    one.advance(150);
    one.push(BodyId(1), Vector3::x() * 20.0, Vector3::z());
    let bytes = one.snapshot();
    let mut two = engine(0.02);
    two.restore(&bytes).unwrap();
    assert!(two.snapshot() == bytes);
    for step in 0..100 {
        one.advance(1);
        two.advance(1);
        assert!(one.snapshot() == two.snapshot(), "differs after step {step}");
    }
    // Restoring the state in the same engine repeats the same steps.
    let end = one.snapshot();
    one.restore(&bytes).unwrap();
    for _ in 0..100 {
        one.advance(1);
    }
    assert!(one.snapshot() == end);
}

#[test]
fn foreign_or_damaged_snapshot_is_refused() {
    let mut engine = busy();
    let good = engine.snapshot();
    assert!(engine.restore(&[]).is_err());
    assert!(engine.restore(&good[..good.len() - 1]).is_err());
    let mut other = good.clone();
    other[3] ^= 1;
    assert!(engine.restore(&other).unwrap_err().contains("version"));
    let mut bad = good.clone();
    let middle = bad.len() / 2;
    bad[middle] ^= 1;
    assert!(engine.restore(&bad).unwrap_err().contains("damaged"));
    assert!(engine.snapshot() == good);
}

/// The number of threads does not affect the bits of the result.
#[test]
fn result_does_not_depend_on_the_number_of_threads() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut engine = busy();
            engine.advance(200);
            engine.snapshot()
        })
    };
    let one = run(1);
    assert!(one == run(2));
    assert!(one == run(3));
}

/// A body that receives a NaN or infinite value is frozen at its pose and reported once; other bodies are unaffected.
#[test]
fn body_with_nan_is_frozen_and_reported_once() {
    let nan = Vector3::new(f64::NAN, 0.0, 0.0);
    type InvalidChange<'a> = &'a dyn Fn(&mut Rapier, BodyId);
    let poisons: [InvalidChange; 4] = [
        &|e, id| e.push(id, nan, Vector3::zeros()),
        &|e, id| e.set_twist(id, &Twist { linear: nan, angular: Vector3::zeros() }),
        &|e, id| e.set_pose(id, &at(f64::INFINITY, 0.0, 0.0)),
        // Every push is finite, but their sum overflows.
        &|e, id| {
            for _ in 0..4 {
                e.push(id, Vector3::x() * f64::MAX, Vector3::zeros());
            }
        },
    ];
    for (case, poison) in poisons.into_iter().enumerate() {
        let mut engine = engine(0.01);
        floor(&mut engine);
        let ball = |x: f64| body(at(x, 0.0, 0.1), mass(1.0, [0.004; 3]), sphere(0.1));
        let (sick, sound) = (engine.add_body(&ball(0.0)), engine.add_body(&ball(1.0)));
        engine.advance(50);
        let before = engine.pose(sick);
        poison(&mut engine, sick);
        engine.advance(50);
        assert_eq!(engine.quarantined(), [sick], "case {case}");
        assert!(engine.quarantined().is_empty());
        assert_eq!(engine.pose(sick), before, "case {case}");
        assert!((engine.pose(sound).translation.vector - Vector3::new(1.0, 0.0, 0.1)).norm() < 1e-3);
    }
}

/// A body with invalid values from the start is created, frozen and reported, which keeps ids dense.
#[test]
fn body_created_with_nan_is_frozen_and_reported() {
    let mut engine = engine(0.01);
    let bad = mass(f64::NAN, [0.1; 3]);
    let id = engine.add_body(&body(at(0.0, 0.0, 1.0), bad, sphere(0.1)));
    engine.advance(10);
    assert_eq!(engine.quarantined(), [id]);
}
