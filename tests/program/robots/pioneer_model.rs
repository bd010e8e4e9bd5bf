//! Tests of the Pioneer model: its tree, its masses, and which shapes collide and are visible.
//!
//! The expected values are from V-REP's model and the data sheets (`tests/facts/pioneer.md`).

use super::flat::FlatRobot;
use crate::kit::*;

pub fn vrep() -> FlatRobot {
    FlatRobot::new("pioneer_p3dx", "")
}

pub fn sheet() -> FlatRobot {
    FlatRobot::new("pioneer_p3dx", "preset = \"as the data sheet\"")
}

pub fn both() -> [FlatRobot; 2] {
    [vrep(), sheet()]
}

pub fn close(a: f64, b: f64, by: f64) -> bool {
    (a - b).abs() <= by
}

#[test]
fn the_object_tree_is_that_of_the_file() {
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
            assert_eq!(robot.parent(object), parent, "{alias}");
        }
        assert_eq!(robot.objects[0].alias, "Pioneer_p3dx", "the base must be the first object");
        assert!(robot.objects[0].is("model_base"));
        for slot in 1..=11 {
            robot.get(&format!("Pioneer_p3dx_connection{slot}"));
        }
    }
}

#[test]
fn masses_add_up() {
    let sum = |robot: &FlatRobot| -> f64 {
        let dynamic = robot.objects.iter().filter(|o| o.is("dynamic"));
        dynamic.map(|o| o.number("mass_kg")).sum()
    };
    assert!(close(sum(&vrep()), 20.25, 1e-9), "{}", sum(&vrep()));
    assert!(close(sum(&sheet()), 9.0, 1e-9), "{}", sum(&sheet()));
}

#[test]
fn masks_and_inertias_are_those_of_the_file() {
    let robot = vrep();
    let rows = [
        ("Pioneer_p3dx", 16.0, [1.92, 1.93907, 2.0906], Some(65520.0)),
        ("Pioneer_p3dx_leftWheel", 1.5, [0.03, 0.03, 0.06], Some(65295.0)),
        ("Pioneer_p3dx_rightWheel", 1.5, [0.03, 0.03, 0.06], Some(65295.0)),
        ("Pioneer_p3dx_caster_link", 1.0, [0.016, 0.016, 0.019984], None),
        // The value of V-REP's file about z, 0.0070088 kg m^2, is physically impossible.
        ("Pioneer_p3dx_caster_wheel", 0.25, [0.0010192, 0.0010192, 0.002], Some(65295.0)),
    ];
    for (alias, mass, inertia, mask) in rows {
        let o = robot.get(alias);
        assert_eq!(o.number("mass_kg"), mass, "{alias}");
        assert_eq!(o.numbers("inertia_kg_m2"), inertia, "{alias}");
        assert_eq!(o.is("respondable"), mask.is_some(), "{alias}");
        if let Some(mask) = mask {
            assert_eq!(o.number("respondable_mask"), mask, "{alias}");
        }
    }
    // No parts of the robot collide: the low bytes of base and wheels have no common bit, and the wheels are far from
    // the caster.
    assert_eq!((65520 & 65295) & 0xFF, 0);
}

#[test]
fn colliding_shapes_are_hidden_and_visible_ones_do_not_collide() {
    for robot in both() {
        for o in robot.objects.iter().filter(|o| o.kind == "shape") {
            let hidden = !o.is_visible();
            assert_eq!(hidden, o.is("dynamic"), "{}", o.alias);
            assert_eq!(hidden, !o.alias.ends_with("_visible"), "{}", o.alias);
            if hidden {
                assert!(o.has("detectable") && !o.is("detectable"), "{}", o.alias);
            } else {
                assert!(!o.is("respondable"), "{}", o.alias);
            }
        }
    }
}

#[test]
fn motors_hold_still_with_the_torque_of_the_file() {
    for robot in both() {
        for side in ["left", "right"] {
            let motor = robot.get(&format!("Pioneer_p3dx_{side}Motor"));
            assert_eq!(motor.text("type"), "revolute");
            assert!(!motor.has("mode"), "`mode` must have its default, dynamic");
            assert_eq!(motor.text("control"), "velocity");
            assert_eq!(motor.number("max_force_nm"), 3.0);
            assert!(!motor.has("target_velocity_deg_s"), "`target_velocity_deg_s` must have its default, 0");
        }
        for n in [1, 2] {
            let joint = robot.get(&format!("Pioneer_p3dx_caster_freeJoint{n}"));
            assert_eq!(joint.text("control"), "free");
        }
        let caster = robot.get("Pioneer_p3dx_caster_wheel");
        assert_eq!(caster.number("friction"), 0.0);
        assert_eq!(caster.text("collide_as"), "sphere");
    }
}

#[test]
fn an_unknown_preset_is_refused_by_name() {
    let place = TestFolder::scene("[[model]]\nmodel = \"pioneer_p3dx\"\npreset = \"as I like\"\n");
    place.tatu(&["check", "scene.toml"]).refused(&["as I like", "as the data sheet"]);
}

#[test]
fn sonars_can_be_left_out_together_or_one_by_one() {
    let sonars = |lines: &str| {
        let robot = FlatRobot::new("pioneer_p3dx", lines);
        robot.objects.iter().filter(|o| o.kind == "sensor").count()
    };
    assert_eq!([sonars(""), sonars("sonars = false")], [16, 0]);
    assert_eq!(sonars("remove = [\"Pioneer_p3dx_ultrasonicSensor9\"]"), 15);
}

#[test]
fn slots_accept_models_mounted_by_a_plate() {
    let lines = "slots = { Pioneer_p3dx_connection4 = { model = \"hokuyo\" } }";
    let robot = FlatRobot::new("pioneer_p3dx", lines);
    assert_eq!(robot.parent(robot.get("Hokuyo_URG_04LX_UG01")), "Pioneer_p3dx_connection4");
    let place =
        TestFolder::scene(&format!("[[model]]\nmodel = \"pioneer_p3dx\"\n{}\n", lines.replace("hokuyo", "tool")));
    let tool = "format = 1\n[model]\ntext = \"A tool.\"\nmount = \"flange\"\n[[object]]\nkind = \"dummy\"\n";
    place.write("models/tool/model.toml", tool);
    place.tatu(&["check", "scene.toml"]).refused(&["sensor-plate", "flange"]);
}

#[test]
fn every_parameter_is_in_the_readme() {
    let place = TestFolder::new();
    let rows = place.tatu(&["list", "models", "--json"]).good().json();
    for model in rows.as_array().unwrap() {
        let id = model["id"].as_str().unwrap();
        let readme = std::fs::read_to_string(root().join("models").join(id).join("README.md")).unwrap();
        for param in model["parameters"].as_array().unwrap() {
            let key = param["name"].as_str().unwrap();
            // `sick` is an alias of another model, whose README describes the parameters.
            assert!(id == "sick" || readme.contains(&format!("`{key}`")), "{id}: {key}");
        }
    }
}
