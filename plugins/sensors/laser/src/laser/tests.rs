use std::f64::consts::{FRAC_PI_2, PI};

use super::*;

fn settings() -> LaserSettings {
    LaserSettings {
        start_angle: -FRAC_PI_2,
        end_angle: FRAC_PI_2,
        beams: 181,
        elevations: vec![0.0],
        near: 0.0,
        min_range: 0.0,
        range: 10.0,
        none_as_max: false,
        full_intensity: 1.0,
        scan_time: 0.0,
        skip_own_model: false,
    }
}

#[test]
fn both_ends_are_measured_and_the_first_beam_is_the_rightmost() {
    let laser = LaserScanner::new(settings());
    assert_eq!(laser.angles.len(), 181);
    let degrees = |i: usize| laser.angles[i].0.to_degrees();
    for (i, wanted) in [(0, -90.0), (1, -89.0), (90, 0.0), (180, 90.0)] {
        assert!((degrees(i) - wanted).abs() < 1e-12, "{i}: {}", degrees(i));
    }
    // +x is to the left, +y up, +z ahead.
    let near = |d: [f64; 3], e: [f64; 3]| (0..3).all(|i| (d[i] - e[i]).abs() < 1e-12);
    assert!(near(laser.directions[0], [-1.0, 0.0, 0.0]));
    assert!(near(laser.directions[90], [0.0, 0.0, 1.0]));
    assert!(near(laser.directions[180], [1.0, 0.0, 0.0]));
}

#[test]
fn layers_lie_one_above_the_other() {
    let laser = LaserScanner::new(LaserSettings { beams: 3, elevations: vec![-0.1, 0.2], ..settings() });
    assert_eq!(laser.angles.iter().map(|a| a.1).collect::<Vec<_>>(), [-0.1, -0.1, -0.1, 0.2, 0.2, 0.2]);
    assert_eq!(laser.directions[4], [0.0, 0.2_f64.sin(), 0.2_f64.cos()]);
    for d in &laser.directions {
        assert!((d.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_single_beam_looks_along_the_first_angle() {
    let laser = LaserScanner::new(LaserSettings { beams: 1, start_angle: 0.5, end_angle: 0.5, ..settings() });
    assert_eq!(laser.angles, [(0.5, 0.0)]);
}

#[test]
fn the_strength_of_an_echo_follows_the_lidar_equation() {
    let laser = LaserScanner::new(settings());
    let ahead = [0.0, 0.0, 1.0];
    let tilted = |a: f64| [0.0, a.sin(), -a.cos()];
    let white = [255; 3];
    let strength = |r, normal, color| laser.echo(ahead, r, normal, color).intensity;
    assert_eq!(strength(1.0, tilted(0.0), white), 1.0);
    assert_eq!(strength(0.3, tilted(0.0), white), 1.0, "at most 1");
    assert_eq!(strength(2.0, tilted(0.0), white), 0.25, "1/r²");
    assert!((strength(1.0, tilted(PI / 3.0), white) - 0.5).abs() < 1e-12, "the cosine of 60 degrees");
    assert!((strength(1.0, tilted(0.0), [255, 0, 0]) - 1.0 / 3.0).abs() < 1e-12);
    assert!((laser.echo(ahead, 1.0, tilted(0.3), white).incidence - 0.3).abs() < 1e-12);
}

#[test]
fn surface_below_min_range_is_reported_as_no_hit() {
    let laser = LaserScanner::new(LaserSettings { min_range: 0.06, ..settings() });
    let echo = |r| laser.echo([0.0, 0.0, 1.0], r, [0.0, 0.0, -1.0], [255; 3]);
    assert_eq!(echo(0.059), Echo::NONE);
    assert_eq!(echo(0.06).distance, 0.06);
    assert_eq!(echo(f64::INFINITY), Echo::NONE);
}

#[test]
fn presets_have_the_beams_of_their_sheets() {
    // Preset, number of beams and step in degrees, from the sources that the presets cite: beams = field / step + 1.
    let sheets = [
        ("hokuyo_urg_04lx", 682, 360.0 / 1024.0),
        ("hokuyo_utm_30lx", 1081, 0.25),
        ("sick_lms200", 181, 1.0),
        ("sick_lms200_half_degree", 361, 0.5),
        ("sick_s300", 541, 0.5),
        ("velodyne_vlp16", 1808, 360.0 / 1808.0),
        ("vrep_laser_scanner_2d", 361, 0.5),
    ];
    let number = |preset: &Preset, key: &str| -> f64 {
        let line = preset.settings.lines().find_map(|l| l.strip_prefix(key)?.strip_prefix(" = "));
        line.unwrap_or_else(|| panic!("{}: {key}", preset.id)).parse().unwrap()
    };
    for (id, beams, step) in sheets {
        let preset = presets::ALL.iter().find(|p| p.id == id).unwrap();
        assert_eq!(number(preset, "rays") as usize, beams, "{id}");
        let field = number(preset, "end_angle_deg") - number(preset, "start_angle_deg");
        assert!((field / (beams - 1) as f64 - step).abs() < 1e-9, "{id}: {field}");
    }
    // The URG's front is step 384, which is beam 340, counted from step 44.
    let urg = &presets::ALL[0];
    assert!((number(urg, "start_angle_deg") + 340.0 * 360.0 / 1024.0).abs() < 1e-9);
}

#[test]
fn readme_names_every_parameter_field_and_preset() {
    let readme = include_str!("../../README.md");
    let quoted = |d: &dyn std::fmt::Debug| format!("{d:?}").split('"').nth(1).unwrap().to_owned();
    let all = (LaserScanner::params().into_iter().map(|p| quoted(&p)).collect::<Vec<_>>().into_iter())
        .chain(LaserScanner::fields().into_iter().map(|f| quoted(&f)))
        .chain(LaserScanner::PRESETS.iter().map(|p| p.id.to_owned()));
    for name in all {
        assert!(readme.contains(&format!("| `{name}`")), "{name}");
    }
}
