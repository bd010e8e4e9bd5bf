//! Tests of the Pioneer's sonars against geometry: the nearest detectable point of a plate in the cone.
//!
//! The ring and the cones are described in `tests/facts/pioneer.md`, 1: 30 degrees, a tip of 5 mm, a threshold of 0.05
//! m, and at most 45 degrees between line of sight and surface normal. The model allows 72 degrees by default, for the
//! reason in its README. The expected value is computed by bisecting the face of the plate into negligible pieces,
//! without the program's geometry code.

use crate::kit::*;

type Vec3 = [f64; 3];

/// x (m), y (m) and heading (degrees) of the sonars 1 to 16 in the robot's frame. All are at z = 0.0681 m.
#[rustfmt::skip]
const RING: [Vec3; 16] = [
    [ 0.1064,  0.1382,   90.0], [ 0.1554,  0.1250,   50.0], [ 0.1906,  0.0831,   30.0], [ 0.2092,  0.0273,   10.0],
    [ 0.2092, -0.0273,  -10.0], [ 0.1905, -0.0785,  -30.0], [ 0.1555, -0.1202,  -50.0], [ 0.1064, -0.1381,  -90.0],
    [-0.1103, -0.1382,  -90.0], [-0.1596, -0.1202, -130.0], [-0.1946, -0.0785, -150.0], [-0.2132, -0.0273, -170.0],
    [-0.2132,  0.0273,  170.0], [-0.1946,  0.0785,  150.0], [-0.1596,  0.1203,  130.0], [-0.1103,  0.1382,   90.0],
];
const SONAR_HEIGHT: f64 = 0.0681;
const ROBOT: &str = "/Pioneer_p3dx";

fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn add(a: Vec3, b: Vec3, s: f64) -> Vec3 {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}
/// Rotates `v` by the quaternion x y z w.
fn turn([x, y, z, w]: [f64; 4], v: Vec3) -> Vec3 {
    let cross = |a: Vec3, b: Vec3| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let t = cross([x, y, z], v);
    add(add(v, t, 2.0 * w), cross([x, y, z], t), 2.0)
}
/// Returns the quaternion of a rotation by `yaw` about z, followed by `pitch` about the rotated y, rad.
fn heading(yaw: f64, pitch: f64) -> [f64; 4] {
    let ((s, c), (t, d)) = ((yaw / 2.0).sin_cos(), (pitch / 2.0).sin_cos());
    [-s * t, c * t, s * d, c * d]
}

/// The cone of a sonar, with angles in rad and lengths in m.
#[derive(Clone, Copy)]
struct SonarCone {
    half: f64,
    slant: f64,
    far: f64,
}

impl SonarCone {
    fn new(slant_deg: f64, far: f64) -> Self {
        SonarCone { half: 15f64.to_radians(), slant: slant_deg.to_radians(), far }
    }
    /// Returns the cone with its angle and range increased by these amounts, which can be negative.
    fn grown(self, degrees: f64, metres: f64) -> Self {
        let by = degrees.to_radians();
        SonarCone { half: self.half + by, slant: self.slant + by, far: self.far + metres }
    }
}

/// A thin box at any pose.
#[derive(Clone, Copy)]
struct Plate {
    at: Vec3,
    turned: [f64; 4],
    half: Vec3,
}

impl Plate {
    /// Returns the distance from a sonar at `eye`, which faces along `ahead`, to the nearest detectable point.
    fn seen(&self, eye: Vec3, ahead: Vec3, cone: SonarCone) -> Option<f64> {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|a| turn(self.turned, a));
        let mut best = f64::INFINITY;
        for (i, sign) in (0..3).flat_map(|i| [(i, 1.0), (i, -1.0)]) {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let middle = add(add(self.at, axes[i], sign * self.half[i]), eye, -1.0);
            let face = PlateFace { normal: axes[i], along: [axes[j], axes[k]], ahead, cone };
            face.halve(middle, [self.half[j], self.half[k]], &mut best);
        }
        best.is_finite().then_some(best)
    }
}

struct PlateFace {
    normal: Vec3,
    along: [Vec3; 2],
    ahead: Vec3,
    cone: SonarCone,
}

