//! Tests of `tatu new` and `tatu plugin`: a project is created from each template, built, and checked by its scene.

use std::fs;

use crate::kit::*;

/// Creates a plugin, builds it and runs its scene: the exit code must be 0, and the compiler must not warn.
fn works(kind: &str, lang: &str) {
    let place = TestFolder::new();
    let name = format!("my_{kind}");
    place.tatu(&["new", "plugin", &name, "--lang", lang, "--kind", kind]).good();
    let target = place.path().join("target");
    let env = [&SINGLE_BUILD[..], &[("CARGO_TARGET_DIR", target.to_str().unwrap())]].concat();
    let done = run(program(), place.path(), &["plugin", "run", &name], &env).good();
    assert!(!done.err.contains("warning"), "{}", done.err);
    assert!(done.out.contains(&format!("{name} works")), "{}\n{}", done.out, done.err);
    assert!(place.path().join(&name).join("build").join(library(&format!("tatu_{name}"))).is_file());
    // Its scene is its first test. For crates, this is the same for all kinds.
    if lang != "rust" || kind == "sensor" {
        let tested = run(program(), place.path(), &["plugin", "test", &name], &env).good();
        assert!(tested.out.ends_with("1 passed, 0 failed\n"), "{}\n{}", tested.out, tested.err);
    }
    // The scene of `tatu plugin watch` prints what the plugin does, and does not end by itself.
    let build = place.path().join(&name).join("build");
    let scene = format!("{name}/watch.toml");
    let env = [("TATU_PLUGIN_PATH", build.to_str().unwrap())];
    let watched = run(program(), place.path(), &["run", &scene, "--seconds", "5", "--strict"], &env).good();
    assert_eq!(watched.out.lines().count(), 5, "{}\n{}", watched.out, watched.err);
    assert!(watched.err.contains("100 steps"), "{}", watched.err);
    // Without the plugin's folder the scene must fail, which proves that its check is effective.
    let without = run(program(), place.path(), &["run", &format!("{name}/scene.toml"), "--steps", "200"], &[]);
    assert_ne!(without.code, 0);
}

