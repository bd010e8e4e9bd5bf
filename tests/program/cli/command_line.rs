//! Tests of the command line: output streams, the fields of JSON output, the length of a run, and changes to a scene.

use serde_json::Value;

use crate::kit::*;

const ROBOT: &str = "/Pioneer_p3dx";
const MOTOR: &str = "/Pioneer_p3dx/Pioneer_p3dx_leftMotor";

/// Kinds of errors described in docs/reference/errors.md.
const ERROR_KINDS: [&str; 8] =
    ["unknown_function", "unsupported", "bad_argument", "missing_object", "runtime", "budget", "plugin", "physics"];

fn scene() -> TestFolder {
    let drive = "function sysCall_init()
        sim.addStatusbarMessage('hello')
        print('printed')
        sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_leftMotor'), 2)
        sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_rightMotor'), 2)
    end";
    let wall = cuboid("wall", [0.1, 4.0, 1.0], [0.8, 0.0, 0.5], "");
    TestFolder::scene(&format!("{FLOOR}{wall}{}", pioneer(drive, "")))
}

fn keys(v: &Value) -> Vec<&str> {
    v.as_object().unwrap().keys().map(String::as_str).collect()
}

fn is_hash(v: &Value) -> bool {
    v.as_str().is_some_and(|s| s.len() == 16 && s.chars().all(|c| c.is_ascii_digit() || ('a'..='f').contains(&c)))
}

#[test]
fn a_run_ends_with_a_summary() {
    let done = scene().run(&["--steps", "7"]).good();
    let sum = done.json();
    assert_eq!(
        keys(&sum),
        ["errors", "hash", "objects", "scripts", "sim_time_s", "step_wall_s", "steps", "wall_s", "warnings"]
    );
    assert_eq!((sum["steps"].as_u64(), sum["errors"].as_array().map(Vec::len)), (Some(7), Some(0)));
    assert!((sum["sim_time_s"].as_f64().unwrap() - 0.35).abs() < 1e-12);
    assert!(sum["wall_s"].as_f64().unwrap() >= 0.0 && is_hash(&sum["hash"]));
    let [median, p99, max] = ["median", "p99", "max"].map(|name| sum["step_wall_s"][name].as_f64().unwrap());
    assert!(0.0 < median && median <= p99 && p99 <= max);
    assert_eq!(keys(&sum["objects"]), [ROBOT], "the summary must list the bases of models");
    let robot = &sum["objects"][ROBOT];
    assert_eq!(keys(robot), ["hash", "position", "quaternion"]);
    assert!(is_hash(&robot["hash"]) && numbers(&robot["position"]).len() == 3);
    let turn: f64 = numbers(&robot["quaternion"]).iter().map(|x| x * x).sum();
    assert!((turn - 1.0).abs() < 1e-9);
}

#[test]
fn the_summary_is_of_the_last_step_and_not_of_the_reset() {
    let place = scene();
    let lines = place.trace(&[ROBOT], &["--seconds", "2"]);
    let sum = place.run(&["--seconds", "2"]).json();
    assert_eq!(sum["hash"], lines.last().unwrap().0["hash"]);
    let end = numbers(&sum["objects"][ROBOT]["position"]);
    assert_eq!(end, lines.last().unwrap().object::<3>(ROBOT, "position"));
    assert!(end[0] > 0.2, "the robot has not driven: {end:?}");
}

#[test]
fn standard_output_contains_only_json() {
    let place = scene();
    let done = place.run(&["--steps", "2"]).good();
    assert!(done.json().is_object());
    assert!(done.err.contains("hello") && done.err.contains("printed"));
    // Without --json, standard output contains the lines of the status bar, and the summary is human-readable.
    let done = place.tatu(&["run", "scene.toml", "--steps", "2"]).good();
    assert!(done.out.lines().any(|l| l == "hello") && done.err.contains("2 steps"), "{}\n{}", done.out, done.err);
    let failing = TestFolder::scene(&watcher("a", "function sysCall_init() error('mine') end"));
    let done = failing.tatu(&["run", "scene.toml", "--steps", "2"]);
    assert_eq!(done.code, 1);
    done.reports(&["mine", "1 distinct error(s)"]);
}

#[test]
fn errors_have_their_fields() {
    let script =
        "function sysCall_actuation()\nsim.getObject('/nothing')\nend\nfunction sysCall_sensing() error('mine') end";
    let errors = TestFolder::scene(&watcher("a", script)).run(&["--steps", "3"]).errors();
    assert!(!errors.is_empty());
    for e in &errors {
        for key in ["code", "kind", "plugin", "script", "object", "file", "line", "message", "count"] {
            assert!(e.as_object().unwrap().contains_key(key), "no `{key}` in {e}");
        }
        assert!(ERROR_KINDS.contains(&e["kind"].as_str().unwrap()), "{e}");
        assert!(e["count"].as_u64().unwrap() >= 1 && e["line"].as_u64().unwrap() >= 1, "{e}");
        assert!(!e["code"].as_str().unwrap().is_empty() && e["script"].is_string(), "{e}");
    }
}

