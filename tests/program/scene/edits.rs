//! Tests of edits that clients make in a stopped world: they are undone, redone, saved into the scene file, and read
//! again.

use std::{
    fs,
    io::{BufRead, BufReader, Write},
    net::TcpStream,
};

use serde_json::{Value, json};

use crate::kit::{served_scene::ServedScene, *};

/// A scene with comments, units, a script in a file and a model.
const SCENE: &str = "\
# A cup on a table.
format = 1

[[object]]
kind = \"shape\"
alias = \"floor\"
primitive = \"plane\"
respondable = true

# The table stands at the origin.
[[object]]
kind = \"shape\"
alias = \"table\"
size_m = [1.0, 0.6, 0.7]  # a desk
position_m = [0.0, 0.0, 0.35]

[[object]]
kind = \"shape\"
alias = \"cup\"
parent = \"table\"
position_m = [0.2, 0.1, 0.41]   # near the edge
dynamic = true
script = \"cup.lua\"

[[model]]
model = \"pioneer_p3dx\"
alias = \"blue\"   # the robot
position_m = [2.0, 0.0, 0.0]
";

struct SceneEditor {
    to: TcpStream,
    from: BufReader<TcpStream>,
    _program: ServedScene,
}

impl SceneEditor {
    fn open(place: &TestFolder, more: &[&str]) -> SceneEditor {
        let program = ServedScene::with("jsonl", &place.path().join("scene.toml").display().to_string(), more);
        let to = program.connect();
        SceneEditor { from: BufReader::new(to.try_clone().unwrap()), to, _program: program }
    }
    fn ask(&mut self, message: &Value) -> Value {
        // The message is written at once, because the second of several packets would wait for an acknowledgement.
        self.to.write_all(format!("{message}\n").as_bytes()).unwrap();
        let mut line = String::new();
        assert!(self.from.read_line(&mut line).unwrap() > 0, "the program has exited");
        serde_json::from_str(&line).unwrap()
    }
    /// Calls a command and returns its results or its error.
    fn attempt(&mut self, name: &str, args: Value) -> Result<Value, String> {
        let answer = self.ask(&json!({ "id": 1, "call": name, "args": args }));
        match answer.get("error") {
            Some(e) => Err(e["text"].as_str().unwrap_or_default().to_owned()),
            None => Ok(answer["result"].clone()),
        }
    }
    #[track_caller]
    fn call(&mut self, name: &str, args: Value) -> Value {
        self.attempt(name, args).unwrap_or_else(|e| panic!("{name}: {e}"))[0].clone()
    }
    #[track_caller]
    fn edit(&mut self, label: &str, calls: Value) -> Value {
        self.call("tatu.edit", json!([label, calls]))
    }
    fn get(&mut self, object: &Value, key: &str) -> Value {
        self.attempt("tatu.get", json!([object, key])).map_or(Value::Null, |v| v[0].clone())
    }
    fn find(&mut self, path: &str) -> Value {
        self.attempt("sim.getObject", json!([path])).map_or(Value::Null, |v| v[0].clone())
    }
    fn path(&mut self, object: &Value) -> String {
        self.call("sim.getObjectAlias", json!([object, 2])).as_str().unwrap().to_owned()
    }
    /// Returns the state of the scene as sorted lines: one for each settable property, except parents, unique names and
    /// poses; one for the pose of each object in the world; and one for each script. Values are rounded.
    fn all(&mut self) -> Vec<String> {
        let mut out = Vec::new();
        for object in self.call("tatu.list", json!([])).as_array().unwrap().clone() {
            let path = self.path(&object);
            for row in self.call("tatu.properties", json!([object])).as_array().unwrap().clone() {
                let key = row["key"].as_str().unwrap();
                let placed = ["object.quaternion", "object.orientation", "object.pose", "object.world_pose"];
                if row["settable"] == true && !placed.contains(&key) && !["object.parent", "object.name"].contains(&key)
                {
                    out.push(format!("{path} {key} {}", rounded(&self.get(&object, key))));
                }
            }
            let pose = self.call("sim.getObjectMatrix", json!([object, -1]));
            out.push(format!("{path} {}", rounded(&pose)));
        }
        for script in self.call("tatu.list", json!(["script"])).as_array().unwrap().clone() {
            let owner = self.get(&script, "object.parent");
            let text = self.call("tatu.getScript", json!([script]));
            out.push(format!("{} {text}", self.path(&owner)));
        }
        out.sort();
        out
    }
}

