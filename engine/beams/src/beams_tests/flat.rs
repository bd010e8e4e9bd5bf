//! Tests of cones against triangles, boxes and planes.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use tatu_geometry::Form;

use super::{
    super::{Beam, Faces},
    TestRng, cast_on, check_minimum, mesh,
};

#[test]
fn ten_thousand_triangles_are_met_at_their_nearest_point() {
    let mut dice = TestRng(1);
    let (mut hits, mut sharp) = (0, 0);
    for i in 0..10_000 {
        let size = if i % 2 == 0 { 2.0 } else { 0.4 };
        let centre = dice.vector(1.5);
        let corners = [0; 3].map(|_| Point3::from(centre + dice.vector(size)));
        let form = mesh(corners.to_vec(), vec![[0, 1, 2]]);
        let beam = dice.cone(Isometry3::identity(), if i % 3 == 0 { PI } else { FRAC_PI_2 });
        let (hit, close) = check_minimum(&form, &beam, Isometry3::identity(), 20, &mut dice);
        hits += usize::from(hit);
        sharp += usize::from(close);
        // The point must be on the triangle.
        if hit {
            let point = cast_on(form, Isometry3::identity(), &beam).point;
            let [a, b, c] = corners;
            let normal = (b - a).cross(&(c - a));
            let area = |p: &Point3<f64>, q: &Point3<f64>| (p - point).cross(&(q - point)).dot(&normal);
            let sum = normal.norm_squared();
            let parts = [area(&a, &b), area(&b, &c), area(&c, &a)];
            assert!(parts.iter().all(|x| *x > -1e-7 * sum), "{parts:?} {sum}");
            assert!((point - a).dot(&normal.normalize()).abs() < 1e-9);
        }
    }
    // The comparison is meaningful only if there are many hits, and the sampling confirms nearly all of them.
    assert!(hits > 2500 && sharp * 100 > hits * 90, "{hits} hits, {sharp} confirmed within 0.1 mm");
}

#[test]
fn boxes_and_planes_are_met_at_their_nearest_point() {
    let mut dice = TestRng(2);
    let mut hits = 0;
    for i in 0..2000 {
        let form = if i % 8 == 0 { Form::Plane } else { Form::Box { half: dice.vector(1.0).abs() } };
        let (pose, beam_pose) = (dice.pose(1.5), dice.pose(1.0));
        let beam = dice.cone(beam_pose, if i % 2 == 0 { PI } else { 1.0 });
        hits += usize::from(check_minimum(&form, &beam, pose, 20, &mut dice).0);
    }
    assert!(hits > 800, "{hits}");
}

#[test]
fn a_plate_in_the_cone_is_as_far_as_the_closed_form_says() {
    let half_angle = 15_f64.to_radians();
    for step in 0..=95 {
        let z = 0.05 + 0.01 * f64::from(step);
        for tilt in (-85..=85).step_by(5) {
            let tilt = f64::from(tilt).to_radians();
            // A plate 4 m wide, with its front rotated about x through the point (0, 0, z).
            let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), tilt);
            let place = Isometry3::from_parts(Vector3::new(0.0, 0.0, z).into(), turn)
                * Isometry3::translation(0.0, 0.0, 0.5e-3);
            let plate = Form::Box { half: Vector3::new(2.0, 2.0, 0.5e-3) };
            let hit = cast_on(plate, place, &Beam::cone(Isometry3::identity(), half_angle, 1.0));
            let height = z * tilt.cos();
            let expected = height / (tilt.abs() - half_angle).max(0.0).cos();
            let expected = if expected <= 1.0 { expected } else { f64::INFINITY };
            assert!(
                hit.distance == expected || (hit.distance - expected).abs() < 1e-6,
                "z {z} tilt {tilt}: {} {expected}",
                hit.distance
            );
        }
    }
}

