use std::{
    f64::consts::{FRAC_PI_2, TAU},
    sync::Arc,
};

use nalgebra::{Point3, Vector3};
use tatu_geometry::Mesh;

use super::*;
use crate::{BodyContact, JointDesc, JointForm, JointKind, PassiveForces, Twist};

const BALL_INERTIA: [f64; 3] = [0.4e-2; 3];

/// Semi-implicit Euler with sub-step h: v = g t exactly, and the distance is g t (t + h) / 2.
#[test]
fn falling_body_matches_the_sub_step_integration() {
    let mut engine = engine(0.01);
    let ball = engine.add_body(&body(at(0.0, 0.0, 10.0), mass(1.0, BALL_INERTIA), sphere(0.1)));
    engine.advance(100);
    let h = 0.01 / 4.0;
    assert!((engine.twist(ball).linear.z + G).abs() < 1e-9);
    let z = engine.pose(ball).translation.z;
    assert!((z - (10.0 - G * (1.0 + h) / 2.0)).abs() < 1e-9, "{z}");
}

/// v = F t / m and w = M t / I; a push acts in every step of one advance and not in the next.
#[test]
fn pushed_body_accelerates_for_one_advance() {
    let mut engine = engine(0.01);
    engine.configure(EngineSettings { gravity: Vector3::zeros(), step: 0.01, ..EngineSettings::default() });
    let ball = engine.add_body(&body(at(0.0, 0.0, 0.0), mass(2.0, [0.1, 0.2, 0.5]), vec![]));
    for _ in 0..20 {
        engine.push(ball, Vector3::x(), Vector3::z());
        engine.advance(5);
    }
    let Twist { linear, angular } = engine.twist(ball);
    assert!((linear - Vector3::x() * 0.5).norm() < 0.001 * 0.5);
    assert!((angular - Vector3::z() * 2.0).norm() < 0.001 * 2.0);
    engine.advance(5);
    assert!((engine.twist(ball).linear - linear).norm() < 1e-12);
}

/// The motion of the centre of mass does not depend on where the body's origin is.
#[test]
fn free_body_spins_about_its_centre_of_mass() {
    let mut engine = engine(0.01);
    engine.configure(EngineSettings { gravity: Vector3::zeros(), step: 0.01, ..EngineSettings::default() });
    let com = Point3::new(0.3, 0.0, 0.0);
    let props = MassProps { com, ..mass(1.0, [0.1; 3]) };
    let spin = Vector3::z() * 2.0;
    let id = engine.add_body(&BodyDesc { angular_velocity: spin, ..body(at(1.0, 2.0, 3.0), props, vec![]) });
    engine.advance(100);
    let now = engine.pose(id) * com;
    assert!((now - Point3::new(1.3, 2.0, 3.0)).norm() < 1e-9, "{now}");
    // 2 rad in 1 s; each sub-step's rotation is exact to third order.
    assert!((engine.pose(id).rotation.angle() - 2.0).abs() < 1e-4);
}

/// A physical pendulum of length l has the period T = 2 pi sqrt((I + m l^2) / (m g l)), times 1 + a^2/16 at amplitude
/// a.
#[test]
fn pendulum_has_its_closed_form_period() {
    let mut engine = engine(0.005);
    let (l, m, i, amplitude) = (1.0, 1.0, 0.01, 0.05f64);
    let base = engine.add_body(&fixed(at(0.0, 0.0, 2.0), vec![]));
    let axis = turned(Vector3::zeros(), Vector3::x(), -FRAC_PI_2);
    let hang = turned(Vector3::zeros(), Vector3::y(), amplitude);
    let bob = engine.add_body(&body(at(0.0, 0.0, 2.0) * hang * at(0.0, 0.0, -l), mass(m, [i; 3]), vec![]));
    let joint = engine
        .add_joint(&JointDesc {
            a: base,
            b: bob,
            frame_in_a: axis,
            frame_in_b: at(0.0, 0.0, l) * axis,
            kind: JointKind::Revolute,
            form: JointForm::Impulse,
            passive: PassiveForces::default(),
            geared: false,
            limits: None,
            position: 0.0,
        })
        .unwrap();
    assert!((engine.joint_state(joint).position.abs() - amplitude).abs() < 1e-12);
    // Times of passing the lowest point, interpolated linearly between steps.
    let mut passed = Vec::new();
    let mut before = engine.joint_state(joint).position;
    for step in 1..4000 {
        engine.advance(1);
        let now = engine.joint_state(joint).position;
        if before < 0.0 && now >= 0.0 {
            passed.push((f64::from(step) - now / (now - before)) * 0.005);
        }
        before = now;
    }
    let swings = passed.len() - 1;
    let period = (passed[swings] - passed[0]) / swings as f64;
    let wanted = TAU * ((i + m * l * l) / (m * G * l)).sqrt() * (1.0 + amplitude * amplitude / 16.0);
    assert!((period / wanted - 1.0).abs() < 0.002, "{period} s instead of {wanted} s");
}

