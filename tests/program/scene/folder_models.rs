//! Tests of models without code, which are folders with a `model.toml`: their parameters, the folders in which they are
//! found, and their texts in input logs.

use serde_json::Value;

use crate::kit::{said::said, *};

/// A robot with three parameters and two slots.
pub const ROVER: &str = include_str!("../../outside/rover/models/rover/model.toml");

/// A device for a slot of the robot.
pub const CLAW: &str = include_str!("../../outside/rover/models/claw/model.toml");

/// Creates a folder with both models, and a scene with these entries.
pub fn place(scene: &str) -> TestFolder {
    let place = TestFolder::scene(scene);
    place.write("models/rover/model.toml", ROVER).write("models/claw/model.toml", CLAW);
    place.write("models/rover/blink.lua", "function sysCall_init() print('blinks') end\n");
    place
}

/// Returns the scene as saved by the program, with an entry for each object in place of models.
pub fn flat(place: &TestFolder, args: &[&str]) -> String {
    place.tatu(&[&["convert", "scene.toml", "flat.toml"], args].concat()).good();
    place.read("flat.toml")
}

/// Returns the entry of the object with the unique name `name` or, if no object has it, the alias `name`.
pub fn object<'t>(flat: &'t str, name: &str) -> &'t str {
    let named = |key: &str| flat.split("[[object]]").find(|o| o.contains(&format!("\n{key} = \"{name}\"\n")));
    named("name").or_else(|| named("alias")).unwrap_or_else(|| panic!("no {name} in\n{flat}"))
}

#[track_caller]
pub fn has(flat: &str, name: &str, lines: &[&str]) {
    let object = object(flat, name);
    for line in lines {
        assert!(object.lines().any(|l| l == *line), "{name} lacks `{line}`:\n{object}");
    }
}

/// Creates four instances of one model with different parameters. The expected values follow from the expressions.
#[test]
fn each_instance_has_its_own_parameters() {
    let place = place(
        "[[model]]\nmodel = \"rover\"\nalias = \"a\"\n\
         [[model]]\nmodel = \"rover\"\nalias = \"b\"\nlength_m = 1.0\nlook = \"bright\"\n\
         [[model]]\nmodel = \"rover\"\nalias = \"c\"\nwith_arm = false\nposition_m = [0.0, 2.0, 0.0]\n\
         [[model]]\nfile = \"models/rover/model.toml\"\nalias = \"d\"\nlength_m = 0.5\n",
    );
    let text = flat(&place, &["--set", "/d.length_m=0.8"]);
    has(&text, "a", &["size_m = [0.4, 0.3, 0.1]", "color = [0.5, 0.5, 0.5]", "position_m = [0.0, 0.0, 0.1]"]);
    has(&text, "front", &["position_m = [0.2, 0.0, 0.0]", "orientation_deg = [0.0, 90.0, 0.0]", "parent = \"a\""]);
    has(&text, "arm", &["size_m = [0.1, 0.02, 0.02]", "parent = \"a\""]);
    has(&text, "b#0", &["size_m = [1.0, 0.3, 0.1]", "color = [1.0, 0.25, 0.0]"]);
    has(&text, "tip#0", &["position_m = [0.125, 0.0, 0.0]", "parent = \"arm#0\""]);
    has(&text, "c#1", &["position_m = [0.0, 2.0, 0.1]"]);
    has(&text, "led_2#1", &["position_m = [0.25, 0.0, 0.0]", "data = { note = \"=not an expression\" }"]);
    has(&text, "led_1#1", &["layer = 2"]);
    assert!(!text.contains("arm#1") || object(&text, "arm#1").contains("d#2"), "c must not have an arm:\n{text}");
    has(&text, "d#2", &["size_m = [0.8, 0.3, 0.1]"]);
    // A parameter of a model within a model can also be set.
    let text = flat(&place, &["--set", "/a/arm.reach_m=0.3"]);
    has(&text, "arm", &["size_m = [0.3, 0.02, 0.02]"]);
    has(&text, "arm#0", &["size_m = [0.25, 0.02, 0.02]"]);
    let done = place.tatu(&["run", "scene.toml", "--steps", "2"]).good();
    assert_eq!(done.out.matches("blinks").count(), 4, "{}", done.out);
    place.tatu(&["check", "scene.toml"]).good();
}