fn rounded(value: &Value) -> String {
    match value {
        Value::Number(n) if n.is_f64() => format!("{:.5}", n.as_f64().unwrap() + 0.0).replace("-0.00000", "0.00000"),
        Value::Array(all) => all.iter().map(rounded).collect::<Vec<_>>().join(" "),
        other => other.to_string(),
    }
}

fn place() -> TestFolder {
    let place = TestFolder::new();
    place.write("scene.toml", SCENE).write("cup.lua", "function sysCall_init() end\n");
    place
}

fn scene(place: &TestFolder) -> String {
    fs::read_to_string(place.path().join("scene.toml")).unwrap()
}

/// Returns the lines of `text` that `other` does not contain.
fn lines_beside<'a>(text: &'a str, other: &str) -> Vec<&'a str> {
    text.lines().filter(|l| !other.lines().any(|o| o == *l)).collect()
}

#[test]
fn a_deleted_object_is_restored_by_undo() {
    let place = place();
    let mut e = SceneEditor::open(&place, &[]);
    let (table, cup) = (e.find("/table"), e.find("/table/cup"));
    let before = (e.call("tatu.list", json!([])), e.call("tatu.list", json!(["script"])), e.all());
    e.edit("Delete table", json!([["tatu.remove", [table, cup]]]));
    assert!(e.find("/table").is_null());
    assert_eq!(e.call("tatu.undo", json!([])), "Delete table");
    assert_eq!((e.call("tatu.list", json!([])), e.call("tatu.list", json!(["script"])), e.all()), before);
    assert_eq!((e.find("/table"), e.find("/table/cup")), (table.clone(), cup));
    assert_eq!(e.call("tatu.redo", json!([])), "Delete table");
    assert!(e.find("/table").is_null());
    let edits = e.call("tatu.edits", json!([]));
    assert_eq!(
        (&edits["undo"], &edits["redo"], &edits["unsaved"]),
        (&json!(["Delete table"]), &json!([]), &json!(true))
    );
}

#[test]
fn a_failed_edit_has_no_effect_and_a_drag_is_one_edit() {
    let place = place();
    let mut e = SceneEditor::open(&place, &[]);
    let cup = e.find("/table/cup");
    let before = e.all();
    let wrong = e.attempt(
        "tatu.edit",
        json!(["Move", [["tatu.set", cup, "object.position", [1, 1, 1]], ["tatu.set", cup, "no.key", 1]]]),
    );
    assert!(wrong.unwrap_err().contains("no.key"));
    assert_eq!((e.all(), e.call("tatu.edits", json!([]))["unsaved"].clone()), (before.clone(), json!(false)));
    for n in 0..5 {
        e.call("tatu.edit", json!(["Move cup", [["tatu.set", cup, "object.position", [n, 0, 1]]], "drag 1"]));
    }
    assert_eq!(e.get(&cup, "object.position")[0], 4.0);
    e.call("tatu.undo", json!([]));
    assert_eq!(e.all(), before);
    assert!(e.call("tatu.undo", json!([])).is_null());
}

#[test]
fn moving_a_box_changes_one_line_of_the_file() {
    let place = place();
    let mut e = SceneEditor::open(&place, &[]);
    let cup = e.find("/table/cup");
    e.edit("Move cup", json!([["tatu.set", cup, "object.position", [0.25, 0.1, 0.41]]]));
    e.attempt("tatu.saveScene", json!([])).unwrap();
    let saved = scene(&place);
    assert_eq!(lines_beside(&saved, SCENE), ["position_m = [0.25, 0.1, 0.41]   # near the edge"]);
    assert_eq!(saved.lines().count(), SCENE.lines().count());
    assert_eq!(e.call("tatu.edits", json!([]))["unsaved"], false);
    // When the move is undone and saved, the file equals the original.
    e.call("tatu.undo", json!([]));
    assert_eq!(e.call("tatu.edits", json!([]))["unsaved"], true);
    e.attempt("tatu.saveScene", json!([])).unwrap();
    assert_eq!(scene(&place), SCENE);
}