impl PlateFace {
    /// Searches a piece of the face, whose centre relative to the sonar is `middle`, and updates the smallest distance.
    fn halve(&self, middle: Vec3, half: [f64; 2], best: &mut f64) {
        let (distance, reach) = (dot(middle, middle).sqrt(), f64::hypot(half[0], half[1]));
        if distance - reach >= best.min(self.cone.far) {
            return;
        }
        // An upper bound of the angle between the direction of the piece's centre and any of its points.
        let blur = if reach < distance { (reach / distance).asin() } else { std::f64::consts::PI };
        let aside = (dot(middle, self.ahead) / distance).clamp(-1.0, 1.0).acos();
        let slanted = (dot(middle, self.normal).abs() / distance).min(1.0).acos();
        if aside - blur > self.cone.half || slanted - blur > self.cone.slant {
            return;
        }
        if half[0].max(half[1]) < 5e-5 {
            let counts = aside <= self.cone.half && slanted <= self.cone.slant;
            if counts && (0.005..=self.cone.far).contains(&distance) {
                *best = best.min(distance);
            }
            return;
        }
        let longer = usize::from(half[1] > half[0]);
        let mut part = half;
        part[longer] /= 2.0;
        for sign in [-1.0, 1.0] {
            self.halve(add(middle, self.along[longer], sign * part[longer]), part, best);
        }
    }
}

/// Returns the position and direction of a sonar for a robot's position and quaternion.
fn eye(n: usize, at: Vec3, turned: [f64; 4]) -> (Vec3, Vec3) {
    let [x, y, degrees] = RING[n - 1];
    let (s, c) = degrees.to_radians().sin_cos();
    (add(at, turn(turned, [x, y, SONAR_HEIGHT]), 1.0), turn(turned, [c, s, 0.0]))
}

fn path(n: usize) -> String {
    format!("{ROBOT}/Pioneer_p3dx_visible/Pioneer_p3dx_ultrasonicSensor{n}")
}

