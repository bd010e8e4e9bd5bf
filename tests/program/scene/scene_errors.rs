//! Tests of errors in scenes and scripts: they state the problem, the line, what was expected, and what to do.

use std::fmt::Write;

use crate::{kit::said::*, kit::*};

/// Returns the text of a scene with a floor and further entries.
fn with(more: &str) -> String {
    format!("format = 1\n[scene]\ndt_s = 0.05\n{FLOOR}{more}")
}

fn robot(more: &str) -> String {
    with(&format!("[[model]]\nmodel = \"pioneer_p3dx\"\n{more}\n"))
}

fn shape(more: &str) -> String {
    with(&format!("[[object]]\nkind = \"shape\"\nalias = \"crate\"\n{more}\n"))
}

#[test]
fn unknown_keys_are_named_with_the_known_ones() {
    let mut said = said!();
    said.refused(&with("[[objekt]]\nkind = \"shape\"\n"), "objekt");
    said.refused("format = 1\n[scene]\ngravty_m_s2 = [0, 0, 0]\n", "gravty");
    said.refused(&shape("sise_m = [1, 1, 1]"), "sise");
    said.refused(&robot("sonar_rnage_m = 2"), "rnage");
    said.refused(&robot("script = { txt = '' }"), "txt");
    said.refused(&shape("primitive = \"compound\"\nparts = [{ primitiv = \"box\" }]"), "primitiv =");
}

#[test]
fn wrong_units_are_reported_with_the_right_one() {
    let mut said = said!();
    said.refused(&robot("sonar_range_cm = 100"), "_cm");
    said.refused(&robot("sonar_range = 1"), "sonar_range");
    said.refused(&shape("position_mm = [1, 1, 1]"), "_mm");
    said.refused(&shape("mass_g = 100"), "mass_g");
    said.refused("format = 1\n[scene]\ndt_ms = 50\n", "dt_ms");
    said.refused(&with("[[object]]\nkind = \"joint\"\nmax_force = 2\n"), "max_force");
}

#[test]
fn misspelt_names_get_the_nearest_one() {
    let mut said = said!();
    said.refused(&with("[[model]]\nmodel = \"pioneer_p3dy\"\n"), "p3dy");
    said.refused(&with("[[object]]\nkind = \"shap\"\n"), "\"shap\"");
    said.refused(&shape("primitive = \"sfere\""), "sfere");
    said.refused(&with("[[object]]\nkind = \"sensor\"\nsensor = \"proximty\"\n"), "proximty");
    said.refused(&with("[[object]]\nkind = \"sensor\"\n"), "sensor");
    said.refused(&with("[[object]]\nalias = \"a\"\n"), "alias = \"a\"");
    said.refused(&with("[[model]]\nalias = \"a\"\n"), "alias = \"a\"");
    said.refused(&shape("parent = \"flor\""), "flor");
    said.refused(&shape("parent = \"/nowhere/at/all\""), "nowhere");
    said.refused(&robot("script = { text = '', language = \"luaa\" }"), "luaa");
}

#[test]
fn bad_values_are_reported_with_the_expected_one() {
    let mut said = said!();
    said.refused(&shape("size_m = [1, 2]"), "size_m");
    said.refused(&shape("mass_kg = \"heavy\""), "mass_kg");
    said.refused(&shape("dynamic = 1.5"), "dynamic");
    said.refused(&shape("alias = 5").replace("alias = \"crate\"\n", ""), "alias = 5");
    said.refused(&robot("sonar_range_m = 50"), "sonar_range_m");
    said.refused(&robot("preset = \"as VREP\""), "as VREP");
    said.refused(&robot("color = [0, 0, 2]"), "color");
    said.refused(&robot("position_m = [1, 2]"), "position_m");
    said.refused(&robot("quaternion = [0, 0, 0, 0]"), "quaternion");
    said.refused("format = 1\n[scene]\ndt_s = 0\n", "dt_s");
    said.refused("format = 1\n[scene]\ndt_s = nan\n", "dt_s");
    said.refused("format = 1\n[scene]\nseed = -1\n", "seed");
    said.refused("format = 1\nmodel = 5\n", "model");
}

#[test]
fn numbers_without_a_meaning_are_refused() {
    let mut said = said!();
    said.refused(&shape("dynamic = true\nmass_kg = -1.0"), "mass_kg");
    said.refused(&shape("size_m = [1, -1, 1]"), "size_m");
    said.refused(&shape("mass_kg = nan"), "mass_kg");
    said.refused(&shape("position_m = [inf, 0, 0]"), "position_m");
}

