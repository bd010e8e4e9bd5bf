//! Tests that scenes of any format are converted to readable scene files that give bit-identical runs.

use std::{fs, path::PathBuf};

use crate::kit::*;

fn hash(done: &RunOutput) -> String {
    done.json()["hash"].as_str().unwrap().to_owned()
}

/// Runs a scene and its conversion; returns both hashes.
fn both(scene: &str, steps: &str) -> (String, String, TestFolder) {
    let place = TestFolder::new();
    place.tatu(&["convert", scene, "out.toml"]).good();
    let run = |scene: &str| place.tatu(&["run", scene, "--steps", steps, "--json"]);
    let (a, b) = (run(scene), run("out.toml"));
    assert_eq!(a.code, b.code, "{}\n{}", a.err, b.err);
    (hash(&a), hash(&b), place)
}

#[test]
fn scenes_and_demos_stay_the_same() {
    let mut all: Vec<PathBuf> = Vec::new();
    for folder in ["scenes/first", "plugins/importers/mesh", "plugins/importers/urdf", "plugins/sensors/laser"] {
        let files = fs::read_dir(root().join(folder)).unwrap().map(|e| e.unwrap().path());
        all.extend(files.filter(|p| p.extension().is_some_and(|x| x == "toml") && p.file_stem().unwrap() != "Cargo"));
    }
    assert!(all.len() > 5);
    for scene in all {
        let (a, b, _) = both(scene.to_str().unwrap(), "60");
        assert_eq!(a, b, "{}", scene.display());
    }
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn files_of_vrep_stay_the_same() {
    let mut count = 0;
    for e in fs::read_dir(shared("corpus/ttt")).unwrap() {
        let file = e.unwrap().path();
        if file.extension().is_some_and(|x| x == "ttt" || x == "ttm") {
            let (a, b, _) = both(file.to_str().unwrap(), "15");
            assert_eq!(a, b, "{}", file.display());
            count += 1;
        }
    }
    assert_eq!(count, 41);
}

/// A conversion preserves every property of an object, and also names, bytes and references that are easily lost.
#[test]
fn every_kind_of_value_survives_a_conversion() {
    let text = r#"
        gravity_m_s2 = [0.0, 0.1, -9.0]
        friction_pairs = [["rubber", "ice", 0.1]]
        budget = { instructions = 1000000, memory_mb = 32 }
        data = { note = "a \"quoted\" line\nand another", "\u0001tag" = { base64 = "/wD+" } }
        [[object]]
        kind = "shape"
        alias = "floor"
        primitive = "plane"
        respondable = true
        [[object]]
        kind = "shape"
        alias = "a b"
        position_m = [0.1, 0.2, 0.7]
        orientation_deg = [10.0, 20.0, 30.0]
        dynamic = true
        respondable = true
        mass_kg = 0.3
        inertia_kg_m2 = [0.01, 0.02, 0.03]
        data = { k = "v" }
        [[object]]
        kind = "joint"
        alias = "j"
        parent = "a b"
        quaternion = [0.0, 0.6, 0.0, 0.8]
        limits_deg = [-17.3, 33.3]
        control = "position"
        target_position_deg = 12.0
        max_force_nm = 3.0
        gains = [10.0, 0.0, 0.0]
        [[object]]
        kind = "shape"
        alias = "a b"
        parent = "j"
        position_m = [0.3, 0.0, 0.0]
        dynamic = true
        [[object]]
        kind = "sensor"
        sensor = "proximity"
        alias = "eye"
        parent = "a b#0"
        range_m = 2.0
        noise = { distance = { sigma = 0.01 } }
        [[object]]
        kind = "graph"
        alias = "g"
        streams = [{ name = "height", unit = "m", of = "/d", data = "z" }]
        [[object]]
        kind = "dummy"
        alias = "d"
        script = { text = "function sysCall_actuation() x = (x or 0) + 1 end", priority = "first" }
    "#;
    let place = TestFolder::scene(text);
    place.tatu(&["check", "scene.toml"]).good();
    place.tatu(&["convert", "scene.toml", "out.toml"]).good();
    // Converting the result again gives the same text.
    place.tatu(&["convert", "out.toml", "again.toml"]).good();
    let (out, again) = (place.read("out.toml"), place.read("again.toml"));
    assert_eq!(out, again.replace("again_files", "out_files"));
    for words in
        ["limits_deg = [-17.3, 33.3]", "base64 = \"/wD+\"", "name = \"a b#0\"", "parent = \"a b\"", "range_m = 2.0"]
    {
        assert!(out.contains(words), "{words}\n{out}");
    }
    let run = |scene: &str| hash(&place.tatu(&["run", scene, "--steps", "50", "--json"]).good());
    assert_eq!(run("scene.toml"), run("out.toml"));
}

#[test]
fn conversions_that_cannot_be_written_are_refused() {
    let place = TestFolder::scene(FLOOR);
    place.tatu(&["convert", "scene.toml", "out.txt"]).refused(&["error[E105]", ".toml"]);
    place.tatu(&["convert", "scene.toml", "nowhere/out.toml"]).refused(&["error[E105]", "nowhere"]);
    place.tatu(&["convert", "missing.toml", "out.toml"]).refused(&["error[E105]", "missing.toml"]);
}

#[test]
fn meshes_are_named_by_their_files() {
    let mesh = |name: &str| format!("{FLOOR}[[object]]\nkind = \"shape\"\nprimitive = \"mesh\"\nmesh = \"{name}\"\n");
    let place = TestFolder::scene(&mesh("m.obj"));
    place.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").write("bad.obj", "f 1 2 3\n");
    place.run(&["--steps", "1"]).good();
    for (name, words) in
        [("missing.obj", "missing.obj"), ("bad.obj", "bad.obj"), ("../m.obj", "outside"), ("m.xyz", "m.xyz")]
    {
        place.write("scene.toml", &format!("format = 1\n{}", mesh(name)));
        place.write("m.xyz", "what");
        place.run(&[]).refused(&["scene.toml:", words]);
    }
}
