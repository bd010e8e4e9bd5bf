//! Tests of plugins written as authors outside of this repository would write them. Those in C and C++ are built by the
//! command in the comment at their top, those in Rust by Cargo. Each is checked by its scene.

use std::{fs, process::Command};

use crate::kit::*;

/// Copies one of the plugins and builds it with the command at its top.
pub fn built(name: &str) -> TestFolder {
    let place = TestFolder::new();
    let from = root().join("tests/outside").join(name);
    copy(&from, place.path());
    let source = if from.join(format!("{name}.c")).is_file() { format!("{name}.c") } else { format!("{name}.cpp") };
    let text = fs::read_to_string(from.join(&source)).unwrap();
    let line = text.lines().find_map(|l| l.strip_prefix("// Build: ")).expect("the file has a line `// Build: `");
    let include = root().join("plugin-api/include").display().to_string();
    let words = line.split_whitespace().map(|w| match w {
        w if w.ends_with("plugin-api/include") => include.clone(),
        w if w.starts_with("libtatu_") => library(&format!("tatu_{name}")),
        w => w.to_owned(),
    });
    let words: Vec<String> = words.collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    succeed(Command::new(compiler(words[0])).args(&words[1..]).current_dir(place.path()));
    place
}

/// Copies one of the plugins in Rust, together with its library, which Cargo has built with the tests.
fn in_rust(name: &str) -> TestFolder {
    let place = TestFolder::new();
    copy(&root().join("tests/outside").join(name), place.path());
    let file = library(&format!("tatu_{name}"));
    fs::copy(program().with_file_name("deps").join(&file), place.path().join(&file)).unwrap();
    place
}

/// As `built`; the scene loads the plugin, and has no script that checks the behaviour.
pub fn built_for_its_scene(name: &str) -> TestFolder {
    let place = built(name);
    let scene = place.read("scene.toml").replace("[scene]\n", "[scene]\nplugins = [\".\"]\n");
    let (scene, _) = scene.split_once("[[object]]\nkind = \"dummy\"\nalias = \"checker\"").unwrap();
    place.write("scene.toml", scene);
    place
}

/// Checks that the scene runs to its end, that its script reports no failed check, and that the hashes with one and two
/// threads are equal.
fn works(place: &TestFolder, scene: &str, more: &[&str]) {
    let env = [("TATU_PLUGIN_PATH", ".")];
    let hash = |threads| {
        let args = [&["run", scene, "--json", "--threads", threads], more].concat();
        run(program(), place.path(), &args, &env).good().json()["hash"].clone()
    };
    assert_eq!(hash("1"), hash("2"));
}

#[test]
fn commands_that_call_functions_and_wait() {
    works(&built("fleet"), "scene.toml", &["--steps", "60"]);
}

#[test]
fn a_sensor_with_a_schema_and_a_preset() {
    works(&built("lamp"), "scene.toml", &["--steps", "40"]);
}

#[test]
fn a_sensor_that_counts_shocks() {
    works(&built("shock"), "scene.toml", &["--steps", "60"]);
    works(&in_rust("knock"), "scene.toml", &["--steps", "60"]);
    // The count is in the state block, so snapshots contain it.
    let place = built("shock");
    let env = [("TATU_PLUGIN_PATH", ".")];
    let end = |more: &[&str]| {
        let args =
            [&["run", "scene.toml", "--steps", "60", "--trace", "t.jsonl", "--watch", "/box/feeler"], more].concat();
        let done = run(program(), place.path(), &args, &env).good();
        assert!(!done.err.contains("replay"), "{}", done.err);
        place.lines("t.jsonl").pop().unwrap().sensor("/box/feeler", "shock.count")
    };
    let whole = end(&["--snapshot-at", "1", "half"]);
    assert!(whole >= 1.0);
    assert_eq!(end(&["--from", "half"]), whole);
}

#[test]
fn a_robot_with_a_drive() {
    works(&built("cart"), "scene.toml", &["--steps", "120"]);
}

