//! Tests that the host enforces which of its functions a plugin may call: other calls are refused, and the plugin is
//! named.

use std::process::Command;

use crate::kit::*;

/// Host functions that change the world.
const WRITE_CALLS: [&str; 10] = [
    "scene.set_pose",
    "scene.set",
    "scene.create",
    "scene.remove",
    "bodies.impulse",
    "commands.call",
    "signals.set",
    "events.publish",
    "session.request",
    "stage.run",
];

/// Creates a scene with sensors that call functions where these are forbidden. `script` belongs to an object that calls
/// commands.
fn place(eyes: usize, eye: &str, script: &str) -> TestFolder {
    let mut scene =
        format!("{}{}", cuboid("box", [0.2; 3], [0.0, 0.0, 2.0], "dynamic = true"), watcher("caller", script));
    for i in 0..eyes {
        scene += &format!("[[object]]\nkind = \"sensor\"\nsensor = \"nosy\"\nalias = \"eye{i}\"\nwhere = \"{eye}\"\n");
    }
    let place = TestFolder::scene(&format!("plugins = [\"mine\"]\n{scene}"));
    place.write("mine/trespass.c", include_str!("trespass.c"));
    succeed(
        Command::new(compiler("cc"))
            .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-pthread", "-shared", "-fPIC", "-I"])
            .arg(root().join("plugin-api/include"))
            .args(["trespass.c", "-o", &library("tatu_nosy")])
            .current_dir(place.path().join("mine")),
    );
    place
}

/// Checks that the run continues, that each call to a function is refused and reported with the plugin function `call`
/// that made it, and that no call took effect.
fn refused(done: &RunOutput, call: &str, functions: &[&str]) {
    assert!(!done.err.contains("TRESPASSED"), "{}", done.err);
    let errors = done.errors();
    for function in functions {
        let text = format!("`{function}` was called in `{call}`, and is refused");
        let told = errors.iter().find(|e| e["message"].as_str().unwrap().contains(&text));
        let told = told.unwrap_or_else(|| panic!("`{text}` is not in {errors:?}"));
        assert_eq!(
            (told["plugin"].as_str(), told["code"].as_str()),
            (Some("org.example.nosy"), Some("F207")),
            "{told}"
        );
    }
}

const SETTER_SCRIPT: &str = "function sysCall_init() eye = sim.getObject('/eye0') end
    function sysCall_actuation() sim.setFloatProperty(eye, 'nosy.knob', sim.getSimulationTime()) end";

#[test]
fn writes_are_refused_in_read_only_functions() {
    let healthy = |done: &RunOutput| done.json()["objects"]["/box"]["hash"].clone();
    let expected = healthy(&place(1, "nowhere", SETTER_SCRIPT).run(&["--steps", "6"]).good());
    for (eye, call) in [
        ("create", "tatu_life.create"),
        ("configure", "tatu_life.configure"),
        ("beams", "tatu_sensor.beams"),
        ("save", "tatu_life.save"),
        ("destroy", "tatu_life.destroy"),
    ] {
        let place = place(1, eye, SETTER_SCRIPT);
        let saved: &[&str] = if eye == "save" { &["--snapshot-at", "0.15", "t.snap"] } else { &[] };
        let done = place.run(&[&["--steps", "6"], saved].concat());
        if eye == "destroy" {
            // Faults after the last step are reported as log lines.
            assert!(!done.err.contains("TRESPASSED"), "{}", done.err);
            continue;
        }
        refused(&done, call, &WRITE_CALLS);
        assert_eq!(healthy(&done), expected, "{eye}");
    }
}

#[test]
fn a_batch_may_call_only_the_log() {
    let looks = ["scene.pose", "scene.get", "bodies.contacts", "files.resolve", "commands.alloc"];
    for threads in ["1", "2"] {
        let place = place(40, "measure", "");
        let done = place.run(&["--steps", "6", "--threads", threads]);
        refused(&done, "tatu_sensor.measure", &[&WRITE_CALLS[..], &looks].concat());
        assert_eq!(done.json()["steps"], 6);
    }
}

#[test]
fn threads_of_a_plugin_cannot_access_worlds() {
    for threads in ["1", "2"] {
        let place = place(1, "nowhere", "function sysCall_actuation() nosy.thread() end");
        let done = place.run(&["--steps", "4", "--threads", threads]);
        assert!(!done.err.contains("TRESPASSED"), "{}", done.err);
        // The fault names the library, because the host does not know which plugin started a thread.
        assert!(done.errors().iter().all(|e| e["code"] == "F207"));
        done.reports(&[
            &library("tatu_nosy"),
            "`scene.pose` was called for a world that does not exist, or from a thread that is not the world's",
        ]);
        done.reports(&["log.write, commands.wake, session.wake and session.stop"]);
    }
}

#[test]
fn null_is_refused_wherever_something_is_expected() {
    let place = place(1, "nowhere", "function sysCall_init() nosy.nulls(sim.getObject('/eye0')) end");
    let done = place.run(&["--steps", "2"]);
    assert!(!done.err.contains("TRESPASSED"), "{}", done.err);
    assert_eq!(done.err.matches("was refused:").count(), 33, "{}", done.err);
    let of_world =
        |e: &serde_json::Value| e["message"].as_str().is_some_and(|m| m.contains("with a null pointer as the world"));
    assert!(done.errors().iter().all(of_world), "{}", done.err);
}
