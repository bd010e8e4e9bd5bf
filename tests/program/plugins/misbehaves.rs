//! Tests of a plugin that misbehaves in each function of each table: the run ends normally, an error names the plugin,
//! instance and call once, and everything else has the same results as without the plugin.

use std::{collections::BTreeSet, fs};

use crate::kit::*;

/// Tables that plugins fill in, and the kinds of instance of `tatu_life`.
const TABLES: [&str; 12] = [
    "tatu_plugin_t",
    "tatu_life",
    "tatu_command",
    "tatu_sensor",
    "tatu_actuator",
    "tatu_part",
    "tatu_ext_event",
    "tatu_model",
    "tatu_ext_model",
    "tatu_importer",
    "tatu_language",
    "tatu_service",
];
const INSTANCE_KINDS: [&str; 6] = ["world", "sensor", "actuator", "part", "script", "service"];
/// The kinds of instance that have parameters and therefore `configure`.
const CONFIGURED_KINDS: [&str; 3] = ["sensor", "actuator", "part"];

/// Sets the language of all scripts in a scene, which is required because two plugins offer a language.
fn with_lua(scene: &str) -> String {
    scene.replace("{ text = '''", "{ language = \"lua\", text = '''")
}

/// Returns the scene entries, in addition to the healthy robot, that cause a function to be called, and the name of the
/// object or plugin in its error.
fn scene_for(function: &str) -> (String, &'static str) {
    let sensor = "[[object]]\nkind = \"sensor\"\nsensor = \"misbehaves\"\nalias = \"eye\"\n";
    let script =
        "[[object]]\nkind = \"dummy\"\nalias = \"talker\"\nscript = { text = 'x', language = \"misbehaves\" }\n";
    let model = "[[model]]\nmodel = \"misbehaves\"\n";
    let actuator = "[[object]]\nkind = \"shape\"\nalias = \"ball\"\nprimitive = \"sphere\"\nsize_m = [0.1, 0.1, 0.1]\n\
        position_m = [5.0, 5.0, 5.0]\ndynamic = true\nmass_kg = 1.0\n[[object]]\nkind = \"actuator\"\n\
        actuator = \"misbehaves\"\nalias = \"engine\"\nparent = \"/ball\"\n";
    let part = "[[object]]\nkind = \"part\"\npart = \"misbehaves\"\nalias = \"helm\"\n";
    let setter = |path: &str| {
        let set = format!("sim.setFloatProperty(sim.getObject('{path}'), 'misbehaves.range', 0.5)");
        with_lua(&watcher("caller", &format!("function sysCall_init() {set} end")))
    };
    match function {
        // `finish` is called only for sensors with noise.
        "tatu_sensor.finish" => return (format!("{sensor}noise = {{ number = {{ sigma = 0.1 }} }}\n"), "/eye"),
        "tatu_life.configure:sensor" => return (format!("{sensor}{}", setter("/eye")), "/eye"),
        "tatu_life.configure:actuator" => return (format!("{actuator}{}", setter("/ball/engine")), "/ball/engine"),
        "tatu_life.configure:part" => return (format!("{part}{}", setter("/helm")), "/helm"),
        "tatu_part.contact" => {
            let ball =
                cuboid("ball", [0.1; 3], [5.0, 5.0, 0.05], "dynamic = true\nrespondable = true\nmass_kg = 1.0\n");
            return (format!("{ball}{part}parent = \"/ball\"\n"), "/ball/helm");
        }
        "tatu_part.paused" => {
            let pause =
                "function sysCall_sensing() if sim.getSimulationTime() > 0.25 then sim.pauseSimulation() end end";
            return (format!("{part}{}", with_lua(&watcher("caller", pause))), "/helm");
        }
        // `sniff` is also called for the meshes of the robot, which are read first.
        "tatu_importer.sniff" => return ("[[import]]\nfile = \"thing.misbehaves\"\n".into(), "the import of "),
        "tatu_language.knows_dialect" => {
            return (script.replace("}\n", ", dialect = \"strange\" }\n"), "the dialect `strange`");
        }
        _ => {}
    }
    let (table, kind) = function.split_once(':').unwrap_or((function, ""));
    match (table.split('.').next().unwrap(), kind) {
        ("tatu_sensor", _) | (_, "sensor") => (sensor.into(), "/eye"),
        ("tatu_actuator", _) | (_, "actuator") => (actuator.into(), "/ball/engine"),
        ("tatu_part", _) | (_, "part") => (part.into(), "/helm"),
        ("tatu_importer", _) => ("[[import]]\nfile = \"thing.misbehaves\"\n".into(), "thing.misbehaves"),
        ("tatu_service", _) | (_, "service") => {
            ("[[service]]\nid = \"misbehaves\"\n".into(), "the service `misbehaves`")
        }
        ("tatu_language", _) | (_, "script") => (script.into(), "/talker"),
        ("tatu_ext_model", _) => ("[[model]]\nmodel = \"told\"\n".into(), "told"),
        ("tatu_model", _) => (model.into(), "the model `misbehaves`"),
        ("tatu_command", _) => {
            (with_lua(&watcher("caller", "function sysCall_actuation() misbehaves.call() end")), "/caller")
        }
        // Instances of the plugin or the whole world are named after the plugin. The scene must use the plugin.
        ("tatu_plugin", _) => (sensor.into(), "org.tatu.misbehaves"),
        _ => (String::new(), "org.tatu.misbehaves"),
    }
}

