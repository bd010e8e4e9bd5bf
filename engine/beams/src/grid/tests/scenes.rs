//! Random scenes and cameras for the tests.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};
use tatu_geometry::{Form, Mesh};

use super::*;
use crate::BeamTarget;
use crate::Faces;

pub(super) fn target(object: u64, pose: Isometry3<f64>, form: Form) -> BeamTarget {
    BeamTarget {
        object,
        group: object as u32 % 3,
        world_from_target: pose,
        form,
        color: [0.7; 3],
        opacity: 1.0,
        texture: None,
    }
}

pub(super) fn scene(targets: impl IntoIterator<Item = BeamTarget>) -> BeamScene {
    let mut scene = BeamScene::default();
    scene.set(targets);
    scene
}

pub(super) fn mesh(vertices: Vec<Point3<f64>>, triangles: Vec<[u32; 3]>) -> Form {
    Form::Mesh { mesh: Arc::new(Mesh { vertices, triangles, ..Default::default() }), convex: false }
}

/// Returns a closed, bumpy sphere of triangles.
pub(super) fn ball(dice: &mut TestRng, radius: f64, around: u32, up: u32, bumps: f64) -> Form {
    let mut vertices = vec![Point3::new(0.0, 0.0, -radius)];
    for i in 1..up {
        let tilt = std::f64::consts::PI * (f64::from(i) / f64::from(up) - 0.5);
        for j in 0..around {
            let turn = std::f64::consts::TAU * f64::from(j) / f64::from(around);
            let r = radius * (1.0 + dice.between(-bumps, bumps));
            vertices.push(Point3::new(r * tilt.cos() * turn.cos(), r * tilt.cos() * turn.sin(), r * tilt.sin()));
        }
    }
    vertices.push(Point3::new(0.0, 0.0, radius));
    let (top, at) = (vertices.len() as u32 - 1, |i: u32, j: u32| 1 + (i - 1) * around + j % around);
    let mut triangles = Vec::new();
    for j in 0..around {
        triangles.push([0, at(1, j + 1), at(1, j)]);
        triangles.push([top, at(up - 1, j), at(up - 1, j + 1)]);
        for i in 1..up - 1 {
            triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    mesh(vertices, triangles)
}

pub(super) fn any_form(dice: &mut TestRng, size: f64) -> Form {
    let s = |dice: &mut TestRng| dice.between(0.05, 1.0) * size;
    match dice.between(0.0, 7.0) as u32 {
        0 => Form::Box { half: Vector3::new(s(dice), s(dice), s(dice)) },
        1 => Form::Sphere { radius: s(dice) },
        2 => Form::Cylinder { radius: s(dice), half_length: s(dice) },
        3 => Form::Capsule { radius: 0.5 * s(dice), half_length: s(dice) },
        4 => {
            let (around, up) = (dice.between(3.0, 60.0) as u32, dice.between(2.0, 40.0) as u32);
            let radius = s(dice);
            ball(dice, radius, around, up, 0.1)
        }
        5 => {
            // Unconnected triangles of random sizes.
            let vertices: Vec<Point3<f64>> = (0..60).map(|_| Point3::from(dice.vector(size))).collect();
            mesh(vertices, (0..20).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
        }
        _ => Form::Box { half: Vector3::new(s(dice), 0.0, s(dice)) },
    }
}

pub(super) fn any_grid(dice: &mut TestRng, perspective: bool) -> Grid {
    Grid {
        columns: dice.between(1.0, 90.0) as u32,
        rows: dice.between(1.0, 70.0) as u32,
        projection: if perspective {
            ImageProjection::Perspective { angle: dice.between(0.2, 2.4) }
        } else {
            ImageProjection::Orthographic { width: dice.between(0.5, 8.0) }
        },
        near: dice.between(0.01, 0.4),
        far: dice.between(2.0, 12.0),
    }
}

pub(super) fn cast_of<'a>(grid: &'a Grid, light: &'a ImageLighting, pose: Isometry3<f64>) -> GridCast<'a> {
    GridCast {
        grid,
        world_from_sensor: pose,
        faces: Faces::BOTH,
        skip_group: None,
        only_object: None,
        outputs: ImageOutputs::ALL,
        light,
    }
}
