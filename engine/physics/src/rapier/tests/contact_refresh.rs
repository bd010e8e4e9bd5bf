//! Tests of rolling cylinders.

use std::f64::consts::FRAC_PI_2;

use super::*;

/// A rolling cylinder keeps its speed, even across a snapshot.
#[test]
fn rolling_cylinder_does_not_accelerate() {
    const RADIUS: f64 = 0.03;
    const SPEED: f64 = 0.02;
    let mut first = engine(0.005);
    first.add_body(&fixed(at(0.0, 0.0, -0.1), part(Form::Box { half: Vector3::new(1.0, 1.0, 0.1) })));
    let can = first.add_body(&BodyDesc {
        linear_velocity: Vector3::x() * SPEED,
        angular_velocity: Vector3::y() * (SPEED / RADIUS),
        ..body(
            turned(Vector3::new(0.0, 0.0, RADIUS), Vector3::x(), FRAC_PI_2),
            mass(0.2, [2e-4, 2e-4, 1e-4]),
            part(Form::Cylinder { radius: RADIUS, half_length: 0.07 }),
        )
    });
    first.advance(200);
    let mut second = engine(0.005);
    second.restore(&first.snapshot()).unwrap();
    for engine in [&mut first, &mut second] {
        engine.advance(600);
        let speed = engine.twist(can).linear.x;
        assert!((speed / SPEED - 1.0).abs() < 1e-3, "{speed}");
    }
    assert_eq!(first.pose(can), second.pose(can));
}
