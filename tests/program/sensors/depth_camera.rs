//! Tests of depth cameras against closed-form geometry: facing and slanted plates, a ball, parallel lines of sight.
//!
//! With f = (half the number of columns) / tan(half the angle), the pixel (column, row) of a pinhole camera has the
//! direction (-(column - cx) / f, (row - cy) / f, 1), where +z points forward, +y up and +x to the left. The depth is
//! the distance along z, not along the ray (`tests/facts/devices.md`).

use crate::kit::*;

const COLUMNS: usize = 64;
const ROWS: usize = 48;
/// Angle between the left and right edge of the image, degrees.
const ANGLE: f64 = 57.0;

/// Returns a camera at (0, 0, 1) that points along x with z up: its x is the world's y, its y the world's z.
fn camera(more: &str) -> String {
    format!(
        "[[object]]\nkind = \"sensor\"\nalias = \"eye\"\nsensor = \"depth_camera\"\nposition_m = [0, 0, 1]\n\
         orientation_deg = [0, 90, 90]\n{more}\n"
    )
}

fn small(more: &str) -> String {
    camera(&format!("columns = {COLUMNS}\nrows = {ROWS}\n{more}"))
}

/// Returns the depths that a scene's camera measures in one step, and the line of the trace.
fn depths(scene: &str) -> (Vec<f64>, TraceLine) {
    let mut lines = TestFolder::scene(scene).trace(&["/eye"], &["--steps", "1"]);
    let line = lines.remove(0);
    let all = line.0["readings"]["/eye"]["depth_image.depth"].as_array().unwrap();
    // JSON cannot represent infinity, so the trace contains null instead.
    (all.iter().map(|z| z.as_f64().unwrap_or(f64::INFINITY)).collect(), line)
}

/// Returns the slopes of a pixel's line of sight: x and y per metre of depth.
fn slopes(i: usize, columns: usize, rows: usize, degrees: f64) -> [f64; 2] {
    let f = columns.max(rows) as f64 / 2.0 / (degrees.to_radians() / 2.0).tan();
    let (c, r) = ((i % columns) as f64, (i / columns) as f64);
    [-(c - (columns as f64 - 1.0) / 2.0) / f, (r - (rows as f64 - 1.0) / 2.0) / f]
}

#[track_caller]
fn near(is: f64, wanted: f64, i: usize) {
    assert!((is - wanted).abs() <= 1e-3 * wanted, "pixel {i} reads {is} m, not {wanted} m");
}

/// The face of a plate with a thickness of 2 cm at 1.5 m has the depth 1.49 m in all of its pixels. Pixels beside it
/// have no depth.
#[test]
fn a_square_plate_is_as_far_everywhere() {
    let plate = cuboid("plate", [0.02, 1.0, 0.8], [1.5, 0.0, 1.0], "");
    let (z, line) = depths(&format!("{}{plate}", small("")));
    assert_eq!(z.len(), COLUMNS * ROWS);
    let mut seen = 0;
    for (i, z) in z.iter().enumerate() {
        let [x, y] = slopes(i, COLUMNS, ROWS, ANGLE);
        if (x * 1.49).abs() < 0.499 && (y * 1.49).abs() < 0.399 {
            near(*z, 1.49, i);
            seen += 1;
        } else if (x * 1.49).abs() > 0.501 || (y * 1.49).abs() > 0.401 {
            assert!(z.is_infinite(), "pixel {i} beside the plate reads {z}");
        }
    }
    assert!(seen > 900, "{seen}");
    let reading = &line.0["readings"]["/eye"];
    assert_eq!(numbers(&reading["depth_image.limits"]), [0.01, 3.5]);
    let f = 32.0 / (ANGLE.to_radians() / 2.0).tan();
    let k = numbers(&reading["depth_image.intrinsics"]);
    assert!((k[0] - f).abs() < 1e-9 && (k[1] - f).abs() < 1e-9 && k[2..] == [31.5, 23.5], "{k:?}");
}

