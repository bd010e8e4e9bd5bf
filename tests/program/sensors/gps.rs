//! Tests of satellite receivers: the antenna's position and velocity, in the world and on Earth.

use crate::kit::*;

const ORIGIN: &str = "origin = { lat_deg = 48.1372, lon_deg = 11.5756, alt_m = 519.0 }\n";

fn receiver(parent: &str, keys: &str) -> String {
    format!("[[object]]\nkind = \"sensor\"\nalias = \"gps\"\nsensor = \"gps\"\n{parent}\n{keys}\n")
}

fn field<const N: usize>(line: &TraceLine, path: &str, name: &str) -> [f64; N] {
    let value = &line.0["readings"][path][format!("gps.{name}")];
    let all = match value.as_f64() {
        Some(x) => vec![x],
        None => numbers(value),
    };
    all.try_into().unwrap_or_else(|v| panic!("{name}: {v:?} in {}", line.0["readings"]))
}

#[test]
fn without_noise_the_position_is_the_mounts_to_the_last_bit() {
    let ball = "[[object]]\nkind = \"shape\"\nalias = \"ball\"\nprimitive = \"sphere\"\nsize_m = [0.2, 0.2, 0.2]\n\
        position_m = [1.25, -2.5, 10.0]\ndynamic = true\nmass_kg = 1.0\n";
    let place = TestFolder::scene(&format!("{ORIGIN}{ball}{}", receiver("parent = \"/ball\"", "")));
    let lines = place.trace(&["/ball", "/ball/gps"], &["--steps", "10"]);
    let mut before = 10.0;
    for line in &lines {
        let [x, y, z]: [f64; 3] = line.object("/ball", "position");
        assert_eq!(field(line, "/ball/gps", "position"), [x, y, z]);
        // The velocity is the distance travelled in the last step divided by 0.05 s.
        let [east, north, up] = field(line, "/ball/gps", "velocity");
        assert!(east == 0.0 && north == 0.0 && (up - (z - before) / 0.05).abs() < 1e-9, "{up}");
        assert_eq!(field(line, "/ball/gps", "valid"), [1.0]);
        before = z;
    }
    // The velocity of free fall in the middle of the tenth step is 9.81 m/s² · 0.475 s.
    let [_, _, up] = field(lines.last().unwrap(), "/ball/gps", "velocity");
    assert!((up + 4.66).abs() < 0.06, "{up}");
}

#[test]
fn an_antenna_is_at_its_offset() {
    // The mount is rotated by 90 degrees to the left, so its x axis points north, along the world's y axis.
    let keys = "position_m = [10.0, 20.0, 1.0]\norientation_deg = [0.0, 0.0, 90.0]\nantenna_m = [0.5, 0.0, 0.25]";
    let line = TestFolder::scene(&receiver("", keys)).trace(&["/gps"], &["--steps", "1"]).pop().unwrap();
    let found: [f64; 3] = field(&line, "/gps", "position");
    for (a, b) in found.into_iter().zip([10.0, 20.5, 1.25]) {
        assert!((a - b).abs() < 1e-12, "{found:?}");
    }
}

#[test]
fn the_worlds_origin_lies_where_the_scene_says() {
    let at = |origin: &str, position: &str| {
        let scene = format!("{origin}{}", receiver("", &format!("position_m = {position}")));
        let line = TestFolder::scene(&scene).trace(&["/gps"], &["--steps", "1"]).pop().unwrap();
        ["latitude", "longitude", "altitude"].map(|name| field::<1>(&line, "/gps", name)[0])
    };
    let [lat, lon, alt] = at(ORIGIN, "[0.0, 0.0, 0.0]");
    assert!((lat.to_degrees() - 48.1372).abs() < 1e-12 && (lon.to_degrees() - 11.5756).abs() < 1e-12);
    assert!((alt - 519.0).abs() < 1e-8);
    // EPSG guidance note 7-2, method 9837: in the plane at 55°N 5°E 200 m this point is 53°48'33.820"N 2°07'46.380"E 73
    // m.
    let [lat, lon, alt] =
        at("origin = { lat_deg = 55.0, lon_deg = 5.0, alt_m = 200.0 }\n", "[-189013.869, -128642.040, -4220.171]");
    assert!((lat.to_degrees() - (53.0 + 48.0 / 60.0 + 33.820 / 3600.0)).abs() < 3e-8, "{}", lat.to_degrees());
    assert!((lon.to_degrees() - (2.0 + 7.0 / 60.0 + 46.380 / 3600.0)).abs() < 3e-8, "{}", lon.to_degrees());
    assert!((alt - 73.0).abs() < 2e-3, "{alt}");
    // The default origin is the intersection of the Greenwich meridian and the equator.
    assert_eq!(at("", "[0.0, 0.0, 7.0]")[..2], [0.0, 0.0]);
}