#[test]
fn steps_and_seconds_set_the_length_of_a_run() {
    let place = scene();
    let steps = |args: &[&str]| place.run(args).good().json()["steps"].as_u64().unwrap();
    assert_eq!(steps(&["--steps", "3"]), 3);
    assert_eq!(steps(&["--steps", "0"]), 0);
    // round(seconds / dt), with dt = 50 ms.
    assert_eq!(steps(&["--seconds", "1"]), 20);
    assert_eq!(steps(&["--seconds", "0.12"]), 2);
    assert_eq!(steps(&["--seconds", "0.13"]), 3);
    assert_eq!(steps(&["--seconds", "1", "--set", "scene.dt_s=0.02"]), 50);
    assert_eq!(steps(&["--seconds", "0.3", "--set", "scene.dt_s=0.1"]), 3);
}

#[test]
fn a_script_may_stop_the_run() {
    let script = "function sysCall_sensing() if sim.getSimulationTime() > 0.14 then sim.stopSimulation() end end
        function sysCall_cleanup() sim.addStatusbarMessage('cleaned up') end";
    let done = TestFolder::scene(&watcher("a", script)).run(&["--steps", "50"]).good();
    let steps = done.json()["steps"].as_u64().unwrap();
    assert!((3..=6).contains(&steps), "{steps}");
    assert!(done.err.contains("cleaned up"), "{}", done.err);
}

#[test]
fn set_changes_properties_and_parameters() {
    let place = scene();
    // During the acceleration the motor exerts its maximum torque: 3 N m (tests/facts/pioneer.md, 3), or the value that
    // `--set` specifies.
    let torque = |args: &[&str]| {
        let lines = place.trace(&[MOTOR], &[&["--steps", "1"], args].concat());
        lines[0].0["objects"][MOTOR]["joint"]["effort"].as_f64().unwrap()
    };
    assert!((torque(&[]) - 3.0).abs() < 1e-9);
    assert!((torque(&["--set", &format!("{MOTOR}.max_force_nm=1.5")]) - 1.5).abs() < 1e-9);
    // `--set` changes a parameter of a model. The wall's face is 0.54 m ahead of sonar 4.
    let sonar = "/Pioneer_p3dx/Pioneer_p3dx_visible/Pioneer_p3dx_ultrasonicSensor4";
    let sees = |args: &[&str]| {
        let lines = place.trace(&[sonar], &[&["--steps", "1"], args].concat());
        lines[0].sensor(sonar, "proximity.detected") == 1.0
    };
    assert!(sees(&[]) && sees(&["--set", "/Pioneer_p3dx.sonar_range_m=3"]));
    assert!(!sees(&["--set", "/Pioneer_p3dx.sonar_range_m=0.3"]));
    // The last of several values is used. Values can be negative numbers and strings.
    assert!(sees(&["--set", "/Pioneer_p3dx.sonar_range_m=0.3", "--set", "/Pioneer_p3dx.sonar_range_m=2"]));
    let lines = place
        .trace(&["/wall"], &["--steps", "1", "--set", "/wall.position_m=[-3, 0, 0.5]", "--set", "/wall.color=[1,0,0]"]);
    assert_eq!(lines[0].object::<3>("/wall", "position"), [-3.0, 0.0, 0.5]);
    place.run(&["--steps", "1", "--set", "/Pioneer_p3dx.preset=as the data sheet"]).good();
}

#[test]
fn script_option_replaces_the_script_of_an_object() {
    let place = scene();
    place.write("mine.lua", "function sysCall_init() sim.addStatusbarMessage('mine') end");
    let done = place.run(&["--steps", "2", "--script", "/Pioneer_p3dx=mine.lua"]).good();
    assert!(done.err.contains("mine") && !done.err.contains("hello"), "{}", done.err);
}

#[test]
fn each_step_has_a_line_in_the_trace() {
    let place = scene();
    let sonar = "/Pioneer_p3dx/Pioneer_p3dx_visible/Pioneer_p3dx_ultrasonicSensor4";
    let lines = place.trace(&[ROBOT, sonar, MOTOR], &["--steps", "4"]);
    assert_eq!(lines.len(), 4);
    for (i, line) in lines.iter().enumerate() {
        assert_eq!(keys(&line.0), ["console", "hash", "objects", "readings", "statusbar", "step", "time"]);
        assert_eq!(line.0["step"], i as u64 + 1);
        assert!((line.time() - 0.05 * (i + 1) as f64).abs() < 1e-12 && is_hash(&line.0["hash"]));
        for path in [ROBOT, sonar, MOTOR] {
            line.object::<3>(path, "position");
            line.object::<4>(path, "quaternion");
            line.object::<3>(path, "linear_velocity");
            line.object::<3>(path, "angular_velocity");
        }
        assert_eq!(line.sensor(sonar, "proximity.detected"), 1.0);
        assert!((0.4..0.6).contains(&line.sensor(sonar, "proximity.distance")));
        assert_eq!(line.status().contains(&"hello"), i == 0);
    }
    // Objects can also be given by their names of older versions.
    let lines = place.trace(&["Pioneer_p3dx_leftMotor"], &["--steps", "1"]);
    lines[0].object::<3>(MOTOR, "position");
}

