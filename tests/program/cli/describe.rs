//! Tests of `tatu describe`: plugins, kinds and commands are described, and their examples work.

use serde_json::Value;

use crate::kit::*;

fn describe(id: &str) -> Value {
    TestFolder::new().tatu(&["describe", id, "--json"]).good().json()
}

/// Returns the ids in the output of `tatu list`.
fn ids(what: &str) -> Vec<String> {
    let list = TestFolder::new().tatu(&["list", what, "--json"]).good().json();
    list.as_array().unwrap().iter().map(|i| i["id"].as_str().unwrap().to_owned()).collect()
}

fn parameter<'v>(fact: &'v Value, name: &str) -> &'v Value {
    let found = fact["parameters"].as_array().unwrap().iter().find(|p| p["name"] == name);
    found.unwrap_or_else(|| panic!("there is no parameter `{name}` in {fact}"))
}

#[test]
fn parameters_have_all_that_is_declared() {
    let fact = describe("proximity");
    assert_eq!((&fact["what"], &fact["plugin"]), (&"sensor kind".into(), &"tatu.sensor.proximity".into()));
    assert_eq!(fact["schemas"], serde_json::json!(["proximity/1"]));
    for p in fact["parameters"].as_array().unwrap() {
        for key in ["name", "type", "unit", "range", "default", "text"] {
            assert!(p.as_object().unwrap().contains_key(key), "{key} in {p}");
        }
    }
    let angle = parameter(&fact, "angle");
    assert_eq!((&angle["unit"], &angle["key"], &angle["type"]), (&"rad".into(), &"angle_deg".into(), &"number".into()));
    assert_eq!(angle["default"].as_f64(), Some(std::f64::consts::PI / 6.0));
    assert_eq!(numbers(&angle["range"]), [0.0, std::f64::consts::TAU]);
    let volumes = ["ray", "cone", "pyramid", "cylinder", "disc", "random_rays"];
    assert_eq!(parameter(&fact, "volume")["choices"], serde_json::json!(volumes));
    let fields = fact["fields"].as_array().unwrap();
    let point = fields.iter().find(|f| f["name"] == "proximity.point").unwrap();
    assert_eq!(
        (&point["element"], &point["shape"], &point["unit"]),
        (&"f64".into(), &serde_json::json!([3]), &"m".into())
    );
    // Dimensions of a field that depend on the sensor have names.
    let shape = |kind: &str, field: &str| {
        let all = describe(kind)["fields"].as_array().unwrap().clone();
        all.iter().find(|f| f["name"] == field).unwrap()["shape"].clone()
    };
    assert_eq!(shape("range_scan/1", "range_scan.distance"), serde_json::json!(["beams"]));
    assert_eq!(shape("depth_camera", "color_image.rgb"), serde_json::json!(["rows", "columns", "own"]));
    assert_eq!(shape("floor", "reflectance.value"), serde_json::json!(["own"]));
    let told = TestFolder::new().tatu(&["describe", "floor"]).good().out;
    assert!(told.lines().any(|l| l.split_whitespace().take(3).eq(["reflectance.value", "f64", "own"])), "{told}");
    // The description of a schema contains the sensors that use it, and the values that mean "nothing measured".
    let schema = describe("proximity/1");
    assert_eq!(schema["sensors"], serde_json::json!(["proximity"]));
    assert!(schema["fields"].as_array().unwrap().iter().all(|f| f["nothing"].is_string()));
    // The description of a model contains its slots, and that of an object kind its properties.
    assert_eq!(describe("pioneer_p3dx")["slots"].as_array().unwrap().len(), 11);
    assert_eq!(parameter(&describe("joint"), "max_force")["key"], "max_force_nm");
}

#[test]
fn commands_are_found_by_any_of_their_names() {
    let fact = describe("sim.getObjectHandle");
    assert_eq!(fact, describe("simGetObjectHandle"));
    assert_eq!(fact["names"], serde_json::json!(["sim.getObjectHandle", "simGetObjectHandle"]));
    assert!(fact["example"].as_str().unwrap().contains("sim.getObjectHandle("));
    assert_eq!(fact["returns"][0]["name"], "handle");
    let done = TestFolder::new().tatu(&["describe", "simGetObjectHandle"]).good();
    for word in ["command sim.getObjectHandle", "parameters:", "options", "returns:", "handle", "example:", "assert("] {
        assert!(done.out.contains(word), "{word} in {}", done.out);
    }
}

#[test]
fn plugins_list_what_they_offer_on_a_page() {
    let plugins = ids("plugins");
    assert!(plugins.len() >= 5);
    for id in plugins {
        let done = TestFolder::new().tatu(&["describe", &id]).good();
        assert!(done.out.lines().count() < 100, "{id}: {} lines", done.out.lines().count());
        assert!(done.out.contains("version: ") && done.out.contains("path: "), "{}", done.out);
        assert_eq!(describe(&id)["id"], id.as_str());
    }
    let api = describe("tatu.commands.vrep");
    assert!(api["commands"].as_array().unwrap().len() > 150);
}

