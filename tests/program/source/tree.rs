//! Tests of the source tree: the core names no plugin, every plugin is in the manifest, files are short and portable.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::kit::*;

/// Words that must not occur in the core: kinds of sensors, robots, script languages, and the script API of V-REP.
/// V-REP itself may be named as the source of a convention or value.
#[rustfmt::skip]
const FORBIDDEN_WORDS: [&str; 28] = [
    "sonar", "ultrasonic", "proximity", "laser", "lidar", "gps", "hokuyo", "kinect", "gyro",
    "thruster", "manta", "vrep",
    "pioneer", "p3dx", "e-puck", "epuck", "kuka", "turtlebot", "robotino", "braitenberg",
    "lua", "python", "javascript",
    "sysCall", "sim_call_type", "simGet", "simSet", "simRead",
];

/// Returns the files below a folder, except those that cargo and git create.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let mut out = Vec::new();
    let mut entries: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        // Files that a build copies into the Python package are not sources.
        let is_gathered =
            ["plugins", "scenes", "models", "addons", "_commands.pyi", "THIRD-PARTY.txt"].contains(&name.as_str());
        if is_gathered && folder.ends_with("hosts/python/tatu_sim") {
            continue;
        }
        // `.git` is a file in a linked working tree.
        if path.is_dir() || name == ".git" {
            if !["target", ".git", "node_modules", "corpus", "found"].contains(&name.as_str()) {
                out.extend(files(&path));
            }
        } else if !["Cargo.lock", "package-lock.json"].contains(&name.as_str()) {
            out.push(path);
        }
    }
    out
}

fn short(path: &Path) -> String {
    path.strip_prefix(root()).unwrap().display().to_string()
}

fn is_letter(c: Option<char>) -> bool {
    c.is_some_and(|c| c.is_ascii_alphabetic())
}

/// Returns whether a line contains a word: `lua` occurs in `lua_state` and `.lua`, but not in `evaluate`.
fn has_word(line: &str, word: &str) -> bool {
    let line = line.to_lowercase();
    line.match_indices(&word.to_lowercase()).any(|(at, w)| {
        let (before, behind) = (line[..at].chars().next_back(), line[at + w.len()..].chars().next());
        // `sim` and `sysCall` are prefixes of function names, so any characters may follow.
        !is_letter(before) && (word.starts_with("sim") || word == "sysCall" || !is_letter(behind))
    })
}

#[test]
fn words_are_matched_at_identifier_boundaries() {
    assert!(has_word("a `lua_State`", "lua") && has_word("x.lua", "lua") && has_word("SimGetObject", "simGet"));
    assert!(!has_word("let evaluated", "lua") && !has_word("sonarity", "sonar"));
}

#[test]
fn the_core_names_no_sensor_robot_language_or_script_function() {
    let mut found = Vec::new();
    let all = ["engine", "core"].iter().flat_map(|storey| files(&root().join(storey)));
    for file in all.filter(|f| f.extension().is_some_and(|e| e == "rs")) {
        for (i, line) in fs::read_to_string(&file).unwrap().lines().enumerate() {
            // The only exception is the path of an example scene in a doc comment.
            let line = if line.trim_start().starts_with("//") { without_scene_paths(line) } else { line.to_owned() };
            for word in FORBIDDEN_WORDS.iter().filter(|w| has_word(&line, w)) {
                found.push(format!("{}:{}: `{word}` in: {}", short(&file), i + 1, line.trim()));
            }
        }
    }
    assert!(found.is_empty(), "the core must not contain these names:\n{}", found.join("\n"));
}

fn without_scene_paths(line: &str) -> String {
    line.split(['"', '`', ' ', '(', ')']).filter(|w| !w.starts_with("scenes/first/")).collect::<Vec<_>>().join(" ")
}

#[test]
fn every_plugin_is_in_the_manifest() {
    let manifest = fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let mut missing = Vec::new();
    for kind in folders(&root().join("plugins")) {
        for plugin in folders(&kind).into_iter().filter(|p| p.join("Cargo.toml").exists()) {
            let text = fs::read_to_string(plugin.join("Cargo.toml")).unwrap();
            // Crates shared by several plugins are not plugins.
            if !text.contains("cdylib") {
                continue;
            }
            let name = text.lines().find_map(|l| l.strip_prefix("name = ")).unwrap().trim_matches('"');
            let line = format!("{name} = {{ path = \"{}\" }}", short(&plugin));
            if !manifest.lines().any(|l| l == line) {
                missing.push(line);
            }
        }
    }
    assert!(missing.is_empty(), "add these to [dependencies] in the root Cargo.toml:\n{}", missing.join("\n"));
}