/// Runs a static robot while a script moves the plate to the next pose in each step, and returns the trace.
fn moved(plates: &[Plate], sonars: &[usize], model: &str) -> Vec<TraceLine> {
    let size = plates[0].half.map(|h| 2.0 * h);
    let rows: Vec<String> = plates
        .iter()
        .map(|p| {
            let ([x, y, z], [i, j, k, w]) = (p.at, p.turned);
            format!("{{{x:.17},{y:.17},{z:.17},{i:.17},{j:.17},{k:.17},{w:.17}}}")
        })
        .collect();
    let script = format!(
        "local places = {{{}}}
        function sysCall_init() plate, step = sim.getObject('/plate'), 0 end
        function sysCall_actuation()
            step = math.min(step + 1, #places)
            sim.setObjectPosition(plate, {{table.unpack(places[step], 1, 3)}})
            sim.setObjectQuaternion(plate, {{table.unpack(places[step], 4, 7)}})
        end",
        rows.join(",\n")
    );
    let plate = cuboid("plate", size, [9.0, 9.0, 9.0], "");
    let scene = format!("{FLOOR}{plate}{}{}", pioneer("function sysCall_init() end", model), watcher("mover", &script));
    let watch: Vec<String> = sonars.iter().map(|n| path(*n)).chain([ROBOT.to_owned()]).collect();
    let watch: Vec<&str> = watch.iter().map(String::as_str).collect();
    TestFolder::scene(&scene).trace(&watch, &["--steps", &plates.len().to_string()])
}

/// Compares all readings with the geometry; returns the number of detections.
fn compare(plates: &[Plate], sonars: &[usize], model: &str, cone: SonarCone) -> usize {
    let (mut found, mut worst) = (0, 0.0);
    for (i, (line, plate)) in moved(plates, sonars, model).iter().zip(plates).enumerate() {
        for n in sonars {
            let (eye, ahead) = eye(*n, line.object(ROBOT, "position"), line.object(ROBOT, "quaternion"));
            let detected = line.sensor(&path(*n), "proximity.detected") == 1.0;
            let distance = line.sensor(&path(*n), "proximity.distance");
            let exact = plate.seen(eye, ahead, cone);
            let with = |degrees, metres| plate.seen(eye, ahead, cone.grown(degrees, metres));
            let what = || format!("step {i}, sonar {n}: {detected} {distance} m, geometry {exact:?}");
            match exact {
                // An object closer than 5 cm blinds a sonar.
                Some(d) if (0.049..0.051).contains(&d) => {}
                Some(d) if d < 0.049 => assert!(!detected, "too close, but detected: {}", what()),
                Some(d) if detected => {
                    let mut off = (d - distance).abs();
                    if off >= 0.001 {
                        // At an edge of the cone, the angular tolerance changes the distance by this amount.
                        let near = with(0.02, 0.0).map_or(0.0, |d| d - distance);
                        off = near.max(with(-0.02, 0.0).map_or(0.0, |d| distance - d)).max(0.0);
                    }
                    assert!(off < 0.001, "{}", what());
                    worst = f64::max(worst, off);
                    found += 1;
                }
                Some(_) => assert!(with(-0.5, -0.001).is_none(), "not detected: {}", what()),
                None => assert!(!detected || with(0.5, 0.001).is_some(), "wrongly detected: {}", what()),
            }
        }
    }
    println!("{found} readings, at most {:.4} mm off", worst * 1e3);
    found
}

/// Returns a plate at a distance (m) in front of a sonar, in a direction given by the angles `aside` and `up`. The
/// plate is rotated away from facing the sonar by `turned` and `tilt`.
fn before(n: usize, distance: f64, [aside, up]: [f64; 2], [turned, tilt]: [f64; 2], half: Vec3) -> Plate {
    let (origin, _) = eye(n, [0.0, 0.0, 0.1388], [0.0, 0.0, 0.0, 1.0]);
    let (yaw, pitch) = ((RING[n - 1][2] + aside).to_radians(), -up.to_radians());
    let at = add(origin, turn(heading(yaw, pitch), [1.0, 0.0, 0.0]), distance);
    Plate { at, turned: heading(yaw + turned.to_radians(), pitch + tilt.to_radians()), half }
}

/// Returns `count` plates distributed over the cones of some sonars, at distances from 4 cm to slightly beyond the
/// range.
fn strewn(count: usize, sonars: &[usize], range: f64, half: Vec3) -> Vec<Plate> {
    // An additive recurrence with the square roots of primes fills the space evenly without a random generator.
    let part = |i: usize, prime: f64| ((i + 1) as f64 * prime.sqrt()).fract();
    let spread = |i, prime, width: f64| (2.0 * part(i, prime) - 1.0) * width;
    (0..count)
        .map(|i| {
            let distance = 0.04 + (1.06 * range - 0.04) * part(i, 2.0);
            let (angles, turns) =
                ([spread(i, 3.0, 24.0), spread(i, 5.0, 7.0)], [spread(i, 7.0, 80.0), spread(i, 11.0, 30.0)]);
            before(sonars[i % sonars.len()], distance, angles, turns, half)
        })
        .collect()
}

#[test]
fn distances_match_the_geometry() {
    let sonars = [1, 2, 4, 5, 7, 8, 11, 14];
    let plates = strewn(600, &sonars, 1.0, [0.001, 0.1, 0.1]);
    assert!(compare(&plates, &sonars, "", SonarCone::new(72.0, 1.0)) > 500);
    let as_the_original = "sonar_max_incidence_deg = 45.0";
    assert!(compare(&plates, &sonars, as_the_original, SonarCone::new(45.0, 1.0)) > 500);
}

#[test]
fn a_longer_range_is_seen_to_its_end() {
    let sonars = [2, 5, 12];
    let plates = strewn(300, &sonars, 5.0, [0.001, 0.25, 0.1]);
    assert!(compare(&plates, &sonars, "sonar_range_m = 5.0", SonarCone::new(72.0, 5.0)) > 100);
}

#[test]
fn the_cone_ends_where_it_should() {
    // A small plate at 0.5 m that faces the sonar moves by 0.1 degrees per step, sideways and upwards.
    const PLATE_HALF_SIZE: Vec3 = [0.0005, 0.01, 0.01];
    let edge = 15.0 + 0.01f64.atan2(0.5).to_degrees();
    for (n, upwards) in [(4, false), (5, true), (8, false), (16, true)] {
        let angle = |i: usize| -20.0 + 0.1 * i as f64;
        let sweep =
            |i| before(n, 0.5, if upwards { [0.0, angle(i)] } else { [angle(i), 0.0] }, [0.0; 2], PLATE_HALF_SIZE);
        let plates: Vec<Plate> = (0..=400).map(sweep).collect();
        let lines = moved(&plates, &[n], "");
        let seen = |i: &usize| lines[*i].sensor(&path(n), "proximity.detected") == 1.0;
        let (first, last) = ((0..=400).find(seen).unwrap(), (0..=400).rev().find(seen).unwrap());
        println!("sonar {n}: from {:.1} to {:.1} degrees, {edge:.2} expected", angle(first), angle(last));
        assert!((angle(first) + edge).abs() < 0.5 && (angle(last) - edge).abs() < 0.5);
        assert!((first..=last).all(|i| seen(&i)), "the cone of sonar {n} has gaps");
    }
}