#[test]
fn an_origin_that_is_not_on_earth_is_refused() {
    for (origin, words) in [
        ("origin = { lat_deg = 91.0 }\n", ["lat_deg", "1.57"]),
        ("origin = { lat = 48.0 }\n", ["`lat`", "lat_deg"]),
        ("origin = { height_m = 1.0 }\n", ["height_m", "[scene.origin]"]),
        ("origin = 3.0\n", ["origin", "[scene]"]),
    ] {
        TestFolder::scene(&format!("{origin}{}", receiver("", ""))).run(&["--steps", "1"]).refused(&words);
    }
}

/// Returns the trace of a resting receiver at (10, 20, 30).
fn resting(keys: &str, steps: &str) -> Vec<TraceLine> {
    let scene = format!("{ORIGIN}{}", receiver("", &format!("position_m = [10.0, 20.0, 30.0]\n{keys}")));
    TestFolder::scene(&scene).trace(&["/gps"], &["--steps", steps])
}

#[test]
fn v_reps_gps_has_a_constant_shift_and_varying_noise() {
    let lines = resting("preset = \"vrep_gps\"", "400");
    let truth = [10.0, 20.0, 30.0];
    let mut shifts = [0.0; 3];
    for (axis, (noise, shift)) in [(0.1, 1.0), (0.1, 1.0), (0.05, 0.5)].into_iter().enumerate() {
        let errors: Vec<f64> = lines.iter().map(|l| field::<3>(l, "/gps", "position")[axis] - truth[axis]).collect();
        let (low, high) = errors.iter().fold((f64::MAX, f64::MIN), |(a, b), e| (a.min(*e), b.max(*e)));
        // All 400 uniformly distributed numbers are within ±noise of the same shift, and their range is nearly 2 ·
        // noise.
        assert!(high - low <= 2.0 * noise + 1e-9 && high - low > 1.9 * noise, "axis {axis}: {low} to {high}");
        shifts[axis] = (low + high) / 2.0;
        assert!(shifts[axis].abs() <= shift + 1e-9 && shifts[axis] != 0.0, "axis {axis}: {}", shifts[axis]);
    }
    // The shifts are drawn separately for each axis.
    assert!((shifts[0] - shifts[1]).abs() > 1e-3 && (shifts[1] - shifts[2]).abs() > 1e-3, "{shifts:?}");
}

#[test]
fn latitude_and_longitude_are_those_of_the_noisy_position() {
    // One millionth of a radian is 6.4 m, so a noise of 10 m would be detected.
    let (lat, lon) = (48.1372_f64.to_radians(), 11.5756_f64.to_radians());
    let (a, f) = (6_378_137.0, 1.0 / 298.257_223_563);
    let e2: f64 = f * (2.0 - f);
    let bend = 1.0 - e2 * lat.sin().powi(2);
    let (along, across) = (a * (1.0 - e2) / bend.powf(1.5) + 519.0, (a / bend.sqrt() + 519.0) * lat.cos());
    let mut moved = 0.0_f64;
    for line in resting("noise = { position = { sigma = 10.0 } }", "20") {
        let [x, y, z]: [f64; 3] = field(&line, "/gps", "position");
        moved = moved.max((x - 10.0).abs());
        let ([north], [east]) = (field(&line, "/gps", "latitude"), field(&line, "/gps", "longitude"));
        assert!((north - lat - y / along).abs() < 1e-9 && (east - lon - x / across).abs() < 1e-9, "{north} {east}");
        let [up] = field(&line, "/gps", "altitude");
        assert!((up - 519.0 - z).abs() < 1e-3, "{up}");
    }
    assert!(moved > 5.0, "the positions have no noise: {moved}");
}

#[test]
fn without_a_fix_all_fields_are_zero() {
    let lines = resting("noise = { position = { dropout = 0.3, valid = \"valid\" } }", "100");
    let mut lost = 0;
    for line in &lines {
        let ([valid], position) = (field(line, "/gps", "valid"), field::<3>(line, "/gps", "position"));
        let [latitude] = field(line, "/gps", "latitude");
        match valid {
            0.0 => assert_eq!((position, latitude), ([0.0; 3], 0.0)),
            _ => assert!(position == [10.0, 20.0, 30.0] && latitude > 0.8, "{position:?} {latitude}"),
        }
        lost += usize::from(valid == 0.0);
    }
    assert!(lost > 10 && lost < 100, "{lost}");
}

#[test]
fn presets_measure_as_often_as_their_receivers() {
    for (preset, wanted) in [("ublox_m8", 2), ("ublox_6", 8), ("typical", 10), ("vrep_gps", 40)] {
        let lines = resting(&format!("preset = \"{preset}\""), "40");
        let mut positions: Vec<[f64; 3]> = lines.iter().map(|l| field(l, "/gps", "position")).collect();
        positions.dedup();
        assert_eq!(positions.len(), wanted, "{preset} in 2 s");
    }
}
