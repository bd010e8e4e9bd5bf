//! Tests of measures that save computing time: hulls in boxes, and sub-steps halved only during fast swings.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};
use tatu_geometry::{Form, Mesh};

use super::{at, body, engine, fixed, floor, mass, part};
use crate::{Engine, JointDesc, JointDrive, JointForm, JointKind, PassiveForces};

/// Returns a hull of points on the rings of a sphere.
fn ball(rings: u32, radius: f64) -> Form {
    let round = 2 * rings;
    let point = |i: u32| {
        let (polar, turn) = (f64::from(i / round) + 0.5, f64::from(i % round));
        let (polar, turn) = (polar / f64::from(rings), turn / f64::from(round));
        let (s, c) = (std::f64::consts::PI * polar).sin_cos();
        let (y, x) = (std::f64::consts::TAU * turn).sin_cos();
        Point3::new(radius * s * x, radius * s * y, radius * c)
    };
    let vertices: Vec<_> = (0..rings * round).map(point).collect();
    let triangles = (2..vertices.len() as u32).map(|i| [0, i - 1, i]).collect();
    Form::Mesh { mesh: Arc::new(Mesh { vertices, triangles, ..Default::default() }), convex: true }
}

#[test]
fn large_hulls_have_a_rotating_bounding_box() {
    for (rings, boxed, least) in [(3, false, 0.07), (16, true, 0.098)] {
        let mut engine = engine(0.005);
        floor(&mut engine);
        let id = engine.add_body(&body(at(0.0, 0.0, 0.2), mass(1.0, [0.004; 3]), part(ball(rings, 0.1))));
        let handle = engine.state.bodies.record(id).unwrap().handle;
        let collider = engine.state.bodies.world.bodies[handle].colliders()[0];
        assert_eq!(engine.state.bodies.world.colliders[collider].shape().as_compound().is_some(), boxed);
        // The body comes to rest on one of its faces.
        engine.advance(400);
        let height = engine.pose(id).translation.z;
        assert!(height < 0.1 && height > least, "{rings}: {height}");
    }
}

/// A pendulum that damping brings to rest: sub-steps are halved while it swings, including at the turning points, and
/// no longer once it hangs still.
#[test]
fn sub_steps_are_halved_until_a_swing_ends() {
    let mut engine = engine(0.005);
    let post = engine.add_body(&fixed(at(0.0, 0.0, 2.0), Vec::new()));
    let bob = engine.add_body(&body(at(0.0, 0.4, 2.0), mass(1.0, [1e-3; 3]), Vec::new()));
    let about_x = Isometry3::rotation(Vector3::y() * std::f64::consts::FRAC_PI_2);
    let joint = engine.add_joint(&JointDesc {
        a: post,
        b: bob,
        frame_in_a: about_x,
        frame_in_b: at(0.0, -0.4, 0.0) * about_x,
        kind: JointKind::Revolute,
        limits: None,
        position: 0.0,
        form: JointForm::Reduced,
        passive: PassiveForces { damping: 0.15, ..PassiveForces::default() },
        geared: false,
    });
    let joint = joint.unwrap();
    engine.drive(joint, JointDrive::Free);
    let (mut halved, mut fastest, mut last_fast) = (Vec::new(), 0.0f64, 0);
    for step in 0..3000 {
        engine.advance(1);
        halved.push(engine.state.bodies.world.integration_parameters.num_solver_iterations == 8);
        let speed = engine.joint_state(joint).velocity.abs();
        fastest = fastest.max(speed);
        if speed > 0.2 {
            last_fast = step;
        }
    }
    assert!(fastest > 4.0, "{fastest}");
    let (first, end) = (halved.iter().position(|h| *h).unwrap(), halved.iter().rposition(|h| *h).unwrap());
    assert!(halved[first..=end].iter().all(|h| *h), "sub-steps must change only once");
    assert!((end as i32 - last_fast - 200).abs() < 5, "fast until step {last_fast}, halved until {end}");
}