#[test]
fn models_are_saved_as_models_with_what_differs() {
    let place = place();
    let mut e = SceneEditor::open(&place, &[]);
    let (blue, motor) = (e.find("/blue"), e.find("/blue/Pioneer_p3dx_leftMotor"));
    let sonar = e.find("/blue/Pioneer_p3dx_ultrasonicSensor1");
    let z = e.get(&blue, "object.position")[2].clone();
    let script = e.call("tatu.list", json!(["script"]))[0].clone();
    let added = e.edit("Add", json!([["tatu.addModel", "gps"]]))[0][0].clone();
    e.edit(
        "Change",
        json!([
            ["tatu.set", blue, "object.position", [2, 1, z]],
            ["tatu.set", blue, "object.alias", "green"],
            ["tatu.set", motor, "joint.max_force", 4.0],
            ["tatu.set", added, "object.position", [1, 2, 0.5]],
            ["tatu.remove", [sonar]],
            ["tatu.setScript", script, "-- new\n"],
        ]),
    );
    let all = e.all();
    e.attempt("tatu.saveScene", json!([])).unwrap();
    let saved = scene(&place);
    for line in [
        "alias = \"green\"   # the robot",
        "position_m = [2.0, 1.0, 0.0]",
        "model = \"gps\"",
        "remove = [\"Pioneer_p3dx_visible/Pioneer_p3dx_ultrasonicSensor1\"]",
        "\"/green/Pioneer_p3dx_leftMotor.max_force_nm\" = 4.0",
    ] {
        assert!(saved.lines().any(|l| l == line), "{line}:\n{saved}");
    }
    assert_eq!(fs::read_to_string(place.path().join("cup.lua")).unwrap(), "-- new\n");
    assert_eq!(SceneEditor::open(&place, &[]).all(), all);
}

#[test]
fn a_file_that_others_changed_is_not_overwritten_unasked() {
    let place = place();
    let mut e = SceneEditor::open(&place, &[]);
    let cup = e.find("/table/cup");
    e.edit("Move cup", json!([["tatu.set", cup, "object.position", [0.25, 0.1, 0.41]]]));
    place.write("scene.toml", &format!("{SCENE}\n# mine\n"));
    let refused = e.attempt("tatu.saveScene", json!([])).unwrap_err();
    assert!(refused.contains("has changed on disk"), "{refused}");
    assert!(scene(&place).ends_with("# mine\n"));
    let other = place.path().join("other.toml");
    e.attempt("tatu.saveScene", json!([Value::Null, true])).unwrap();
    assert!(!scene(&place).contains("# mine") && !other.exists());
}

/// Stopping a run reverts the edits that were made during it, except for those of script texts. Earlier edits can then
/// be undone again, and effects of scripts are not saved.
#[test]
fn a_stop_reverts_edits_made_in_a_run() {
    let place = place();
    place.write(
        "cup.lua",
        "function sysCall_init() sim.setShapeColor(sim.getObject('/floor'), nil, 0, {1, 0, 0}) \
                  sim.writeCustomDataBlock(sim.handle_scene, 'found', 'by a script') end",
    );
    let mut e = SceneEditor::open(&place, &[]);
    let (cup, table) = (e.find("/table/cup"), e.find("/table"));
    e.edit("Move table", json!([["tatu.set", table, "object.position", [1, 0, 0.35]]]));
    assert!(e.attempt("sim.startSimulation", json!([])).is_ok());
    let running = |e: &mut SceneEditor| e.get(&json!(0), "scene.running") == true;
    assert!((0..1000).any(|_| running(&mut e) || {
        std::thread::sleep(std::time::Duration::from_millis(5));
        false
    }));
    e.edit("Delete cup", json!([["tatu.remove", [cup]]]));
    let refused = e.attempt("tatu.undo", json!([])).unwrap_err();
    assert!(refused.contains("while the simulation runs"), "{refused}");
    assert!(e.attempt("sim.stopSimulation", json!([])).is_ok());
    assert!((0..1000).any(|_| !running(&mut e) || {
        std::thread::sleep(std::time::Duration::from_millis(5));
        false
    }));
    assert_eq!(e.find("/table/cup"), cup);
    assert_eq!(e.call("tatu.list", json!(["script", cup])).as_array().unwrap().len(), 1);
    e.attempt("tatu.saveScene", json!([])).unwrap();
    assert_eq!(lines_beside(&scene(&place), SCENE), ["position_m = [1.0, 0.0, 0.35]"]);
    assert_eq!(e.call("tatu.undo", json!([])), "Move table");
}

