//! Faulty scenes and scripts: what is wrong, in which line, what was expected, what to do.

use std::fmt::Write;

use crate::kit::*;

/// Runs and checks a scene that must be refused: exit 2, with the line in which `wrong` stands, and these words.
#[track_caller]
fn refused(scene: &str, wrong: &str, words: &[&str]) {
    refused_in(&Place::new(), scene, wrong, words);
}

#[track_caller]
fn refused_in(place: &Place, scene: &str, wrong: &str, words: &[&str]) {
    place.write("scene.toml", scene);
    let line = scene.lines().position(|l| l.contains(wrong)).expect("the scene has the wrong line") + 1;
    for command in [&["run", "scene.toml", "--json"][..], &["check", "scene.toml"]] {
        let done = place.tatu(command);
        done.refused(words);
        done.tells(&[&format!("scene.toml:{line}:")]);
        assert!(done.out.is_empty(), "nothing started: {}", done.out);
    }
}

/// A scene with a floor and more.
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
    refused(
        &with("[[objekt]]\nkind = \"shape\"\n"),
        "objekt",
        &["unknown key `objekt`", "did you mean `object`?", "model"],
    );
    refused(
        "format = 1\n[scene]\ngravty_m_s2 = [0, 0, 0]\n",
        "gravty",
        &["`gravty_m_s2`", "did you mean `gravity_m_s2`?", "physics_dt_s"],
    );
    refused(&shape("sise_m = [1, 1, 1]"), "sise", &["`sise_m`", "did you mean `size_m`?", "mass_kg"]);
    refused(&robot("sonar_rnage_m = 2"), "rnage", &["`sonar_rnage_m`", "did you mean `sonar_range_m`?", "preset"]);
    refused(&robot("script = { txt = '' }"), "txt", &["unknown key `txt` of a script", "file or text"]);
    refused(
        &shape("primitive = \"compound\"\nparts = [{ primitiv = \"box\" }]"),
        "primitiv =",
        &["primitiv", "did you mean `primitive`?"],
    );
}

#[test]
fn wrong_units_are_told_with_the_right_one() {
    refused(&robot("sonar_range_cm = 100"), "_cm", &["wrong unit", "write `sonar_range_m`"]);
    refused(&robot("sonar_range = 1"), "sonar_range", &["lacks its unit", "write `sonar_range_m`"]);
    refused(&shape("position_mm = [1, 1, 1]"), "_mm", &["wrong unit", "write `position_m`"]);
    refused(&shape("mass_g = 100"), "mass_g", &["wrong unit", "write `mass_kg`"]);
    refused("format = 1\n[scene]\ndt_ms = 50\n", "dt_ms", &["wrong unit", "write `dt_s`"]);
    refused(
        &with("[[object]]\nkind = \"joint\"\nmax_force = 2\n"),
        "max_force",
        &["lacks its unit", "write `max_force_nm`"],
    );
}

#[test]
fn misspelt_names_get_the_nearest_one() {
    refused(
        &with("[[model]]\nmodel = \"pioneer_p3dy\"\n"),
        "p3dy",
        &["`pioneer_p3dy`", "did you mean `pioneer_p3dx`?"],
    );
    refused(&with("[[object]]\nkind = \"shap\"\n"), "\"shap\"", &["`shap`", "shape", "joint", "dummy"]);
    refused(&shape("primitive = \"sfere\""), "sfere", &["sfere", "sphere", "cylinder"]);
    refused(
        &with("[[object]]\nkind = \"sensor\"\nsensor = \"proximty\"\n"),
        "proximty",
        &["`proximty`", "did you mean `proximity`?"],
    );
    refused(&with("[[object]]\nkind = \"sensor\"\n"), "sensor", &["a sensor without its kind", "tatu list sensors"]);
    refused(&with("[[object]]\nalias = \"a\"\n"), "alias = \"a\"", &["without `kind`", "shape"]);
    refused(&with("[[model]]\nalias = \"a\"\n"), "alias = \"a\"", &["without `model`"]);
    refused(&shape("parent = \"flor\""), "flor", &["there is no object `flor`", "did you mean `floor`?"]);
    refused(&shape("parent = \"/nowhere/at/all\""), "nowhere", &["there is no object `/nowhere/at/all`"]);
    refused(&robot("script = { text = '', language = \"luaa\" }"), "luaa", &["luaa", "lua"]);
}

