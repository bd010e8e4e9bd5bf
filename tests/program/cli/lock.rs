//! Tests of `tatu lock`, and of the key `needs` of a scene.

use crate::kit::*;

const MODEL: &str = "format = 1\n[model]\ntext = \"A box.\"\n[[object]]\nkind = \"shape\"\nalias = \"box\"\n";

#[test]
fn lock_check_names_the_changed_files() {
    let place = TestFolder::scene(&format!("[[model]]\nmodel = \"crate\"\n{}", watcher("d", "")));
    std::fs::create_dir_all(place.path().join("models/crate")).unwrap();
    place.write("models/crate/model.toml", MODEL);
    place.tatu(&["lock", "scene.toml", "--check"]).refused(&["E105", "scene.lock", "tatu lock scene.toml"]);
    let done = place.tatu(&["lock", "scene.toml"]).good();
    assert!(done.out.contains("scene.lock: ") && done.out.contains("models: 1, other files: 1"), "{}", done.out);
    let lock = place.read("scene.lock");
    for part in
        ["id = \"tatu.models.folder\"", "file = \"models/crate/model.toml\"", "file = \"scene.toml\"", "sha256 = "]
    {
        assert!(lock.contains(part), "{part}: {lock}");
    }
    assert_eq!(place.tatu(&["lock", "scene.toml", "--check"]).good().out, "scene.toml: agrees with its lock file\n");
    // Changes are reported by name, including changed contents of a plugin's file.
    place.write("models/crate/model.toml", &MODEL.replace("A box.", "A crate."));
    let folder = lock.split("[[plugin]]").find(|p| p.contains("tatu.models.folder")).unwrap();
    place.write("scene.lock", &lock.replace(folder, &folder.replace("version = \"", "version = \"9")));
    let done = place.tatu(&["lock", "scene.toml", "--check"]);
    assert_eq!(done.code, 1, "{}", done.err);
    for line in [
        "model models/crate/model.toml: its contents have changed",
        "plugin tatu.models.folder: version 9",
        "scene.lock: 2",
    ] {
        assert!(done.out.contains(line), "{line}: {}", done.out);
    }
    place.write("scene.lock", "plugin = 1\n");
    place.tatu(&["lock", "scene.toml", "--check"]).refused(&[
        "E100",
        "scene.lock",
        "`plugin` is not an array of tables",
    ]);
}

#[cfg(unix)]
#[test]
fn a_lock_replaces_only_locks() {
    let place = TestFolder::scene(&watcher("d", ""));
    let lock = place.path().join("scene.lock");
    let text = place.read("scene.toml");
    place.write("scene.lock", "version = 4\n");
    place.tatu(&["lock", "scene.toml"]).refused(&["E105", "was not written by `tatu lock`"]);
    assert_eq!(place.read("scene.lock"), "version = 4\n");
    std::fs::remove_file(&lock).unwrap();
    std::os::unix::fs::symlink("scene.toml", &lock).unwrap();
    place.tatu(&["lock", "scene.toml"]).refused(&["E105", "not a regular file"]);
    std::fs::remove_file(&lock).unwrap();
    succeed(std::process::Command::new("mkfifo").arg(&lock));
    place.tatu(&["lock", "scene.toml"]).refused(&["E105", "not a regular file"]);
    place.tatu(&["lock", "scene.toml", "--check"]).refused(&["E105", "not a plain file"]);
    assert_eq!(place.read("scene.toml"), text);
}

#[test]
fn plugin_requirements_of_a_scene_are_checked() {
    let scene =
        |needs: &str| TestFolder::scene(&format!("needs = {needs}\n{}", watcher("d", ""))).run(&["--steps", "1"]);
    scene("[\"tatu.sensor.gps\", \"tatu.sensor.imu >= 0.1\", \"tatu.sensor.imu = 0.1\"]").good();
    scene("[\"org.author.imu >= 1.2\"]").refused(&["E104", "`org.author.imu`, which is not loaded", "scene.toml:"]);
    scene("[\"tatu.sensor.imo\"]").refused(&["E104", "did you mean `tatu.sensor.imu`?"]);
    scene("[\"tatu.sensor.imu >= 7.2\"]").refused(&[
        "E104",
        "needs `tatu.sensor.imu >= 7.2`",
        "version 0.1.0 is loaded",
    ]);
    scene("[\"tatu.sensor.imu >= new\"]").refused(&["E102", "`tatu.sensor.imu >= new` is not a valid requirement"]);
    scene("\"tatu.sensor.imu\"").refused(&["E102", "not a list of plugins"]);
    scene("[3]").refused(&["E102", "not a list of plugins"]);
}
