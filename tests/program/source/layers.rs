//! Tests that the imports between the files of a crate have no cycles. Cycles between crates are refused by Cargo.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use super::imports::{FileImports, circles, imports};
use crate::kit::*;

/// Allowed cycles, each with its reason, and with three files at most.
const ALLOWED_CYCLES: [(&[&str], &str); 0] = [];
const MAX_CYCLE_FILES: usize = 3;

/// Returns the source folders of all crates that are not tests.
fn sources() -> Vec<PathBuf> {
    fn find(folder: &Path, out: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.join("Cargo.toml").is_file() && path.join("src").is_dir() {
                out.push(path.join("src"));
            } else if path.is_dir() && path.file_name().is_some_and(|n| n != "template" && n != "node_modules") {
                find(&path, out);
            }
        }
    }
    let mut out = vec![root().join("hosts/cli"), root().join("plugin-api/src")];
    for storey in ["engine", "core", "hosts"] {
        find(&root().join(storey), &mut out);
    }
    find(&root().join("plugins"), &mut out);
    out.sort();
    out
}

fn short(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string().replace('\\', "/")
}

/// Formats a cycle: for each file, the names that it imports from the others.
fn format_cycle(circle: &[PathBuf], all: &FileImports) -> String {
    let line = |file: &PathBuf| {
        let takes = all[file].iter().filter(|(to, _)| circle.contains(to));
        let takes: Vec<String> = takes.map(|(to, name)| format!("{} ({name})", short(to))).collect();
        format!("  {} imports {}", short(file), takes.join(", "))
    };
    circle.iter().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn files_of_a_crate_import_downward_only() {
    let mut wrong = Vec::new();
    for src in sources() {
        let all = imports(&src);
        for circle in circles(&all) {
            let names: Vec<String> = circle.iter().map(|f| short(f)).collect();
            let is_meant = ALLOWED_CYCLES.iter().any(|(files, _)| *files == names.as_slice());
            if !is_meant || circle.len() > MAX_CYCLE_FILES {
                wrong.push(format!("{} files:\n{}", circle.len(), format_cycle(&circle, &all)));
            }
        }
    }
    assert!(wrong.is_empty(), "cycles of imports:\n{}", wrong.join("\n"));
}

#[test]
fn imports_are_found_in_every_form() {
    let place = TestFolder::new();
    place.write(
        "src/lib.rs",
        "mod a;\npub mod b;\nmod c { pub struct Inside; }\npub use b::deep::Deep;\npub use c::Inside;\n",
    );
    place.write(
        "src/a.rs",
        "// use crate::b::Not;\nuse crate::{Deep, b::{self, Other}};\nfn f() { b::free(); \"crate::b::x\"; }\n",
    );
    place.write("src/b/mod.rs", "pub mod deep;\npub struct Other;\npub fn free() -> super::Inside { todo!() }\n");
    place.write(
        "src/b/deep.rs",
        "use super::*;\npub struct Deep(Other);\n#[cfg(test)]\nmod tests { use crate::a::f; }\n",
    );
    let src = place.path().join("src");
    let found: BTreeMap<String, Vec<String>> = imports(&src)
        .iter()
        .map(|(from, to)| (from, to.keys().map(|f| name_in(&src, f)).collect()))
        .map(|(from, to)| (name_in(&src, from), to))
        .collect();
    let expected =
        [("a.rs", vec!["b/deep.rs", "b/mod.rs"]), ("b/deep.rs", vec!["b/mod.rs"]), ("b/mod.rs", vec!["lib.rs"])];
    let expected = expected.map(|(from, to)| (from.to_owned(), to.into_iter().map(str::to_owned).collect()));
    assert_eq!(found, BTreeMap::from(expected));
}

fn name_in(src: &Path, file: &Path) -> String {
    file.strip_prefix(src).unwrap().display().to_string().replace('\\', "/")
}

#[test]
fn a_cycle_of_imports_is_found() {
    let pair = |from: &str, to: &str| (PathBuf::from(from), BTreeMap::from([(PathBuf::from(to), String::new())]));
    assert!(circles(&FileImports::from([pair("a", "b"), pair("b", "c")])).is_empty());
    let closed = circles(&FileImports::from([pair("a", "b"), pair("b", "c"), pair("c", "b")]));
    assert_eq!(closed, [[PathBuf::from("b"), PathBuf::from("c")]]);
}

/// The storeys of the workspace: for each, the folders of the packages on which its packages may depend.
const STOREYS: [(&str, &[&str]); 3] = [
    ("engine/", &["engine/"]),
    ("core/", &["engine/", "core/", "plugin-api"]),
    ("plugins/", &["engine/", "core/", "plugin-api", "plugins/"]),
];

#[test]
fn packages_depend_on_their_storey_and_those_below() {
    let read = |file: PathBuf| fs::read_to_string(file).unwrap();
    let folder_in = |line: &str| Some(line.split_once("path = \"")?.1.split('"').next()?.to_owned());
    let name_in = |line: &str| Some(line.split([' ', '.']).next()?.to_owned());
    let manifest = read(root().join("Cargo.toml"));
    let folders: BTreeMap<String, String> =
        manifest.lines().filter_map(|l| Some((name_in(l)?, folder_in(l)?))).collect();
    let mut checked = 0;
    for src in sources() {
        let package = src.parent().unwrap();
        let Some((_, below)) = STOREYS.iter().find(|(storey, _)| short(package).starts_with(storey)) else { continue };
        for line in read(package.join("Cargo.toml")).lines() {
            let by_path = folder_in(line).map(|path| short(&package.join(path).canonicalize().unwrap()));
            let Some(to) = by_path.or_else(|| folders.get(&name_in(line)?).cloned()) else { continue };
            assert!(below.iter().any(|b| to.starts_with(b)), "{} depends on {to}, which is above it", short(package));
            checked += 1;
        }
    }
    assert!(checked > 50, "only {checked} dependencies were found");
}

/// Returns the modules listed in the doc comment at the top of a file: the names in backticks before an entry's colon.
fn listed(head: &str) -> Vec<String> {
    let items = head.split("\n- ").skip(1).map(|item| item.split("\n\n").next().unwrap_or(item));
    let parts = items.flat_map(|item| item.split(';')).filter_map(|part| part.split_once(':').map(|(names, _)| names));
    let names = parts.flat_map(|names| names.split([',', ' ', '\n']));
    let quoted = names.filter_map(|n| n.strip_prefix('`')?.strip_suffix('`'));
    quoted
        .filter(|n| n.chars().all(|c| c.is_ascii_lowercase() || c == '_' || c.is_ascii_digit()))
        .map(str::to_owned)
        .collect()
}

#[test]
fn documented_modules_exist() {
    let mut wrong = Vec::new();
    for file in sources().iter().flat_map(|src| super::tree::files(src)) {
        let Ok(text) = fs::read_to_string(&file) else { continue };
        let head: Vec<&str> =
            text.lines().map_while(|l| l.strip_prefix("//!")).map(|l| l.strip_prefix(' ').unwrap_or(l)).collect();
        let declared: Vec<&str> = text.lines().filter_map(|l| l.split_once("mod ")?.1.strip_suffix(';')).collect();
        if declared.is_empty() {
            continue;
        }
        let gone = listed(&head.join("\n")).into_iter().filter(|name| !declared.contains(&name.as_str()));
        wrong.extend(gone.map(|name| format!("{} lists `{name}`", short(&file))));
    }
    assert!(wrong.is_empty(), "documented modules that do not exist:\n{}", wrong.join("\n"));
}
