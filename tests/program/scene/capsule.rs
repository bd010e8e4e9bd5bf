//! Tests of recorded runs, and of `tatu verify`, which repeats them.

use std::{
    fs,
    io::{Cursor, Read, Write},
};

use zip::{ZipArchive, ZipWriter, write::SimpleFileOptions};

use crate::kit::*;

/// Writes a copy of a recorded run in which `change` has changed the contents of its files.
fn changed(place: &TestFolder, name: &str, change: impl Fn(&str, String) -> String) {
    let mut from = ZipArchive::new(fs::File::open(place.path().join("run.tatu")).unwrap()).unwrap();
    let mut to = ZipWriter::new(Cursor::new(Vec::new()));
    for i in 0..from.len() {
        let mut entry = from.by_index(i).unwrap();
        let name = entry.name().unwrap().into_owned();
        let mut text = Vec::new();
        entry.read_to_end(&mut text).unwrap();
        to.start_file(name.as_str(), SimpleFileOptions::default()).unwrap();
        match String::from_utf8(text) {
            Ok(text) => to.write_all(change(&name, text).as_bytes()),
            Err(binary) => to.write_all(binary.as_bytes()),
        }
        .unwrap();
    }
    fs::write(place.path().join(name), to.finish().unwrap().into_inner()).unwrap();
}

fn recorded(scene: &str, more: &[&str]) -> TestFolder {
    let place = TestFolder::new();
    let scene = root().join(scene);
    let run = [&["run", scene.to_str().unwrap(), "--capsule", "run.tatu"][..], more].concat();
    place.tatu(&run).good();
    place
}

#[test]
fn recorded_runs_are_the_same() {
    for scene in [
        "scenes/first/pioneer_avoids_walls.toml",
        "scenes/course/gps.toml",
        "scenes/course/kinect_capture.toml",
        "scenes/course/laser_scanner_2d_signal_tube_log.toml",
    ] {
        let place = recorded(scene, &["--steps", "12", "--seed", "7", "--set", "scene.dt_s=0.04"]);
        for threads in ["1", "2"] {
            let verified = place.tatu(&["verify", "run.tatu", "--threads", threads]).good();
            assert!(verified.out.starts_with("same: 12 steps, hash "), "{scene}: {}", verified.out);
        }
        // It is a scene as well.
        let hash = place.tatu(&["run", "run.tatu", "--steps", "12", "--json"]).good().json()["hash"].clone();
        let verified = place.tatu(&["verify", "run.tatu", "--json"]).good().json();
        assert_eq!((&verified["result"], &verified["steps"], &verified["hash"]), (&"same".into(), &12.into(), &hash));
    }
}

