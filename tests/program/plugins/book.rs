//! Tests of the book for plugin authors: its shell commands run, and its code is taken from templates that are built
//! and run.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::kit::{browser::wait_for, *};

const BOOK: &str = "docs/plugin-authors";

/// Returns language and text of each code block of a page, in order.
fn blocks(page: &str) -> Vec<(String, String)> {
    let text = fs::read_to_string(root().join(BOOK).join(page)).unwrap();
    let mut parts = text.split("\n```");
    parts.next();
    let mut out = Vec::new();
    while let (Some(block), Some(_)) = (parts.next(), parts.next()) {
        let (language, text) = block.split_once('\n').unwrap();
        out.push((language.to_owned(), text.to_owned()));
    }
    out
}

/// Runs all shell blocks of a page in a single shell, which stops at the first failure. `before` contains the commands
/// that the page assumes to have been run.
fn runs(page: &str, before: &str) {
    let place = TestFolder::new();
    let shell = blocks(page).into_iter().filter(|(language, _)| language == "sh").map(|(_, text)| text);
    let script = format!("set -e\n{before}\n{}\n", shell.collect::<Vec<_>>().join("\n"));
    let folder = program().parent().unwrap().display().to_string();
    let path = format!("{folder}:{}", std::env::var("PATH").unwrap());
    let target = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("book");
    let env = [("PATH", path.as_str()), ("CARGO_TARGET_DIR", target.to_str().unwrap()), ("CARGO_NET_OFFLINE", "true")];
    let env = [&SINGLE_BUILD[..], &env].concat();
    run(Path::new("bash"), place.path(), &["-c", &script], &env).good();
}

macro_rules! pages {
    ($($test:ident: $page:literal $before:literal;)*) => {
        $(#[cfg(unix)] #[test] fn $test() { runs($page, $before); })*
        const RUN: &[&str] = &[$($page),*];
    };
}

pages! {
    the_way_in: "README.md" "";
    first_command: "first-command.md" "";
    sensors: "sensors.md" "";
    actuators: "actuators.md" "";
    parts: "parts.md" "";
    robots: "robots.md" "";
    importers: "importers.md" "";
    services: "services.md" "";
    script_languages: "script-languages.md" "";
    add_ons: "add-ons.md" "";
    checking: "checking.md" "tatu new plugin hello --lang c && cd hello && tatu plugin build";
    shipping: "shipping.md" "tatu new plugin hello --lang c && cd hello";
}

#[test]
fn every_page_with_commands_is_run() {
    // The tests in `testkit` run the examples of this page.
    let elsewhere = ["testing.md"];
    let mut pages: Vec<String> = fs::read_dir(root().join(BOOK))
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .filter(|page| page.ends_with(".md") && !elsewhere.contains(&page.as_str()))
        .collect();
    pages.sort();
    for page in pages {
        let has_commands = blocks(&page).iter().any(|(language, _)| language == "sh");
        assert_eq!(has_commands, RUN.contains(&page.as_str()), "{page}");
    }
}

/// Collapses white space, so that excerpts can have a different indentation.
fn collapsed(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Adds the texts of all files below a folder to `out`, with collapsed white space.
fn texts(folder: &Path, out: &mut Vec<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            texts(&path, out);
        } else if let Ok(text) = fs::read_to_string(&path) {
            out.push(collapsed(&text));
        }
    }
}

#[test]
fn all_code_is_that_of_plugins_which_are_tested() {
    let mut sources = Vec::new();
    for folder in ["plugin-api/template", "tests/outside", "tests/program/plugins"] {
        texts(&root().join(folder), &mut sources);
    }
    for page in RUN.iter().chain(&["commands.md", "exporters.md", "panes.md", "subcommands.md"]) {
        for (language, text) in blocks(page) {
            // Another test uses the example of tatu-check.toml.
            if !["c", "cpp", "rust", "lua", "toml"].contains(&language.as_str()) || text.contains("[[allow]]") {
                continue;
            }
            let wanted = collapsed(&text);
            assert!(sources.iter().any(|s| s.contains(&wanted)), "{page}: no template has this code:\n{text}");
        }
    }
}

#[cfg(unix)]
#[test]
fn findings_with_a_reason_are_allowed() {
    let place = TestFolder::new();
    let config = blocks("checking.md").into_iter().find(|(language, _)| language == "toml").unwrap().1;
    place.write("tatu-check.toml", &config);
    place.tatu(&["new", "plugin", "hello", "--lang", "c"]).good();
    place.tatu(&["plugin", "build", "hello"]).good();
    let checked = place.tatu(&["plugin", "check", "hello", "--json", "--config", "tatu-check.toml"]).good().json();
    let names: Vec<&str> = checked["tests"].as_array().unwrap().iter().map(|t| t["test"].as_str().unwrap()).collect();
    assert!(names.contains(&"arguments") && !names.contains(&"cost"), "{names:?}");
    place.write("tatu-check.toml", "[[allow]]\ntest = \"repeat\"\nplace = \"x\"\n");
    place.tatu(&["plugin", "check", "hello", "--config", "tatu-check.toml"]).refused(&["lacks `reason`"]);
}

