//! Tests of forces that act for a whole advance, and for a single step of it.

use super::*;
use crate::BodyWrench;

fn ball(engine: &mut Rapier) -> BodyId {
    let mut desc = body(at(0.0, 0.0, 0.0), mass(2.0, [0.1; 3]), sphere(0.1));
    desc.mass.com = Point3::new(0.05, 0.0, 0.0);
    engine.add_body(&desc)
}

#[test]
fn push_of_a_step_acts_only_in_that_step() {
    let mut engine = Rapier::new(EngineSettings { gravity: Vector3::zeros(), step: 0.01, ..EngineSettings::default() });
    let ball = ball(&mut engine);
    engine.push(ball, Vector3::new(4.0, 0.0, 0.0), Vector3::zeros());
    let mut seen = Vec::new();
    engine.advance_with(
        5,
        Some(&mut |engine, step, out| {
            seen.push((step, engine.twist(ball).linear));
            if step == 2 {
                // Two pushes on one body add up.
                for _ in 0..2 {
                    out.push(BodyWrench {
                        body: ball,
                        force: Vector3::new(0.0, 3.0, 0.0),
                        torque: Vector3::new(0.0, 0.0, 1.0),
                    });
                }
            }
        }),
    );
    // The velocity grows by F t / m in each step.
    for (step, v) in &seen {
        assert!((v.x - 2.0 * 0.01 * f64::from(*step)).abs() < 1e-12, "{step}: {v}");
    }
    assert_eq!(seen.iter().map(|s| s.0).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
    let t = engine.twist(ball);
    assert!((t.linear.x - 0.1).abs() < 1e-12 && (t.linear.y - 6.0 * 0.01 / 2.0).abs() < 1e-12, "{t:?}");
    assert!((t.angular.z - 2.0 * 0.01 / 0.1).abs() < 1e-9, "{t:?}");
    // Pushes do not persist into the next advance.
    engine.advance(5);
    assert!((engine.twist(ball).linear - t.linear).norm() < 1e-12);
}

#[test]
fn push_in_every_step_equals_one_push_for_the_advance() {
    let run = |each: bool| {
        let mut engine = engine(0.01);
        let ball = ball(&mut engine);
        let (force, torque) = (Vector3::new(0.3, -0.7, 21.0), Vector3::new(0.01, 0.02, 0.03));
        for _ in 0..20 {
            if each {
                engine.advance_with(5, Some(&mut |_, _, out| out.push(BodyWrench { body: ball, force, torque })));
            } else {
                engine.push(ball, force, torque);
                engine.advance(5);
            }
        }
        (engine.pose(ball), engine.twist(ball))
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn centre_of_mass_is_reported_in_the_world_frame() {
    let mut engine = Rapier::new(EngineSettings { gravity: Vector3::zeros(), step: 0.01, ..EngineSettings::default() });
    let ball = ball(&mut engine);
    engine.set_pose(ball, &turned(Vector3::new(1.0, 2.0, 3.0), Vector3::z(), std::f64::consts::FRAC_PI_2));
    assert!((engine.centre_of_mass(ball) - Point3::new(1.0, 2.05, 3.0)).norm() < 1e-12);
}

#[test]
fn push_with_nan_freezes_its_body() {
    let mut engine = engine(0.01);
    let ball = ball(&mut engine);
    let force = Vector3::new(f64::NAN, 0.0, 0.0);
    engine.advance_with(1, Some(&mut |_, _, out| out.push(BodyWrench { body: ball, force, torque: Vector3::zeros() })));
    assert_eq!(engine.quarantined(), [ball]);
}
