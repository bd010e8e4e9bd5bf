//! Tests of laser scanners against the geometry of a rectangular room.

use std::f64::consts::PI;

use crate::kit::*;

/// Returns a room with white walls, whose inner sides are at x = ±4 m and y = ±3 m.
fn room() -> String {
    let white = "color = [1.0, 1.0, 1.0]";
    [
        cuboid("front", [0.2, 7.0, 2.0], [4.1, 0.0, 1.0], white),
        cuboid("back", [0.2, 7.0, 2.0], [-4.1, 0.0, 1.0], white),
        cuboid("left", [9.0, 0.2, 2.0], [0.0, 3.1, 1.0], white),
        cuboid("right", [9.0, 0.2, 2.0], [0.0, -3.1, 1.0], white),
    ]
    .concat()
}

/// Returns the scanner, 0.5 m above the origin. It faces along the world's x axis: its +z points forward, +y up, +x
/// left.
fn scanner(keys: &str) -> String {
    format!(
        "[[object]]\nkind = \"sensor\"\nalias = \"eye\"\nsensor = \"laser\"\nposition_m = [0.0, 0.0, 0.5]\n\
         quaternion = [0.5, 0.5, 0.5, 0.5]\n{keys}\n"
    )
}

/// Returns the distance to the wall of the room at an azimuth (from x, rad), and the incidence there (rad).
fn wall(azimuth: f64) -> (f64, f64) {
    let (s, c) = azimuth.sin_cos();
    let (x, y) = (4.0 / c.abs(), 3.0 / s.abs());
    (x.min(y), if x < y { c.abs().acos() } else { s.abs().acos() })
}

/// Returns a field of the scanner in the last line of a trace; non-finite values are infinity.
fn field(line: &TraceLine, name: &str) -> Vec<f64> {
    let value = &line.0["readings"]["/eye"][format!("range_scan.{name}")];
    let all = value.as_array().unwrap_or_else(|| panic!("no {name}: {}", line.0["readings"]));
    all.iter().map(|v| v.as_f64().unwrap_or(f64::INFINITY)).collect()
}

fn scan(scene: &str) -> TraceLine {
    let place = TestFolder::scene(scene);
    place.trace(&["/eye"], &["--steps", "2"]).pop().unwrap()
}

#[test]
fn a_scan_of_a_room_has_its_walls() {
    let line = scan(&format!(
        "{}{}",
        room(),
        scanner("start_angle_deg = -180.0\nend_angle_deg = 179.0\nrays = 360\nrange_m = 20.0\nmin_range_m = 0.1")
    ));
    let (angle, distance) = (field(&line, "angle"), field(&line, "distance"));
    let (incidence, intensity) = (field(&line, "incidence"), field(&line, "intensity"));
    assert_eq!([angle.len(), distance.len(), incidence.len(), intensity.len()], [360; 4]);
    for i in 0..360 {
        let azimuth = (i as f64 - 180.0) * PI / 180.0;
        assert!((angle[i] - azimuth).abs() < 1e-12);
        let (wanted, slant) = wall(azimuth);
        assert!((distance[i] - wanted).abs() < 1e-6, "beam {i}: {} m instead of {wanted} m", distance[i]);
        assert!((incidence[i] - slant).abs() < 1e-6, "beam {i}: {} rad instead of {slant}", incidence[i]);
        // The intensity of a white surface is the cosine of the incidence divided by the square of the distance.
        let strength = slant.cos() / (wanted * wanted);
        assert!((intensity[i] - strength).abs() < 1e-6, "beam {i}: {} instead of {strength}", intensity[i]);
    }
    assert_eq!(field(&line, "limits"), [0.1, 20.0]);
    assert_eq!(field(&line, "elevation"), [0.0; 360]);
}