/// Returns the name of a function in the plugin's plan and in the program's errors.
fn written(table: &str, function: &str) -> String {
    format!("{}.{function}", table.trim_end_matches("_t"))
}

/// Returns all function pointers that plugins fill in, as declared in the header.
fn functions() -> Vec<String> {
    let header = header_text(&root().join("plugin-api/include"));
    let mut out = Vec::new();
    for table in TABLES {
        let start = header.find(&format!("struct {table} {{")).unwrap_or_else(|| panic!("no table {table}"));
        let body = &header[start..start + header[start..].find("\n}").unwrap()];
        for part in body.split("(TATU_CALL *").skip(1) {
            let name = part.split(')').next().unwrap();
            let name = written(table, name);
            match table {
                "tatu_life" if name == "tatu_life.configure" => {
                    out.extend(CONFIGURED_KINDS.iter().map(|kind| format!("{name}:{kind}")));
                }
                // `end_run` is called only for the data that a plugin has per world.
                "tatu_life" if name == "tatu_life.end_run" => out.push(format!("{name}:world")),
                "tatu_life" => out.extend(INSTANCE_KINDS.iter().map(|kind| format!("{name}:{kind}"))),
                _ => out.push(name),
            }
        }
    }
    out
}

#[test]
fn every_table_that_a_plugin_fills_is_walked() {
    // Each table with functions either belongs to the host or is tested here. A new table must be added to one of the
    // two lists.
    let header = header_text(&root().join("plugin-api/include"));
    let hosts = ["tatu_error", "tatu_host", "tatu_writer", "tatu_random", "tatu_call_api", "tatu_builder"];
    let mut found = BTreeSet::new();
    let mut table = "";
    for line in header.lines() {
        if let Some(name) = line.strip_prefix("typedef struct ").or(line.strip_prefix("struct ")) {
            table = name.trim_end_matches([' ', '{']);
        } else if line.starts_with('}') {
            table = "";
        } else if line.contains("(TATU_CALL *")
            && !["", "tatu_test", "tatu_test_case", "tatu_test_host"].contains(&table)
            && !table.starts_with("tatu_host_")
            && !hosts.contains(&table)
        {
            found.insert(table);
        }
    }
    assert_eq!(found, TABLES.into_iter().collect());
    assert!(functions().len() >= 40, "{:?}", functions());
}

struct FaultBench {
    place: TestFolder,
    /// The hash of the healthy robot after a run without the plugin.
    robot: serde_json::Value,
}

/// Returns scene entries for a driving robot and a sonar that work correctly.
fn healthy() -> String {
    let drive = "function sysCall_init() left = sim.getObject('/Pioneer_p3dx_leftMotor') end
        function sysCall_actuation() sim.setJointTargetVelocity(left, 1 + sim.getSimulationTime()) end";
    with_lua(&format!("plugins = [\"mine\"]\n{FLOOR}{}", pioneer(drive, "")))
}