#[test]
fn parts_drive_to_the_bits_of_the_scripts_that_they_replace() {
    let place = built("controllers");
    let env = [("TATU_PLUGIN_PATH", ".")];
    let ran = |scene: &str, more: &[&str]| {
        let done = run(program(), place.path(), &[&["run", scene, "--json"], more].concat(), &env).good();
        assert!(!done.err.contains("replay"), "{}", done.err);
        done
    };
    let arena = root().join("scenes/first/pioneer_avoids_walls.toml");
    let seconds = ["--seconds", "20"];
    let script = ran(arena.to_str().unwrap(), &seconds).json()["hash"].clone();
    for threads in ["1", "2", "4"] {
        let part = ran("pioneer.toml", &[&seconds[..], &["--threads", threads]].concat()).json();
        assert_eq!(part["hash"], script, "{threads} threads");
        let told = &part["parts"][0];
        assert_eq!((told["object"].as_str(), told["calls"].as_u64()), (Some("/Pioneer_p3dx/driver"), Some(400)));
        assert!(told["wall_s"].as_f64().is_some_and(|s| s > 0.0 && s < 20.0), "{told}");
    }
    // The side to which it turns is saved by the part itself.
    ran("pioneer.toml", &["--seconds", "20", "--snapshot-at", "9", "half"]);
    assert_eq!(ran("pioneer.toml", &["--seconds", "20", "--from", "half"]).json()["hash"], script);

    let arm = |scene: &str, more: &[&str]| {
        let done = ran(scene, &[&["--seconds", "2"], more].concat()).json();
        (done["objects"]["/post"]["hash"].clone(), done["hash"].clone())
    };
    let (script, part) = (arm("arm_script.toml", &[]), arm("arm.toml", &[]));
    assert_eq!(part.0, script.0);
    assert_ne!(part.1, script.1, "the hash of the world includes the part's state block");
    arm("arm.toml", &["--snapshot-at", "0.7", "half"]);
    assert_eq!(arm("arm.toml", &["--from", "half"]), part);
}