/// Models are found in the folders in which their authors develop them.
#[test]
fn models_of_others_work() {
    let from = root().join("tests/outside/rover");
    let done = run(program(), &from, &["run", "scene.toml", "--steps", "4", "--strict"], &[]).good();
    assert_eq!(done.out.matches("blinks").count(), 2, "{}", done.out);
}

#[test]
fn a_model_runs_alone_and_finds_its_neighbours() {
    let place = place("");
    let done = place.tatu(&["run", "models/rover/model.toml", "--steps", "2", "--set", "/body.length_m=1"]).good();
    assert!(done.out.contains("blinks"), "{}", done.out);
    let place = TestFolder::scene("");
    place.write("robot.toml", &CLAW.replace("A claw", "A robot"));
    place.tatu(&["check", "robot.toml"]).good();
}

/// The first folder in the search order is used. If a plugin has a model with the same id, the scene must select one.
#[test]
fn the_first_folder_is_used_and_conflicts_are_reported() {
    let place = TestFolder::scene("[[model]]\nmodel = \"claw\"\n");
    let of = |size: &str| CLAW.replace("\"=reach\", 0.02, 0.02", size);
    place.write("models/claw/model.toml", &of("0.1, 0.1, 0.1"));
    place.write("given/claw/model.toml", &of("0.2, 0.2, 0.2"));
    place.write(".data/tatu/models/claw/model.toml", &of("0.3, 0.3, 0.3"));
    let check = |size: &str| {
        let given = place.path().join("given");
        let env = [("TATU_MODEL_PATH", given.to_str().unwrap())];
        run(program(), place.path(), &["convert", "scene.toml", "flat.toml"], &env).good();
        has(&place.read("flat.toml"), "claw", &[size]);
    };
    check("size_m = [0.1, 0.1, 0.1]");
    std::fs::remove_dir_all(place.path().join("models")).unwrap();
    check("size_m = [0.2, 0.2, 0.2]");
    std::fs::remove_dir_all(place.path().join("given")).unwrap();
    check("size_m = [0.3, 0.3, 0.3]");

    let library = library("tatu_testing_misbehaves_safely");
    let scene = |chosen: &str| {
        let place = TestFolder::scene(&format!("{chosen}[[model]]\nmodel = \"misbehaves_safely\"\n"));
        place.write("models/misbehaves_safely/model.toml", CLAW).write("more/readme", "");
        std::fs::copy(program().with_file_name("deps").join(&library), place.path().join("more").join(&library))
            .unwrap();
        let done =
            run(program(), place.path(), &["convert", "scene.toml", "flat.toml"], &[("TATU_PLUGIN_PATH", "more")]);
        (place, done)
    };
    scene("").1.refused(&["E322", "tatu.models.folder", "[providers]"]);
    for (by, tip) in [("tatu.models.folder", true), ("tatu.testing.misbehaves_safely", false)] {
        let (place, done) = scene(&format!("[providers]\n\"misbehaves_safely\" = \"{by}\"\n"));
        done.good();
        assert_eq!(place.read("flat.toml").contains("\"tip\""), tip, "{by}");
    }
}

const TWO_ROVERS: &str = "[[model]]\nmodel = \"rover\"\nslots = { front = { model = \"claw\" } }\n\
                   [[model]]\nmodel = \"rover\"\nlength_m = 1.0\nposition_m = [0.0, 2.0, 0.0]\n";