impl FaultBench {
    fn new() -> Self {
        let place = TestFolder::scene(&healthy());
        let robot = place.run(&["--steps", "8"]).good().json()["objects"]["/Pioneer_p3dx"]["hash"].clone();
        assert!(robot.is_string());
        let file = library("tatu_testing_misbehaves");
        fs::create_dir(place.path().join("mine")).unwrap();
        fs::copy(program().with_file_name("deps").join(&file), place.path().join("mine").join(&file)).unwrap();
        place.write("thing.misbehaves", "whatever").write("models/told/model.toml", "format = \"another\"\n");
        FaultBench { place, robot }
    }
    fn scene(&self, more: &str) {
        self.place.write("scene.toml", &format!("format = 1\n[scene]\n{}{more}", healthy()));
    }
    /// Runs the scene with `function` misbehaving, and returns a line for each deviation from the expected outcome.
    fn run(&self, function: &str, how: &str, args: &[&str]) -> Vec<String> {
        let (more, instance) = scene_for(function);
        self.scene(&more);
        let file = ["state"];
        match function.split(':').next().unwrap() {
            "tatu_life.save" if how == "error" => self.check_replay_restore(function, how, instance),
            "tatu_life.save" => self.check(function, how, &[args, &["--snapshot-at", "0.2"], &file].concat(), instance),
            "tatu_life.load" => {
                self.place.run(&["--steps", "8", "--snapshot-at", "0.2", "state"]).good();
                match how {
                    // Services restore their state after the world has already started to continue.
                    _ if function.ends_with(":service") => {
                        self.check(function, how, &[args, &["--from"], &file].concat(), instance)
                    }
                    "hang" => self.check(function, how, &[args, &["--from"], &file].concat(), instance),
                    _ => self.check_replay_restore(function, how, instance),
                }
            }
            _ => self.check(function, how, args, instance),
        }
    }
    /// Checks that state that cannot be saved or loaded does not fail the run: it is restored by a replay, and the
    /// reason is reported.
    fn check_replay_restore(&self, function: &str, how: &str, instance: &str) -> Vec<String> {
        let asked = format!("{function}={how}");
        let all = ["run", "scene.toml", "--json", "--steps", "8"];
        let run =
            |args: &[&str]| run(program(), self.place.path(), &[&all, args].concat(), &[("TATU_MISBEHAVE", &asked)]);
        let saves = function.starts_with("tatu_life.save");
        let saved = saves.then(|| run(&["--snapshot-at", "0.2", "state"]));
        let resumed = run(&["--from", "state"]);
        let what = if saves { "on request" } else { "tatu_life.load of `org.tatu.misbehaves`" };
        let reason = |done: &RunOutput, begin: &str| {
            let reports = |l: &&str| l.starts_with(begin) && l.contains(instance) && l.contains(what);
            done.err.lines().filter(reports).count() == 1
        };
        let wanted = [
            ("the function was never reached", resumed.err.contains(&format!("misbehaving in {function}")) || saves),
            (
                "the reason is not reported when the snapshot is written",
                saved.as_ref().is_none_or(|s| s.code == 0 && reason(s, "note: state")),
            ),
            ("the reason is not reported when the snapshot is read", reason(&resumed, "note: restored by replay")),
            ("a panic was not caught", !resumed.err.contains("panicked at")),
            ("the exit code is wrong", resumed.code == 0),
            (
                "the other robot has a different hash",
                resumed.code == 0 && resumed.json()["objects"]["/Pioneer_p3dx"]["hash"] == self.robot,
            ),
        ];
        let wrong = wanted.iter().filter(|(_, is)| !is);
        wrong.map(|(what, _)| format!("{asked}: {what} (exit {})\n{}", resumed.code, resumed.err)).collect()
    }
    fn check(&self, function: &str, how: &str, args: &[&str], instance: &str) -> Vec<String> {
        let asked = format!("{function}={how}");
        let all = [&["run", "scene.toml", "--json", "--steps", "8"], args].concat();
        let done = run(program(), self.place.path(), &all, &[("TATU_MISBEHAVE", &asked)]);
        let told: Vec<&str> =
            done.err.lines().filter(|l| l.starts_with("error") || l.starts_with("warning[E")).collect();
        let has = |what: &str| told.iter().any(|l| l.contains(what));
        let errors = told.iter().filter(|l| l.starts_with("error")).count();
        let call = match (function, how) {
            // The error contains the name of the command. An invalid number is detected where it is used.
            ("tatu_command.call", "hang") => "tatu_command.call",
            ("tatu_command.call", _) => "misbehaves.call",
            ("tatu_language.find", "nonsense") => "tatu_language.call",
            ("tatu_language.keep_func", "nonsense") => "tatu_language.call_func",
            _ => function.split(':').next().unwrap(),
        };
        // For an unknown dialect an error is a valid answer: the language reports it.
        let answers = (function, how) == ("tatu_language.knows_dialect", "error");
        let names_plugin = |l: &str| l.contains("org.tatu.misbehaves") || answers;
        let instance = if answers { "no dialect `strange` of the language `misbehaves`" } else { instance };
        // The error of a command is that of its caller, but the summary names the plugin that offers the command.
        let in_summary = || !done.out.is_empty() && done.json()["errors"][0]["plugin"] == "org.tatu.misbehaves";
        let robot = || done.json()["objects"]["/Pioneer_p3dx"]["hash"].clone();
        let began = done.code == 1 && how != "hang";
        let wanted = [
            ("the function was never reached", done.err.contains(&format!("misbehaving in {function}"))),
            ("the exit code is wrong", done.code == 1 || done.code == 2 && done.out.is_empty()),
            ("a panic was not caught", !done.err.contains("panicked at")),
            ("the plugin is not named", told.iter().any(|l| names_plugin(l)) || done.code == 1 && in_summary()),
            ("the instance is not named", has(instance)),
            ("the call is not named", has(call) || answers),
            // Before a run, the error is reported twice: as the reason, and for what is missing because of it. `place`
            // is only called for another error, which is also reported.
            (
                "the error is not reported exactly once",
                if done.code == 1 {
                    errors == 1 + usize::from(call == "tatu_language.place" && how != "hang")
                } else {
                    (1..=2).contains(&errors)
                },
            ),
            ("the other robot has a different hash", !began || robot() == self.robot),
        ];
        let wrong = wanted.iter().filter(|(_, is)| !is);
        wrong.map(|(what, _)| format!("{asked}: {what} (exit {})\n{}", done.code, done.err)).collect()
    }
}