/// On a slope, a box slides with a = g (sin s - mu cos s), where mu is the product of both coefficients, or not at all.
#[test]
fn box_slides_on_a_slope_by_coulomb_friction() {
    let slope = 30f64.to_radians();
    for (frictions, wanted) in [((0.5, 0.4), G * (slope.sin() - 0.2 * slope.cos())), ((1.0, 0.8), 0.0)] {
        let mut engine = engine(0.005);
        let incline = turned(Vector3::zeros(), Vector3::y(), slope);
        engine.add_body(&BodyDesc { friction: frictions.0, ..fixed(incline, part(Form::Plane)) });
        let half = Vector3::new(0.1, 0.1, 0.05);
        let props = mass(1.0, [0.01 / 3.0 * 1.25, 0.01 / 3.0 * 1.25, 0.02 / 3.0]);
        let start = incline * at(0.0, 0.0, 0.05);
        let slider =
            engine.add_body(&BodyDesc { friction: frictions.1, ..body(start, props, part(Form::Box { half })) });
        // The contact settles in the first tenth of a second.
        engine.advance(20);
        let v0 = (incline.inverse() * engine.twist(slider).linear).x;
        engine.advance(200);
        let v1 = (incline.inverse() * engine.twist(slider).linear).x;
        assert!((v1 - v0 - wanted).abs() < 0.01 * G, "{} m/s^2 instead of {wanted}", v1 - v0);
    }
}

/// A ball of inertia 2/5 m r^2 rolls down a slope with a = 5/7 g sin s if friction prevents slipping.
#[test]
fn ball_rolls_down_a_slope_without_slipping() {
    let slope = 10f64.to_radians();
    let mut engine = engine(0.005);
    let incline = turned(Vector3::zeros(), Vector3::y(), slope);
    engine.add_body(&fixed(incline, part(Form::Plane)));
    let ball = engine.add_body(&body(incline * at(0.0, 0.0, 0.1), mass(1.0, BALL_INERTIA), sphere(0.1)));
    engine.advance(20);
    let v0 = engine.twist(ball).linear.norm();
    engine.advance(200);
    let wanted = 5.0 / 7.0 * G * slope.sin();
    let a = engine.twist(ball).linear.norm() - v0;
    assert!((a / wanted - 1.0).abs() < 0.01, "{a} instead of {wanted}");
    let mut contacts = Vec::new();
    engine.contacts(&mut contacts);
    let below = engine.pose(ball) * engine.pose(ball).rotation.inverse() * (incline * Point3::new(0.0, 0.0, -0.1));
    assert!((contacts[0].point - below).norm() < 0.002, "{} is not {below}", contacts[0].point);
}

