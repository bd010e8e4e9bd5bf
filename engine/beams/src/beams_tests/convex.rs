//! Tests of pyramids, cylinders and flat sectors against closed-form solutions and dense sampling.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{Isometry3, Point3, Vector3};
use tatu_geometry::Form;

use super::{
    super::{Beam, Faces, Volume},
    TestRng, cast_on, check_minimum, mesh,
};

fn volume(dice: &mut TestRng) -> Volume {
    match (dice.unit() * 3.0) as usize {
        0 => Volume::Pyramid {
            x_near: dice.between(0.0, 1.0),
            y_near: dice.between(0.0, 1.0),
            x_far: dice.between(0.0, 3.0),
            y_far: dice.between(0.0, 3.0),
        },
        1 => Volume::Cylinder { radius_near: dice.between(0.0, 0.6), radius_far: dice.between(0.0, 1.5) },
        _ => {
            let angle = dice.between(0.1, TAU);
            let gap = if dice.chance(0.3) { dice.between(0.0, 0.8) * angle } else { 0.0 };
            Volume::Disc { angle, height: dice.between(0.02, 1.0), gap }
        }
    }
}

/// Returns a beam with a random volume; in some cases, its minimum distance, incidence or faces are also limited.
fn beam(dice: &mut TestRng, pose: Isometry3<f64>) -> Beam {
    let mut beam = Beam { volume: volume(dice), ..Beam::ray(pose, dice.between(1.2, 5.0)) };
    if dice.chance(0.4) {
        beam.near = dice.between(0.0, 1.0);
    }
    if dice.chance(0.3) {
        beam.max_incidence = dice.between(0.1, 1.5);
    }
    if dice.chance(0.3) {
        beam.faces = if dice.chance(0.5) { Faces::FRONT } else { Faces::BACK };
    }
    beam
}

/// Casts random beams on random forms. Returns the number of hits, and the number of hits that the sampling confirmed.
fn sweep(seed: u64, questions: usize, grid: usize, form: impl Fn(&mut TestRng) -> Form) -> (usize, usize) {
    let mut dice = TestRng(seed);
    let (mut hits, mut close) = (0, 0);
    for _ in 0..questions {
        let (pose, at) = (dice.pose(1.2), dice.pose(1.2));
        let beam = beam(&mut dice, at);
        let (hit, near) = check_minimum(&form(&mut dice), &beam, pose, grid, &mut dice);
        hits += usize::from(hit);
        close += usize::from(near);
    }
    println!("{hits} of {questions} hit, {close} close to a sample");
    (hits, close)
}

#[test]
fn ten_thousand_triangles_are_met_at_their_nearest_point_in_every_volume() {
    let (hits, close) = sweep(31, 10_000, 8, |dice| {
        let corners: Vec<Point3<f64>> = (0..3).map(|_| dice.vector(1.5).into()).collect();
        mesh(corners, vec![[0, 1, 2]])
    });
    assert!(hits > 1200 && close * 10 > hits * 6, "{hits} {close}");
}

#[test]
fn boxes_and_planes_are_met_at_their_nearest_point_in_every_volume() {
    let (hits, close) = sweep(32, 1500, 10, |dice| {
        if dice.chance(0.2) {
            return Form::Plane;
        }
        Form::Box { half: Vector3::new(dice.between(0.05, 1.0), dice.between(0.05, 1.0), dice.between(0.05, 1.0)) }
    });
    assert!(hits > 500 && close * 10 > hits * 6, "{hits} {close}");
}

#[test]
fn round_forms_are_met_at_their_nearest_point_in_every_volume() {
    let (hits, close) = sweep(33, 1500, 14, |dice| {
        let (a, b) = (dice.between(0.05, 1.0), dice.between(0.05, 1.0));
        match (dice.unit() * 3.0) as usize {
            0 => Form::Sphere { radius: a },
            1 => Form::Cylinder { radius: a, half_length: b },
            _ => Form::Capsule { radius: a, half_length: b },
        }
    });
    assert!(hits > 300 && close * 10 > hits * 6, "{hits} {close}");
}

fn at(volume: Volume, near: f64, far: f64) -> Beam {
    Beam { volume, near, ..Beam::ray(Isometry3::identity(), far) }
}

