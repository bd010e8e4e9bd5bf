//! Tests of a program that was copied without its libraries: it reports which are missing, where it searched, and what
//! to do.

use std::{fs, path::PathBuf};

use crate::kit::*;

/// Copies the program, without any libraries, into a new folder.
fn copied() -> (TestFolder, PathBuf) {
    let place = TestFolder::scene(&format!("{FLOOR}{}", pioneer("", "")));
    let exe = place.path().join("bin").join(program().file_name().unwrap());
    fs::create_dir(exe.parent().unwrap()).unwrap();
    fs::copy(program(), &exe).unwrap();
    (place, exe)
}

/// Copies the models into `folder`: the folder of an installed program, or the one next to the program.
fn with_models(place: &TestFolder, folder: &str) -> PathBuf {
    let to = place.path().join(folder);
    copy(&root().join("models"), &to);
    to
}

/// Returns the stems of the program's own libraries, as listed in the manifest.
fn libraries() -> Vec<String> {
    let manifest = fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let lines = manifest.lines().filter(|l| l.contains("path = \"plugins/"));
    lines.map(|l| l.split_whitespace().next().unwrap().replace('-', "_")).collect()
}

#[test]
fn missing_plugins_are_reported_with_searched_folders_and_help() {
    let (place, exe) = copied();
    for command in ["run", "check"] {
        let done = run(&exe, place.path(), &[command, "scene.toml"], &[]);
        done.refused(&["missing", "TATU_PLUGIN_PATH", "pioneer_p3dx", "scene.toml:"]);
        for name in libraries() {
            done.reports(&[&library(&name)]);
        }
        let bin = exe.parent().unwrap();
        for folder in [bin.join("plugins"), bin.join("deps"), place.path().join("lib/tatu/plugins")] {
            done.reports(&[folder.to_str().unwrap()]);
        }
    }
    // A folder that was specified is reported too.
    let done = run(&exe, place.path(), &["run", "scene.toml"], &[("TATU_PLUGIN_PATH", "no_such_folder")]);
    done.refused(&["no_such_folder"]);
}

#[test]
fn each_suggested_remedy_works() {
    let (place, exe) = copied();
    let put = |folder: &str| {
        let to = place.path().join(folder);
        fs::create_dir_all(&to).unwrap();
        for name in libraries() {
            fs::copy(program().with_file_name("deps").join(library(&name)), to.join(library(&name))).unwrap();
        }
        to
    };
    for (folder, env) in [("mine", Some("mine")), ("bin/plugins", None), ("lib/tatu/plugins", None), ("bin/deps", None)]
    {
        let to = put(folder);
        let env: Vec<(&str, &str)> = env.map(|e| ("TATU_PLUGIN_PATH", e)).into_iter().collect();
        for models in ["share/tatu/models", "bin/models"] {
            let models = with_models(&place, models);
            let done = run(&exe, place.path(), &["run", "scene.toml", "--steps", "1"], &env).good();
            assert!(!done.err.contains("missing"), "{folder}: {}", done.err);
            fs::remove_dir_all(models).unwrap();
        }
        run(&exe, place.path(), &["check", "scene.toml"], &env).refused(&["pioneer_p3dx", "scene.toml:"]);
        fs::remove_dir_all(to).unwrap();
    }
}

#[test]
fn a_missing_library_is_reported_by_name() {
    let (place, exe) = copied();
    let plugins = exe.parent().unwrap().join("plugins");
    fs::create_dir(&plugins).unwrap();
    for name in libraries().iter().filter(|n| !n.contains("proximity")) {
        fs::copy(program().with_file_name("deps").join(library(name)), plugins.join(library(name))).unwrap();
    }
    with_models(&place, "share/tatu/models");
    let done = run(&exe, place.path(), &["run", "scene.toml"], &[]);
    done.refused(&[&library("tatu_sensors_proximity"), "proximity"]);
    assert!(!done.err.contains(&library("tatu_scripts_lua")), "reports an existing library as missing: {}", done.err);
}

#[test]
fn a_file_that_is_no_library_is_reported_and_the_rest_loads() {
    let place = TestFolder::scene(&format!("plugins = [\"broken\"]\n{FLOOR}"));
    place.write(&format!("broken/{}", library("tatu_broken")), "this is no library");
    let done = place.run(&["--steps", "1"]).good();
    done.reports(&["tatu_broken"]);
}