#[test]
fn the_file_itself_is_checked() {
    let mut said = said!();
    said.refused("format = 2\n", "format");
    said.refused("[scene]\ntext = \"x\"\n", "[scene]");
    said.refused("format = 1\n[scene\n", "[scene");
    said.refused(&with("[[object]]\nkind = \"shape\"\nkind = \"joint\"\n"), "kind = \"joint\"");
    let place = TestFolder::new();
    for command in ["run", "check"] {
        said.not_started(&place, &[command, "nowhere.toml"]);
    }
    std::fs::write(place.path().join("scene.toml"), b"format = 1 \xff").unwrap();
    said.not_started(&place, &["run", "scene.toml", "--json"]);
}

#[test]
fn files_that_are_missing_are_named_with_where_they_should_be() {
    let mut said = said!();
    let place = TestFolder::new();
    said.refused_in(&place, &robot("script = \"nowhere.lua\""), "nowhere");
    said.refused_in(&place, &with("[[model]]\nmodel = \"nowhere.toml\"\n"), "nowhere");
    place.write("controller.js", "print(1)");
    said.refused_in(&place, &robot("script = \"controller.js\""), "controller");
}

#[test]
fn models_must_not_contain_themselves() {
    let mut said = said!();
    let place = TestFolder::new();
    let using = |file: &str| format!("format = 1\n[[model]]\nmodel = \"{file}\"\n");
    said.refused_in(&place, &using("scene.toml"), "scene.toml");

    place.write("a.toml", &using("b.toml")).write("b.toml", &using("a.toml")).write("scene.toml", &using("a.toml"));
    said.not_started(&place, &["run", "scene.toml", "--json"]);
    // The same file used twice is not a cycle.
    place.write("b.toml", "format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"x\"\n");
    place.write("scene.toml", &(using("b.toml") + &using("b.toml").replace("format = 1\n", "")));
    place.run(&["--steps", "1"]).good();
}

#[test]
fn changes_by_path_are_checked_in_scenes_and_on_the_command_line() {
    let mut said = said!();
    let set = |line: &str| robot(&format!("[set]\n{line}"));
    for (path, value) in [
        ("/Pioneer_p3dx/Pioneer_p3dx_leftMotor.max_forse_nm", "2"),
        ("/Pioneer_p3dx/Pioneer_p3dx_leftMotor.max_force_kn", "2"),
        ("/Pioneer_p3dx/Pioneer_p3dx_leftMotr.max_force_nm", "2"),
        ("/Pioneer_p3dx.sonar_range_m", "50"),
        ("/Pioneer_p3dx.sonar_rnge_m", "2"),
        ("floor.mass_kg", "\"x\""),
        ("floor.path", "\"/x\""),
    ] {
        said.refused(&set(&format!("\"{path}\" = {value}")), path);
        let place = TestFolder::new();
        place.write("scene.toml", &robot(""));
        for command in ["run", "check"] {
            said.not_started(&place, &[command, "scene.toml", "--set", &format!("{path}={value}")]);
        }
    }
    said.refused(&set("nonsense = 1"), "nonsense");
    let place = TestFolder::new();
    place.write("scene.toml", &robot(""));
    said.not_started(&place, &["run", "scene.toml", "--json", "--set", "nonsense"]);
    said.not_started(&place, &["run", "scene.toml", "--json", "--set", "scene.dt_ms=5"]);
}

#[test]
fn arguments_that_name_missing_things_are_refused() {
    let mut said = said!();
    let place = TestFolder::new();
    place.write("scene.toml", &robot("")).write("a.lua", "");
    said.not_started(&place, &["run", "scene.toml", "--json", "--trace", "t.jsonl", "--watch", "/Pioneer_p3dy"]);
    said.not_started(&place, &["run", "scene.toml", "--json", "--script", "/Pioneer_p3dy=a.lua"]);
    said.not_started(&place, &["run", "scene.toml", "--json", "--script", "/Pioneer_p3dx=b.lua"]);
    said.not_started(&place, &["run", "scene.toml", "--json", "--script", "/Pioneer_p3dx"]);
    said.not_started(&place, &["run", "scene.toml", "--json", "--trace", "no/such/folder/t.jsonl"]);
    for wrong in
        [&["--seconds", "-1"][..], &["--seconds", "much"], &["--steps", "2.5"], &["--threads", "0"], &["--secnds", "1"]]
    {
        said.not_started(&place, &[&["run", "scene.toml", "--json"], wrong].concat());
    }
    said.not_started(&place, &["run", "scene.toml", "--json", "--steps", "1", "--seconds", "1"]);
}