/// The plate is rotated by 40 degrees about the vertical. Its front is the plane n . p = d, so the depth is
/// z = d / (n . (sx, sy, 1)).
#[test]
fn a_slanted_plate() {
    let turn = 40_f64.to_radians();
    let plate = cuboid("plate", [0.02, 12.0, 12.0], [2.0, 0.0, 1.0], "orientation_deg = [0, 0, 40]");
    let (z, _) = depths(&format!("{}{plate}", small("far_m = 10.0")));
    // The face towards the camera has the outward normal (-cos, -sin) in the world's x and y, and is 1 cm in front of
    // the centre of the plate.
    let distance = 2.0 * turn.cos() - 0.01;
    for (i, z) in z.iter().enumerate() {
        let [left, _] = slopes(i, COLUMNS, ROWS, ANGLE);
        near(*z, distance / (turn.cos() + left * turn.sin()), i);
    }
}

/// For a ball of 0.5 m in front of a plate, the depth is the smaller root of |z s - m| = r, or that of the plate if
/// there is no root.
#[test]
fn a_ball() {
    let ball = "[[object]]\nkind = \"shape\"\nalias = \"ball\"\nprimitive = \"sphere\"\nsize_m = [1, 1, 1]\n\
                position_m = [2, 0.2, 1.1]\n";
    let plate = cuboid("plate", [0.02, 9.0, 9.0], [3.0, 0.0, 1.0], "");
    let (z, _) = depths(&format!("{}{ball}{plate}", small("")));
    let (mut on, mut off, mut edge) = (0, 0, 0);
    for (i, z) in z.iter().enumerate() {
        let [x, y] = slopes(i, COLUMNS, ROWS, ANGLE);
        let (a, b, c) = (x * x + y * y + 1.0, 0.2 * x + 0.1 * y + 2.0, 0.04 + 0.01 + 4.0 - 0.25);
        let root = b * b - a * c;
        if root.abs() < 2e-3 {
            edge += 1;
        } else if root > 0.0 {
            near(*z, (b - root.sqrt()) / a, i);
            on += 1;
        } else {
            near(*z, 2.99, i);
            off += 1;
        }
    }
    assert!(on > 300 && off > 1000 && edge < 100, "{on} {off} {edge}");
}

/// A camera with parallel lines of sight, 32 x 16 pixels of 5 cm, measures a plate that is 60 cm wide and 40 cm high.
#[test]
fn parallel_lines_of_sight() {
    let plate = cuboid("plate", [0.02, 0.6, 0.4], [1.0, 0.1, 1.0], "");
    let (z, line) = depths(&format!("{}{plate}", camera("columns = 32\nrows = 16\northo_size_m = 1.6")));
    for (i, z) in z.iter().enumerate() {
        let (left, up) = ((15.5 - (i % 32) as f64) * 0.05, ((i / 32) as f64 - 7.5) * 0.05);
        if (left - 0.1).abs() < 0.3 && up.abs() < 0.2 {
            near(*z, 0.99, i);
        } else {
            assert!(z.is_infinite(), "pixel {i} at {left} {up} reads {z}");
        }
    }
    assert_eq!(line.sensor("/eye", "depth_image.parallel"), 1.0);
}

/// The near and far limits are planes. A camera measures visible objects, whether they are detectable or not.
#[test]
fn range_limits_are_planes_and_only_visibility_counts() {
    let three = [(0.4, "visible = true"), (0.8, "visible = false"), (1.2, "detectable = false"), (2.0, "")];
    let plates: Vec<String> = three
        .iter()
        .enumerate()
        .map(|(i, (x, more))| cuboid(&format!("plate{i}"), [0.02, 6.0, 6.0], [*x, 0.0, 1.0], more))
        .collect();
    let plates = plates.join("");
    let all = |more: &str, wanted: f64| {
        let (z, _) = depths(&format!("{}{plates}", small(more)));
        z.iter().enumerate().for_each(|(i, z)| near(*z, wanted, i));
    };
    all("", 0.39);
    all("near_m = 0.5", 1.19);
    all("near_m = 1.5", 1.99);
    let (z, _) = depths(&format!("{}{plates}", small("near_m = 1.5\nfar_m = 1.9")));
    assert!(z.iter().all(|z| z.is_infinite()));
    let (z, _) = depths(&format!("{}{plates}", small("near_m = 1.5\nfar_m = 1.9\nempty = \"zero\"")));
    assert!(z.iter().all(|z| *z == 0.0));
}

