//! Tests of the Pioneer's sonar ring: its poses are those of V-REP's file, and no sonar detects its own robot.

use std::f64::consts::FRAC_PI_2;

use super::{
    flat::{FlatObject, FlatRobot},
    pioneer_model::{both, close, sheet, vrep},
};

fn sensor(robot: &FlatRobot, n: usize) -> &FlatObject {
    robot.get(&format!("Pioneer_p3dx_ultrasonicSensor{n}"))
}

/// Poses of the sensors (w x y z, x y z) in the frame of the visible body, copied from V-REP's file.
#[rustfmt::skip]
const V_REP_POSES: [(usize, [f64; 4], [f64; 3]); 16] = [
    (8, [0.707094, 0.70712, 0.0, 0.0], [0.106405, -0.138144, 0.068101]),
    (7, [0.664463, 0.664463, 0.241845, 0.241845], [0.155548, -0.120238, 0.068109]),
    (6, [0.612373, 0.612372, 0.353553, 0.353553], [0.190571, -0.0785, 0.068105]),
    (5, [0.541675, 0.541675, 0.454519, 0.454519], [0.20919, -0.027272, 0.068098]),
    (4, [-0.454519, -0.454519, -0.541675, -0.541675], [0.20919, 0.027275, 0.068094]),
    (3, [0.353553, 0.353553, 0.612372, 0.612373], [0.190606, 0.083135, 0.068098]),
    (2, [0.241845, 0.241845, 0.664463, 0.664463], [0.15543, 0.125051, 0.068102]),
    (1, [0.0, 0.0, 0.707094, 0.70712], [0.106405, 0.1382, 0.068101]),
    (16, [0.0, 0.0, 0.707094, 0.70712], [-0.110295, 0.1382, 0.068163]),
    (15, [-0.241845, -0.241845, 0.664463, 0.664463], [-0.159538, 0.120265, 0.06816]),
    (14, [-0.353446, -0.353661, 0.612434, 0.612311], [-0.194561, 0.0785, 0.068158]),
    (13, [0.454237, 0.454381, -0.541949, -0.541754], [-0.213179, 0.027274, 0.068157]),
    (12, [-0.541788, -0.541912, 0.454426, 0.454195], [-0.213179, -0.027275, 0.068157]),
    (11, [0.612319, 0.612426, -0.353676, -0.353431], [-0.194552, -0.0785, 0.068158]),
    (10, [-0.664383, -0.664462, 0.242077, 0.241836], [-0.159538, -0.120241, 0.06816]),
    (9, [0.707094, 0.70712, -0.000123, 0.000124], [-0.110295, -0.13815, 0.068163]),
];

#[test]
fn sonar_poses_are_those_of_the_file() {
    let robot = vrep();
    for (n, [w, x, y, z], position) in V_REP_POSES {
        let o = sensor(&robot, n);
        let p = o.numbers("position_m");
        assert!((0..3).all(|i| close(p[i], position[i], 0.1e-3)), "{n}: {p:?} {position:?}");
        // The quaternions q and -q are the same rotation. Those of V-REP's file deviate by up to 0.7 mrad (sensor 12).
        let q = o.numbers("quaternion");
        let off = |sign: f64| {
            let pairs = [x, y, z, w].into_iter().zip(&q);
            pairs.map(|(a, b)| (a - sign * b).abs()).fold(0.0, f64::max)
        };
        assert!(off(1.0).min(off(-1.0)) < 0.4e-3, "{n}: {q:?}");
    }
}

/// Headings of sensors 1 to 16, degrees.
const HEADINGS: [f64; 16] =
    [90.0, 50.0, 30.0, 10.0, -10.0, -30.0, -50.0, -90.0, -90.0, -130.0, -150.0, -170.0, 170.0, 150.0, 130.0, 90.0];

#[test]
fn sonars_look_horizontally_along_their_headings() {
    for robot in both() {
        for (i, heading) in HEADINGS.into_iter().enumerate() {
            let f = robot.frame(sensor(&robot, i + 1));
            let (s, c) = heading.to_radians().sin_cos();
            let z = f.direction([0.0, 0.0, 1.0]);
            let y = f.direction([0.0, 1.0, 0.0]);
            assert!((0..3).all(|k| close(z[k], [c, s, 0.0][k], 1e-9)), "{}: {z:?}", i + 1);
            assert!(close(y[2], 1.0, 1e-9), "sensor {}: the y axis does not point up", i + 1);
        }
    }
}

/// The poses equal those that V-REP reports, in m and degrees (tests/facts/pioneer.md, 1).
#[test]
fn sonar_poses_are_those_measured_in_v_rep() {
    const RING: [(f64, f64, f64); 16] = [
        (0.1064, 0.1382, 90.0),
        (0.1554, 0.1250, 50.0),
        (0.1906, 0.0831, 30.0),
        (0.2092, 0.0273, 10.0),
        (0.2092, -0.0273, -10.0),
        (0.1905, -0.0785, -30.0),
        (0.1555, -0.1202, -50.0),
        (0.1064, -0.1381, -90.0),
        (-0.1103, -0.1382, -90.0),
        (-0.1596, -0.1202, -130.0),
        (-0.1946, -0.0785, -150.0),
        (-0.2132, -0.0273, -170.0),
        (-0.2132, 0.0273, 170.0),
        (-0.1946, 0.0785, 150.0),
        (-0.1596, 0.1203, 130.0),
        (-0.1103, 0.1382, 90.0),
    ];
    let robot = vrep();
    for (n, (x, y, _)) in (1..).zip(RING) {
        let here = sensor(&robot, n).numbers("position_m");
        // The measurement has a resolution of 0.1 mm.
        for (a, b) in here.iter().zip([x, y, 0.0681]) {
            assert!(close(*a, b, 0.2e-3), "{n}: {here:?}");
        }
    }
}