fn walk(how: &str, args: &[&str]) {
    let bench = FaultBench::new();
    let all = functions();
    let wrong: Vec<String> = all.iter().flat_map(|f| bench.run(f, how, args)).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn panics_stay_inside_in_every_function() {
    walk("panic", &[]);
}

#[test]
fn errors_are_reported_in_every_function() {
    walk("error", &[]);
}

#[test]
fn nonsense_is_refused_in_every_function() {
    walk("nonsense", &[]);
}

#[test]
fn a_function_that_never_returns_is_named_and_the_run_ended() {
    walk("hang", &["--watchdog", "0.4", "--trace", "trace.jsonl"]);
}

#[test]
fn output_written_before_a_stuck_call_is_complete() {
    let bench = FaultBench::new();
    let caller = "function sysCall_actuation() if sim.getSimulationTime() > 0.16 then misbehaves.call() end end";
    let caller = with_lua(&watcher("caller", caller));
    bench.place.write("scene.toml", &format!("format = 1\n[scene]\n{}{caller}", healthy()));
    let args = ["--watchdog", "0.4", "--trace", "trace.jsonl"];
    let wrong = bench.check("tatu_command.call", "hang", &args, "/caller");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let lines = bench.place.lines("trace.jsonl");
    assert_eq!(lines.len(), 4, "expected four steps of 0.05 s");
    let all = ["run", "scene.toml", "--json", "--watchdog", "0.4"];
    let done = run(program(), bench.place.path(), &all, &[("TATU_MISBEHAVE", "tatu_command.call=hang")]);
    let errors = done.errors();
    assert_eq!(done.json()["steps"], 4);
    assert_eq!(
        (errors.len(), errors[0]["code"].as_str(), errors[0]["kind"].as_str()),
        (1, Some("F210"), Some("stuck"))
    );
    assert_eq!(errors[0]["plugin"], "org.tatu.misbehaves");
}

#[test]
fn results_that_cannot_be_are_refused() {
    let bench = FaultBench::new();
    for sort in 1..=4 {
        let caller = with_lua(&watcher("caller", &format!("function sysCall_actuation() misbehaves.call({sort}) end")));
        bench.place.write("scene.toml", &format!("format = 1\n[scene]\n{}{caller}", healthy()));
        let wrong = bench.check("tatu_command.call", "nonsense", &[], "/caller");
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }
}

#[test]
fn an_importer_that_cannot_sniff_does_not_stop_the_others() {
    let bench = FaultBench::new();
    bench.place.write("one.urdf", "<robot name=\"one\"><link name=\"base\"/></robot>");
    bench.scene("[[import]]\nfile = \"one.urdf\"\n");
    let all = ["run", "scene.toml", "--json", "--steps", "8"];
    for how in ["panic", "error", "nonsense"] {
        let env = [("TATU_MISBEHAVE", format!("tatu_importer.sniff={how}"))];
        let done = run(program(), bench.place.path(), &all, &env.each_ref().map(|(k, v)| (*k, v.as_str()))).good();
        assert_eq!(done.json()["objects"]["/Pioneer_p3dx"]["hash"], bench.robot, "{how}");
        let reports = |l: &&str| l.starts_with("note: ") && l.contains("`org.tatu.misbehaves`") && l.contains("sniff");
        assert_eq!(done.err.lines().filter(reports).count(), 1, "{}", done.err);
    }
}

#[test]
fn a_well_behaved_plugin_has_no_effect() {
    let bench = FaultBench::new();
    for function in &functions() {
        bench.scene(&scene_for(function).0);
        let whole = bench.place.run(&["--steps", "8", "--snapshot-at", "0.2", "state"]).good();
        let resumed = bench.place.run(&["--steps", "8", "--from", "state"]).good();
        for done in [whole, resumed] {
            assert_eq!(done.json()["objects"]["/Pioneer_p3dx"]["hash"], bench.robot, "{function}");
            assert!(!done.err.contains("misbehaving"), "{}", done.err);
        }
    }
}
