//! Tests that a packed scene holds all that it needs, runs the same anywhere, and cannot harm where it is unpacked.

use std::{fs, path::PathBuf, process::Command};

use crate::kit::*;

fn hash(place: &TestFolder, scene: &str, steps: &str) -> String {
    let done = place.tatu(&["run", scene, "--steps", steps, "--json", "--allow", "net=*:*"]);
    done.json()["hash"].as_str().unwrap_or_else(|| panic!("{scene}: {}", done.err)).to_owned()
}

#[test]
fn packed_scenes_run_to_the_same_hash() {
    let mut scenes: Vec<PathBuf> = Vec::new();
    for folder in ["scenes/course", "scenes/first", "scenes/showcase", "scenes/learn"] {
        let files = fs::read_dir(root().join(folder)).unwrap().map(|e| e.unwrap().path());
        scenes.extend(files.filter(|path| path.extension().is_some_and(|suffix| suffix == "toml")));
    }
    scenes.sort();
    assert!(scenes.len() > 30);
    // A sixth of them, since each one is loaded four times.
    for scene in scenes.iter().step_by(6) {
        let (place, scene) = (TestFolder::new(), scene.to_str().unwrap());
        place.tatu(&["pack", scene, "packed.tatu"]).good();
        assert_eq!(hash(&place, scene, "12"), hash(&place, "packed.tatu", "12"), "{scene}");
        let cached = fs::read_dir(place.path().join(".cache/tatu/packs")).unwrap().next().unwrap().unwrap().path();
        let text = fs::read_to_string(cached.join("scene.toml")).unwrap();
        assert!(!text.contains("[[model]]") && !text.contains("[[import]]"), "{scene} needs models");
    }
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn packed_files_of_vrep_run_to_the_same_hash() {
    let mut files: Vec<PathBuf> = fs::read_dir(shared("corpus/ttt")).unwrap().map(|e| e.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|suffix| suffix == "ttt"));
    files.sort();
    assert!(files.len() >= 20);
    // Conversions, which are tested with all of them, write the same scene.
    for file in files.iter().step_by(10) {
        let (place, file) = (TestFolder::new(), file.to_str().unwrap());
        place.tatu(&["pack", file, "packed.tatu"]).good();
        assert_eq!(hash(&place, file, "5"), hash(&place, "packed.tatu", "5"), "{file}");
    }
}

const MODULES: &str = r#"
[[object]]
kind = "dummy"
alias = "a"
script = "lua/main.lua"
"#;

fn scene_with_modules() -> TestFolder {
    let place = TestFolder::scene(MODULES);
    fs::create_dir_all(place.path().join("lua/far")).unwrap();
    place.write(
        "lua/main.lua",
        "local m = require('far/inner')\nfunction sysCall_init() print(m.word(), io.open('data.csv'):read()) end",
    );
    place.write("lua/far/inner.lua", "local other = require('other')\nreturn { word = function() return other end }");
    place.write("lua/other.lua", "return 'the word'").write("lua/unused.lua", "").write("data.csv", "1,2,3");
    place
}

/// A script and its modules beside the scene, which is named without a folder.
#[test]
fn modules_in_the_working_folder_are_packed() {
    let place = TestFolder::scene("[[object]]\nkind = \"dummy\"\nalias = \"a\"\nscript = \"main.lua\"\n");
    place.write("main.lua", "function sysCall_init() print(require('other')) end").write("other.lua", "return 'here'");
    place.tatu(&["pack", "scene.toml", "packed.tatu"]).good();
    let elsewhere = TestFolder::new();
    fs::copy(place.path().join("packed.tatu"), elsewhere.path().join("p.tatu")).unwrap();
    let done = elsewhere.tatu(&["run", "p.tatu", "--steps", "1"]).good();
    assert!(done.out.contains("here"), "{}{}", done.out, done.err);
}

#[test]
fn modules_and_named_files_are_packed() {
    let place = scene_with_modules();
    let unpacked = TestFolder::new();
    place.tatu(&["pack", "scene.toml", "packed.tatu", "--file", "data.csv"]).good();
    fs::copy(place.path().join("packed.tatu"), unpacked.path().join("p.tatu")).unwrap();
    let done = unpacked.tatu(&["run", "p.tatu", "--steps", "1"]).good();
    assert!(done.out.contains("the word\t1,2,3"), "{}{}", done.out, done.err);
    unpacked.tatu(&["unpack", "p.tatu", "-o", "here"]).good();
    assert_eq!(unpacked.read("here/other.lua"), "return 'the word'");
    assert!(!unpacked.path().join("here/unused.lua").exists());
    unpacked.tatu(&["lock", "here/scene.toml", "--check"]).good();
    // The same files give the same bytes.
    place.tatu(&["pack", "scene.toml", "again.tatu", "--file", "data.csv"]).good();
    assert_eq!(fs::read(place.path().join("packed.tatu")).unwrap(), fs::read(place.path().join("again.tatu")).unwrap());
}

#[test]
fn packs_that_cannot_be_written_are_refused() {
    let place = scene_with_modules();
    place.tatu(&["pack", "scene.toml", "packed.zip"]).refused(&["error[E105]", ".tatu"]);
    place.tatu(&["pack", "scene.toml", "p.tatu", "--file", "/etc/hostname"]).refused(&["error[E105]", "not below"]);
    place.tatu(&["pack", "scene.toml", "p.tatu", "--file", "scene.toml"]).refused(&["two files named `scene.toml`"]);
    assert!(!place.path().join("p.tatu").exists());
    place.tatu(&["pack", "scene.toml", "p.tatu"]).good();
    place.tatu(&["unpack", "p.tatu", "-o", "lua"]).refused(&["error[E105]", "not empty"]);
}

#[test]
fn damaged_and_hostile_packs_are_refused() {
    let place = scene_with_modules();
    place.tatu(&["pack", "scene.toml", "good.tatu"]).good();
    let good = fs::read(place.path().join("good.tatu")).unwrap();
    for cut in [0, 10, good.len() / 2, good.len() - 1] {
        fs::write(place.path().join("cut.tatu"), &good[..cut]).unwrap();
        let refused = place.tatu(&["run", "cut.tatu"]);
        assert!(refused.code == 2 && refused.err.contains("cannot unpack cut.tatu"), "{cut}: {}", refused.err);
    }
    let python = "import zipfile\nz = zipfile.ZipFile('evil.tatu', 'w')\nz.writestr('scene.toml', 'format = 1')\n\
                  z.writestr('../../evil.txt', 'x')";
    succeed(Command::new("python3").arg("-c").arg(python).current_dir(place.path()));
    place.tatu(&["unpack", "evil.tatu", "-o", "deep/er"]).refused(&["error[E105]", "leads out"]);
    assert!(!place.path().join("deep").exists() && !place.path().join("evil.txt").exists());
}

#[test]
fn paths_of_this_computer_in_scripts_are_reported() {
    let place = TestFolder::new();
    let text = format!("local where = '{}'", place.path().canonicalize().unwrap().display());
    place.write("scene.toml", &format!("format = 1\n{MODULES}").replace("lua/main.lua", "m.lua")).write("m.lua", &text);
    let done = place.tatu(&["pack", "scene.toml", "p.tatu"]).good();
    assert!(
        done.err.contains("line 1 of the packed file `files/") && done.err.contains("this computer"),
        "{}",
        done.err
    );
}