#[test]
fn a_scan_begins_at_the_right_and_angles_grow_to_the_left() {
    // One post is 2 m ahead and 1 m to the left (+y), and another is behind. The scan of 180 degrees covers only the
    // first.
    let posts =
        [cuboid("post", [0.2, 0.2, 1.0], [2.0, 1.0, 0.5], ""), cuboid("behind", [0.2, 0.2, 1.0], [-2.0, 1.0, 0.5], "")];
    let line = scan(&format!("{}{}", posts.concat(), scanner("")));
    let (angle, distance) = (field(&line, "angle"), field(&line, "distance"));
    assert!((angle[0] + PI / 2.0).abs() < 1e-12 && (angle[180] - PI / 2.0).abs() < 1e-12);
    let seen: Vec<f64> = (0..181).filter(|i| distance[*i].is_finite()).map(|i| angle[i]).collect();
    // The outermost visible corners of the post are (2.1, 0.9) and (1.9, 1.1).
    let (right, left) = ((0.9_f64 / 2.1).atan(), (1.1_f64 / 1.9).atan());
    assert!(!seen.is_empty() && seen.iter().all(|a| *a > right && *a < left), "{seen:?}");
    assert_eq!(seen.len(), ((left.to_degrees().floor()) - right.to_degrees().ceil()) as usize + 1);
}

#[test]
fn layers_meet_a_wall_where_their_elevation_says() {
    let keys = "start_angle_deg = -10.0\nend_angle_deg = 10.0\nrays = 3\nlayers = 3\nvertical_field_deg = 20.0";
    let line = scan(&format!("{}{}", room(), scanner(keys)));
    let (distance, elevation) = (field(&line, "distance"), field(&line, "elevation"));
    for (i, wanted) in [-10.0, -10.0, -10.0, 0.0, 0.0, 0.0, 10.0, 10.0, 10.0_f64].into_iter().enumerate() {
        assert!((elevation[i] - wanted.to_radians()).abs() < 1e-12);
        let azimuth = [-10.0, 0.0, 10.0_f64][i % 3].to_radians();
        // The wall ahead is 4 m away and 2 m high. There is no floor, so beams that pass below the wall hit nothing.
        let along = 4.0 / (azimuth.cos() * wanted.to_radians().cos());
        let height = 0.5 + along * wanted.to_radians().sin();
        if (0.0..=2.0).contains(&height) {
            assert!((distance[i] - along).abs() < 1e-6, "beam {i}: {} m instead of {along} m", distance[i]);
        } else {
            assert!(distance[i].is_infinite(), "beam {i}: {} m below the walls", distance[i]);
        }
    }
}

#[test]
fn beams_without_an_echo_read_infinity_or_the_range() {
    // A post 0.3 m ahead, a wall 4 m ahead.
    let post = cuboid("post", [0.1, 0.1, 1.0], [0.35, 0.0, 0.5], "");
    let ahead = "start_angle_deg = 0.0\nend_angle_deg = 90.0\nrays = 2\nrange_m = 3.5\n";
    let first_two = |keys: &str| {
        let line = scan(&format!("{}{post}{}", room(), scanner(&format!("{ahead}{keys}"))));
        (field(&line, "distance"), field(&line, "intensity"))
    };
    let near = |d: &[f64], wanted: [f64; 2]| d.iter().zip(wanted).all(|(a, b)| *a == b || (a - b).abs() < 1e-6);
    assert!(near(&first_two("").0, [0.3, 3.0]));
    // The post is too close to give a reading, and also hides the wall behind it.
    let (distance, intensity) = first_two("min_range_m = 0.31");
    assert!(near(&distance, [f64::INFINITY, 3.0]) && intensity[0] == 0.0, "{distance:?}");
    assert!(near(&first_two("min_range_m = 0.31\nnone_as_max = true").0, [3.5, 3.0]));
    // If the beams start behind the post, they do not hit it, and the wall at 4 m is beyond the range.
    assert!(near(&first_two("near_m = 0.45").0, [f64::INFINITY, 3.0]));
}

#[test]
fn settings_that_cannot_be_are_refused_by_name() {
    for (keys, words) in [
        ("start_angle_deg = 10.0\nend_angle_deg = -10.0", ["`end_angle`", "greater"]),
        ("rays = 1000000\nlayers = 100", ["16777216", "in total"]),
        ("min_range_m = 11.0", ["`range`", "`min_range`"]),
        ("full_intensity_m = 0.0", ["`full_intensity`", "more than 0"]),
        ("elevations_deg = [0.0, 100.0]", ["elevations_deg", "1.57"]),
    ] {
        TestFolder::scene(&scanner(keys)).run(&["--steps", "1"]).refused(&words);
    }
}

