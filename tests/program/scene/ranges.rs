//! Tests of values that properties refuse: in files, on the command line and in scripts, always in the same words.

use crate::kit::*;

/// Values without a meaning: the kind of object, the key, the value as a scene file and a script write it, and what is
/// expected.
const INVALID_VALUES: &[(&str, &str, &str, &str)] = &[
    ("joint", "gains", "[1.0, 2.0]", "expected 3 numbers, or none, found 2"),
    ("joint", "follow_curve", "[0.0, 1.0, 0.0, 2.0]", "first numbers ascend, or none, found [0.0, 1.0, 0.0, 2.0]"),
    ("joint", "slip", "-1.0", "expected a number, at least 0, found -1"),
    ("joint", "max_velocity", "-5.0", "expected a number, at least 0, found -5"),
    ("joint", "damping", "-1.0", "expected a number, at least 0, found -1"),
    ("shape", "respondable_mask", "65536", "expected an integer from 0 to 65535, found 65536"),
    ("shape", "respondable_mask", "-1", "expected an integer from 0 to 65535, found -1"),
    ("shape", "respondable_mask", "70000", "expected an integer from 0 to 65535, found 70000"),
    ("shape", "detectable_mask", "65536", "expected an integer from 0 to 65535, found 65536"),
    ("shape", "layer", "4294967296", "expected an integer from 0 to 4294967295, found 4294967296"),
    ("shape", "layer", "-1", "expected an integer from 0 to 4294967295, found -1"),
    ("shape", "mass", "0.0", "expected a number above 0, found 0"),
    ("shape", "friction", "-0.5", "expected a number, at least 0, found -0.5"),
    ("shape", "restitution", "1.5", "expected a number from 0 to 1, found 1.5"),
    ("shape", "color", "[0.0, 2.0, 0.0]", "expected 3 numbers from 0 to 1, found 2 as number 2"),
    ("shape", "linear_damping", "-1.0", "expected a number, at least 0, found -1"),
    ("force_sensor", "samples", "0", "expected an integer from 1 to 1000, found 0"),
    ("force_sensor", "break_count", "0", "expected an integer from 1 to 4294967295, found 0"),
    ("camera", "near", "0.0", "expected a number above 0, found 0"),
    ("light", "color", "[-1.0, 0.0, 0.0]", "expected 3 numbers from 0 to 1, found -1 as number 1"),
    ("path", "points", "[1.0, 2.0]", "expected 7 numbers for each point, found 2 numbers"),
    ("graph", "buffer", "0", "expected an integer from 1 to 1000000, found 0"),
];

/// Returns the key as files write it.
fn with_unit(key: &str) -> String {
    match key {
        "max_velocity" => "max_velocity_rad_s".into(),
        "damping" => "damping_nms_rad".into(),
        "mass" => "mass_kg".into(),
        "near" => "near_m".into(),
        _ => key.to_owned(),
    }
}

fn object(kind: &str) -> String {
    format!("[[object]]\nkind = \"{kind}\"\nalias = \"it\"\n")
}

fn full(kind: &str, key: &str) -> String {
    format!("{}.{key}", if key == "layer" { "object" } else { kind })
}

#[test]
fn senseless_values_are_refused_in_a_file_and_on_the_command_line() {
    for (kind, key, value, expected) in INVALID_VALUES {
        let (written, sentence) = (with_unit(key), [format!("`{}`: ", full(kind, key)), (*expected).to_owned()]);
        let sentence = sentence.each_ref().map(String::as_str);
        let place = TestFolder::scene(&format!("{}{written} = {value}\n", object(kind)));
        place.tatu(&["check", "scene.toml"]).refused(&sentence);
        let place = TestFolder::scene(&object(kind));
        place.run(&["--set", &format!("/it.{written}={value}"), "--steps", "1"]).refused(&sentence);
    }
}

#[test]
fn senseless_values_are_refused_in_scripts_with_the_object() {
    for kind in ["joint", "shape", "force_sensor", "camera", "light", "path", "graph"] {
        let mut script = String::from("function sysCall_init()\nlocal it = sim.getObject('/it')\n");
        let of_kind = || INVALID_VALUES.iter().filter(|s| s.0 == kind);
        for (_, key, value, _) in of_kind() {
            let (key, value) = (full(kind, key), value.replace('[', "{").replace(']', "}"));
            script += &format!("print(select(2, pcall(tatu.set, it, '{key}', {value})))\n");
        }
        script += "end";
        let done = TestFolder::scene(&format!("{}{}", object(kind), watcher("w", &script))).run(&["--steps", "1"]);
        for (_, key, _, expected) in of_kind() {
            done.reports(&[&format!("`{}` of /it: ", full(kind, key)), expected]);
        }
    }
}

#[test]
fn senseless_values_are_refused_in_scripts_that_run_in_parallel() {
    let script = "function sysCall_init() it = sim.getObject('/it') end
function sysCall_actuation()
    print(pcall(sim.setFloatProperty, it, 'joint.slip', -1))
    print(sim.getFloatProperty(it, 'joint.slip'))
end";
    let watcher = watcher("w", script).replace("script = { ", "script = { side_by_side = true, ");
    let done = TestFolder::scene(&format!("{}{watcher}", object("joint"))).run(&["--steps", "2"]);
    done.reports(&["expected a number, at least 0, found -1"]);
    assert!(!done.err.contains("\n-1"), "{}", done.err);
}

#[test]
fn a_mask_of_all_bits_collides_with_the_floor() {
    let place = TestFolder::scene(&format!(
        "{FLOOR}{}",
        cuboid("it", [0.1, 0.1, 0.1], [0.0, 0.0, 0.2], "dynamic = true\nrespondable = true\nrespondable_mask = 65535")
    ));
    let lines = place.trace(&["/it"], &["--seconds", "1"]);
    let [_, _, z] = lines.last().unwrap().object("/it", "position");
    assert!(z > 0.04, "{z}");
}

#[test]
fn describe_shows_the_range_and_the_default_of_each_property() {
    let place = TestFolder::new();
    let shape = place.tatu(&["describe", "shape", "--json"]).good().json();
    let all = shape.as_array().cloned().unwrap_or_else(|| vec![shape.clone()]);
    let of = |name: &str| {
        let rows = all.iter().flat_map(|what| what["parameters"].as_array().unwrap());
        let row = rows.into_iter().find(|p| p["name"] == name).unwrap();
        (row["range"].clone(), row["default"].clone())
    };
    assert_eq!(of("respondable_mask"), (serde_json::json!([0.0, 65535.0]), serde_json::json!(65535)));
    assert_eq!(of("friction"), (serde_json::json!([0.0, null]), serde_json::json!(1.0)));
    assert_eq!(of("material"), (serde_json::Value::Null, serde_json::json!("")));
}
