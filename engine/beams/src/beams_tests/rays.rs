//! Tests of rays against sampled surfaces and closed-form solutions.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};
use proptest::prelude::*;
use tatu_geometry::{Form, Mesh};

use super::{
    super::{Beam, Faces, Volume},
    TestRng,
    brute::patches,
    cast_on, mesh, surface_distance,
};

/// A hit of a ray must be on the surface, and no sampled point may be in front of it.
///
/// A sampled point p is in front of a hit at distance t if it is almost on the ray and nearer.
#[test]
fn rays_stop_at_the_surface() {
    let mut dice = TestRng(5);
    let mut hits = 0;
    for i in 0..1500 {
        let (a, b) = (dice.between(0.2, 0.8), dice.between(0.2, 0.8));
        let form = match i % 5 {
            0 => Form::Sphere { radius: a },
            1 => Form::Cylinder { radius: a, half_length: b },
            2 => Form::Capsule { radius: a, half_length: b },
            3 => Form::Plane,
            _ => Form::Box { half: Vector3::new(a, b, 0.5) },
        };
        let (pose, beam_pose) = (dice.pose(0.7), dice.pose(1.5));
        let beam = Beam::ray(beam_pose, 8.0);
        let hit = cast_on(form.clone(), pose, &beam);
        hits += usize::from(hit.is_some());
        // The hit must be on the surface.
        if hit.is_some() {
            assert!((hit.point.coords - Vector3::z() * hit.distance).norm() < 1e-12);
            let p = pose.inverse_transform_point(&(beam_pose * hit.point));
            let off = surface_distance(&form, &p);
            assert!(off.abs() < 1e-9, "{off} {form:?}");
        }
        // Nothing may be nearer.
        if matches!(form, Form::Plane) {
            continue;
        }
        let to_beam = beam_pose.inverse() * pose;
        for patch in patches(&form) {
            for k in 0..1600 {
                let (p, normal) = patch(f64::from(k % 40) / 39.0, f64::from(k / 40) / 39.0);
                let (p, normal) = (to_beam * p, to_beam * normal);
                // Unless the angle is grazing, a surface point 1 mm from the ray implies that the ray crosses the
                // surface within 2 cm.
                let near_ray = p.xy().coords.norm() < 1e-3 && p.z > 0.05 && normal.z.abs() > 0.3;
                assert!(!near_ray || hit.distance < p.z + 0.02, "{p:?} {hit:?}");
            }
        }
    }
    assert!(hits > 200, "{hits}");
}

#[test]
fn rays_through_a_closed_mesh_never_slip_between_triangles() {
    // An octahedron, with rays aimed at its edges and corners.
    let tips = [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y(), Vector3::z(), -Vector3::z()];
    let vertices: Vec<Point3<f64>> = tips.iter().map(|v| Point3::from(*v)).collect();
    let mut triangles = Vec::new();
    for [a, b, c] in [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4]] {
        triangles.push([a, b, c]);
        triangles.push([b, a, c + 1]);
    }
    let form = mesh(vertices, triangles);
    let mut dice = TestRng(6);
    for _ in 0..2000 {
        let (a, b) = (tips[(dice.unit() * 6.0) as usize], tips[(dice.unit() * 6.0) as usize]);
        if a == -b {
            continue;
        }
        let aim = Point3::from(a.lerp(&b, if dice.chance(0.2) { 0.0 } else { dice.unit() }));
        let turn = nalgebra::UnitQuaternion::rotation_between(&Vector3::z(), &aim.coords);
        let Some(turn) = turn else { continue };
        let beam = Beam::ray(Isometry3::from_parts(Default::default(), turn), 3.0);
        let hit = cast_on(form.clone(), Isometry3::identity(), &beam);
        assert!((hit.distance - aim.coords.norm()).abs() < 1e-9, "{hit:?} {aim:?}");
    }
}

#[test]
fn rays_respect_range_face_and_incidence_limits() {
    let ball = Form::Sphere { radius: 1.0 };
    let place = Isometry3::translation(0.0, 0.0, 3.0);
    let mut beam = Beam::ray(Isometry3::identity(), 9.0);
    assert_eq!(cast_on(ball.clone(), place, &beam).distance, 2.0);
    beam.near = 2.5;
    assert_eq!(cast_on(ball.clone(), place, &beam).distance, 4.0);
    beam.faces = Faces::FRONT;
    assert!(!cast_on(ball.clone(), place, &beam).is_some());
    beam.near = 0.0;
    // The ray passes the centre at a distance of 0.6, so it meets the ball at an incidence of asin(0.6).
    let aside = Isometry3::translation(0.6, 0.0, 3.0);
    beam.max_incidence = 0.6_f64.asin() + 1e-6;
    assert!((cast_on(ball.clone(), aside, &beam).distance - 2.2).abs() < 1e-9);
    beam.max_incidence = 0.6_f64.asin() - 1e-6;
    assert!(!cast_on(ball, aside, &beam).is_some());
}

/// Generates mostly ordinary numbers, but also 0, NaN, infinity, and very small and very large numbers.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => -2.0..2.0,
        1 => Just(0.0),
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
        1 => Just(1e-300),
        1 => Just(1e300),
    ]
}

proptest! {
    #[test]
    fn no_number_makes_a_cast_panic(n in proptest::collection::vec(any_number(), 32), kind in 0..6, ray in any::<bool>()) {
        let corner = |i: usize| Point3::new(n[i], n[i + 1], n[i + 2]);
        let form = match kind {
            0 => Form::Plane,
            1 => Form::Box { half: Vector3::new(n[0], n[1], n[2]) },
            2 => Form::Sphere { radius: n[0] },
            3 => Form::Cylinder { radius: n[0], half_length: n[1] },
            4 => Form::Capsule { radius: n[0], half_length: n[1] },
            _ => Form::Mesh {
                mesh: Arc::new(Mesh {
                    vertices: vec![corner(0), corner(3), corner(6), corner(9)],
                    triangles: vec![[0, 1, 2], [1, 2, 3], [0, 0, 1], [0, 1, 9]],
                    ..Default::default()
                }),
                convex: false,
            },
        };
        let pose = |i: usize| Isometry3::new(corner(i).coords, corner(i + 3).coords);
        let mut beam = Beam::ray(pose(12), n[24]);
        if !ray {
            beam.volume = Volume::Cone { half_angle: n[25] };
        }
        (beam.near, beam.max_incidence) = (n[26], n[27]);
        let hit = cast_on(form, pose(18), &beam);
        prop_assert!(!hit.distance.is_nan());
    }
}