#[test]
fn v_reps_hokuyo_is_wrong_by_at_most_a_centimetre() {
    let line = scan(&format!("{}{}", room(), scanner("preset = \"vrep_hokuyo_urg_04lx_ug01\"")));
    let (angle, distance) = (field(&line, "angle"), field(&line, "distance"));
    assert_eq!(distance.len(), 684);
    let errors: Vec<f64> = (0..684).map(|i| distance[i] - wall(angle[i]).0).collect();
    assert!(errors.iter().all(|e| e.abs() <= 0.01 + 1e-9), "{errors:?}");
    // The errors are uniformly distributed with a standard deviation of 10 mm / √3 = 5.77 mm. From 684 samples, the
    // standard deviation can be estimated to about 2 %, and the mean to 0.22 mm.
    let mean = errors.iter().sum::<f64>() / 684.0;
    let sigma = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / 684.0).sqrt();
    assert!(mean.abs() < 1e-3 && (sigma - 0.01 / 3_f64.sqrt()).abs() < 5e-4, "{mean} {sigma}");
}

#[test]
fn a_real_hokuyo_measures_whole_millimetres_ten_times_a_second() {
    let place = TestFolder::scene(&format!("{}{}", room(), scanner("preset = \"hokuyo_urg_04lx\"")));
    let lines = place.trace(&["/eye"], &["--steps", "8"]);
    let scans: Vec<Vec<f64>> = lines.iter().map(|l| field(l, "distance")).collect();
    // A step is 50 ms, so each scan remains unchanged for two steps.
    let changes: Vec<bool> = scans.windows(2).map(|w| w[0] != w[1]).collect();
    assert_eq!(changes.iter().filter(|c| **c).count(), 3, "{changes:?}");
    assert!(!changes.windows(2).any(|w| w[0] && w[1]), "{changes:?}");
    let angle = field(&lines[0], "angle");
    assert_eq!(angle.len(), 682);
    // Step 384 of 1024 is ahead, and the first that is measured is step 44.
    assert!(angle[340].abs() < 1e-9 && (angle[0] + 340.0 * 2.0 * PI / 1024.0).abs() < 1e-9);
    for (i, d) in scans[0].iter().enumerate().filter(|(_, d)| d.is_finite()) {
        assert!((d * 1000.0 - (d * 1000.0).round()).abs() < 1e-6, "beam {i}: {d} m");
        let (wanted, _) = wall(angle[i]);
        if wanted < 4.0 {
            // The tolerance is six standard deviations of at most 14 mm.
            assert!((d - wanted).abs() < 0.084, "beam {i}: {d} m instead of {wanted} m");
        }
    }
}

#[test]
fn presets_without_noise_are_exact() {
    for (preset, rays) in [("vrep_laser_scanner_2d", 361), ("sick_s300", 541)] {
        let line = scan(&format!("{}{}", room(), scanner(&format!("preset = \"{preset}\""))));
        let (angle, distance) = (field(&line, "angle"), field(&line, "distance"));
        assert_eq!(distance.len(), rays, "{preset}");
        for (i, d) in distance.iter().enumerate() {
            assert!((d - wall(angle[i]).0).abs() < 1e-6, "{preset} beam {i}: {d}");
        }
    }
}

#[test]
fn the_velodyne_has_sixteen_layers_all_around() {
    let line = scan(&format!("{}{}", room(), scanner("preset = \"velodyne_vlp16\"\nnoise = \"none\"")));
    let (angle, elevation) = (field(&line, "angle"), field(&line, "elevation"));
    assert_eq!(angle.len(), 16 * 1808);
    for layer in 0..16 {
        // tests/facts/devices.md: sorted, the angles are -15, -13 ... 15 degrees.
        let wanted = (2.0 * layer as f64 - 15.0).to_radians();
        assert!((elevation[layer * 1808] - wanted).abs() < 1e-9, "layer {layer}: {}", elevation[layer * 1808]);
        assert_eq!(angle[layer * 1808..][..1808], angle[..1808]);
    }
    // The layer at 1 degree above the horizontal hits the wall ahead. A single hit there is tested.
    let ahead = 8 * 1808 + 904;
    assert!(angle[ahead].abs() < 1e-9);
    let distance = field(&line, "distance")[ahead];
    assert!((distance - 4.0 / 1_f64.to_radians().cos()).abs() < 1e-6, "{distance}");
}