#[test]
fn script_mistakes_are_reported_with_file_and_line() {
    // Line 3 of the script, the kind of the error, and a word of its message or help.
    let mistakes = [
        ("local speed = sped + 1", "runtime", "sped"),
        ("sim.setJointTargetVelocity(motr, 2)", "bad_argument", "joint"),
        ("sim.setJointTargetVelocity(left, fast)", "bad_argument", "velocity"),
        ("sim.setJointTargetVelocty(left, 2)", "unknown_function", "sim.setJointTargetVelocty"),
        ("setMotor(left, 2)", "runtime", "setMotor"),
        ("sim.getObject('/Pioneer_p3dx_leftMotr')", "missing_object", "leftMotr"),
        ("sim.getObjectPosition(99999)", "missing_object", "99999"),
        ("sim.readProximitySensor(left)", "bad_argument", "sensor"),
        ("sim.setObjectPosition(left, {1, 2})", "bad_argument", "3"),
        ("local a = names[1].x", "runtime", "names"),
        ("print('a' .. {})", "runtime", "concatenate"),
        ("error('my own')", "runtime", "my own"),
    ];
    for (line, kind, word) in mistakes {
        let place = TestFolder::new();
        let mut script =
            String::from("function sysCall_actuation()\n    left = sim.getObject('./Pioneer_p3dx_leftMotor')\n");
        let _ = writeln!(script, "    {line}\nend");
        place.write("scene.toml", &robot("script = \"robot.lua\"")).write("robot.lua", &script);
        let done = place.run(&["--steps", "2"]);
        let errors = done.errors();
        let e = &errors[0];
        assert_eq!(errors.len(), 1, "{line}: {errors:?}");
        assert!(e["file"].as_str().unwrap().ends_with("robot.lua") && e["line"] == 3, "{line}: {e}");
        assert_eq!((e["kind"].as_str(), e["object"].as_str()), (Some(kind), Some("/Pioneer_p3dx")), "{line}: {e}");
        assert!(format!("{} {}", e["message"], e["help"]).contains(word), "{line}: `{word}` is not in {e}");
        done.reports(&["robot.lua:3:"]);
    }
}

#[test]
fn syntax_errors_are_reported_with_file_and_line() {
    for (script, line, word) in [
        ("function sysCall_init()\n  x = 1\n", 3, "end"),
        ("x = 1\nif x = 2 then\nend\n", 2, "then"),
        ("x = 1\n\nint y = 5\n", 3, "y"),
        ("print('abc)\n", 1, "string"),
    ] {
        let place = TestFolder::new();
        place.write("scene.toml", &robot("script = \"robot.lua\"")).write("robot.lua", script);
        let done = place.run(&["--steps", "2"]);
        let e = &done.errors()[0];
        assert!(e["file"].as_str().unwrap().ends_with("robot.lua") && e["line"] == line, "{script}: {e}");
        assert!(e["message"].as_str().unwrap().contains(word), "{script}: {e}");
        done.reports(&[&format!("robot.lua:{line}:")]);
    }
}

#[test]
fn unknown_dialects_are_reported_with_the_known_ones() {
    let mut said = said!();
    for wrong in ["3,2", "modern", "3.x"] {
        let scene = format!("format = 1\n[scene]\ndialect = \"{wrong}\"\n");
        said.refused(&scene, wrong);
        let script = format!("script = {{ text = '', dialect = \"{wrong}\" }}");
        said.refused(&robot(&script), wrong);
    }
    let place = TestFolder::new();
    place.write("scene.toml", &robot("script = { text = '', dialect = '2.6' }"));
    place.run(&["--steps", "1", "--set", "scene.dialect=4.10.1"]).good();
    place.run(&["--steps", "1", "--set", "scene.dialect='4.10.1'"]).good();
    said.not_started(&place, &["run", "scene.toml", "--json", "--steps", "1", "--set", "scene.dialect='4,9'"]);
}

#[test]
fn more_misspelt_names_get_the_nearest_one() {
    let mut said = said!();
    said.refused(&shape("primitive = \"spheer\""), "spheer");
    said.refused(&robot("preset = \"as VREP\""), "as VREP");
    said.refused(&robot("script = { txt = '' }"), "txt");
    said.refused(&robot("script = { text = '', kind = 'chidl' }"), "chidl");
    said.refused(&robot("positon_m = [0, 0, 0]"), "positon_m");
    said.refused(&with("[[object]]\nkind = \"sensor\"\nsensor = \"proximty/1\"\n"), "proximty");
    said.refused(&with("[providers]\n\"proximty/1\" = \"proximity\"\n"), "proximty");
    said.refused(&with("[[imprt]]\nfile = \"x.urdf\"\n"), "imprt");
}

#[test]
fn missing_plugin_folders_are_reported() {
    let place = TestFolder::new();
    place.write("scene.toml", &format!("format = 1\n[scene]\nplugins = [\"nowhere\", \".\"]\n{FLOOR}"));
    let done = place.run(&["--steps", "1"]).good();
    done.reports(&["warning[E311]", "nowhere", "which does not exist"]);
    assert_eq!(done.err.matches("E311").count(), 1, "{}", done.err);
}