#[test]
fn runs_replays_and_snapshots_have_the_same_bits() {
    let place = place(TWO_ROVERS);
    let hash = |done: RunOutput| done.good().json()["hash"].clone();
    let first = hash(place.run(&["--steps", "30", "--log", "run.log", "--snapshot-at", "0.5", "at.snap"]));
    assert_eq!(first, hash(place.run(&["--steps", "30", "--threads", "2"])));
    assert_eq!(first, hash(place.run(&["--steps", "30", "--from", "at.snap"])));
    // A replay needs neither the scene nor the models, and ignores other models with the same names.
    let other = TestFolder::new();
    other.write("models/rover/model.toml", CLAW);
    std::fs::copy(place.path().join("run.log"), other.path().join("run.log")).unwrap();
    assert_eq!(first, hash(other.tatu(&["run", "--replay", "run.log", "--json"])));
}

#[test]
fn files_of_importers_are_models_by_name() {
    let urdf = "<robot name=\"bench\"><link name=\"base\"><visual><geometry><box size=\"1 1 1\"/></geometry></visual>\
                </link><link name=\"lid\"/><joint name=\"hinge\" type=\"fixed\"><parent link=\"base\"/>\
                <child link=\"lid\"/></joint></robot>";
    let place = TestFolder::scene(
        "[[model]]\nmodel = \"bench\"\nalias = \"one\"\nfixed_base = true\n\
         [[model]]\nmodel = \"stool\"\nalias = \"two\"\nslots = { lid = { sensor = \"proximity\", alias = \"eye\" } }\n",
    );
    place.write("models/bench/bench.urdf", urdf).write("models/stool.urdf", urdf);
    let text = flat(&place, &[]);
    has(&text, "one", &[]);
    assert!(object(&text, "eye").contains("parent = \"lid"), "{text}");
    let listed = place.tatu(&["list", "models", "--json"]).good().json();
    let row = |id: &str| listed.as_array().unwrap().iter().find(|r| r["id"] == id).cloned().unwrap_or_default();
    for id in ["bench", "stool"] {
        assert_eq!(row(id)["plugin"], "tatu.importer.urdf", "{listed}");
        let keys: Vec<Value> = row(id)["parameters"].as_array().unwrap().iter().map(|p| p["name"].clone()).collect();
        assert!(keys.contains(&"fixed_base".into()), "{keys:?}");
    }
}

#[test]
fn scripts_list_and_add_models_of_folders() {
    let script = "function sysCall_init()
          local texts = {}
          for _, m in ipairs(tatu.models()) do texts[m.id] = m.text end
          assert(texts.rover == 'A robot on two wheels.' and texts.pioneer_p3dx and not texts.broken)
          print(sim.getObjectAlias(sim.loadModel('rover'), 2), tatu.addModel('claw') > 0)
          assert(not pcall(sim.loadModel, 'rovre'))
        end";
    let place = place(&watcher("maker", script));
    place.write("models/broken/model.toml", "format = 1\n[model]\n");
    let done = place.tatu(&["run", "scene.toml", "--steps", "2"]).good();
    assert!(done.out.contains("/body\ttrue"), "{}\n{}", done.out, done.err);
}

/// The program lists and describes models. A broken model causes a warning and does not affect the others.
#[test]
fn models_of_folders_are_listed_and_described() {
    let place = place(TWO_ROVERS);
    let described = place.tatu(&["describe", "rover", "claw"]).good().out;
    let mut said = said!();
    said.add("describe rover claw", &place, &described);
    let rows = place.tatu(&["list", "models", "--json"]).good().json();
    let rover = rows.as_array().unwrap().iter().find(|r| r["id"] == "rover").cloned().unwrap();
    said.add("list models --json", &place, &serde_json::to_string_pretty(&rover).unwrap());
    place.write("models/broken/model.toml", "format = 1\n[model]\ntext = 3\n");
    let listed = place.tatu(&["list", "models"]).good();
    assert!(listed.out.contains("rover") && !listed.out.contains("broken"), "{}", listed.out);
    listed.reports(&["warning[E111]", "models/broken/model.toml:3:1", "`text`: expected a string"]);
    place.tatu(&["check", "scene.toml"]).good();
}