#[test]
fn lost_beams_have_no_strength_and_read_as_the_range_where_asked() {
    let keys = "rays = 1000\nrange_m = 9.0\nnone_as_max = true\nnoise = { distance = { dropout = 0.5 } }";
    let line = scan(&format!("{}{}", room(), scanner(keys)));
    let (distance, intensity) = (field(&line, "distance"), field(&line, "intensity"));
    let lost: Vec<usize> = (0..1000).filter(|i| distance[*i] == 9.0).collect();
    // Half of the beams are lost: 500 with a standard deviation of 16. The tolerance is five standard deviations.
    assert!((420..=580).contains(&lost.len()), "{}", lost.len());
    for i in 0..1000 {
        assert_eq!(intensity[i] == 0.0, lost.contains(&i), "beam {i}: {} m, {}", distance[i], intensity[i]);
    }
}

#[test]
fn a_slow_scan_is_distorted_by_the_motion_of_the_robot() {
    // The mount drives ahead at 2 m/s towards the wall at x = 4, along beams at -60, 0 and 60 degrees, 0.1 s apart.
    let keys = "start_angle_deg = -60.0\nend_angle_deg = 60.0\nrays = 3\nscan_time_s = 0.2";
    let drive = "script = { language = \"lua\", text = \"\"\"\nfunction sysCall_init() n = 0 end\n\
        function sysCall_actuation() n = n + 1 sim.setObjectPosition(sim.getObject('/eye'), {0.1 * n, 0, 0.5}) end\n\"\"\" }";
    let place = TestFolder::scene(&format!("{}{}", room(), scanner(&format!("{keys}\n{drive}"))));
    let line = place.trace(&["/eye"], &["--steps", "5"]).pop().unwrap();
    let x = line.object::<3>("/eye", "position")[0];
    assert!((x - 0.5).abs() < 1e-9, "{x}");
    let distance = field(&line, "distance");
    // The beams were sent 0.2, 0.1 and 0 s ago, from positions 0.4, 0.2 and 0 m further back. Those at 60 degrees hit
    // the side walls.
    let beside = 3.0 / 60_f64.to_radians().sin();
    for (found, wanted) in distance.iter().zip([beside, 4.0 - (x - 0.2), beside]) {
        assert!((found - wanted).abs() < 1e-6, "{distance:?}: {wanted} m");
    }
}

#[test]
fn glass_is_detected_by_sonars_and_not_by_lasers() {
    // The mask 16 makes an object detectable by ultrasonic sensors only.
    let pane = cuboid("pane", [0.02, 1.0, 1.0], [1.01, 0.0, 0.5], "detectable_mask = 16");
    let sonar = "[[object]]\nkind = \"sensor\"\nalias = \"sonar\"\nsensor = \"proximity\"\nwaves = \"ultrasonic\"\n\
        range_m = 5.0\nposition_m = [0.0, 0.0, 0.5]\nquaternion = [0.5, 0.5, 0.5, 0.5]\n";
    let infrared = sonar.replace("\"sonar\"", "\"infrared\"").replace("ultrasonic", "infrared");
    let any = sonar.replace("\"sonar\"", "\"any\"").replace("waves = \"ultrasonic\"\n", "");
    let scene = format!("{}{pane}{}{sonar}{infrared}{any}", room(), scanner("rays = 1\nstart_angle_deg = 0.0"));
    let line =
        TestFolder::scene(&scene).trace(&["/eye", "/sonar", "/infrared", "/any"], &["--steps", "2"]).pop().unwrap();
    let seen = |path: &str| line.sensor(path, "proximity.distance");
    assert!((seen("/sonar") - 1.0).abs() < 1e-6 && (seen("/any") - 1.0).abs() < 1e-6);
    assert!((seen("/infrared") - 4.0).abs() < 1e-6, "{}", seen("/infrared"));
    let value = &line.0["readings"]["/eye"]["range_scan.distance"];
    let laser = value.as_f64().unwrap_or_else(|| numbers(value)[0]);
    assert!((laser - 4.0).abs() < 1e-6, "{laser}");
}