/// The poses equal those in ARIA's table (tests/facts/pioneer.md, 2). Only half of them are listed, because the table
/// is symmetric.
#[test]
fn sonar_poses_of_the_data_sheet_are_those_of_aria() {
    let robot = sheet();
    let right = [
        (8, 69.0, 136.0),
        (7, 114.0, 119.0),
        (6, 148.0, 78.0),
        (5, 166.0, 27.0),
        (9, -157.0, 136.0),
        (10, -203.0, 119.0),
        (11, -237.0, 78.0),
        (12, -255.0, 27.0),
    ];
    for (n, x, y) in right {
        let mirror = if n <= 8 { 9 - n } else { 25 - n };
        for (n, y) in [(n, -y), (mirror, y)] {
            let p = sensor(&robot, n).numbers("position_m");
            let expected = [x / 1000.0 + 0.0445, y / 1000.0, 0.208 - 0.1388];
            assert!((0..3).all(|i| close(p[i], expected[i], 1e-9)), "{n}: {p:?} {expected:?}");
        }
    }
}

#[test]
fn sonar_beams_follow_the_parameters() {
    let robot = vrep();
    for n in 1..=16 {
        let o = sensor(&robot, n);
        assert_eq!((o.text("sensor"), o.text("volume")), ("proximity", "cone"));
        assert!(close(o.number("range_m"), 1.0, 1e-12), "the range of V-REP's file");
        assert_eq!((o.number("near_m"), o.number("min_range_m")), (0.005, 0.05));
        assert!(close(o.number("angle_deg"), 30.0, 1e-9) && close(o.number("max_incidence_deg"), 72.0, 1e-9));
        assert!(o.is("skip_own_model"));
    }
    assert_eq!(sensor(&sheet(), 1).number("range_m"), 5.0);
    let lines = "preset = \"as the data sheet\"\nsonar_range_m = 4.3\nsonar_angle_deg = 20\n\
                 sonar_max_incidence_deg = 90\nsonar_min_range_m = 0.1";
    let wide = FlatRobot::new("pioneer_p3dx", lines);
    let o = sensor(&wide, 3);
    assert_eq!(
        ["range_m", "angle_deg", "max_incidence_deg", "min_range_m"].map(|k| o.number(k)),
        [4.3, 20.0, 90.0, 0.1]
    );
}

/// No sonar detects the floor: cones of 15 degrees to each side reach it at 75 degrees or more from its normal.
#[test]
fn the_incidence_limit_excludes_the_floor() {
    let robot = vrep();
    let o = sensor(&robot, 4);
    let steepest = FRAC_PI_2 - o.number("angle_deg").to_radians() / 2.0;
    assert!(o.number("max_incidence_deg").to_radians() < steepest);
    let height = robot.frame(o).point([0.0; 3])[2];
    let reach = height / (o.number("angle_deg").to_radians() / 2.0).sin();
    assert!(reach < o.number("range_m"), "without the limit the floor would be detected from {reach} m on");
}

/// Returns points on all surfaces of the robot that beams can detect, in the world frame.
fn seen(robot: &FlatRobot) -> Vec<[f64; 3]> {
    let mut out = Vec::new();
    let base = robot.frame(robot.get("Pioneer_p3dx"));
    for (points, triangles) in robot.objects.iter().filter(|o| o.has("mesh")).map(|o| robot.mesh(o)) {
        for t in triangles {
            let [a, b, c] = t.map(|i| points[i]);
            const N: usize = 40;
            for i in 0..=N {
                for j in 0..=N - i {
                    let (u, v) = (i as f64 / N as f64, j as f64 / N as f64);
                    let p = std::array::from_fn(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]));
                    out.push(base.point(p));
                }
            }
        }
    }
    for side in ["left", "right"] {
        let o = robot.get(&format!("Pioneer_p3dx_{side}Wheel"));
        let (f, size) = (robot.frame(o), o.numbers("size_m"));
        for i in 0..720 {
            let (s, c) = (f64::from(i) * std::f64::consts::PI / 360.0).sin_cos();
            for j in -10..=10 {
                let r = size[0] / 2.0;
                out.push(f.point([r * c, r * s, f64::from(j) / 20.0 * size[2]]));
            }
        }
    }
    out
}

#[test]
fn no_part_of_the_robot_enters_a_cone() {
    for robot in both() {
        let points = seen(&robot);
        for n in 1..=16 {
            let o = sensor(&robot, n);
            let f = robot.frame(o);
            let (p, z) = (f.point([0.0; 3]), f.direction([0.0, 0.0, 1.0]));
            // The cosine of the half angle of the cone, with a margin of one degree.
            let edge = (o.number("angle_deg").to_radians() / 2.0 + 1f64.to_radians()).cos();
            for q in &points {
                let d: [f64; 3] = std::array::from_fn(|k| q[k] - p[k]);
                let r = d.iter().map(|x| x * x).sum::<f64>().sqrt();
                let along: f64 = d.iter().zip(z).map(|(a, b)| a * b).sum();
                assert!(along < edge * r, "sensor {n} sees {q:?} at {r}");
            }
        }
    }
}