macro_rules! templates {
    ($($(#[$condition:meta])? $test:ident: $kind:literal $lang:literal;)*) => {
        $(#[test] $(#[$condition])? fn $test() { works($kind, $lang); })*
        const MADE: &[(&str, &str)] = &[$(($kind, $lang)),*];
    };
}

templates! {
    a_command_in_c: "command" "c";
    a_sensor_in_c: "sensor" "c";
    an_actuator_in_c: "actuator" "c";
    a_part_in_c: "part" "c";
    a_model_in_c: "model" "c";
    an_importer_in_c: "importer" "c";
    a_service_in_c: "service" "c";
    a_script_language_in_c: "script" "c";
    #[cfg_attr(no_cxx, ignore = "there is no C++ compiler")] a_command_in_cpp: "command" "cpp";
    #[cfg_attr(no_cxx, ignore = "there is no C++ compiler")] a_sensor_in_cpp: "sensor" "cpp";
    #[cfg_attr(no_cxx, ignore = "there is no C++ compiler")] an_actuator_in_cpp: "actuator" "cpp";
    #[cfg_attr(no_cxx, ignore = "there is no C++ compiler")] a_part_in_cpp: "part" "cpp";
    #[cfg_attr(no_cxx, ignore = "there is no C++ compiler")] a_model_in_cpp: "model" "cpp";
    #[cfg_attr(no_cxx, ignore = "there is no C++ compiler")] an_importer_in_cpp: "importer" "cpp";
    #[cfg_attr(no_cxx, ignore = "there is no C++ compiler")] a_service_in_cpp: "service" "cpp";
    a_command_in_rust: "command" "rust";
    a_sensor_in_rust: "sensor" "rust";
    an_actuator_in_rust: "actuator" "rust";
    a_part_in_rust: "part" "rust";
    a_model_in_rust: "model" "rust";
    an_importer_in_rust: "importer" "rust";
    a_service_in_rust: "service" "rust";
    a_script_language_in_rust: "script" "rust";
}

#[test]
fn the_list_of_templates_is_complete() {
    let folder = root().join("plugin-api/template");
    for kind in ["command", "sensor", "actuator", "part", "model", "importer", "service", "script"] {
        for lang in ["c", "cpp", "rust"] {
            let there = folder.join(format!("{kind}_{lang}")).is_dir();
            assert_eq!(there, MADE.contains(&(kind, lang)), "{kind} in {lang}");
        }
    }
}

#[test]
fn addons_scenes_and_robots_run() {
    let place = TestFolder::new();
    for what in ["addon", "scene", "robot"] {
        place.tatu(&["new", what, &format!("my_first_{what}")]).good();
    }
    let addon =
        ["run", "my_first_addon/scene.toml", "--addon", "my_first_addon/my_first_addon.lua:every=1", "--seconds", "2"];
    let done = place.tatu(&addon).good();
    assert!(done.out.contains("/Pioneer_p3dx: ") && done.out.lines().count() >= 2, "{}", done.out);
    place.tatu(&["run", "my_first_scene/scene.toml", "--seconds", "2", "--strict"]).good();
    let done = place.tatu(&["run", "my_first_robot/scene.toml", "--strict"]).good();
    for robot in ["/robot", "/long_robot"] {
        assert!(done.out.contains(&format!("{robot} has arrived")), "{}", done.out);
    }
    let done = place.tatu(&["run", "my_first_robot/check.toml", "--strict", "--seconds", "3.5"]).good();
    assert!(done.out.contains("/small passes") && done.out.contains("/large passes"), "{}", done.out);
    place.tatu(&["run", "my_first_robot/models/my_first_robot/model.toml", "--strict", "--steps", "2"]).good();
}

#[test]
fn existing_folders_are_not_overwritten_and_names_are_checked() {
    let place = TestFolder::new();
    place.write("mine/keep.txt", "mine");
    place.tatu(&["new", "scene", "mine"]).refused(&["E610", "mine already exists", "nothing was changed"]);
    assert_eq!(fs::read_dir(place.path().join("mine")).unwrap().count(), 1);
    for (name, told) in [("My-Robot", "try `my_robot`"), ("end", "try another, such as `my_end`"), ("a/b", "try `a_b`")]
    {
        place.tatu(&["new", "robot", name]).refused(&["E610", told]);
    }
    let wanted = "there is no template for a script in C++";
    place.tatu(&["new", "plugin", "x", "--lang", "cpp", "--kind", "script"]).refused(&["E610", wanted]);
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1, "files were created");
    place.tatu(&["new", "scene", "other", "--to", "mine"]).good();
    assert!(place.path().join("mine/other/scene.toml").is_file());
}

#[test]
fn build_errors_are_reported_with_the_cause() {
    let place = TestFolder::new();
    place.tatu(&["plugin", "build"]).refused(&["E611", "tatu.toml", "tatu new plugin"]);
    place.tatu(&["new", "plugin", "lamp", "--lang", "c", "--kind", "sensor"]).good();
    let env = [("CC", "no-such-compiler")];
    let done = run(program(), place.path(), &["plugin", "build", "lamp"], &env);
    done.refused(&["E612", "there is no `no-such-compiler`", "install a compiler", "CC"]);
    // The compiler's output is printed, and the exit code is 1.
    place.write("lamp/broken.c", "int f(void) { return no_such_thing; }\n");
    let done = place.tatu(&["plugin", "build", "lamp"]);
    assert_eq!(done.code, 1, "{}", done.err);
    done.reports(&["broken.c:1", "no_such_thing"]);
    place.write("lamp/tatu.toml", "name = \"lamp\"\nlang = \"pascal\"\nsdk = \"0.1.0\"\n");
    place.tatu(&["plugin", "build", "lamp"]).refused(&["E611", "unknown language `pascal`"]);
}

#[test]
fn update_sdk_replaces_only_the_sdk() {
    let place = TestFolder::new();
    place.tatu(&["new", "plugin", "lamp", "--lang", "rust", "--kind", "sensor"]).good();
    let settings = place.read("lamp/tatu.toml");
    let old = settings.replace("sdk = \"", "sdk = \"0.0.1-");
    place
        .write("lamp/tatu.toml", &old)
        .write("lamp/src/lib.rs", "// mine\n")
        .write("lamp/sdk/rust/src/lib.rs", "broken");
    place.write("lamp/sdk/include/old.h", "");
    place.tatu(&["plugin", "update-sdk", "lamp"]).good();
    assert_eq!(place.read("lamp/tatu.toml"), settings);
    assert_eq!(place.read("lamp/src/lib.rs"), "// mine\n");
    assert_eq!(
        place.read("lamp/sdk/rust/src/lib.rs"),
        fs::read_to_string(root().join("plugin-api/src/lib.rs")).unwrap()
    );
    assert!(!place.path().join("lamp/sdk/include/old.h").exists() && !place.path().join("lamp/sdk.new").exists());
    // The SDK contains the crate of this repository without the parts that only the workspace needs.
    let manifest = place.read("lamp/sdk/rust/Cargo.toml");
    assert!(manifest.contains("name = \"tatu-plugin-api\"") && !manifest.contains("abi_stable"), "{manifest}");
}
