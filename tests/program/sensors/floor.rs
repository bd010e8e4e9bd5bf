//! Tests of floor sensors: lines, edges, distances.

use crate::kit::*;

/// A white floor with a black line of 20 mm along y.
const TRACK: &str = "[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\ncolor = [1, 1, 1]\n\
    [[object]]\nkind = \"shape\"\nalias = \"line\"\nsize_m = [0.02, 4, 0.001]\nposition_m = [0, 0, 0.0005]\ncolor = [0, 0, 0]\n";

/// Returns a sensor at a position that faces down, with its +x axis along that of the world.
fn array(at: [f64; 3], keys: &str) -> String {
    format!(
        "[[object]]\nkind = \"sensor\"\nalias = \"array\"\nsensor = \"floor\"\nposition_m = {at:?}\n\
         orientation_deg = [180.0, 0.0, 0.0]\n{keys}\n"
    )
}

fn seen(scene: &str) -> (Vec<f64>, Vec<f64>) {
    let line = TestFolder::scene(scene).trace(&["/array"], &["--steps", "1"]).pop().unwrap();
    let of = |field: &str| {
        let value = &line.0["readings"]["/array"][format!("reflectance.{field}")];
        value.as_f64().map_or_else(|| numbers(value), |x| vec![x])
    };
    (of("value"), of("detected"))
}

#[test]
fn spots_on_a_line_are_dark() {
    let five = "count = 5\npitch_m = 0.012";
    // The spots are at -0.024, -0.012, 0, 0.012 and 0.024 m from the sensor.
    let (values, detected) = seen(&format!("{TRACK}{}", array([0.0, 0.0, 0.01], five)));
    assert_eq!(values, [1.0, 1.0, 0.0, 1.0, 1.0]);
    assert_eq!(detected, values);
    let (values, _) = seen(&format!("{TRACK}{}", array([0.02, 0.0, 0.01], five)));
    assert_eq!(values, [0.0, 0.0, 1.0, 1.0, 1.0]);
    let chosen = "spots_m = [0.005, 0.1, 0.03, 0.0, -0.009, -0.2]";
    let (values, _) = seen(&format!("{TRACK}{}", array([0.0, 0.0, 0.01], chosen)));
    assert_eq!(values, [0.0, 1.0, 0.0]);
}

#[test]
fn wide_spots_see_the_share_of_the_line() {
    // Half of a spot of 20 mm is on the line.
    let keys = "diameter_m = 0.02\nrays = 256\nthreshold = 0.4";
    let (values, detected) = seen(&format!("{TRACK}{}", array([0.01, 0.0, 0.01], keys)));
    assert!((values[0] - 0.5).abs() < 0.02, "{values:?}");
    assert_eq!(detected, [1.0]);
    // A cone of 90 degrees is 20 mm wide on the floor, and the edge of the line is in its middle.
    let keys = "view_deg = 90.0\nrays = 256\nthreshold = 0.6";
    let (values, detected) = seen(&format!("{TRACK}{}", array([0.01, 0.0, 0.01], keys)));
    assert!((values[0] - 0.5).abs() < 0.04, "{values:?}");
    assert_eq!(detected, [0.0]);
}

#[test]
fn the_response_falls_with_the_distance_and_ends_at_the_range() {
    let grey = TRACK.replace("color = [1, 1, 1]", "color = [0.4, 0.4, 0.4]");
    for (height, value) in
        [(0.004, 1.0 - 0.7 / 4.0), (0.008, 1.0 - 0.7 / 2.0), (0.0159, 1.0 - 0.7 * 0.0159 / 0.016), (0.0161, 0.0)]
    {
        let keys = "preset = \"e_puck\"\nnoise = \"none\"";
        for (scene, share) in [(TRACK, 1.0), (&grey, 0.4)] {
            let (values, _) = seen(&format!("{scene}{}", array([1.0, 0.0, height], keys)));
            assert_eq!(values.len(), 3);
            // The tolerance is that of a colour with 8 bits.
            assert!(values.iter().all(|v| (v - share * value).abs() < 0.002), "{height}: {values:?}");
        }
    }
}

#[test]
fn noise_stays_within_the_scale() {
    let scene =
        format!("{TRACK}{}", array([0.0, 0.0, 0.01], "count = 64\nnoise.value = { sigma = 0.5 }\nthreshold = 0.9"));
    let (values, detected) = seen(&scene);
    assert!(values.iter().all(|v| (0.0..=1.0).contains(v)), "{values:?}");
    assert!(values.contains(&0.0) && values.contains(&1.0) && values.iter().any(|v| *v > 0.0 && *v < 1.0));
    for (value, detected) in values.iter().zip(detected) {
        assert_eq!(detected == 1.0, *value >= 0.9, "{value}");
    }
}

#[test]
fn lists_that_are_no_pairs_are_refused() {
    for (keys, words) in [
        ("spots_m = [0.1, 0.2, 0.3]", ["`spots`", "pairs"]),
        ("response = [0.01, 1.0, 0.0, 0.5]", ["`response`", "increasing"]),
        ("response = [0.01]", ["`response`", "pairs"]),
    ] {
        TestFolder::scene(&array([0.0; 3], keys)).run(&["--steps", "1"]).refused(&words);
    }
}