#[test]
fn bad_values_are_told_with_what_is_expected() {
    refused(&shape("size_m = [1, 2]"), "size_m", &["size", "3 numbers"]);
    refused(&shape("mass_kg = \"heavy\""), "mass_kg", &["mass", "number"]);
    refused(&shape("dynamic = 1.5"), "dynamic", &["dynamic", "true or false"]);
    refused(&shape("alias = 5").replace("alias = \"crate\"\n", ""), "alias = 5", &["`alias`", "text"]);
    refused(&robot("sonar_range_m = 50"), "sonar_range_m", &["sonar_range", "0.1", "5"]);
    refused(&robot("preset = \"as VREP\""), "as VREP", &["as VREP", "as V-REP", "as the data sheet"]);
    refused(&robot("color = [0, 0, 2]"), "color", &["color", "1"]);
    refused(&robot("position_m = [1, 2]"), "position_m", &["`position_m`", "3 numbers"]);
    refused(&robot("quaternion = [0, 0, 0, 0]"), "quaternion", &["`quaternion`", "x y z w"]);
    refused("format = 1\n[scene]\ndt_s = 0\n", "dt_s", &["`dt_s`"]);
    refused("format = 1\n[scene]\ndt_s = nan\n", "dt_s", &["`dt_s`"]);
    refused("format = 1\n[scene]\nseed = -1\n", "seed", &["`seed`"]);
    refused("format = 1\nmodel = 5\n", "model", &["`model`", "[[model]]"]);
}

#[test]
fn numbers_without_a_meaning_are_refused() {
    refused(&shape("dynamic = true\nmass_kg = -1.0"), "mass_kg", &["mass"]);
    refused(&shape("size_m = [1, -1, 1]"), "size_m", &["size"]);
    refused(&shape("mass_kg = nan"), "mass_kg", &["mass"]);
    refused(&shape("position_m = [inf, 0, 0]"), "position_m", &["position"]);
}

#[test]
fn the_file_itself_is_checked() {
    refused("format = 2\n", "format", &["format 2", "format = 1"]);
    refused("[scene]\ntext = \"x\"\n", "[scene]", &["format = 1", "on top"]);
    refused("format = 1\n[scene\n", "[scene", &["not a TOML file"]);
    refused(
        &with("[[object]]\nkind = \"shape\"\nkind = \"joint\"\n"),
        "kind = \"joint\"",
        &["not a TOML file", "duplicate"],
    );
    let place = Place::new();
    for command in ["run", "check"] {
        place.tatu(&[command, "nowhere.toml"]).refused(&["nowhere.toml", "cannot read the scene"]);
    }
    std::fs::write(place.path().join("scene.toml"), b"format = 1 \xff").unwrap();
    place.run(&[]).refused(&["scene.toml"]);
}

#[test]
fn files_that_are_missing_are_named_with_where_they_should_be() {
    let place = Place::new();
    let there = place.path().join("nowhere.lua");
    let there = there.file_name().unwrap().to_str().unwrap();
    refused_in(&place, &robot("script = \"nowhere.lua\""), "nowhere", &["cannot read the script `nowhere.lua`", there]);
    refused_in(
        &place,
        &with("[[model]]\nmodel = \"nowhere.toml\"\n"),
        "nowhere",
        &["cannot read the model `nowhere.toml`"],
    );
    place.write("controller.py", "print(1)");
    refused_in(&place, &robot("script = \"controller.py\""), "controller", &["controller.py", "lua"]);
}

#[test]
fn models_must_not_contain_themselves() {
    let place = Place::new();
    let using = |file: &str| format!("format = 1\n[[model]]\nmodel = \"{file}\"\n");
    refused_in(&place, &using("scene.toml"), "scene.toml", &["contains itself", "without a cycle"]);

    place.write("a.toml", &using("b.toml")).write("b.toml", &using("a.toml")).write("scene.toml", &using("a.toml"));
    let done = place.run(&[]);
    done.refused(&["`a.toml` contains itself", "b.toml:3:", "scene.toml > ", "a.toml > "]);
    // Twice the same one is no cycle.
    place.write("b.toml", "format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"x\"\n");
    place.write("scene.toml", &(using("b.toml") + &using("b.toml").replace("format = 1\n", "")));
    place.run(&["--steps", "1"]).good();
}

#[test]
fn changes_by_path_are_checked_in_scenes_and_on_the_command_line() {
    let set = |line: &str| robot(&format!("[set]\n{line}"));
    for (path, value, words) in [
        (
            "/Pioneer_p3dx/Pioneer_p3dx_leftMotor.max_forse_nm",
            "2",
            &["max_forse_nm", "did you mean `max_force_nm`?"][..],
        ),
        ("/Pioneer_p3dx/Pioneer_p3dx_leftMotor.max_force_kn", "2", &["wrong unit", "write `max_force_nm`"]),
        (
            "/Pioneer_p3dx/Pioneer_p3dx_leftMotr.max_force_nm",
            "2",
            &["there is no object", "did you mean `Pioneer_p3dx_leftMotor`?"],
        ),
        ("/Pioneer_p3dx.sonar_range_m", "50", &["sonar_range_m", "5"]),
        ("/Pioneer_p3dx.sonar_rnge_m", "2", &["sonar_rnge_m", "did you mean `sonar_range_m`?"]),
        ("floor.mass_kg", "\"x\"", &["mass", "number"]),
        ("floor.path", "\"/x\"", &["path"]),
    ] {
        refused(&set(&format!("\"{path}\" = {value}")), path, words);
        let place = Place::new();
        place.write("scene.toml", &robot(""));
        for command in ["run", "check"] {
            place.tatu(&[command, "scene.toml", "--set", &format!("{path}={value}")]).refused(words);
        }
    }
    refused(&set("nonsense = 1"), "nonsense", &["`nonsense` names no property"]);
    let place = Place::new();
    place.write("scene.toml", &robot(""));
    place.run(&["--set", "nonsense"]).refused(&["nonsense", "PATH.PROPERTY=VALUE"]);
    place.run(&["--set", "scene.dt_ms=5"]).refused(&["wrong unit", "write `dt_s`"]);
}

