//! Tests of the catalogue of commands: the lists, and the example of each command, which raises an error if the command
//! has no effect.

use std::fmt::Write;

use serde_json::Value;

use crate::kit::*;

fn commands() -> Vec<Value> {
    let list = TestFolder::new().tatu(&["list", "commands", "--json"]).good().json();
    list.as_array()
        .unwrap()
        .iter()
        .filter(|c| !c["name"].as_str().unwrap().starts_with("misbehaves"))
        .cloned()
        .collect()
}

fn text<'v>(c: &'v Value, key: &str) -> &'v str {
    c[key].as_str().unwrap_or_else(|| panic!("there is no string `{key}` in {c}"))
}

/// Scene entries for the objects to which examples refer by name.
const OBJECTS: &str = r#"
[[object]]
kind = "sensor"
sensor = "proximity"
alias = "sonar"
position_m = [0, 0, 40]
volume = "cone"
range_m = 1

[[object]]
kind = "sensor"
sensor = "depth_camera"
alias = "eye"
position_m = [0, 0, 60]
columns = 16
rows = 12
near_m = 0.5
far_m = 2.5

[[object]]
kind = "sensor"
sensor = "depth_camera"
alias = "filtering"
position_m = [0, 0, 60]
columns = 4
rows = 3
data = { "vision.filters" = "1;3;4" }

[[object]]
kind = "sensor"
sensor = "depth_camera"
alias = "working"
position_m = [0, 0, 60]
columns = 4
rows = 3

[[object]]
kind = "shape"
alias = "seen"
size_m = [9, 9, 0.02]
position_m = [0, 0, 61.01]
"#;

/// Commands that end the run, or whose examples need a separate world for another reason.
const SEPARATE_COMMANDS: &[&str] =
    &["sim.stopSimulation", "sim.quitSimulator", "sim.startSimulation", "sim.setArrayParam", "tatu.set"];

#[test]
fn each_command_has_a_status_and_an_example() {
    for c in commands() {
        let name = text(&c, "name");
        assert!(c["aliases"].is_array(), "{name}");
        assert!(["full", "partial", "stub"].contains(&text(&c, "status")), "{name}");
        let example = text(&c, "example");
        match text(&c, "status") {
            "stub" => assert!(!text(&c, "notes").is_empty(), "{name} is a stub without a note on the reason"),
            status => {
                assert!(example.contains(name), "{name} ({status}) has no example that calls it: {example:?}");
                assert!(status == "full" || !text(&c, "notes").is_empty(), "{name} has no note on what is missing");
            }
        }
    }
}

/// Runs all examples in one world, each as a separate script.
#[test]
fn examples_raise_no_errors() {
    let all = commands();
    let with: Vec<&Value> =
        all.iter().filter(|c| text(c, "status") != "stub" && !text(c, "example").is_empty()).collect();
    assert!(with.len() > 100, "the list has only {} examples", with.len());
    let mut scene = String::from("dialect = \"4.9\"\nphysics_dt_s = 0.025\n");
    scene += OBJECTS;
    let (mut names, mut alone) = (Vec::new(), Vec::new());
    for (i, c) in with.iter().enumerate() {
        // Each example has its own graph.
        let own = format!("/graph{i}");
        let example = text(c, "example").replace("'/graph'", &format!("'{own}'"));
        let object = |at: usize| {
            let graph = if example.contains(&own) {
                &format!("\n[[object]]\nkind = \"graph\"\nalias = \"graph{i}\"\n")
            } else {
                ""
            };
            format!(
                "{graph}\n[[object]]\nkind = \"dummy\"\nalias = \"example{at}\"\nscript = {{ text = '''\n{example}\n''' }}\n"
            )
        };
        if SEPARATE_COMMANDS.contains(&text(c, "name")) {
            alone.push((text(c, "name"), format!("dialect = \"4.9\"\n{OBJECTS}{}", object(0))));
        } else {
            let _ = write!(scene, "{}", object(i));
            names.push((format!("example{i}"), text(c, "name")));
        }
    }
    let mut failed = Vec::new();
    let done = TestFolder::scene(&scene).tatu(&["run", "scene.toml", "--steps", "20", "--json"]);
    for e in done.json()["errors"].as_array().unwrap() {
        let whole = e.to_string();
        let who = names
            .iter()
            .find(|(object, _)| whole.contains(&format!("{object}\"")) || whole.contains(&format!("{object}`")));
        failed.push(format!("{}: {}", who.map_or("?", |(_, name)| name), e["message"]));
    }
    for (name, scene) in alone {
        let done = TestFolder::scene(&scene).tatu(&["run", "scene.toml", "--steps", "5", "--json"]);
        let errors = done.json()["errors"].as_array().unwrap().clone();
        failed.extend(errors.iter().map(|e| format!("{name}: {}", e["message"])));
    }
    assert!(failed.is_empty(), "{} examples raise errors:\n{}", failed.len(), failed.join("\n"));
}

/// The pages in docs/ equal the output of `tatu describe --all --markdown docs/reference/commands`.
#[test]
fn the_reference_pages_are_those_of_the_declarations() {
    let place = TestFolder::new();
    place.tatu(&["describe", "--all", "--markdown", "pages"]).good();
    let folder = root().join("docs/reference/commands");
    for page in std::fs::read_dir(place.path().join("pages")).unwrap() {
        let name = page.unwrap().file_name().into_string().unwrap();
        if name.starts_with("README") || name.starts_with("misbehaves") {
            continue;
        }
        let written = place.read(&format!("pages/{name}"));
        let kept = std::fs::read_to_string(folder.join(&name)).unwrap_or_default();
        assert!(
            written == kept.replace("\r\n", "\n"),
            "{name} differs from the declarations: run `tatu describe --all --markdown docs/reference/commands`"
        );
    }
}