/// With a projected pattern, surfaces that the pattern does not reach, or that are too slanted or too close, have no
/// depth.
#[test]
fn structured_light_loses_shadowed_slanted_and_close_surfaces() {
    let post = cuboid("post", [0.02, 0.2, 3.0], [1.01, 0.0, 1.0], "");
    let wall = cuboid("wall", [0.02, 9.0, 9.0], [2.01, 0.0, 1.0], "");
    let row = |more: &str| {
        let (z, _) = depths(&format!("{}{post}{wall}", small(more)));
        z[24 * COLUMNS..25 * COLUMNS].to_vec()
    };
    let ideal = row("");
    let left = ideal.iter().position(|z| *z < 1.5).unwrap();
    // The shadow is f * offset * (1 / near - 1 / far) wide: with f = 58.93 pixels, 0.1 m, 1 m and 2 m, it covers 2.9
    // pixels to the left of the post.
    let lit = row("projector_m = -0.1");
    let dark: Vec<usize> = (0..COLUMNS).filter(|c| lit[*c] == 0.0).collect();
    assert!((2..=3).contains(&dark.len()) && dark.last() == Some(&(left - 1)), "{dark:?} left of {left}");
    let far = row("noise = { depth = { limits = [1.5, 9.0] } }");
    assert!(far.iter().zip(&ideal).all(|(z, ideal)| *z == if *ideal < 1.5 { 0.0 } else { *ideal }), "{far:?}");
    // At 20 degrees from the middle, the incidence on the wall is 20 degrees.
    let slanted = row("max_incidence_deg = 20");
    for (c, z) in slanted.iter().enumerate() {
        let [x, y] = slopes(24 * COLUMNS + c, COLUMNS, ROWS, ANGLE);
        let incidence = (1.0 / (1.0 + x * x + y * y).sqrt()).acos().to_degrees();
        assert_eq!(*z == 0.0, incidence > 20.0, "column {c}: {incidence} degrees");
    }
}

/// A camera without noise also measures points, which are the ends of the lines of sight.
#[test]
fn points_without_noise() {
    let wall = cuboid("wall", [0.02, 9.0, 9.0], [2.01, 0.0, 1.0], "");
    let (z, line) = depths(&format!("{wall}{}", small("points = true")));
    let points = numbers(&line.0["readings"]["/eye"]["depth_image.points"]);
    assert_eq!(points.len(), 3 * z.len());
    for (i, z) in z.iter().enumerate() {
        let [x, y] = slopes(i, COLUMNS, ROWS, ANGLE);
        assert!((z - 2.0).abs() < 1e-5, "pixel {i}: {z} m");
        assert!((0..3).all(|k| (points[3 * i + k] - [x * z, y * z, *z][k]).abs() < 1e-5), "pixel {i}");
    }
}

/// Points are the ends of the lines of sight, with the noise of the depths; the wall's incidence is the angle to the
/// axis.
#[test]
fn points_and_angles_of_incidence() {
    let wall = cuboid("wall", [0.02, 9.0, 9.0], [2.01, 0.0, 1.0], "");
    let (z, line) = depths(&format!(
        "{wall}{}",
        small(
            "color = false\npoints = true\nincidence = true\nnoise = { depth = { sigma = [0.01], limits = [1.99, 9.0] } }"
        )
    ));
    let reading = &line.0["readings"]["/eye"];
    let (points, angles) = (numbers(&reading["depth_image.points"]), numbers(&reading["depth_image.incidence"]));
    assert_eq!((points.len(), angles.len()), (3 * z.len(), z.len()));
    assert!(numbers(&reading["color_image.rgb"]).is_empty());
    let (mut lost, mut off) = (0, 0);
    for (i, z) in z.iter().enumerate() {
        let [x, y] = slopes(i, COLUMNS, ROWS, ANGLE);
        let angle = (1.0 / (1.0 + x * x + y * y).sqrt()).acos();
        assert!((angles[i] - angle).abs() < 2e-3, "pixel {i}: {} rad, not {angle}", angles[i]);
        let wanted = [x * z, y * z, *z];
        assert!((0..3).all(|k| (points[3 * i + k] - wanted[k]).abs() < 1e-5), "pixel {i}");
        lost += usize::from(*z == 0.0);
        off += usize::from((z - 2.0).abs() > 1e-4 && *z != 0.0);
    }
    // A depth is more than one standard deviation below the mean in 16 % of 3072 pixels.
    assert!((400..580).contains(&lost) && off > 2000, "{lost} {off}");
}

