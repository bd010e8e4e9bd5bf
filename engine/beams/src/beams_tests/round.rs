//! Tests of cones against spheres, cylinders and capsules.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Point3, Vector3};
use tatu_geometry::Form;

use super::{super::Beam, TestRng, cast_on, check_minimum, mesh};

fn random_form(dice: &mut TestRng, i: usize) -> Form {
    let (radius, half_length) = (dice.between(0.05, 1.0), dice.between(0.05, 1.0));
    match i % 3 {
        0 => Form::Sphere { radius },
        1 => Form::Cylinder { radius, half_length },
        _ => Form::Capsule { radius, half_length },
    }
}

#[test]
fn round_forms_are_met_at_their_nearest_point() {
    let mut dice = TestRng(3);
    let (mut hits, mut sharp) = (0, 0);
    for i in 0..3000 {
        let form = random_form(&mut dice, i);
        let (pose, beam_pose) = (dice.pose(1.0), dice.pose(1.0));
        let beam = dice.cone(beam_pose, if i % 2 == 0 { PI } else { 1.0 });
        let (hit, close) = check_minimum(&form, &beam, pose, 40, &mut dice);
        hits += usize::from(hit);
        sharp += usize::from(close);
    }
    assert!(hits > 1200 && sharp * 100 > hits * 90, "{hits} hits, {sharp} confirmed within 0.1 mm");
}

/// Returns an inscribed mesh of a solid of revolution: rings of (radius, z), from pole to pole.
fn lathe(rings: &[(f64, f64)], sides: u32) -> Form {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for (i, (radius, z)) in rings.iter().enumerate() {
        for k in 0..sides {
            let angle = TAU * f64::from(k) / f64::from(sides);
            vertices.push(Point3::new(radius * angle.cos(), radius * angle.sin(), *z));
            if i > 0 {
                let (low, high) = ((i as u32 - 1) * sides, i as u32 * sides);
                let next = (k + 1) % sides;
                triangles.push([low + k, low + next, high + next]);
                triangles.push([low + k, high + next, high + k]);
            }
        }
    }
    mesh(vertices, triangles)
}

fn arc(z: f64, radius: f64, from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> {
    (0..=64).map(move |i| {
        let angle = from + (to - from) * f64::from(i) / 64.0;
        (radius * angle.cos(), z + radius * angle.sin())
    })
}

#[test]
fn round_forms_agree_with_a_fine_mesh() {
    let mut dice = TestRng(4);
    let mut hits = 0;
    for i in 0..150 {
        let form = random_form(&mut dice, i);
        let quarter = PI / 2.0;
        let rings: Vec<(f64, f64)> = match form {
            Form::Sphere { radius } => arc(0.0, radius, -quarter, quarter).collect(),
            Form::Cylinder { radius: r, half_length: l } => vec![(0.0, -l), (r, -l), (r, l), (0.0, l)],
            Form::Capsule { radius, half_length } => {
                arc(-half_length, radius, -quarter, 0.0).chain(arc(half_length, radius, 0.0, quarter)).collect()
            }
            _ => unreachable!(),
        };
        // With 128 sides and 64 steps per half circle, a mesh of radius 1 m lies at most 2 * 0.31 mm below the surface.
        let gap = 6.2e-4;
        let meshed = lathe(&rings, 128);
        let (pose, beam_pose) = (dice.pose(1.5), dice.pose(1.5));
        let half_angle = dice.between(0.1, 1.2);
        let cone = |half_angle| Beam::cone(beam_pose, half_angle, 10.0);
        let exact = cast_on(form, pose, &cone(half_angle)).distance;
        // Moving a point by `gap` at distance d changes its direction by at most asin(gap / d).
        let wide = cast_on(meshed.clone(), pose, &cone(half_angle + 0.02)).distance;
        let slim = cast_on(meshed, pose, &cone(half_angle - 0.02)).distance;
        if wide < 0.05 {
            continue;
        }
        assert!(exact >= wide - gap && exact <= slim + gap, "{i}: {wide} {exact} {slim}");
        hits += usize::from(exact.is_finite());
    }
    assert!(hits > 30, "{hits}");
}

#[test]
fn a_ball_beside_the_axis_has_a_closed_form() {
    let ball = Form::Sphere { radius: 0.1 };
    let beam = Beam::cone(Isometry3::identity(), 0.2, 2.0);
    for off in 0..30 {
        let off = f64::from(off) * 0.01;
        let place = Isometry3::translation(off.sin(), 0.0, off.cos());
        let hit = cast_on(ball.clone(), place, &beam);
        // On the cone's surface, the ball is hit along the ray at `off - 0.2` from its centre.
        let aside = (off - 0.2).max(0.0);
        let expected = aside.cos() - (0.01 - aside.sin().powi(2)).sqrt();
        if aside < 0.1_f64.asin() {
            assert!((hit.distance - expected).abs() < 1e-12, "{off}: {hit:?} {expected}");
        } else {
            assert!(!hit.is_some(), "{off}: {hit:?}");
        }
    }
}

#[test]
fn a_pipe_around_the_sensor_is_equally_near_all_around() {
    let pipe = Form::Cylinder { radius: 0.5, half_length: 3.0 };
    let hit = cast_on(pipe, Isometry3::identity(), &Beam::cone(Isometry3::identity(), 0.4, 9.0));
    assert!((hit.distance - 0.5 / 0.4_f64.sin()).abs() < 1e-9, "{hit:?}");
    let ball = Form::Sphere { radius: 0.5 };
    assert_eq!(cast_on(ball, Isometry3::identity(), &Beam::cone(Isometry3::identity(), 0.4, 9.0)).distance, 0.5);
}

#[test]
fn a_post_at_the_edge_of_the_cone_is_seen_from_its_flank() {
    // An upright post at (x, 0, 1), parallel to y: in the plane of the x and z axes, the problem is that of a circle.
    let post = Form::Cylinder { radius: 0.1, half_length: 2.0 };
    let place = Isometry3::new(Vector3::new(0.3, 0.0, 1.0), Vector3::x() * (PI / 2.0));
    let hit = cast_on(post, place, &Beam::cone(Isometry3::identity(), 0.25, 3.0));
    let away = 0.3_f64.hypot(1.0);
    let aside = 0.3_f64.atan2(1.0) - 0.25;
    let expected = away * aside.cos() - (0.01 - (away * aside.sin()).powi(2)).sqrt();
    assert!((hit.distance - expected).abs() < 1e-9, "{hit:?} {expected}");
}