#[test]
fn every_example_is_a_scene_that_would_start() {
    let mut tried = 0;
    for what in ["sensors", "actuators", "models", "importers", "services"] {
        for id in ids(what) {
            let fact = describe(&id);
            let example = fact["example"].as_str().unwrap();
            let place = TestFolder::new();
            // An importer's example names a file, which must exist.
            for file in example.lines().filter_map(|l| l.strip_prefix("file = ")) {
                let file = file.trim_matches('"');
                let like = match file.rsplit('.').next() {
                    Some("obj") => "mesh/pyramid.obj",
                    Some("xml") => "mjcf/quadruped.xml",
                    Some("sdf") => "sdf/rover.sdf",
                    _ => "urdf/robot.urdf",
                };
                place.write(file, &std::fs::read_to_string(root().join("plugins/importers").join(like)).unwrap());
            }
            place.write("scene.toml", &format!("format = 1\n\n{example}"));
            place.tatu(&["check", "scene.toml"]).good();
            // The example contains all parameters; optional ones are commented out.
            for p in fact["parameters"].as_array().unwrap() {
                assert!(example.contains(&format!("{} = ", p["key"].as_str().unwrap())), "{p} in {example}");
            }
            // The commented lines are also valid when they are uncommented.
            place.write("scene.toml", &format!("format = 1\n\n{}", example.replace("\n# ", "\n")));
            place.tatu(&["check", "scene.toml"]).good();
            tried += 1;
        }
    }
    assert!(tried >= 3, "{tried}");
    let lua = describe("lua");
    let place = TestFolder::new();
    place.write("scene.toml", &format!("format = 1\n{}", lua["example"].as_str().unwrap()));
    place.tatu(&["check", "scene.toml"]).good();
}

/// All listed models can be described in one call, and the example of each description is a valid scene.
#[test]
fn listed_models_are_described_and_named_in_scenes() {
    let place = TestFolder::new();
    place.write("models/shelf/box.toml", "format = 1\n[[object]]\nkind = \"shape\"\nalias = \"box\"\n");
    let list = place.tatu(&["list", "models"]).good();
    assert!(!list.out.contains("null") && list.out.contains("models/shelf/box.toml"), "{}", list.out);
    let rows = place.tatu(&["list", "models", "--json"]).good().json();
    let ids: Vec<&str> = rows.as_array().unwrap().iter().map(|r| r["id"].as_str().unwrap()).collect();
    assert!(rows.as_array().unwrap().iter().all(|r| r["category"].is_string()), "{rows}");
    let all = place.tatu(&[&["describe", "--json"], &ids[..]].concat()).good().json();
    let all = all.as_array().unwrap();
    assert_eq!(all.iter().map(|f| f["id"].as_str().unwrap()).collect::<Vec<_>>(), ids);
    for fact in all {
        let example = fact["example"].as_str().unwrap();
        place.write("scene.toml", &format!("format = 1\n{example}"));
        place.tatu(&["check", "scene.toml"]).good();
    }
    let text = place.tatu(&["describe", "pioneer_p3dx", "proximity"]).good().out;
    assert!(text.contains("model pioneer_p3dx") && text.contains("sensor kind proximity"), "{text}");
    place.tatu(&["describe", "pioneer_p3dx", "nothing_at_all"]).refused(&["error[E130]", "nothing_at_all"]);
}

#[test]
fn unknown_ids_get_the_nearest_of_all() {
    for (wrong, near) in [
        ("proximty", "proximity"),
        ("pioneer_p3d", "pioneer_p3dx"),
        ("urfd", "urdf"),
        ("simGetObjectHandel", "simGetObjectHandle"),
        ("tatu.comands.vrep", "tatu.commands.vrep"),
        ("joimt", "joint"),
    ] {
        let done = TestFolder::new().tatu(&["describe", wrong]);
        done.refused(&["E130", &format!("`{wrong}`"), &format!("did you mean `{near}`?")]);
        assert!(done.out.is_empty(), "{}", done.out);
    }
    let far = TestFolder::new().tatu(&["describe", "zzzzzzzzzzzzzz", "--json"]);
    far.refused(&["E130", "tatu list"]);
    assert!(!far.err.contains("did you mean"), "{}", far.err);
}

#[test]
fn plugins_of_a_scene_are_described_too() {
    let place = TestFolder::scene("plugins = [\"template/c_command\"]\n");
    template(&place, "c_command");
    let fact = place.tatu(&["describe", "example.describe", "--scene", "scene.toml", "--json"]).good().json();
    assert_eq!(fact["plugin"], "org.example.c_command");
    place.tatu(&["describe", "example.describe"]).refused(&["E130"]);
}