/// The presets of the Kinects have their declared effects in front of a wall.
#[test]
fn kinects() {
    let wall = cuboid("wall", [0.02, 20.0, 20.0], [2.01, 0.0, 1.0], "");
    for (preset, far, sigma) in
        [("kinect_v1", 4.0, 1.425e-3 * 4.0_f64), ("kinect_v2", 4.5, 1.5e-3 - 1e-3 + 0.3e-3 * 4.0)]
    {
        let eye = camera(&format!("preset = \"{preset}\"\ncolumns = 64\nrows = 48"));
        let (z, line) = depths(&format!("{wall}{eye}"));
        assert_eq!(numbers(&line.0["readings"]["/eye"]["depth_image.limits"])[0], 0.01);
        let seen: Vec<f64> = z.iter().copied().filter(|z| *z > 0.0).collect();
        assert!(seen.len() > 2500, "{preset}: {}", seen.len());
        let n = seen.len() as f64;
        let mean = seen.iter().sum::<f64>() / n;
        let spread = (seen.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / n).sqrt();
        // Rounding to steps of 2.85e-3 z^2 adds a twelfth of their square to the variance.
        let steps = if preset == "kinect_v1" { 2.85e-3 * 4.0 / 12_f64.sqrt() } else { 0.0 };
        let wanted = sigma.hypot(steps);
        assert!((mean - 2.0).abs() < 3.0 * wanted / n.sqrt() + 1e-3, "{preset}: {mean}");
        assert!((spread / wanted - 1.0).abs() < 0.08, "{preset}: {spread}, not {wanted}");
        // A surface beyond the range is visible, but not measured.
        let wall = cuboid("wall", [0.02, 40.0, 40.0], [far + 0.5, 0.0, 1.0], "");
        let (z, _) = depths(&format!("{wall}{eye}"));
        assert!(z.iter().all(|z| *z == 0.0), "{preset}");
    }
}

/// Light is white, so the colour channels of a surface keep their ratios. A larger y is on the left.
#[test]
fn colours_of_plates() {
    let left = cuboid("left", [0.02, 2.0, 2.0], [1.0, 1.0, 2.0], "color = [0.8, 0.4, 0.0]");
    let right = cuboid("right", [0.02, 2.0, 2.0], [1.0, -1.0, 2.0], "color = [0.0, 0.25, 0.5]");
    let (_, line) = depths(&format!("{left}{right}{}", small("background = [0.2, 0.4, 0.6]")));
    let bytes = line.0["readings"]["/eye"]["color_image.rgb"].to_string();
    let rgb = numbers(&line.0["readings"]["/eye"]["color_image.rgb"]);
    assert_eq!(rgb.len(), 3 * COLUMNS * ROWS, "{}", &bytes[..bytes.len().min(80)]);
    for (i, p) in rgb.chunks(3).enumerate() {
        let (c, r) = (i % COLUMNS, i / COLUMNS);
        if r < ROWS / 2 {
            assert_eq!(p, [51.0, 102.0, 153.0], "pixel {i}, below the plates");
        } else if c < COLUMNS / 2 {
            assert!(p[0] > 60.0 && (p[0] - 2.0 * p[1]).abs() <= 1.0 && p[2] == 0.0, "pixel {i}: {p:?}");
        } else {
            assert!(p[2] > 40.0 && (p[2] - 2.0 * p[1]).abs() <= 1.0 && p[0] == 0.0, "pixel {i}: {p:?}");
        }
    }
}

/// The same scene gives the same bytes with one thread and with two, and two images of it are equal.
#[test]
fn images_do_not_depend_on_threads() {
    let scene = format!(
        "{}{}{}",
        small("lateral_sigma = 1.0\nedges = \"mixed\""),
        cuboid("post", [0.1, 0.3, 3.0], [1.2, 0.1, 1.0], "orientation_deg = [0, 10, 30]"),
        cuboid("wall", [0.02, 9.0, 9.0], [2.5, 0.0, 1.0], "")
    );
    let place = TestFolder::scene(&scene);
    let read =
        |threads: &str| place.trace(&["/eye"], &["--steps", "3", "--threads", threads])[2].0["readings"].to_string();
    let one = read("1");
    assert_eq!(one, read("2"));
    assert_eq!(one, read("1"));
}

#[test]
fn presets_are_listed_and_refusals_name_the_keys() {
    let refused = |more: &str, words: &[&str]| TestFolder::scene(&camera(more)).run(&["--steps", "1"]).refused(words);
    refused("far_m = 0.001", &["far", "near"]);
    refused("edges = \"soft\"", &["edges"]);
    refused("columns = 0", &["columns"]);
}