/// Makes random edits and saves after every few of them. Reading the file must yield the saved state.
#[test]
fn any_edited_scene_can_be_read_again() {
    for seed in 0..3_u64 {
        let place = place();
        let mut e = SceneEditor::open(&place, &[]);
        // A linear congruential generator (Knuth's MMIX) is good enough to choose edits.
        let mut state = seed;
        let mut random = move |n: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % n
        };
        for round in 0..24 {
            let all = e.call("tatu.list", json!([])).as_array().unwrap().clone();
            let object = all[random(all.len())].clone();
            let x = random(200) as f64 / 50.0 - 2.0;
            let script = e.call("tatu.list", json!(["script"])).as_array().unwrap().first().cloned();
            let call = match random(11) {
                0 | 1 => json!(["tatu.set", object, "object.position", [x, 0.5 * x, 0.25]]),
                2 => json!(["tatu.set", object, "object.orientation", [0.2, x / 2.0, x]]),
                3 => json!(["tatu.set", object, "object.alias", format!("thing{round}")]),
                4 => json!(["tatu.remove", [object]]),
                5 => json!(["tatu.copy", [object], Value::Null, [x, 1, 0]]),
                6 => json!(["tatu.addModel", if x > 0.0 { "gps" } else { "sick" }]),
                7 => json!(["tatu.add", "format = 1\n[[object]]\nsensor = \"laser\"\nalias = \"eye\"", object]),
                8 => json!(["tatu.set", object, "object.visible", x > 0.0]),
                9 if script.is_some() => json!(["tatu.setScript", script, format!("-- {x}\n")]),
                _ => json!(["tatu.addScript", object, format!("-- {x}\n")]),
            };
            e.edit("Edit", json!([call]));
            if random(4) == 0 {
                e.call("tatu.undo", json!([]));
            }
            if round % 8 == 7 {
                e.attempt("tatu.saveScene", json!([])).unwrap_or_else(|why| panic!("seed {seed}: {why}"));
                let (saved, read) = (e.all(), SceneEditor::open(&place, &[]).all());
                let lost: Vec<_> = saved.iter().filter(|l| !read.contains(l)).take(5).collect();
                assert!(saved == read, "seed {seed}: {lost:#?}\n{}", scene(&place));
            }
        }
    }
}

/// The replay of a session with edits, undos, a start, a run and a stop yields the same hash.
#[test]
fn a_session_with_edits_is_replayed() {
    let place = place();
    edited_session(&place, "--log", "session.log", |place| {
        fs::read_to_string(place.path().join("session.log")).is_ok_and(|t| t.contains("\"end\":"))
    });
    let text = place.read("session.log");
    let end: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
    assert!(end["end"].as_u64().unwrap() > 20, "{end}");
    let replayed = place.tatu(&["run", "--replay", "session.log", "--json"]);
    assert!(replayed.out.contains(end["hash"].as_str().unwrap()), "{}\n{}", replayed.out, replayed.err);
    assert!(!replayed.err.contains("E504"), "{}", replayed.err);
}

/// A recorded session is repeated from the scene as it was opened.
#[test]
fn a_recorded_session_with_edits_is_the_same() {
    let place = place();
    edited_session(&place, "--capsule", "session.tatu", |place| place.path().join("session.tatu").exists());
    let verified = place.tatu(&["verify", "session.tatu"]).good();
    assert!(verified.out.starts_with("same: "), "{}{}", verified.out, verified.err);
}

/// Serves the scene of `place`, edits it, runs it for some steps, and stops it. Returns when `is_written` holds.
fn edited_session(place: &TestFolder, option: &str, file: &str, is_written: impl Fn(&TestFolder) -> bool) {
    let mut e = SceneEditor::open(place, &[option, &place.path().join(file).display().to_string()]);
    let cup = e.find("/table/cup");
    for n in 0..100 {
        match n % 4 {
            0 => e.edit("Move", json!([["tatu.set", cup, "object.position", [0.01 * f64::from(n), 0, 0.8]]])),
            1 => e.edit("Copy", json!([["tatu.copy", [cup], Value::Null, [0.1, 0.01 * f64::from(n), 0.5]]])),
            2 => e.call("tatu.undo", json!([])),
            _ => e.edit("Push", json!([["tatu.set", cup, "shape.mass", 0.1 + 0.01 * f64::from(n)]])),
        };
    }
    assert!(e.attempt("sim.startSimulation", json!([])).is_ok());
    assert!((0..1000).any(|_| {
        let far = e.get(&json!(0), "scene.step").as_i64().is_some_and(|n| n > 20);
        far || {
            std::thread::sleep(std::time::Duration::from_millis(5));
            false
        }
    }));
    assert!(e.attempt("sim.stopSimulation", json!([])).is_ok());
    assert!((0..1000).any(|_| {
        is_written(place) || {
            std::thread::sleep(std::time::Duration::from_millis(5));
            false
        }
    }));
}