#[test]
fn arguments_that_name_nothing_are_refused() {
    let place = Place::new();
    place.write("scene.toml", &robot("")).write("a.lua", "");
    place.run(&["--watch", "/Pioneer_p3dy"]).refused(&["--watch", "`/Pioneer_p3dy`", "did you mean `"]);
    place.run(&["--script", "/Pioneer_p3dy=a.lua"]).refused(&["`/Pioneer_p3dy`", "did you mean `"]);
    place.run(&["--script", "/Pioneer_p3dx=b.lua"]).refused(&["b.lua"]);
    place.run(&["--script", "/Pioneer_p3dx"]).refused(&["OBJECT=FILE"]);
    place.run(&["--trace", "no/such/folder/t.jsonl"]).refused(&["no/such/folder/t.jsonl"]);
    for wrong in
        [&["--seconds", "-1"][..], &["--seconds", "much"], &["--steps", "2.5"], &["--threads", "0"], &["--secnds", "1"]]
    {
        place.run(wrong).refused(&[wrong[0]]);
    }
    place.run(&["--steps", "1", "--seconds", "1"]).refused(&["--seconds"]);
}

#[test]
fn mistakes_of_beginners_name_file_and_line() {
    // Text of line 3 of the script, kind of the error, a word of its message.
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
        let place = Place::new();
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
        done.tells(&["robot.lua:3:"]);
    }
}

#[test]
fn scripts_that_are_no_lua_name_file_and_line() {
    for (script, line, word) in [
        ("function sysCall_init()\n  x = 1\n", 3, "end"),
        ("x = 1\nif x = 2 then\nend\n", 2, "then"),
        ("x = 1\n\nint y = 5\n", 3, "y"),
        ("print('abc)\n", 1, "string"),
    ] {
        let place = Place::new();
        place.write("scene.toml", &robot("script = \"robot.lua\"")).write("robot.lua", script);
        let done = place.run(&["--steps", "2"]);
        let e = &done.errors()[0];
        assert!(e["file"].as_str().unwrap().ends_with("robot.lua") && e["line"] == line, "{script}: {e}");
        assert!(e["message"].as_str().unwrap().contains(word), "{script}: {e}");
        done.tells(&[&format!("robot.lua:{line}:")]);
    }
}

#[test]
fn dialects_that_nobody_knows_are_told_with_those_that_are() {
    for wrong in ["3,2", "modern", "3.x"] {
        let scene = format!("format = 1\n[scene]\ndialect = \"{wrong}\"\n");
        refused(&scene, wrong, &["E122", &format!("`{wrong}`"), "`lua`", "3.2", "4.9"]);
        let script = format!("script = {{ text = '', dialect = \"{wrong}\" }}");
        refused(&robot(&script), wrong, &["E122", "such as"]);
    }
    let place = Place::new();
    place.write("scene.toml", &robot("script = { text = '', dialect = '2.6' }"));
    place.run(&["--steps", "1", "--set", "scene.dialect=4.10.1"]).good();
    place.run(&["--steps", "1", "--set", "scene.dialect='4.10.1'"]).good();
    place.run(&["--steps", "1", "--set", "scene.dialect='4,9'"]).refused(&["E122", "4,9"]);
}

#[test]
fn more_misspelt_names_get_the_nearest_one() {
    refused(&shape("primitive = \"spheer\""), "spheer", &["did you mean `sphere`?"]);
    refused(&robot("preset = \"as VREP\""), "as VREP", &["did you mean `as V-REP`?"]);
    refused(&robot("script = { txt = '' }"), "txt", &["did you mean `text`?"]);
    refused(&robot("script = { text = '', kind = 'chidl' }"), "chidl", &["did you mean `child`?"]);
    refused(&robot("positon_m = [0, 0, 0]"), "positon_m", &["did you mean `position_m`?"]);
    refused(
        &with("[[object]]\nkind = \"sensor\"\nsensor = \"proximty/1\"\n"),
        "proximty",
        &["did you mean `proximity/1`?"],
    );
    refused(
        &with("[providers]\n\"proximty/1\" = \"proximity\"\n"),
        "proximty",
        &["E113", "did you mean `proximity/1`?", ".urdf"],
    );
    refused(&with("[[imprt]]\nfile = \"x.urdf\"\n"), "imprt", &["did you mean `import`?"]);
}

#[test]
fn plugin_folders_that_are_not_there_are_told() {
    let place = Place::new();
    place.write("scene.toml", &format!("format = 1\n[scene]\nplugins = [\"nowhere\", \".\"]\n{FLOOR}"));
    let done = place.run(&["--steps", "1"]).good();
    done.tells(&["warning[E311]", "nowhere", "which is not there"]);
    assert_eq!(done.err.matches("E311").count(), 1, "{}", done.err);
}
