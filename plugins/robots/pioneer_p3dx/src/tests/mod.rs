//! Tests of the model as the host sees it: recorded calls through the C tables.

mod geometry;
mod recorder;
mod sonars;

use recorder::{Record, build};
use tatu_plugin_api::safe::Value;

fn vrep() -> Record {
    build(&[]).unwrap()
}

fn sheet() -> Record {
    build(&[("preset", "as the data sheet".into())]).unwrap()
}

fn both() -> [Record; 2] {
    [vrep(), sheet()]
}

fn close(a: f64, b: f64, by: f64) -> bool {
    (a - b).abs() <= by
}

#[test]
fn the_tree_is_the_files() {
    let expected = [
        ("shape", "Pioneer_p3dx", ""),
        ("joint", "Pioneer_p3dx_rightMotor", "Pioneer_p3dx"),
        ("shape", "Pioneer_p3dx_rightWheel", "Pioneer_p3dx_rightMotor"),
        ("shape", "Pioneer_p3dx_rightWheel_visible", "Pioneer_p3dx_rightWheel"),
        ("joint", "Pioneer_p3dx_leftMotor", "Pioneer_p3dx"),
        ("shape", "Pioneer_p3dx_leftWheel", "Pioneer_p3dx_leftMotor"),
        ("shape", "Pioneer_p3dx_leftWheel_visible", "Pioneer_p3dx_leftWheel"),
        ("joint", "Pioneer_p3dx_caster_freeJoint1", "Pioneer_p3dx"),
        ("shape", "Pioneer_p3dx_caster_link", "Pioneer_p3dx_caster_freeJoint1"),
        ("joint", "Pioneer_p3dx_caster_freeJoint2", "Pioneer_p3dx_caster_link"),
        ("shape", "Pioneer_p3dx_caster_wheel", "Pioneer_p3dx_caster_freeJoint2"),
        ("shape", "Pioneer_p3dx_caster_wheel_visible", "Pioneer_p3dx_caster_wheel"),
        ("shape", "Pioneer_p3dx_caster_link_visible", "Pioneer_p3dx_caster_link"),
        ("shape", "Pioneer_p3dx_visible", "Pioneer_p3dx"),
        ("sensor", "Pioneer_p3dx_ultrasonicSensor1", "Pioneer_p3dx_visible"),
        ("sensor", "Pioneer_p3dx_ultrasonicSensor16", "Pioneer_p3dx_visible"),
        ("force_sensor", "Pioneer_p3dx_connection1", "Pioneer_p3dx"),
        ("force_sensor", "Pioneer_p3dx_connection11", "Pioneer_p3dx"),
    ];
    for robot in both() {
        for (kind, alias, parent) in expected {
            let object = robot.get(alias);
            assert_eq!(object.kind, kind, "{alias}");
            assert_eq!(robot.parent(object).map_or("", |p| &p.alias), parent, "{alias}");
        }
        assert_eq!(robot.objects[0].alias, "Pioneer_p3dx", "the base comes first");
        assert!(robot.objects[0].is("object.model_base"));
        for slot in crate::parts::SLOTS {
            robot.get(slot);
        }
    }
}

#[test]
fn masses_add_up() {
    let sum = |robot: &Record| -> f64 {
        let dynamic = robot.objects.iter().filter(|o| o.is("shape.dynamic"));
        dynamic.map(|o| o.number("shape.mass")).sum()
    };
    assert!(close(sum(&vrep()), 20.25, 1e-9), "{}", sum(&vrep()));
    assert!(close(sum(&sheet()), 9.0, 1e-9), "{}", sum(&sheet()));
}

#[test]
fn masks_and_inertias_are_the_files() {
    let robot = vrep();
    let rows = [
        ("Pioneer_p3dx", 16.0, [1.92, 1.93907, 2.0906], Some(65520.0)),
        ("Pioneer_p3dx_leftWheel", 1.5, [0.03, 0.03, 0.06], Some(65295.0)),
        ("Pioneer_p3dx_rightWheel", 1.5, [0.03, 0.03, 0.06], Some(65295.0)),
        ("Pioneer_p3dx_caster_link", 1.0, [0.016, 0.016, 0.019984], None),
        // The file's 0.0070088 about z is physically impossible.
        ("Pioneer_p3dx_caster_wheel", 0.25, [0.0010192, 0.0010192, 0.002], Some(65295.0)),
    ];
    for (alias, mass, inertia, mask) in rows {
        let o = robot.get(alias);
        assert_eq!(o.number("shape.mass"), mass, "{alias}");
        assert_eq!(o.numbers("shape.inertia"), inertia, "{alias}");
        assert_eq!(o.is("shape.respondable"), mask.is_some(), "{alias}");
        if let Some(mask) = mask {
            assert_eq!(o.number("shape.respondable_mask"), mask, "{alias}");
        }
    }
    // Within the robot nothing collides: base and wheels by the low byte; wheels and caster are far apart.
    assert_eq!((65520 & 65295) & 0xFF, 0);
}

#[test]
fn what_collides_is_hidden_and_what_is_seen_does_not_collide() {
    for robot in both() {
        for o in robot.objects.iter().filter(|o| o.kind == "shape") {
            let hidden = o.properties.get("object.visible") == Some(&Value::Bool(false));
            assert_eq!(hidden, o.is("shape.dynamic"), "{}", o.alias);
            assert_eq!(hidden, !o.alias.ends_with("_visible"), "{}", o.alias);
            if hidden {
                assert_eq!(o.properties["shape.detectable"], Value::Bool(false));
            } else {
                assert!(!o.is("shape.respondable"), "{}", o.alias);
            }
        }
    }
}

#[test]
fn motors_hold_still_with_the_files_torque() {
    for robot in both() {
        for side in ["left", "right"] {
            let motor = robot.get(&format!("Pioneer_p3dx_{side}Motor"));
            assert_eq!(motor.text("joint.type"), "revolute");
            assert_eq!(motor.text("joint.mode"), "dynamic");
            assert_eq!(motor.text("joint.control"), "velocity");
            assert_eq!(motor.number("joint.max_force"), 3.0);
            assert_eq!(motor.number("joint.target_velocity"), 0.0);
        }
        for n in [1, 2] {
            let joint = robot.get(&format!("Pioneer_p3dx_caster_freeJoint{n}"));
            assert_eq!(joint.text("joint.control"), "free");
        }
        let caster = robot.get("Pioneer_p3dx_caster_wheel");
        assert_eq!(caster.number("shape.friction"), 0.0);
        assert_eq!(caster.text("shape.collide_as"), "sphere");
    }
}

#[test]
fn an_unknown_preset_is_refused_by_name() {
    let said = build(&[("preset", "as I like".into())]).unwrap_err();
    assert!(said.contains("as I like"), "{said}");
}

#[test]
fn every_parameter_stands_in_the_readme() {
    use tatu_plugin_api::safe::Model;
    let readme = include_str!("../../README.md");
    for param in crate::PioneerP3dx::params() {
        let told = format!("{param:?}");
        let key = told.split('"').nth(1).unwrap();
        assert!(readme.contains(&format!("| `{key}` |")), "{key}");
    }
}
