//! Tests of `tatu plugin why` and `tatu plugin list`: how names are resolved, which folders are searched, and which
//! plugins are hidden by others. Broken libraries are tested in `broken`.

#![cfg(target_os = "linux")]

use std::{fs, path::PathBuf};

use crate::{kit::plugin_sources::*, kit::said::*, kit::*};

/// Runs `tatu plugin why` with `mine` in the search path.
pub fn ask(place: &TestFolder, args: &[&str]) -> RunOutput {
    let all = [&["plugin", "why"], args].concat();
    let done = run(program(), place.path(), &all, &[("TATU_PLUGIN_PATH", "mine")]);
    assert!(done.err.is_empty() && done.signal.is_none(), "{}\n{}", done.err, done.out);
    done
}

/// Creates a folder that contains an empty folder `mine`.
pub fn folder() -> TestFolder {
    let place = TestFolder::new();
    fs::create_dir(place.path().join("mine")).unwrap();
    place
}

pub fn file(place: &TestFolder, name: &str) -> PathBuf {
    place.path().join("mine").join(library(&format!("tatu_{name}")))
}

/// Replaces numbers that depend on the compiler.
pub fn without_sizes(text: &str) -> String {
    let number = |w: &str| w.parse::<u64>().is_ok_and(|n| n > 100);
    text.split(' ').map(|w| if number(w) { "SIZE" } else { w }).collect::<Vec<_>>().join(" ")
}

impl OutputSnapshot {
    /// Runs `tatu plugin why`, which must fail, and adds the last two lines of its output: the reason why a plugin is
    /// not loaded, and the help.
    #[track_caller]
    pub fn because(&mut self, tried: &str, place: &TestFolder, args: &[&str]) {
        let done = ask(place, args);
        assert_eq!(done.code, 1, "{}", done.out);
        let (_, last) = done.out.rsplit_once("\n\n").unwrap();
        let lines: Vec<&str> = last.lines().collect();
        assert!(lines.len() == 2 && lines[0].contains(" is not loaded: ") && lines[1].starts_with("help: "), "{last}");
        self.add(tried, place, &without_sizes(last));
    }
}

pub fn good() -> PluginSource {
    PluginSource::new("x")
}

/// Returns the bytes of a valid plugin.
pub fn good_bytes() -> Vec<u8> {
    let place = folder();
    compile(&place, "x", &good().text());
    fs::read(file(&place, "x")).unwrap()
}

#[test]
fn a_loaded_plugin_is_found_by_name_id_and_file() {
    let place = folder();
    compile(&place, "x", &good().text());
    for what in ["x", "tatu_x", "libtatu_x.so", "tatu-x", "org.test.x", "mine/libtatu_x.so", "./mine/libtatu_x.so"] {
        let done = ask(&place, &[what]).good();
        let last = done.out.lines().last().unwrap();
        assert!(last.starts_with("It is loaded: `org.test.x` 1 from "), "{}", done.out);
        assert!(last.ends_with("mine/libtatu_x.so"), "{last}");
    }
    let out = ask(&place, &["x"]).good().out;
    let lines: Vec<&str> = out.lines().collect();
    assert_eq!(
        lines[..2],
        ["x is searched for in these folders, in this order:", "  1. mine (TATU_PLUGIN_PATH): libtatu_x.so"]
    );
    assert!(lines[2].ends_with("debug/plugins (next to the program): does not exist"), "{out}");
    assert!(
        lines[3].contains("deps (built with the program): ") && lines[3].ends_with(" plugins with different names"),
        "{out}"
    );
    assert!(lines[5].ends_with(".data/tatu/plugins (your own, for `tatu plugin install`): does not exist"), "{out}");
    for line in ["  id         org.test.x 1", "  offers     1 command"] {
        assert!(lines.contains(&line), "{line}:\n{out}");
    }
    assert!(out.contains("\n  built for  ABI 0.") && out.contains(", draft 4\n"), "{out}");
    assert!(out.contains("\n  needs      libc.so.6 (/"), "{out}");
    // A plugin of the program, with the output as JSON.
    let json = ask(&place, &["tatu.script.lua", "--json"]).good().json();
    assert_eq!((json["loaded"].as_bool(), json["reason"].is_null()), (Some(true), true), "{json}");
    let json = ask(&place, &["nothing", "--json"]).json();
    assert_eq!((json["loaded"].as_bool(), json["reason"]["kind"].as_str()), (Some(false), Some("unknown")), "{json}");
    assert_eq!(json["folders"][0]["source"], "environment");
    assert_eq!(json["folders"][1]["state"], "missing");
}

#[test]
fn misspelt_plugin_names_get_the_nearest_one() {
    let mut said = said!();
    for name in ["hello.so", "libhello.so", "libtatu-hello.so", "libtatu_hello.so.1", "libTatu_hello.so"] {
        let place = folder();
        fs::write(place.path().join("mine").join(name), good_bytes()).unwrap();
        said.because(name, &place, &["hello"]);
    }
    let place = folder();
    compile(&place, "hello", &PluginSource::new("hello").text());
    said.because("a name with an error", &place, &["helo"]);
    said.because("an id with an error", &place, &["org.test.helo"]);
    said.because("a path with an error", &place, &["mine/libtatu_helo.so"]);
    said.because("a path without lib", &place, &["mine/hello.so"]);
    said.because("a missing folder", &place, &["theirs/libtatu_hello.so"]);
    said.because("no similar name", &place, &["unheard_of_elsewhere"]);
}