fn folders(of: &Path) -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = fs::read_dir(of).unwrap().map(|e| e.unwrap().path()).filter(|p| p.is_dir()).collect();
    all.sort();
    all
}

#[test]
fn every_plugin_says_what_it_is() {
    for kind in folders(&root().join("plugins")) {
        for plugin in folders(&kind) {
            assert!(plugin.join("README.md").exists(), "{} has no README.md", short(&plugin));
        }
    }
}

#[test]
fn the_architecture_page_names_every_top_folder() {
    let page = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    for folder in folders(root()) {
        let name = folder.file_name().unwrap().to_string_lossy().into_owned();
        if name != "target" && !name.starts_with('.') {
            assert!(page.contains(&format!("{name}/")), "ARCHITECTURE.md does not describe {name}/");
        }
    }
}

#[test]
fn no_file_exceeds_the_line_limit() {
    // Files must be short enough to read in one go, except for the C header, which is the manual, and meshes.
    for file in files(root()) {
        let name = short(&file).replace('\\', "/");
        let Ok(text) = fs::read_to_string(&file) else { continue };
        // Each frozen copy of the C header is also a single file.
        if !name.ends_with("/tatu.h") && !name.ends_with(".ply") {
            assert!(text.lines().count() <= 700, "{name} has {} lines; split it", text.lines().count());
        }
    }
}

#[test]
fn no_file_contains_an_absolute_path_of_a_machine() {
    // The paths are written in two halves so that this file does not contain them.
    let places = [("/wo", "rk/"), ("/ho", "me/"), ("/Us", "ers/"), ("/tm", "p/"), ("/ro", "ot/"), ("C:", "\\\\")]
        .map(|(a, b)| format!("{a}{b}"));
    for file in files(root()) {
        let Ok(text) = fs::read_to_string(&file) else { continue };
        for (i, line) in text.lines().enumerate() {
            for place in places.iter().filter(|p| line.contains(p.as_str())) {
                // Part of a longer path is not a path on this machine.
                let at = line.find(place.as_str()).unwrap();
                let before = line[..at].chars().next_back();
                assert!(before.is_some_and(|c| c.is_alphanumeric() || c == '.'), "{}:{}: {line}", short(&file), i + 1);
            }
        }
    }
}

#[test]
fn abi_stable_stays_in_one_file() {
    // See docs/decisions: abi_stable checks the layouts of the frozen types, and of no others.
    let uses = |f: &PathBuf| {
        f.extension().is_some_and(|e| e == "rs") && fs::read_to_string(f).unwrap().contains("abi_stable::")
    };
    let found: Vec<String> =
        files(root()).iter().filter(|f| uses(f)).map(|f| short(f)).filter(|f| !f.starts_with("tests")).collect();
    assert_eq!(found, ["plugin-api/src/abi/frozen.rs"]);
}

#[test]
fn every_dependency_has_its_reason() {
    // Each dependency needs a comment above it, except crates of this repository.
    let text = fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let table = text.split("[workspace.dependencies]").nth(1).unwrap().split("\n[").next().unwrap();
    let mut has_reason = false;
    for line in table.lines().filter(|l| !l.trim().is_empty()) {
        let is_reason = line.starts_with('#');
        assert!(is_reason || has_reason || line.contains("path ="), "no comment with a reason above: {line}");
        has_reason = is_reason;
    }
}

/// The files that may read what the user or the program has chosen, past the check of names in documents. A path that
/// comes from a document must not get there.
const UNRESTRICTED_READERS: [&str; 7] = [
    "hosts/cli/addons/find.rs",
    "hosts/cli/addons/start.rs",
    "core/scene/src/document/overrides.rs",
    "core/scene/src/document/reach.rs",
    "core/scene/src/document/sources.rs",
    "core/scene/src/document/toml/mod.rs",
    "core/world/src/state/source.rs",
];

#[test]
fn readers_of_documents_use_only_allowed_paths() {
    let mut found = Vec::new();
    for file in ["hosts", "core"].iter().flat_map(|folder| files(&root().join(folder))) {
        let Ok(text) = fs::read_to_string(&file) else { continue };
        if text.contains("AllowedFile::chosen(") || file.ends_with("document/reach.rs") {
            found.push(short(&file));
        }
        let reads = ["fs::read(", "fs::read_to_string(", "File::open(", "read_plain(", "read_plain_text("];
        // `packages.rs` reads only manifests, whose name is fixed.
        let may_read = ["reach.rs", "packages.rs"].iter().any(|name| file.ends_with(name));
        let is_document = short(&file).starts_with("core/scene/src/document/") && !may_read;
        assert!(!is_document || !reads.iter().any(|r| text.contains(r)), "{} reads files itself", short(&file));
    }
    assert_eq!(found, UNRESTRICTED_READERS);
}
