use std::f64::consts::PI;

use tatu_plugin_api::{abi::*, safe::Form};

use super::*;

fn cone() -> Settings {
    Settings {
        volume: "cone".into(),
        range: 1.0,
        near: 0.0,
        min_range: 0.05,
        angle: PI / 6.0,
        gap: 0.0,
        size_near: [0.1, 0.2],
        size_far: [0.3, 0.4],
        radius_near: 0.1,
        radius_far: 0.2,
        height: 0.05,
        samples: 20,
        samples_needed: 1,
        max_incidence: PI / 4.0,
        front_faces: true,
        back_faces: true,
        occlusion: false,
        waves: "any".into(),
        skip_own_model: false,
    }
}

fn of(volume: &str) -> Settings {
    Settings { volume: volume.into(), ..cone() }
}

fn at(distance: f64) -> Option<Echo> {
    Some(Echo { distance, point: [0.0, 0.0, distance], normal: [0.0, 0.0, -1.0], object: 7 })
}

#[test]
fn a_cone_has_half_its_opening_angle_to_each_side() {
    let made = cone().check().unwrap();
    assert_eq!(
        made.beams,
        Beams {
            form: Form::Cone { half_angle: PI / 12.0 },
            near: 0.0,
            far: 1.0,
            max_incidence: PI / 4.0,
            skip_own_model: false,
            faces: (true, true),
            ..Beams::default()
        }
    );
}

#[test]
fn a_cone_may_open_to_the_whole_sphere() {
    let half = |angle| match (Settings { angle, ..cone() }).check().unwrap().beams.form {
        Form::Cone { half_angle } => half_angle,
        other => panic!("{other:?}"),
    };
    assert_eq!(half(TAU), PI);
    assert_eq!(half(360.0_f64.to_radians()), PI);
    assert_eq!(half(3.0), 1.5);
}

#[test]
fn a_ray_looks_along_z_whatever_its_angle() {
    let ray = Settings { volume: "ray".into(), angle: 0.0, ..cone() };
    assert_eq!(ray.check().unwrap().beams.form, Form::Rays(vec![[0.0, 0.0, 1.0]]));
}

#[test]
fn a_detection_nearer_than_the_threshold_is_dropped_whole() {
    assert_eq!(reported(at(0.049), 0.05), None);
    assert_eq!(reported(at(0.05), 0.05), at(0.05));
    assert_eq!(reported(at(0.0), 0.0), at(0.0));
}

#[test]
fn nothing_is_reported_when_nothing_is_met() {
    assert_eq!(reported(None, 0.0), None);
    assert_eq!(reported(at(f64::INFINITY), 0.0), None);
    assert_eq!(reported(at(f64::NAN), 0.0), None);
}

#[test]
fn settings_that_cannot_see_are_refused() {
    let bad = [
        Settings { range: 0.0, ..cone() },
        Settings { range: f64::NAN, ..cone() },
        Settings { range: f64::INFINITY, ..cone() },
        Settings { near: -0.1, ..cone() },
        Settings { near: 1.0, ..cone() },
        Settings { min_range: -0.1, ..cone() },
        Settings { angle: 0.0, ..cone() },
        Settings { angle: 7.0, ..cone() },
        Settings { max_incidence: 0.0, ..cone() },
        Settings { front_faces: false, back_faces: false, ..cone() },
        of("ball"),
        Settings { waves: "radio".into(), ..cone() },
        Settings { size_near: [0.0, 0.1], size_far: [0.0, 0.1], ..of("pyramid") },
        Settings { size_far: [-0.1, 0.1], ..of("pyramid") },
        Settings { radius_near: 0.0, radius_far: 0.0, ..of("cylinder") },
        Settings { radius_near: -0.1, ..of("cylinder") },
        Settings { height: 0.0, ..of("disc") },
        Settings { gap: 0.6, angle: 0.6, ..of("disc") },
        Settings { angle: f64::NAN, ..of("disc") },
        Settings { samples: 0, ..of("random_rays") },
        Settings { samples: 5, samples_needed: 6, ..of("random_rays") },
    ];
    for settings in bad {
        let text = format!("{settings:?}");
        assert!(settings.check().is_err(), "{text}");
    }
}

#[test]
fn volumes_cross_the_border_with_their_numbers() {
    let numbers = |volume: &str| match of(volume).check().unwrap().beams.form {
        Form::Volume { form, dims } => (form, dims),
        other => panic!("{other:?}"),
    };
    assert_eq!(numbers("pyramid"), (TATU_BEAMS_PYRAMID, [0.1, 0.2, 0.3, 0.4, 0.0, 0.0]));
    assert_eq!(numbers("cylinder"), (TATU_BEAMS_CYLINDER, [0.1, 0.2, 0.0, 0.0, 0.0, 0.0]));
    assert_eq!(numbers("disc"), (TATU_BEAMS_DISC, [PI / 6.0, 0.05, 0.0, 0.0, 0.0, 0.0]));
}

#[test]
fn switches_cross_the_border_too() {
    let beams = Settings { occlusion: true, waves: "laser".into(), back_faces: false, ..cone() }.check().unwrap().beams;
    assert_eq!((beams.occlude, beams.waves, beams.faces), (true, TATU_WAVES_LASER, (true, false)));
    // V-REP's constants sim.objectspecialproperty_detectable_...
    let bits = ["ultrasonic", "infrared", "laser", "inductive", "capacitive"]
        .map(|w| Settings { waves: w.into(), ..cone() }.check().unwrap().beams.waves);
    assert_eq!(bits, [16, 32, 64, 128, 256]);
}

#[test]
fn random_rays_lie_in_their_cone_and_fill_it_evenly() {
    let angle = 1.2;
    let grid = |n: usize| (0..n).flat_map(move |i| (0..n).map(move |k| [i, k].map(|x| (x as f64 + 0.5) / n as f64)));
    let all: Vec<[f64; 3]> = grid(100).map(|two| within(angle, two)).collect();
    for d in &all {
        assert!((d.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(d[2] >= (angle / 2.0).cos() - 1e-12);
    }
    // The area of a spherical cap is proportional to its height (Archimedes).
    let half = 1.0 - (1.0 - (angle / 2.0).cos()) / 2.0;
    let inner = all.iter().filter(|d| d[2] > half).count();
    assert_eq!(inner, 5000);
    assert_eq!(all.iter().filter(|d| d[0] > 0.0).count(), 5000);
}

#[test]
fn every_parameter_stands_in_the_readme() {
    let readme = include_str!("../../README.md");
    let quoted = |d: &dyn std::fmt::Debug| format!("{d:?}").split('"').nth(1).unwrap().to_owned();
    for p in Proximity::params() {
        assert!(readme.contains(&format!("| `{}`", quoted(&p))), "{p:?}");
    }
    for f in Proximity::fields() {
        assert!(readme.contains(&quoted(&f)), "{f:?}");
    }
}