#[test]
fn what_differs_is_named() {
    let place = recorded("scenes/first/pioneer_avoids_walls.toml", &["--steps", "20"]);
    let result = |name: &str| {
        let done = place.tatu(&["verify", name]);
        (done.code, done.out + &done.err)
    };
    // Scripts and the scene are compared with the record of files, before anything runs.
    changed(&place, "script.tatu", |name, text| match name.ends_with(".lua") {
        true => text.replace("cruise = 3.0", "cruise = 3.1"),
        false => text,
    });
    let (code, text) = result("script.tatu");
    assert!(code == 1 && text.contains("different: file files/Pioneer_p3dx.lua: its contents have"), "{text}");
    changed(&place, "scene.tatu", |name, text| match name {
        "scene.toml" => text.replacen("0.05", "0.04", 1),
        _ => text,
    });
    let (code, text) = result("scene.tatu");
    assert!(code == 1 && text.contains("different: file scene.toml: its contents have changed"), "{text}");
    // Each line of the input has a checksum.
    changed(&place, "log.tatu", |name, text| match name.ends_with("inputs.jsonl") {
        true => text.replace("\"end\":20", "\"end\":21"),
        false => text,
    });
    let (code, text) = result("log.tatu");
    assert!(code == 2 && text.contains("E116") && text.contains("damaged at line 2"), "{text}");
    // A run whose hashes differ: the step and the objects are named.
    changed(&place, "hash.tatu", |name, text| {
        let change = |(i, line): (usize, &str)| {
            let mut step: serde_json::Value = serde_json::from_str(line).unwrap();
            if i >= 12 {
                step["hash"] = "0123456789abcdef".into();
                step["objects"]["/crate"] = "0123456789abcdef".into();
            }
            step.to_string() + "\n"
        };
        if name.ends_with("hashes.jsonl") { text.lines().enumerate().map(change).collect() } else { text }
    });
    let (code, text) = result("hash.tatu");
    assert!(code == 1 && text.contains("different: step 12 (t = 0.600 s): /crate\n"), "{text}");
    changed(&place, "damaged.tatu", |name, text| match name.ends_with("hashes.jsonl") {
        true => text.replacen("\"step\":3", "\"stop\":3", 1),
        false => text,
    });
    let (code, text) = result("damaged.tatu");
    assert!(code == 2 && text.contains("E116") && text.contains("hashes.jsonl:4"), "{text}");
    // Another library of a plugin may do the same, so it is only noted.
    changed(&place, "plugin.tatu", |name, text| match name {
        "scene.lock" => text.replacen("sha256 = \"", "sha256 = \"0", 1),
        _ => text,
    });
    let (code, text) = result("plugin.tatu");
    assert!(code == 0 && text.contains("same: 20") && text.contains("not verified: plugin tatu."), "{text}");
}

#[test]
fn a_run_that_cannot_be_recorded_is_refused() {
    let place = TestFolder::scene("[[object]]\nkind = \"dummy\"\nalias = \"d\"\n");
    let refused = place.tatu(&["run", "scene.toml", "--capsule", "run.toml"]);
    assert!(refused.code == 2 && refused.err.contains("a name that ends with `.tatu`"), "{}", refused.err);
    let addon = root().join("addons/pose_logger.lua");
    let refused = place.tatu(&["run", "scene.toml", "--capsule", "run.tatu", "--addon", addon.to_str().unwrap()]);
    assert!(refused.code == 2 && refused.err.contains("with add-ons: pose_logger"), "{}", refused.err);
    let serve = ["serve", "scene.toml", "--service", "jsonl:port=0", "--capsule", "run.tatu", "--addon"];
    let refused = place.tatu(&[&serve[..], &[addon.to_str().unwrap()]].concat());
    assert!(refused.code == 2 && refused.err.contains("with add-ons: pose_logger"), "{}", refused.err);
    place.tatu(&["pack", "scene.toml", "scene.tatu"]).good();
    let refused = place.tatu(&["verify", "scene.tatu"]);
    assert!(refused.code == 2 && refused.err.contains("contains no recorded run"), "{}", refused.err);
}

/// Files that scripts read are not in the record unless they are named, which the verification says.
#[test]
fn files_that_a_script_reads_are_packed_or_noted() {
    let place = TestFolder::new();
    place.write("scene.toml", "format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"d\"\nscript = \"d.lua\"\n");
    place.write(
        "d.lua",
        "function sysCall_init() local n = tonumber(io.open('data.txt'):read())\n\
         sim.setObjectPosition(sim.getObject('/d'), -1, {n, 0, 0}) end",
    );
    place.write("data.txt", "2");
    place.tatu(&["run", "scene.toml", "--steps", "3", "--capsule", "run.tatu"]).good();
    let noted = place.tatu(&["verify", "run.tatu"]);
    assert!(noted.err.contains("not verified: the run read files") && noted.err.contains("data.txt"), "{}", noted.err);
    let packed = ["--capsule", "whole.tatu", "--capsule-file", "data.txt"];
    place.tatu(&[&["run", "scene.toml", "--steps", "3"][..], &packed].concat()).good();
    fs::remove_file(place.path().join("data.txt")).unwrap();
    let verified = place.tatu(&["verify", "whole.tatu"]).good();
    assert!(verified.out.starts_with("same"), "{}", verified.out);
}
