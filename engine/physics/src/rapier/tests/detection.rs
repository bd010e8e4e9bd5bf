//! Tests of the change between steps in which rapier is called and those in which trees find their contacts themselves.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};
use tatu_geometry::{Form, Mesh};

use super::{G, at, body, engine, fixed, floor, mass, part, tower, tree_joint, turned};
use crate::{
    BodyDesc, BodyId, CollisionMask, Engine, EngineSettings, JointDesc, JointDrive, JointId, JointKind, PassiveForces,
    Rapier,
};

const CUBE: Form = Form::Box { half: Vector3::new(0.1, 0.1, 0.1) };

fn along_x() -> Isometry3<f64> {
    turned(Vector3::zeros(), Vector3::y(), std::f64::consts::FRAC_PI_2)
}

/// Returns a cube as a hull.
fn hull() -> Form {
    let sign = |i: u32, bit: u32| if i >> bit & 1 == 1 { 0.1 } else { -0.1 };
    let vertices = (0..8).map(|i| Point3::new(sign(i, 0), sign(i, 1), sign(i, 2))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    Form::Mesh { mesh: Arc::new(Mesh { vertices, triangles, ..Mesh::default() }), convex: true }
}

fn link(engine: &mut Rapier, pose: Isometry3<f64>, form: Form, tree: u32, friction: f64) -> BodyId {
    let collision_mask = CollisionMask { mask: 0xff00, tree };
    let desc = body(pose, mass(1.0, [1.0 / 150.0; 3]), part(form));
    engine.add_body(&BodyDesc { collision_mask, friction, ..desc })
}

/// Adds a body without colliders.
fn ghost(engine: &mut Rapier, pose: Isometry3<f64>, m: f64) -> BodyId {
    let collision_mask = CollisionMask { mask: 0, tree: 1 };
    engine.add_body(&BodyDesc { collision_mask, ..body(pose, mass(m, [1e-3; 3]), Vec::new()) })
}

/// Adds a body far away, because of which rapier is called.
fn far_ball(engine: &mut Rapier) -> BodyId {
    engine.add_body(&body(at(50.0, 0.0, 50.0), mass(1.0, [0.001; 3]), part(Form::Sphere { radius: 0.05 })))
}

fn force(engine: &Rapier) -> f64 {
    let mut found = Vec::new();
    engine.contacts(&mut found);
    found.iter().map(|c| c.force).sum()
}

fn move_at(engine: &mut Rapier, joint: JointId, target: f64, max_force: f64) {
    engine.drive(joint, JointDrive::Velocity { target, max_force, slip: 0.0 });
}

/// Rapier still stores the normal of forms that touched at their sides, although one has since moved onto the other.
#[test]
fn normal_of_an_earlier_place_is_not_used() {
    let mut engine = engine(0.005);
    engine.add_body(&fixed(at(0.0, 0.0, -0.1), part(hull())));
    let post = engine.add_body(&fixed(Isometry3::identity(), Vec::new()));
    let carriage = ghost(&mut engine, at(-0.3, 0.0, -0.1), 0.1);
    let block = link(&mut engine, at(-0.3, 0.0, -0.1), hull(), 1, 0.5);
    let x = tree_joint(post, carriage, JointKind::Prismatic, at(-0.3, 0.0, -0.1) * along_x(), along_x());
    let x = engine.add_joint(&x).unwrap();
    let z = tree_joint(carriage, block, JointKind::Prismatic, Isometry3::identity(), Isometry3::identity());
    let z = engine.add_joint(&z).unwrap();
    let ball = far_ball(&mut engine);
    move_at(&mut engine, z, 0.0, 1000.0);
    move_at(&mut engine, x, 0.5, 100.0);
    engine.advance(100);
    assert!((force(&engine) - 100.0).abs() < 0.1, "{}", force(&engine));
    engine.remove_body(ball);
    for (joint, speed, steps) in [(x, -0.5, 20), (x, 0.0, 0), (z, 0.5, 100), (z, 0.0, 0), (x, 0.5, 100), (x, 0.0, 0)] {
        move_at(&mut engine, joint, speed, 1000.0);
        engine.advance(steps);
    }
    move_at(&mut engine, z, -0.1, 10.0);
    engine.advance(400);
    let (place, pressed) = (engine.pose(block).translation.vector, force(&engine));
    move_at(&mut engine, x, 0.0, 50.0);
    far_ball(&mut engine);
    for _ in 0..3 {
        engine.advance(1);
        assert!((engine.pose(block).translation.vector - place).norm() < 1e-6);
        assert!((force(&engine) - pressed).abs() < 1e-3 * pressed, "{}", force(&engine));
    }
}

/// A contact that dry friction keeps from moving has the same force with any number of sub-steps.
#[test]
fn held_contact_has_the_same_force_with_any_number_of_sub_steps() {
    let mut engine = engine(0.005);
    engine.configure(EngineSettings { gravity: Vector3::zeros(), step: 0.005, ..EngineSettings::default() });
    let post = engine.add_body(&fixed(Isometry3::identity(), Vec::new()));
    engine.add_body(&fixed(at(0.2, 0.0, 0.0), part(CUBE)));
    let finger = link(&mut engine, at(-0.02, 0.0, 0.0), CUBE, 1, 0.0);
    let passive = PassiveForces { friction: 50.0, ..PassiveForces::default() };
    let slide = tree_joint(post, finger, JointKind::Prismatic, along_x(), along_x());
    let slide = engine.add_joint(&JointDesc { passive, ..slide }).unwrap();
    let wheel = ghost(&mut engine, at(-0.5, 0.0, 0.0), 1e-3);
    // Not about its centre, which would be as calm as if it stood still.
    let off_centre = at(0.0, 0.2, 0.0) * along_x();
    let wheel = tree_joint(finger, wheel, JointKind::Revolute, at(-0.5, 0.0, 0.0) * along_x(), off_centre);
    let wheel = engine.add_joint(&wheel).unwrap();
    move_at(&mut engine, wheel, 10.0, 100.0);
    move_at(&mut engine, slide, 0.1, 90.0);
    engine.advance(200);
    engine.drive(slide, JointDrive::Free);
    engine.advance(40);
    let busy = force(&engine);
    assert!(busy > 30.0, "{busy}");
    for speed in [0.0, 10.0] {
        move_at(&mut engine, wheel, speed, 100.0);
        engine.advance(60);
        assert_eq!(engine.state.forms.trees.mechanisms[0].calm_s > 0.0, speed == 0.0);
        assert!((force(&engine) - busy).abs() < 0.01 * busy, "{speed}: {} instead of {busy}", force(&engine));
    }
}

#[test]
fn new_robot_leaves_another_one_calm() {
    let mut engine = engine(0.005);
    floor(&mut engine);
    tower(&mut engine, Isometry3::identity(), 1);
    engine.advance(100);
    tower(&mut engine, at(50.0, 0.0, 0.0), 2);
    engine.advance(1);
    let calm: Vec<f64> = engine.state.forms.trees.mechanisms.iter().map(|m| m.calm_s).collect();
    assert!(calm[0] >= 0.1 && calm[1] < 0.01, "{calm:?}");
}

/// The friction of a pair is limited to 10, also where each coefficient is below it.
#[test]
fn friction_of_a_pair_is_limited_with_and_without_rapier() {
    for ball in [false, true] {
        let mut engine = engine(0.005);
        let ground = part(Form::Box { half: Vector3::new(9.0, 9.0, 0.1) });
        engine.add_body(&BodyDesc { friction: 4.0, ..fixed(at(0.0, 0.0, -0.1), ground) });
        let plate = Form::Box { half: Vector3::new(1.0, 1.0, 0.02) };
        let [low, top] = [0.02, 0.06].map(|z| link(&mut engine, at(0.0, 0.0, z), plate.clone(), 1, 4.0));
        engine.add_joint(&tree_joint(low, top, JointKind::Fixed, at(0.0, 0.0, 0.02), at(0.0, 0.0, -0.02)));
        if ball {
            far_ball(&mut engine);
        }
        engine.advance(50);
        for _ in 0..100 {
            engine.push(low, Vector3::x() * 2.0 * G * 13.0, Vector3::zeros());
            engine.advance(1);
        }
        let speed = engine.twist(low).linear.x;
        // It slides, at about half of its weight more than friction holds.
        assert!(speed > 13.0 && speed < 20.0, "ball {ball}: {speed}");
    }
}

/// A robot that is placed in the floor is not lifted above its surface, at any damping of contacts.
#[test]
fn overlap_of_a_calm_tree_is_not_overcorrected() {
    for contact_spring in [None, Some([240.0, 1.0]), Some([240.0, 0.3])] {
        let mut engine = engine(0.005);
        engine.configure(EngineSettings { contact_spring, step: 0.005, ..EngineSettings::default() });
        floor(&mut engine);
        let low = tower(&mut engine, Isometry3::identity(), 1);
        engine.advance(100);
        engine.set_pose(low, &at(0.0, 0.0, 0.098));
        for _ in 0..10 {
            engine.advance(1);
            let height = engine.pose(low).translation.z - 0.1;
            assert!(height < 1e-4, "{contact_spring:?}: {height}");
        }
    }
}

#[test]
fn contacts_that_rapier_found_long_ago_are_not_reported() {
    let mut engine = engine(0.005);
    floor(&mut engine);
    let cube = link(&mut engine, at(0.0, 0.0, 0.1), CUBE, 1, 0.7);
    engine.advance(50);
    assert!((force(&engine) - G).abs() < 0.01);
    let post = engine.add_body(&fixed(Isometry3::identity(), Vec::new()));
    let lift = tree_joint(post, cube, JointKind::Prismatic, at(0.0, 0.0, 0.1), Isometry3::identity());
    let lift = engine.add_joint(&lift).unwrap();
    move_at(&mut engine, lift, 1.0, 1000.0);
    engine.advance(400);
    engine.remove_joint(lift);
    assert_eq!(force(&engine), 0.0);
    engine.advance(1);
    assert_eq!(force(&engine), 0.0);
}

#[test]
fn snapshots_do_not_grow_with_removed_bodies() {
    let mut engine = engine(0.005);
    floor(&mut engine);
    tower(&mut engine, Isometry3::identity(), 1);
    let mut sizes = Vec::new();
    for _ in 0..3 {
        for _ in 0..100 {
            let wall = engine.add_body(&fixed(at(3.0, 0.0, 0.5), part(CUBE)));
            engine.advance(1);
            engine.remove_body(wall);
        }
        engine.advance(1);
        sizes.push(engine.snapshot().len());
    }
    // Ids of removed bodies are not used again, and take a few bytes each.
    assert!(sizes[2] - sizes[1] < 1000, "{sizes:?}");
}