#[cfg(unix)]
#[test]
fn the_check_finds_a_fault_and_names_it() {
    let place = TestFolder::new();
    place.tatu(&["new", "plugin", "hello", "--lang", "c"]).good();
    let source = place.read("hello/hello.c");
    let faulty = source.replace("return TATU_OK;\n}", "return TATU_ERR_MISSING;\n}");
    assert_ne!(source, faulty);
    place.write("hello/hello.c", &faulty);
    place.tatu(&["plugin", "build", "hello"]).good();
    let checked = place.tatu(&["plugin", "check", "hello", "--only", "arguments", "--json", "--github"]);
    assert_eq!(checked.code, 1, "{}", checked.out);
    assert!(checked.out.contains("command `hello.reset`") && checked.out.contains("::error title="), "{}", checked.out);
    place.tatu(&["plugin", "check", "hello", "--only", "argument"]).refused(&["did you mean `arguments`?"]);
}

/// A command that returns its version, and how often it was called in this world.
const COUNTER: &str = r#"#include "tatu/command.h"
static tatu_status TATU_CALL count(tatu_call *call) {
  tatu_value all[2] = {tatu_int(VERSION), tatu_int((int64_t)++*(uint64_t *)call->state)};
  return tatu_return_values(call, all, 2);
}
static const tatu_command it = {.size = sizeof(tatu_command), .names = TATU_NAME("hello.count"), .call = count,
  .returns = TATU_PARAMS(TATU_PARAM(TATU_I64, "version", NULL, "Version."), TATU_PARAM(TATU_I64, "calls", NULL, "Calls.")),
  .text = "Counts.", .example = "hello.count()"};
TATU_PLUGIN(TATU_COMMANDS_PER_WORLD(TATU_TABLE(tatu_life, .state_bytes = 8, .version = 1), &it),
  .id = "org.example.hello", .name = "Hello", .version = "1", .licence = "MIT");
"#;

#[cfg(unix)]
#[test]
fn a_watched_scene_continues_with_its_state_when_the_plugin_is_rebuilt() {
    let place = TestFolder::new();
    place.tatu(&["new", "plugin", "hello", "--lang", "c"]).good();
    place.write("hello/hello.c", &COUNTER.replace("VERSION", "1"));
    let script = "function sysCall_actuation() print(string.format('%d %d', hello.count())) end";
    place.write("hello/watch.toml", &format!("format = 1\n{}", watcher("w", script)));
    let output = fs::File::create(place.path().join("said")).unwrap();
    let began = std::time::Instant::now();
    let mut watch = std::process::Command::new(program())
        .args(["plugin", "watch", "hello"])
        .current_dir(place.path())
        .env("XDG_DATA_HOME", place.path().join(".data"))
        .stdout(output)
        .stderr(fs::File::create(place.path().join("told")).unwrap())
        .spawn()
        .unwrap();
    let limit = std::time::Duration::from_secs(120);
    let lines = || -> Vec<(u64, u64)> {
        let number = |text: &str| text.parse::<u64>().ok();
        let line = |l: &str| l.split_once(' ').and_then(|(v, n)| Some((number(v)?, number(n)?)));
        // The last line may be incomplete.
        place.read("said").split_inclusive('\n').filter(|l| l.ends_with('\n')).filter_map(|l| line(l.trim())).collect()
    };
    let counted = |version: u64, n: usize| lines().iter().filter(|l| l.0 == version).count().ge(&n).then_some(());
    wait_for("the first version", limit, || counted(1, 20));
    // A source that cannot be compiled has no effect.
    place.write("hello/hello.c", "int broken");
    wait_for("the failed build", limit, || place.read("told").contains("the build failed").then_some(()));
    place.write("hello/hello.c", &COUNTER.replace("VERSION", "2"));
    wait_for("the second version", limit, || counted(2, 20));
    watch.kill().unwrap();
    watch.wait().unwrap();
    let (all, told) = (lines(), place.read("told"));
    for (i, (version, calls)) in all.iter().enumerate() {
        assert_eq!(*calls, i as u64 + 1, "the count of version {version} starts over: {all:?}\n{told}");
    }
    let seconds = began.elapsed().as_secs_f64();
    assert!(all.len() as f64 * 0.05 <= seconds + 1.0, "{} steps in {seconds} s: not in real time", all.len());
    assert!(told.contains("note: reloaded the plugin org.example.hello"), "{told}");
}

#[cfg(unix)]
#[test]
fn a_scene_that_stops_while_it_is_watched_is_reported() {
    let place = TestFolder::new();
    place.tatu(&["new", "plugin", "hello", "--lang", "c"]).good();
    fs::remove_file(place.path().join("hello/watch.toml")).unwrap();
    let mut watch = std::process::Command::new(program())
        .args(["plugin", "watch", "hello"])
        .current_dir(place.path())
        .stdout(std::process::Stdio::null())
        .stderr(fs::File::create(place.path().join("told")).unwrap())
        .spawn()
        .unwrap();
    let told =
        "note: hello/scene.toml stopped the run: the next one starts anew; a scene watch.toml that does not stop";
    wait_for("the note", std::time::Duration::from_secs(120), || place.read("told").contains(told).then_some(()));
    watch.kill().unwrap();
    watch.wait().unwrap();
}

#[test]
fn the_page_lists_the_tests_as_the_program_does() {
    let page = fs::read_to_string(root().join(BOOK).join("checking.md")).unwrap();
    let place = TestFolder::new();
    let listed = place.tatu(&["plugin", "check", "--list"]).good().out;
    let rows: String = listed
        .lines()
        .map(|line| line.split_once(' ').unwrap())
        .fold(String::new(), |all, (name, text)| all + &format!("| `{name}` | {} |\n", text.trim()));
    assert!(page.contains(&format!("|---|---|\n{rows}\n")), "the page must contain:\n{rows}");
}