#[test]
fn a_plate_enters_the_cone_at_its_edge() {
    for half_deg in [0.5, 7.5, 15.0, 45.0, 89.0, 120.0, 160.0] {
        let half_angle = f64::to_radians(half_deg);
        for distance in [0.05, 0.3, 1.0] {
            // A slat facing the apex, rotated around it; its near edge leads by `lead`.
            let plate = Form::Box { half: Vector3::new(distance * 0.05, distance * 1e-6, 1e-4) };
            let lead = 0.05_f64.atan();
            let seen = |angle: f64| {
                let swing = Isometry3::rotation(Vector3::y() * angle);
                let place = swing * Isometry3::translation(0.0, 0.0, distance + 1e-4);
                cast_on(plate.clone(), place, &Beam::cone(Isometry3::identity(), half_angle, 2.0)).is_some()
            };
            let (mut inside, mut outside) = (half_angle, (half_angle + 0.3).min(PI));
            assert!(seen(inside) && !seen(outside), "{half_deg}");
            for _ in 0..50 {
                let middle = 0.5 * (inside + outside);
                if seen(middle) { inside = middle } else { outside = middle }
            }
            assert!(
                (inside - lead - half_angle).abs().to_degrees() < 0.01,
                "{half_deg} at {distance}: {}",
                (inside - lead - half_angle).to_degrees()
            );
        }
    }
}

#[test]
fn near_and_far_limit_the_distance() {
    let wall = Form::Box { half: Vector3::new(2.0, 2.0, 0.01) };
    let place = Isometry3::translation(0.0, 0.0, 1.01);
    let mut beam = Beam::cone(Isometry3::identity(), 0.5, 2.0);
    beam.faces = Faces::FRONT;
    assert!((cast_on(wall.clone(), place, &beam).distance - 1.0).abs() < 1e-12);
    beam.far = 1.0 - 1e-9;
    assert!(!cast_on(wall.clone(), place, &beam).is_some());
    // The cone meets the wall up to 1/cos(0.5) = 1.139...: a smaller near limit cuts out a disc, a greater one
    // everything.
    (beam.near, beam.far) = (1.1, 2.0);
    assert_eq!(cast_on(wall.clone(), place, &beam).distance, 1.1);
    beam.near = 1.14;
    assert!(!cast_on(wall.clone(), place, &beam).is_some());
    (beam.near, beam.far) = (f64::NAN, f64::NAN);
    assert!(!cast_on(wall, place, &beam).is_some());
}

#[test]
fn a_plate_turned_beyond_the_incidence_limit_is_not_seen() {
    let plate = mesh(
        vec![Point3::new(-9.0, -9.0, 0.0), Point3::new(9.0, -9.0, 0.0), Point3::new(0.0, 9.0, 0.0)],
        vec![[0, 1, 2]],
    );
    let mut beam = Beam::cone(Isometry3::identity(), 0.2, 5.0);
    beam.max_incidence = 0.8;
    for (tilt, seen) in [(0.0, true), (0.99, true), (1.01, false), (-0.99, true), (-1.01, false)] {
        // At a tilt beyond the half angle, the nearest point is closer to the perpendicular than the axis by 0.2 rad.
        let place = Isometry3::new(Vector3::z(), Vector3::x() * tilt);
        assert_eq!(cast_on(plate.clone(), place, &beam).is_some(), seen, "{tilt}");
    }
}

#[test]
fn only_the_faces_asked_for_are_seen() {
    let block = Form::Box { half: Vector3::new(1.0, 1.0, 1.0) };
    let mut beam = Beam::cone(Isometry3::identity(), 0.3, 9.0);
    let outside = Isometry3::translation(0.0, 0.0, 3.0);
    for (faces, from_outside, from_inside) in [
        (Faces::BOTH, 2.0, 1.0),
        (Faces::FRONT, 2.0, f64::INFINITY),
        // From outside, the nearest visible inner surface is a point of the side walls or of the far wall.
        (Faces::BACK, 1.0 / 0.3_f64.sin(), 1.0),
    ] {
        beam.faces = faces;
        let hit = cast_on(block.clone(), outside, &beam);
        let expected: f64 = from_outside;
        assert!((hit.distance - expected).abs() < 1e-9 || hit.distance == expected, "{faces:?} {hit:?}");
        assert_eq!(cast_on(block.clone(), Isometry3::identity(), &beam).distance, from_inside);
    }
}
