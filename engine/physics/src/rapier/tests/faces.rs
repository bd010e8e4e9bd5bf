//! Hulls that stand on faces of many corners.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};
use tatu_geometry::{Form, Mesh};

use super::*;
use crate::JointKind;

/// Returns a prism with `corners` corners at a radius of 5 cm, 6 cm high, about its middle.
fn prism(corners: u32) -> Form {
    let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(corners) + 0.1;
    let ring = |z: f64| (0..corners).map(move |i| Point3::new(0.05 * angle(i).cos(), 0.05 * angle(i).sin(), z));
    let mut triangles = Vec::new();
    for i in 0..corners {
        let next = (i + 1) % corners;
        triangles.extend([[i, next, corners + i], [next, corners + next, corners + i]]);
    }
    for i in 1..corners - 1 {
        triangles.extend([[0, i + 1, i], [corners, corners + i, corners + i + 1]]);
    }
    let vertices = ring(-0.03).chain(ring(0.03)).collect();
    Form::Mesh { mesh: Arc::new(Mesh { vertices, triangles, ..Mesh::default() }), convex: true }
}

/// Returns the surface z = 0 as a mesh of eight triangles, two of whose edges cross below the prism.
fn ground() -> Form {
    let at = |x: f64, y: f64| Point3::new(x, y, 0.0);
    let vertices = vec![
        at(-1.0, -1.0),
        at(0.01, -1.0),
        at(1.0, -1.0),
        at(-1.0, 0.02),
        at(0.01, 0.02),
        at(1.0, 0.02),
        at(-1.0, 1.0),
        at(0.01, 1.0),
        at(1.0, 1.0),
    ];
    let square = |a: u32| [[a, a + 1, a + 4], [a, a + 4, a + 3]];
    let triangles = [0, 1, 3, 4].into_iter().flat_map(square).collect();
    Form::Mesh { mesh: Arc::new(Mesh { vertices, triangles, ..Mesh::default() }), convex: false }
}

/// Puts a prism on a surface that is inclined by `degrees`; returns how far it moves in some seconds after the first.
fn displacement(form: &Form, base: &str, degrees: f64, m: f64, centre: f64, tree: bool, seconds: u32) -> f64 {
    let (mut engine, prism) = place_prism(form, base, degrees, m, centre, tree);
    engine.advance(200);
    let before = engine.pose(prism);
    engine.advance(200 * seconds);
    let after = engine.pose(prism);
    (after.translation.vector - before.translation.vector).norm() + 0.05 * after.rotation.angle_to(&before.rotation)
}

fn place_prism(form: &Form, base: &str, degrees: f64, m: f64, centre: f64, tree: bool) -> (Rapier, BodyId) {
    let mut engine = engine(0.005);
    let slope = turned(Vector3::zeros(), Vector3::y(), f64::to_radians(degrees));
    let (under, below) = match base {
        "plane" => (Form::Plane, 0.0),
        "box" => (Form::Box { half: Vector3::new(1.0, 1.0, 0.1) }, -0.1),
        _ => (ground(), 0.0),
    };
    engine.add_body(&BodyDesc { friction: 0.5, ..fixed(slope * at(0.0, 0.0, below), part(under)) });
    let inertia = [m * 0.001, m * 0.001, m * 0.0013];
    let mass = MassProps { com: Point3::new(centre, 0.0, 0.0), ..mass(m, inertia) };
    let desc = BodyDesc { friction: 1.0, ..body(slope * at(0.0, 0.0, 0.0302), mass, part(form.clone())) };
    let prism = engine.add_body(&desc);
    if tree {
        let small = MassProps { mass: 0.1 * m, com: Point3::origin(), inertia: Matrix3::identity() * (1e-4 * m) };
        let top = body(slope * at(0.0, 0.0, 0.0802), small, part(Form::Sphere { radius: 0.01 }));
        let top = engine.add_body(&top);
        engine.add_joint(&tree_joint(prism, top, JointKind::Fixed, at(0.0, 0.0, 0.05), Isometry3::identity()));
    }
    (engine, prism)
}

#[test]
fn prisms_rest_on_all_surfaces() {
    for corners in [3, 4, 5, 6, 7, 8, 12, 24, 64] {
        let form = prism(corners);
        for base in ["plane", "box", "mesh"] {
            for degrees in [0.0, 20.0] {
                for (m, tree) in [(0.001, false), (100.0, false), (0.001, true), (100.0, true)] {
                    let moved = displacement(&form, base, degrees, m, 0.0, tree, 4);
                    assert!(
                        moved < 1e-6,
                        "{corners} corners, {base}, {degrees} degrees, {m} kg, tree {tree}: {moved:e} m"
                    );
                }
            }
        }
    }
    for tree in [false, true] {
        assert!(displacement(&prism(6), "plane", 0.0, 1.0, 0.0, tree, 60) < 1e-6);
    }
}

/// A prism stands while its centre of mass is above its face, whose sides are at 0.966 of the radius.
#[test]
fn prism_topples_only_with_its_centre_beyond_the_edge() {
    for base in ["plane", "box"] {
        for tree in [false, true] {
            let moved = displacement(&prism(12), base, 0.0, 1.0, 0.85 * 0.05, tree, 10);
            assert!(moved < 1e-6, "{base}, tree {tree}: {moved:e}");
            let (mut engine, body) = place_prism(&prism(12), base, 0.0, 1.0, 1.2 * 0.05, tree);
            engine.advance(400);
            let up = engine.pose(body).rotation * Vector3::z();
            assert!(up.z < 0.5, "{base}, tree {tree}: topples with its centre outside");
        }
    }
}
