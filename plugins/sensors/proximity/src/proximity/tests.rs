use super::*;

fn cone() -> Settings {
    Settings {
        volume: "cone".into(),
        range: 1.0,
        near: 0.0,
        min_range: 0.05,
        angle: PI / 6.0,
        max_incidence: PI / 4.0,
        front_faces: true,
        back_faces: true,
        skip_own_model: false,
    }
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
        Settings { volume: "disc".into(), ..cone() },
    ];
    for settings in bad {
        let text = format!("{settings:?}");
        assert!(settings.check().is_err(), "{text}");
    }
}

#[test]
fn every_parameter_stands_in_the_readme() {
    let readme = include_str!("../../README.md");
    for key in [
        "volume",
        "range",
        "near",
        "min_range",
        "angle",
        "max_incidence",
        "front_faces",
        "back_faces",
        "skip_own_model",
    ] {
        assert!(readme.contains(&format!("| `{key}")), "{key}");
    }
    for field in Proximity::fields() {
        let name = format!("{field:?}");
        let name = name.split('"').nth(1).unwrap();
        assert!(readme.contains(name), "{name}");
    }
}