#[test]
fn folders_that_are_not_searched_are_reported() {
    let mut said = said!();
    let place = folder();
    compile(&place, "hello", &PluginSource::new("hello").text());
    let mut because = |tried: &str, path: &str, args: &[&str]| {
        let done = run(
            program(),
            place.path(),
            &[&["plugin", "why"], args].concat(),
            &[("TATU_PLUGIN_PATH", path), ("TATU_TRUST", "")],
        );
        assert_eq!(done.code, 1, "{}\n{}", done.out, done.err);
        said.add(tried, &place, done.out.rsplit_once("\n\n").unwrap().1);
    };
    because("a missing folder", "nowhere", &["hello"]);
    because("a file instead of a folder", "mine/libtatu_hello.so", &["hello"]);
    because("another folder", "", &["mine/libtatu_hello.so"]);
    because("a parent folder", ".", &["hello"]);
    place.write("scene.toml", "format = 1\n[scene]\nplugins = [\"mine\"]\n");
    because("a scene without permission", "", &["hello", "--scene", "scene.toml"]);
    fs::create_dir(place.path().join("build")).unwrap();
    fs::copy(file(&place, "hello"), place.path().join("build/libtatu_hello.so")).unwrap();
    because("the folder `build`", "", &["hello"]);
    let leave = ["plugin", "why", "hello", "--scene", "scene.toml", "--allow", "plugins"];
    run(program(), place.path(), &leave, &[("TATU_TRUST", "")]).good();
    let done = run(program(), place.path(), &["plugin", "why", "hello", "--scene", "none.toml"], &[]);
    done.refused(&["error[E105]", "none.toml"]);
}

#[test]
fn faults_of_a_plugin_are_reported_wherever_it_is() {
    let place = folder();
    let explained = |path: &str, file: &str| {
        let args = ["plugin", "why", file];
        run(program(), place.path(), &args, &[("TATU_PLUGIN_PATH", path)])
    };
    let draft = PluginSource::new("old")
        .with(|s| s.extension = s.extension.replace("TATU_COMMAND", "\"tatu.command/draft.1\""));
    compile(&place, "old", &draft.text());
    for path in ["", "mine"] {
        let done = explained(path, "mine/libtatu_old.so");
        assert_eq!(done.code, 1, "{}", done.out);
        let (_, last) = done.out.rsplit_once("\n\n").unwrap();
        assert!(last.contains("nothing of it is used: it is built for draft 1 of `tatu.command`"), "{last}");
    }
    let spaced = PluginSource::new("spaced").text().replace("\"spaced.one\"", "\"spaced one\"");
    compile(&place, "spaced", &spaced);
    for (path, code) in [("", 1), ("mine", 0)] {
        let done = explained(path, "mine/libtatu_spaced.so");
        assert!(done.code == code && done.out.contains("its command `spaced one` has an invalid name"), "{}", done.out);
    }
}

#[test]
fn the_plugin_that_hides_another_is_reported() {
    let mut said = said!();
    let place = folder();
    compile(&place, "first", &PluginSource::new("twin").text());
    compile(&place, "second", &PluginSource::new("twin").text());
    said.because("the second plugin with an id", &place, &["second"]);
    ask(&place, &["first"]).good();
    // If several plugins have the same id, it refers to the one that is loaded.
    let done = ask(&place, &["org.test.twin"]).good();
    assert!(done.out.contains("  hidden by  mine/libtatu_first.so\n"), "{}", done.out);
    // A plugin that cannot be loaded does not hide others.
    compile(&place, "first", &PluginSource::new("twin").with(|s| s.major = "7".into()).text());
    ask(&place, &["second"]).good();
}

#[test]
fn all_files_are_listed_in_search_order() {
    let place = folder();
    compile(&place, "a", &PluginSource::new("twin").text());
    compile(&place, "b", &PluginSource::new("twin").text());
    compile(&place, "c", &PluginSource::new("c").with(|s| s.major = "7".into()).text());
    fs::write(place.path().join("mine/libd.so"), good_bytes()).unwrap();
    let env = [("TATU_PLUGIN_PATH", "mine:nowhere")];
    let done = run(program(), place.path(), &["plugin", "list", "--json"], &env).good();
    done.reports(&["note: nowhere (TATU_PLUGIN_PATH): does not exist"]);
    let rows = done.json();
    let rows = rows.as_array().unwrap();
    let row =
        |i: usize| ["id", "from", "file", "state", "hidden_by"].map(|k| rows[i][k].as_str().unwrap_or("-").to_owned());
    assert_eq!(row(0), ["org.test.twin", "environment", "mine/libtatu_a.so", "loaded", "-"]);
    assert_eq!(row(1), ["org.test.twin", "environment", "mine/libtatu_b.so", "hidden", "mine/libtatu_a.so"]);
    assert_eq!(row(2), ["org.test.c", "environment", "mine/libtatu_c.so", "rejected", "-"]);
    assert_eq!(rows[2]["reason"]["kind"], "other-abi");
    assert_eq!(row(3), ["-", "environment", "mine/libd.so", "rejected", "-"]);
    assert_eq!(rows[3]["reason"]["kind"], "wrong-name");
    let built = rows.iter().filter(|r| r["from"] == "built").count();
    assert!(built >= 20 && rows.iter().skip(4).all(|r| r["state"] == "loaded"), "{rows:?}");
    let done = run(program(), place.path(), &["plugin", "list"], &env).good();
    let lines: Vec<&str> = done.out.lines().collect();
    assert!(lines[0].starts_with("ID ") && lines[0].ends_with("STATE"), "{}", done.out);
    assert!(
        lines[2].ends_with("mine/libtatu_b.so  hidden by mine/libtatu_a.so")
            || lines[2].contains("  hidden by mine/libtatu_a.so"),
        "{}",
        done.out
    );
    assert!(lines[3].contains("rejected: it was built for ABI 7."), "{}", done.out);
}