#[test]
fn ends_of_pyramids_and_cylinders_are_flat() {
    // A plate perpendicular to the axis is visible up to the height of the far end, although its edge inside the volume
    // is farther away than that.
    let plate = Form::Box { half: Vector3::new(0.02, 0.02, 0.0) };
    let pyramid = Volume::Pyramid { x_near: 0.2, y_near: 0.2, x_far: 2.0, y_far: 1.0 };
    let cylinder = Volume::Cylinder { radius_near: 0.1, radius_far: 1.0 };
    for volume in [pyramid, cylinder] {
        let beam = at(volume, 0.1, 1.0);
        let corner = Isometry3::translation(0.9, 0.0, 0.99);
        let hit = cast_on(plate.clone(), corner, &beam);
        assert!((hit.distance - 0.88_f64.hypot(0.99)).abs() < 1e-12 && hit.distance > 1.0, "{hit:?}");
        assert!(!cast_on(plate.clone(), Isometry3::translation(0.9, 0.0, 1.01), &beam).is_some());
        assert!(!cast_on(plate.clone(), Isometry3::translation(0.0, 0.0, 0.09), &beam).is_some());
        assert!(cast_on(plate.clone(), Isometry3::translation(0.0, 0.0, 0.11), &beam).is_some());
    }
}

#[test]
fn a_wall_beside_a_cylinder_is_met_where_the_volume_touches_it() {
    // A straight cylinder with a radius of 0.5 m. The wall leans so that its point nearest to the origin is outside the
    // cylinder; the nearest point inside is on the cylinder's side.
    let beam = at(Volume::Cylinder { radius_near: 0.5, radius_far: 0.5 }, 0.0, 3.0);
    let lean = Isometry3::rotation(Vector3::x() * -0.3);
    let wall = Isometry3::translation(0.0, 0.0, 2.0) * lean;
    let hit = cast_on(Form::Plane, wall, &beam);
    // The plane has the normal (0, sin 0.3, cos 0.3) and contains (0, 0, 2). Its foot is 2 cos 0.3 along the normal,
    // and 2 cos 0.3 sin 0.3 = 0.565 beside the axis.
    let (sin, cos) = 0.3_f64.sin_cos();
    assert!(2.0 * cos * sin > 0.5);
    // The point with y = 0.5 on the plane's line in y and z, where z = 2 - y tan 0.3.
    let expected = 0.5_f64.hypot(2.0 - 0.5 * sin / cos);
    assert!((hit.distance - expected).abs() < 1e-9, "{} {expected}", hit.distance);
}

#[test]
fn a_flat_sector_sees_all_around_but_not_above() {
    let disc = |angle, gap| at(Volume::Disc { angle, height: 0.1, gap }, 0.2, 2.0);
    let ball = Form::Sphere { radius: 0.1 };
    let around = |a: f64, y: f64| Isometry3::translation(a.sin(), y, a.cos());
    for a in [0.0, 1.0, 2.0, 3.0, -1.0, -2.5, PI] {
        let hit = cast_on(ball.clone(), around(a, 0.0), &disc(TAU, 0.0));
        assert!((hit.distance - 0.9).abs() < 1e-9, "{a} {hit:?}");
        assert!(!cast_on(ball.clone(), around(a, 0.16), &disc(TAU, 0.0)).is_some());
    }
    // A quarter turn to each side, with a gap of a tenth of a turn ahead.
    let half = disc(PI, TAU / 10.0);
    assert!(cast_on(ball.clone(), around(1.2, 0.0), &half).is_some());
    assert!(!cast_on(ball.clone(), around(0.0, 0.0), &half).is_some());
    assert!(!cast_on(ball.clone(), around(2.0, 0.0), &half).is_some());
    // The near limit is round: a wall through the blind zone is seen at the zone's edge.
    let wall = Isometry3::translation(0.0, 0.0, 0.1);
    let hit = cast_on(Form::Plane, wall, &disc(FRAC_PI_2 * 1.9, 0.0));
    assert!((hit.distance - 0.2).abs() < 1e-9, "{hit:?}");
}

#[test]
fn invalid_volumes_hit_no_target() {
    let near = Isometry3::translation(0.0, 0.0, 0.5);
    let nan = f64::NAN;
    for volume in [
        Volume::Pyramid { x_near: nan, y_near: 1.0, x_far: 1.0, y_far: 1.0 },
        Volume::Pyramid { x_near: -1.0, y_near: 1.0, x_far: 1.0, y_far: 1.0 },
        Volume::Cylinder { radius_near: f64::INFINITY, radius_far: 1.0 },
        Volume::Disc { angle: nan, height: 1.0, gap: 0.0 },
        Volume::Disc { angle: 1.0, height: -1.0, gap: 0.0 },
        Volume::Disc { angle: 1.0, height: 1.0, gap: 1.0 },
    ] {
        assert!(!cast_on(Form::Sphere { radius: 0.1 }, near, &at(volume, 0.0, 1.0)).is_some(), "{volume:?}");
    }
    let endless = at(Volume::Cylinder { radius_near: 1.0, radius_far: 1.0 }, 0.0, f64::INFINITY);
    assert!(!cast_on(Form::Sphere { radius: 0.1 }, near, &endless).is_some());
}
