//! Tests that native code in a scene's folder is loaded only with permission.

use crate::kit::*;

/// Creates a scene with a folder that contains a library. The library is not a plugin, so if it were opened, an error
/// would name it.
fn scene() -> TestFolder {
    let place = TestFolder::scene(&format!("plugins = [\"mine\"]\n{FLOOR}"));
    place.write(&format!("mine/{}", library("tatu_stranger")), "not a library");
    place
}

/// Runs the program with `trust` as the value of `TATU_TRUST`, which replaces that of the test kit.
fn run_in(place: &TestFolder, trust: &str, args: &[&str]) -> RunOutput {
    run(program(), place.path(), args, &[("TATU_TRUST", trust)])
}

#[test]
fn a_scene_with_plugins_of_its_own_asks_first() {
    let place = scene();
    for args in [
        &["run", "scene.toml", "--steps", "1"][..],
        &["check", "scene.toml"],
        &["list", "plugins", "--scene", "scene.toml"],
        &["describe", "proximity", "--scene", "scene.toml"],
        &["look", "scene.toml", "--from", "1,1,1", "--to", "0,0,0", "-o", "x.png"],
    ] {
        let done = run_in(&place, "", args);
        done.refused(&["error[E312]", "mine", "--allow plugins", "TATU_TRUST"]);
        assert!(!done.err.contains("stranger"), "the library was opened: {}", done.err);
        let done = run_in(&place, "", &[args, &["--allow", "plugins"]].concat()).good();
        done.reports(&["E301", "stranger"]);
    }
}

#[test]
fn a_folder_is_trusted_once_by_its_name() {
    let place = scene();
    let folder = place.path().canonicalize().unwrap().join("mine");
    let args = ["run", "scene.toml", "--steps", "1"];
    let all = std::env::join_paths(["/nowhere".into(), folder.clone()]).unwrap();
    run_in(&place, all.to_str().unwrap(), &args).good().reports(&["E301"]);
    run_in(&place, place.path().to_str().unwrap(), &args).good().reports(&["E301"]);
    // Relative names are not accepted, because they denote different folders elsewhere, and neither are prefixes of
    // names.
    for trust in ["mine", "."] {
        run_in(&place, trust, &args).refused(&["E312"]);
    }
    place.write(&format!("mine2/{}", library("tatu_stranger")), "not a library");
    place.write("scene.toml", &place.read("scene.toml").replace("\"mine\"", "\"mine2\""));
    run_in(&place, folder.to_str().unwrap(), &args).refused(&["E312", "mine2"]);
    // Without a library in the folder, no permission is needed.
    std::fs::remove_dir_all(place.path().join("mine2")).unwrap();
    run_in(&place, "", &args).good();
}

/// A log contains the scene's text, and a replay needs the same permission.
#[test]
fn a_replay_asks_too() {
    let place = scene();
    place.run(&["--steps", "2", "--log", "run.log"]).good();
    run_in(&place, "", &["run", "--replay", "run.log"]).refused(&["E312"]);
    run_in(&place, "", &["run", "--replay", "run.log", "--allow", "plugins"]).good();
}