/// Every form rests with its lowest point on the floor, and the contact carries its weight.
#[test]
fn forms_rest_on_their_lowest_point() {
    let corners = |h: f64| {
        let at = |i: u32| Point3::new(h * sign(i, 1), h * sign(i, 2), h * sign(i, 4));
        fn sign(i: u32, bit: u32) -> f64 {
            if i & bit == 0 { -1.0 } else { 1.0 }
        }
        (0..8).map(at).collect::<Vec<_>>()
    };
    let triangles = vec![
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    let cube = Arc::new(Mesh { vertices: corners(0.1), triangles, ..Default::default() });
    let forms = [
        (Form::Sphere { radius: 0.1 }, 0.1),
        (Form::Box { half: Vector3::new(0.1, 0.2, 0.3) }, 0.3),
        (Form::Cylinder { radius: 0.1, half_length: 0.25 }, 0.25),
        (Form::Capsule { radius: 0.1, half_length: 0.2 }, 0.3),
        (Form::Mesh { mesh: cube.clone(), convex: true }, 0.1),
        (Form::Mesh { mesh: cube, convex: false }, 0.1),
    ];
    for (form, height) in forms {
        let mut engine = engine(0.005);
        let ground = floor(&mut engine);
        let id = engine.add_body(&body(at(0.0, 0.0, height), mass(2.0, [0.05; 3]), part(form.clone())));
        engine.advance(100);
        let z = engine.pose(id).translation.z;
        // 240 Hz contacts sink by about g / (2 pi 240)^2, far below a millimetre.
        assert!((z - height).abs() < 1e-3, "{form:?} rests at {z} instead of {height}");
        let mut contacts: Vec<BodyContact> = Vec::new();
        engine.contacts(&mut contacts);
        assert!(contacts.iter().all(|c| c.bodies == (ground, id) && (c.normal - Vector3::z()).norm() < 1e-6));
        assert!(contacts.iter().all(|c| c.point.z.abs() < 1e-3), "{contacts:?}");
        let force: f64 = contacts.iter().map(|c| c.force).sum();
        assert!((force / (2.0 * G) - 1.0).abs() < 0.02, "{form:?}: {force} N");
    }
}

/// The restitution of a pair is the product of both: 1 and 0.5 return half the speed, 0 and 0.5 none of it.
#[test]
fn restitution_of_a_pair_is_the_product() {
    for (restitution, returned) in [(1.0, 0.5), (0.0, 0.0)] {
        let mut engine = engine(0.001);
        engine.add_body(&BodyDesc { restitution: 0.5, ..fixed(at(0.0, 0.0, 0.0), part(Form::Plane)) });
        let start = body(at(0.0, 0.0, 1.1), mass(1.0, BALL_INERTIA), sphere(0.1));
        let ball = engine.add_body(&BodyDesc { restitution, ..start });
        let mut last = 0.0;
        while engine.twist(ball).linear.z <= last {
            last = engine.twist(ball).linear.z;
            engine.advance(1);
        }
        engine.advance(10);
        let up = engine.twist(ball).linear.z + 0.011 * G;
        let down = (2.0 * G * 1.0f64).sqrt();
        assert!((up / down - returned).abs() < 0.05, "{up} of {down} m/s");
    }
}

/// A kinematic body pushes with the velocity of its motion, spread over the steps of an advance.
#[test]
fn kinematic_body_pushes_at_the_speed_of_its_motion() {
    let mut engine = engine(0.01);
    floor(&mut engine);
    let half = Vector3::new(0.1, 0.5, 0.1);
    let pusher = BodyDesc { motion: MotionType::Kinematic, ..fixed(at(0.0, 0.0, 0.1), part(Form::Box { half })) };
    let pusher = engine.add_body(&pusher);
    let half = Vector3::repeat(0.1);
    let slider = body(at(0.25, 0.0, 0.1), mass(1.0, [0.0067; 3]), part(Form::Box { half }));
    let slider = engine.add_body(&BodyDesc { friction: 0.3, ..slider });
    // After this time, the slider is asleep; it must wake when it is touched.
    engine.advance(400);
    for i in 1..=40 {
        let place = at(f64::from(i) * 0.01, 0.0, 0.1);
        engine.set_pose(pusher, &place);
        assert_eq!(engine.pose(pusher), place);
        engine.advance(5);
        assert_eq!(engine.pose(pusher), place);
        assert!((engine.twist(pusher).linear.x - 0.2).abs() < 1e-9);
    }
    let x = engine.pose(slider).translation.x;
    assert!((x - 0.6).abs() < 0.01, "{x}");
    engine.advance(1);
    assert_eq!(engine.twist(pusher).linear.x, 0.0);
}

/// A sleeping body falls when its support is removed or moved away.
#[test]
fn sleeping_body_falls_when_its_support_is_removed() {
    for moved in [false, true] {
        let mut engine = engine(0.01);
        let half = Vector3::repeat(0.5);
        let table = engine.add_body(&fixed(at(0.0, 0.0, 0.0), part(Form::Box { half })));
        let ball = engine.add_body(&body(at(0.0, 0.0, 0.6), mass(1.0, BALL_INERTIA), sphere(0.1)));
        engine.advance(500);
        assert!((engine.pose(ball).translation.z - 0.6).abs() < 1e-3);
        if moved {
            engine.set_pose(table, &at(5.0, 0.0, 0.0));
        } else {
            engine.remove_body(table);
        }
        engine.advance(50);
        assert!(engine.pose(ball).translation.z < 0.0, "moved: {moved}");
    }
}

#[test]
fn ids_of_removed_bodies_are_not_reused() {
    let mut engine = engine(0.01);
    let first = engine.add_body(&body(at(0.0, 0.0, 0.0), mass(1.0, BALL_INERTIA), vec![]));
    engine.remove_body(first);
    engine.remove_body(first);
    engine.remove_body(BodyId(99));
    let second = engine.add_body(&body(at(0.0, 0.0, 0.0), mass(1.0, BALL_INERTIA), vec![]));
    assert_eq!((first, second), (BodyId(0), BodyId(1)));
    engine.push(first, Vector3::x(), Vector3::x());
    engine.set_pose(first, &at(1.0, 0.0, 0.0));
    engine.advance(1);
    assert_eq!(engine.pose(first), Isometry3::identity());
}

/// Equal forms share a shape, and unused shapes are dropped.
#[test]
fn equal_forms_share_a_shape_and_unused_shapes_are_dropped() {
    let mut engine = engine(0.01);
    let mut add = |form: Form| {
        let id = engine.add_body(&body(at(0.0, 0.0, 10.0), mass(1.0, BALL_INERTIA), part(form)));
        let body = &engine.state.bodies.world.bodies[engine.state.bodies.record(id).unwrap().handle];
        let shape = engine.state.bodies.world.colliders[body.colliders()[0]].shared_shape().0.clone();
        // The body is removed again, which leaves only this test and the cache with a reference to the shape.
        engine.remove_body(id);
        (shape, engine.shapes.primitives.len())
    };
    let block = |x| Form::Box { half: Vector3::new(x, 0.1, 0.1) };
    let (first, _) = add(block(0.2));
    assert!(Arc::ptr_eq(&first, &add(block(0.2)).0));
    for other in [block(0.3), Form::Sphere { radius: 0.2 }, Form::Cylinder { radius: 0.2, half_length: 0.1 }] {
        assert!(!Arc::ptr_eq(&first, &add(other).0));
    }
    let kept = (0..1000).map(|i| add(block(1.0 + f64::from(i))).1).max();
    assert!(kept < Some(16), "{kept:?}");
    assert!(Arc::ptr_eq(&first, &add(block(0.2)).0), "a shape in use was dropped");
}