#[test]
fn velocities_are_those_of_the_motion() {
    let lines = scene().trace(&[ROBOT], &["--seconds", "2"]);
    let [a, b] = [&lines[30], &lines[31]];
    let (p, q): ([f64; 3], [f64; 3]) = (a.object(ROBOT, "position"), b.object(ROBOT, "position"));
    let v: [f64; 3] = b.object(ROBOT, "linear_velocity");
    assert!(((q[0] - p[0]) / 0.05 - v[0]).abs() < 0.005, "{v:?}");
}

#[test]
fn lists_have_their_fields() {
    let place = TestFolder::new();
    let list = |what: &str| place.tatu(&["list", what, "--json"]).good().json().as_array().unwrap().clone();
    let plugins = list("plugins");
    for p in &plugins {
        assert_eq!(keys(p), ["abi", "id", "kinds", "name", "path", "version"]);
        assert!(std::path::Path::new(p["path"].as_str().unwrap()).is_file(), "{p}");
        assert!(!p["kinds"].as_array().unwrap().is_empty(), "{p}");
    }
    let ids: Vec<&str> = plugins.iter().map(|p| p["id"].as_str().unwrap()).collect();
    for id in ["tatu.commands.vrep", "tatu.models.folder", "tatu.script.lua", "tatu.sensor.proximity"] {
        assert!(ids.contains(&id), "{id} is not in {ids:?}");
    }
    assert!(list("models").iter().any(|m| m["id"] == "pioneer_p3dx"));
    assert!(list("sensors").iter().any(|s| s["id"] == "proximity"));
    let commands = list("commands");
    assert!(commands.iter().any(|c| c["aliases"].as_array().unwrap().contains(&"simGetObjectHandle".into())));
    for what in ["plugins", "models", "sensors", "commands"] {
        let done = place.tatu(&["list", what]).good();
        assert!(done.out.lines().count() > 1);
    }
}

#[test]
fn check_reports_whether_a_scene_would_start() {
    let place = scene();
    let done = place.tatu(&["check", "scene.toml"]).good();
    assert!(!done.err.contains("hello") && !done.out.contains("hello"), "a script has run");
    assert_eq!(place.tatu(&["check", "scene.toml", "--set", "scene.dt_s=0.01"]).code, 0);
    assert_eq!(place.tatu(&["check", "nowhere.toml"]).code, 2);
}

#[test]
fn a_run_without_end_lasts_until_it_is_stopped() {
    let stop = "function sysCall_actuation()
            if sim.getSimulationTime() > 11.99 then sim.stopSimulation() end
        end";
    let place = TestFolder::scene(&watcher("w", stop));
    let done = place.run(&["--seconds", "inf"]).good();
    assert_eq!(done.json()["sim_time_s"].as_f64().map(f64::round), Some(12.0));
    place.tatu(&["run", "scene.toml", "--seconds", "never"]).refused(&["at least 0, or `inf`"]);
    place.tatu(&["run", "scene.toml", "--watch", "/w"]).refused(&["--trace"]);
}

#[test]
fn the_first_scene_runs_as_the_readme_shows_it() {
    let scene = root().join("scenes/first/pioneer_avoids_walls.toml");
    let place = TestFolder::new();
    let done = place.tatu(&[
        "run",
        scene.to_str().unwrap(),
        "--seconds",
        "30",
        "--json",
        "--trace",
        "t.jsonl",
        "--watch",
        ROBOT,
    ]);
    assert_eq!(done.good().json()["steps"], 600);
    let places: Vec<[f64; 3]> = place.lines("t.jsonl").iter().map(|l| l.object(ROBOT, "position")).collect();
    let path: f64 = places.windows(2).map(|w| f64::hypot(w[1][0] - w[0][0], w[1][1] - w[0][1])).sum();
    // The robot remains inside the walls and keeps moving.
    assert!(places.iter().all(|p| p[0].abs() < 3.0 && p[1].abs() < 3.0) && path > 2.0, "{path} m");
}

/// The example scene at the beginning of the README has no warnings.
#[test]
fn the_scene_of_the_readme_has_no_warnings() {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let at = readme.find("`my_scene.toml`").unwrap();
    let scene = readme[at..].split("```toml\n").nth(1).and_then(|t| t.split("```").next()).unwrap();
    let place = TestFolder::new();
    place.write("my_scene.toml", scene).write("my_controller.lua", "function sysCall_init() end");
    let done = place.tatu(&["check", "my_scene.toml"]).good();
    assert_eq!(done.err, "");
    place.tatu(&["run", "my_scene.toml", "--steps", "2", "--strict"]).good();
}
