//! Scene files of V-REP: what the importer finds in 41 of them is what an independent reader found, and all of them run.

use std::{fs, path::PathBuf};

use serde_json::Value;

use crate::kit::*;

fn files() -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = fs::read_dir(shared("corpus/ttt"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|x| x == "ttt" || x == "ttm"))
        .collect();
    all.sort();
    all
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn files_are_read_as_an_independent_reader_does() {
    let mut count = 0;
    for file in files() {
        let wanted: Value =
            serde_json::from_str(&fs::read_to_string(file.with_extension("expected.json")).unwrap()).unwrap();
        let done = Place::new().tatu(&["check", file.to_str().unwrap(), "--json"]).good();
        let mut found = done.json();
        assert!(found["report"].is_array(), "{}: no report", file.display());
        found.as_object_mut().unwrap().remove("report");
        let differs: Vec<&String> =
            wanted.as_object().unwrap().iter().filter(|(k, v)| found.get(*k) != Some(*v)).map(|(k, _)| k).collect();
        assert!(differs.is_empty() && found == wanted, "{}: {differs:?} differ", file.display());
        count += 1;
    }
    assert_eq!(count, 41);
}

/// Files whose scripts raise errors in the original too, and what they lack.
const LACKING: &[(&str, &str)] = &[
    ("v30003_quadcopter", "simExtQuadcopterReadSensors"),
    ("v30103_3Rob_freeEnvironm", "dlgStyle"),
    ("v30203_Lab2_Environment", "there is no object -1"),
    ("v30301_Pioneer_p3dx_traj_DEMO", "CustomDataFromHeader|a nil value"),
    ("v40000_ur10-rg2-rack-bottles-box", "module `"),
    ("v40300_testSceneForModelDevelopment", "module `blimp`"),
    ("v41000_locomocao", "org.conman.cbor"),
];

/// Scripts of eleven years run without an error, or with those that they have in the original.
#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn files_run() {
    let mut good = 0;
    for file in files() {
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        let done = Place::new().tatu(&["run", file.to_str().unwrap(), "--steps", "30", "--json"]);
        assert!(!done.err.contains("panicked"), "{name}: {}", done.err);
        match LACKING.iter().find(|(n, _)| *n == name) {
            Some((_, words)) => {
                for e in done.errors() {
                    let text = e["message"].as_str().unwrap();
                    assert!(words.split('|').any(|w| text.contains(w)), "{name}: {text}");
                }
            }
            None => {
                done.good();
                good += 1;
            }
        }
    }
    assert_eq!(good, 41 - LACKING.len());
}

/// The original takes position targets as they come, once a step, and so do its scenes.
#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn targets_jump_as_in_the_original() {
    let place = Place::new();
    let file = shared("corpus/ttt/v20606_ackermannControlExample.ttt");
    place.tatu(&["convert", file.to_str().unwrap(), "scene.toml"]).good();
    let scene = place.read("scene.toml");
    let joints = scene.matches("kind = \"joint\"").count();
    assert!(joints > 0);
    assert_eq!(scene.matches("smooth_target = false").count(), joints);
}

/// Cut at many places and with bits turned: a file is refused with its offset, or read; never a crash.
#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn damaged_files_are_refused() {
    let smallest = files().into_iter().min_by_key(|f| fs::metadata(f).unwrap().len()).unwrap();
    let whole = fs::read(&smallest).unwrap();
    let place = Place::new();
    for i in 0..60 {
        let mut bytes = whole.clone();
        let at = (i * 7919 + 31) % whole.len();
        if i % 2 == 0 {
            bytes.truncate(at);
        } else {
            bytes[at] ^= 1 << (i % 8);
        }
        let name = if smallest.extension().is_some_and(|x| x == "ttm") { "d.ttm" } else { "d.ttt" };
        fs::write(place.path().join(name), &bytes).unwrap();
        let done = place.tatu(&["check", name]);
        assert!(matches!(done.code, 0 | 2), "{at}: exit {}\n{}", done.code, done.err);
        assert!(!done.err.contains("panicked"), "{at}: {}", done.err);
    }
}
