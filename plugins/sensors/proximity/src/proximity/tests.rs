use std::f64::consts::PI;

use tatu_plugin_api::{abi::*, safe::Form};

use crate::settings::VolumeSizes;

use super::*;

fn cone() -> ProximitySettings {
    ProximitySettings {
        volume: "cone".into(),
        range: 1.0,
        near: 0.0,
        min_range: 0.05,
        angle: PI / 6.0,
        gap: 0.0,
        sizes: VolumeSizes {
            size_near: [0.1, 0.2],
            size_far: [0.3, 0.4],
            radius_near: 0.1,
            radius_far: 0.2,
            height: 0.05,
        },
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

fn of(volume: &str) -> ProximitySettings {
    ProximitySettings { volume: volume.into(), ..cone() }
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
    let half = |angle| match (ProximitySettings { angle, ..cone() }).check().unwrap().beams.form {
        Form::Cone { half_angle } => half_angle,
        other => panic!("{other:?}"),
    };
    assert_eq!(half(TAU), PI);
    assert_eq!(half(360.0_f64.to_radians()), PI);
    assert_eq!(half(3.0), 1.5);
}

#[test]
fn a_ray_looks_along_z_whatever_its_angle() {
    let ray = ProximitySettings { volume: "ray".into(), angle: 0.0, ..cone() };
    assert_eq!(ray.check().unwrap().beams.form, Form::Rays(vec![[0.0, 0.0, 1.0]]));
}

#[test]
fn detection_below_min_range_is_dropped() {
    assert_eq!(echo_to_report(at(0.049), 0.05), None);
    assert_eq!(echo_to_report(at(0.05), 0.05), at(0.05));
    assert_eq!(echo_to_report(at(0.0), 0.0), at(0.0));
}

#[test]
fn no_echo_is_reported_without_a_hit() {
    assert_eq!(echo_to_report(None, 0.0), None);
    assert_eq!(echo_to_report(at(f64::INFINITY), 0.0), None);
    assert_eq!(echo_to_report(at(f64::NAN), 0.0), None);
}

#[test]
fn settings_without_possible_detection_are_refused() {
    let bad = [
        ProximitySettings { range: 0.0, ..cone() },
        ProximitySettings { range: f64::NAN, ..cone() },
        ProximitySettings { range: f64::INFINITY, ..cone() },
        ProximitySettings { near: -0.1, ..cone() },
        ProximitySettings { near: 1.0, ..cone() },
        ProximitySettings { min_range: -0.1, ..cone() },
        ProximitySettings { angle: 0.0, ..cone() },
        ProximitySettings { angle: 7.0, ..cone() },
        ProximitySettings { max_incidence: 0.0, ..cone() },
        ProximitySettings { front_faces: false, back_faces: false, ..cone() },
        of("ball"),
        ProximitySettings { waves: "radio".into(), ..cone() },
        ProximitySettings {
            sizes: VolumeSizes { size_near: [0.0, 0.1], size_far: [0.0, 0.1], ..of("pyramid").sizes },
            ..of("pyramid")
        },
        ProximitySettings { sizes: VolumeSizes { size_far: [-0.1, 0.1], ..of("pyramid").sizes }, ..of("pyramid") },
        ProximitySettings {
            sizes: VolumeSizes { radius_near: 0.0, radius_far: 0.0, ..of("cylinder").sizes },
            ..of("cylinder")
        },
        ProximitySettings { sizes: VolumeSizes { radius_near: -0.1, ..of("cylinder").sizes }, ..of("cylinder") },
        ProximitySettings { sizes: VolumeSizes { height: 0.0, ..of("disc").sizes }, ..of("disc") },
        ProximitySettings { gap: 0.6, angle: 0.6, ..of("disc") },
        ProximitySettings { angle: f64::NAN, ..of("disc") },
        ProximitySettings { samples: 0, ..of("random_rays") },
        ProximitySettings { samples: 5, samples_needed: 6, ..of("random_rays") },
    ];
    for settings in bad {
        let text = format!("{settings:?}");
        assert!(settings.check().is_err(), "{text}");
    }
}

#[test]
fn volume_dimensions_are_passed_to_the_host() {
    let numbers = |volume: &str| match of(volume).check().unwrap().beams.form {
        Form::Volume { form, dims } => (form, dims),
        other => panic!("{other:?}"),
    };
    assert_eq!(numbers("pyramid"), (TATU_BEAMS_PYRAMID, [0.1, 0.2, 0.3, 0.4, 0.0, 0.0]));
    assert_eq!(numbers("cylinder"), (TATU_BEAMS_CYLINDER, [0.1, 0.2, 0.0, 0.0, 0.0, 0.0]));
    assert_eq!(numbers("disc"), (TATU_BEAMS_DISC, [PI / 6.0, 0.05, 0.0, 0.0, 0.0, 0.0]));
}

#[test]
fn flags_and_waves_are_passed_to_the_host() {
    let beams = ProximitySettings { occlusion: true, waves: "laser".into(), back_faces: false, ..cone() }
        .check()
        .unwrap()
        .beams;
    assert_eq!((beams.occlude, beams.waves, beams.faces), (true, TATU_WAVES_LASER, (true, false)));
    // V-REP's constants sim.objectspecialproperty_detectable_...
    let bits = ["ultrasonic", "infrared", "laser", "inductive", "capacitive"]
        .map(|w| ProximitySettings { waves: w.into(), ..cone() }.check().unwrap().beams.waves);
    assert_eq!(bits, [16, 32, 64, 128, 256]);
}

#[test]
fn random_rays_lie_in_their_cone_and_fill_it_evenly() {
    let angle = 1.2;
    let grid = |n: usize| (0..n).flat_map(move |i| (0..n).map(move |k| [i, k].map(|x| (x as f64 + 0.5) / n as f64)));
    let all: Vec<[f64; 3]> = grid(100).map(|two| direction_in_cone(angle, two)).collect();
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
fn readme_names_every_parameter_and_field() {
    let readme = include_str!("../../README.md");
    let quoted = |d: &dyn std::fmt::Debug| format!("{d:?}").split('"').nth(1).unwrap().to_owned();
    for p in ProximitySensor::params() {
        assert!(readme.contains(&format!("| `{}`", quoted(&p))), "{p:?}");
    }
    for f in ProximitySensor::fields() {
        assert!(readme.contains(&quoted(&f)), "{f:?}");
    }
}