#[test]
fn presets_of_parts_are_applied_before_the_keys_of_the_scene() {
    let place = built("controllers");
    let scene = fs::read_to_string(place.path().join("pioneer.toml")).unwrap();
    let print = "script = { text = '''
        function sysCall_init()
            local driver = sim.getObject('/driver')
            print('cruise', tatu.get(driver, 'braitenberg.cruise'), tatu.get(driver, 'braitenberg.far'))
        end''' }\n";
    let told = |more: &str| {
        let more = format!("alias = \"driver\"\n{more}{print}");
        place.write("preset.toml", &scene.replace("alias = \"driver\"\n", &more));
        run(program(), place.path(), &["run", "preset.toml", "--steps", "1"], &[("TATU_PLUGIN_PATH", ".")])
    };
    let timid = told("preset = \"timid\"\nfar_m = 0.7\n").good();
    assert!(timid.out.contains("cruise\t1.047197551196"), "{}", timid.out);
    assert!(timid.out.trim_end().ends_with("\t0.7"), "{}", timid.out);
    let unknown = told("preset = \"tired\"\n");
    assert!(unknown.err.contains("the part kind `braitenberg` has no preset `tired`"), "{}", unknown.err);
}

#[test]
fn a_radar_that_reads_the_motion_of_its_target() {
    works(&built("radar"), "scene.toml", &["--steps", "40"]);
}

#[test]
fn a_part_with_a_window_in_the_page() {
    works(&built("speedometer"), "scene.toml", &["--steps", "30"]);
}

#[test]
fn a_tag_that_measures_its_distances_to_beacons() {
    let place = built("uwb");
    works(&place, "scene.toml", &["--steps", "50"]);
    // A reloaded plugin gets the targets again; `extremes` removes some.
    for test in ["reload", "extremes"] {
        place.tatu(&["plugin", "check", &library("tatu_uwb"), "--only", test]).good();
    }
}

#[test]
fn a_magnet_that_acts_on_several_bodies() {
    works(&built("magnet"), "scene.toml", &["--steps", "20"]);
}

#[test]
fn a_winch_in_rust_that_lifts_a_crate() {
    works(&in_rust("winch"), "scene.toml", &["--steps", "110"]);
}

#[test]
fn parts_that_push_several_bodies() {
    works(&built("tether"), "scene.toml", &["--steps", "80"]);
    works(&built("wind"), "scene.toml", &["--steps", "20"]);
}

#[test]
fn parts_decide_on_contacts_and_plugins_receive_events() {
    let place = built("surfaces");
    works(&place, "scene.toml", &["--steps", "45"]);
    let env = [("TATU_PLUGIN_PATH", ".")];
    let hash = |more: &[&str]| {
        let args = [&["run", "scene.toml", "--json", "--steps", "45"], more].concat();
        let done = run(program(), place.path(), &args, &env).good();
        assert!(!done.err.contains("replay"), "{}", done.err);
        done.json()["hash"].clone()
    };
    let whole = hash(&["--snapshot-at", "1.2", "half"]);
    assert_eq!(hash(&["--from", "half"]), whole);
    assert_eq!(hash(&["--threads", "4"]), whole);
}

#[test]
fn a_service_with_state_in_snapshots() {
    let place = built("counter");
    works(&place, "scene.toml", &["--steps", "40"]);
    let env = [("TATU_PLUGIN_PATH", ".")];
    let of = |more: &[&str]| {
        let args = [&["run", "snapshot.toml", "--json", "--steps", "40"], more].concat();
        run(program(), place.path(), &args, &env)
    };
    of(&["--snapshot-at", "1", "half.snapshot"]).good();
    of(&["--from", "half.snapshot"]).good();
    let args = ["run", "scene.toml", "--json", "--steps", "40", "--service", "counter:most=20"];
    let errors = run(program(), place.path(), &args, &env).errors();
    let told = errors[0]["message"].as_str().unwrap();
    assert!(told.contains("the service `counter`: ") && told.contains("tatu_service.barrier"), "{told}");
}

#[test]
#[cfg_attr(no_cxx, ignore = "there is no C++ compiler")]
fn exceptions_stay_inside() {
    works(&built("guard"), "scene.toml", &["--allow", "plugins", "--steps", "5"]);
}

#[test]
fn a_sensor_in_rust_with_a_schema_and_a_live_parameter() {
    let place = in_rust("compass");
    works(&place, "scene.toml", &["--steps", "20"]);
    let told = run(program(), place.path(), &["describe", "needle", "--json"], &[("TATU_PLUGIN_PATH", ".")]);
    let told = told.good().json();
    let (heading, [offset, dead]) = (&told["fields"][1], [0, 1].map(|i| &told["parameters"][i]));
    assert_eq!((heading["valid"].as_str(), heading["nothing"].as_str()), (Some("compass.valid"), Some("0")));
    assert_eq!((offset["rebuilds"].as_bool(), dead["rebuilds"].as_bool()), (None, Some(true)));
}

#[test]
fn a_sensor_in_rust_that_remembers_goes_on_from_a_snapshot() {
    let place = in_rust("compass");
    works(&place, "turns.toml", &["--steps", "60"]);
    let env = [("TATU_PLUGIN_PATH", ".")];
    let of = |more: &[&str]| {
        let args = [&["run", "turns.toml", "--json", "--steps", "60"], more].concat();
        let done = run(program(), place.path(), &args, &env).good();
        assert!(!done.err.contains("replay"), "{}", done.err);
        done.json()["hash"].clone()
    };
    let whole = of(&["--snapshot-at", "1.5", "half"]);
    assert_eq!(of(&["--from", "half"]), whole);
}

#[test]
fn commands_in_rust_that_store_state_call_and_wait() {
    let place = in_rust("tally");
    works(&place, "scene.toml", &["--steps", "60"]);
    works(&place, "side_by_side.toml", &["--steps", "60"]);
    let env = [("TATU_PLUGIN_PATH", ".")];
    let hash = |more: &[&str]| {
        let args = [&["run", "scene.toml", "--json", "--steps", "60"], more].concat();
        run(program(), place.path(), &args, &env).good().json()["hash"].clone()
    };
    let whole = hash(&["--snapshot-at", "1.5", "late"]);
    assert_eq!(hash(&["--from", "late"]), whole);
}
