//! Tests that every published scene runs without an error: those in `scenes/`, and the demos of plugins, whose scripts
//! raise an error if a reading does not match the scene's geometry.

use std::path::{Path, PathBuf};

use crate::kit::*;

/// Collects the scene files below a folder.
fn scenes(folder: &Path, out: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    // Skips copies of unsaved scenes (names that begin with a dot), folders `plugin` with plugins that must be built,
    // and folders with models of scenes.
    let hidden = |path: &Path| {
        path.file_name().is_some_and(|n| n.to_string_lossy().starts_with('.'))
            || path.ends_with("plugin")
            || path.ends_with("models")
    };
    for path in entries.into_iter().filter(|p| !hidden(p)) {
        if path.is_dir() {
            scenes(&path, out);
        } else if path.extension().is_some_and(|e| e == "toml") && !path.ends_with("tatu.toml") {
            out.push(path);
        }
    }
}

#[test]
fn scenes_run() {
    let mut all = Vec::new();
    scenes(&root().join("scenes"), &mut all);
    assert!(!all.is_empty());
    // Some scenes write files to the working folder.
    let place = TestFolder::new();
    for scene in all {
        let text = std::fs::read_to_string(&scene).unwrap();
        let mut args = vec!["run".to_owned(), scene.to_str().unwrap().to_owned()];
        args.extend(["--seconds", "1", "--json"].map(str::to_owned));
        // The scene's own ports may be in use by another program.
        for service in text.split("[[service]]\nid = \"").skip(1).filter_map(|s| s.split('"').next()) {
            args.extend(["--service".to_owned(), format!("{service}:port=0")]);
        }
        let run = place.tatu(&args.iter().map(String::as_str).collect::<Vec<_>>());
        // An exercise whose goals are not reached has the code 3.
        let is_exercise = text.contains("exercise.goals");
        assert!(run.code == 0 || run.code == 3 && is_exercise, "{}: {}\n{}", scene.display(), run.code, run.err);
    }
}

#[test]
fn demos_run_and_print_each_second() {
    let mut found = 0;
    for kind in ["sensors", "actuators", "models", "importers", "services", "views"]
        .map(|kind| format!("plugins/{kind}"))
        .into_iter()
        .chain(["models".to_owned()])
    {
        for plugin in std::fs::read_dir(root().join(&kind)).unwrap() {
            let plugin = plugin.unwrap().path();
            // `models` also contains the script that generates meshes.
            if !plugin.is_dir() {
                continue;
            }
            let demo = plugin.join("demo.toml");
            // The README of a binary format states that there is no demo.
            let readme = std::fs::read_to_string(plugin.join("README.md")).unwrap();
            if !demo.exists() && readme.contains("There is no demo") {
                continue;
            }
            let place = TestFolder::new();
            let trace = place.path().join("trace.jsonl");
            let args = ["run", demo.to_str().unwrap(), "--seconds", "3", "--json", "--trace", trace.to_str().unwrap()];
            place.tatu(&args).good();
            found += 1;
            // Demos of robots may print nothing, but those of plugins print what they measure.
            if kind == "models" {
                continue;
            }
            let lines: usize = place.lines("trace.jsonl").iter().map(|l| l.status().len()).sum();
            assert!(lines >= 3, "{}: {lines} lines in 3 s", demo.display());
        }
    }
    assert!(found >= 2);
}
