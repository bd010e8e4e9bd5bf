//! Tests of the manifests: if a package is built alone, cargo reuses the shared crates that were built for the whole
//! workspace.

use std::{
    collections::{BTreeMap, BTreeSet},
    process::Command,
};

use crate::kit::*;

/// Plugins as third parties write them, and the crate that they depend on, which are built without the check of
/// layouts.
const EXTERNAL_PACKAGES: [&str; 6] =
    ["tatu-plugin-api", "tatu-compass", "tatu-knock", "tatu-tally", "tatu-template-rust-sensor", "tatu-winch"];

/// The sets of features with which cargo builds each package; macros and libraries may have different ones.
type BuildFeatures = BTreeMap<String, BTreeSet<String>>;

/// Returns what cargo builds for a selection of packages.
fn built(selection: &[&str]) -> BuildFeatures {
    let arguments = ["tree", "--offline", "--prefix", "none", "--format", "{p}|{f}"];
    let out = Command::new(env!("CARGO")).args(arguments).args(selection).current_dir(root()).output().unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let mut all = BuildFeatures::new();
    for line in String::from_utf8(out.stdout).unwrap().lines() {
        if let Some((package, features)) = line.trim_end_matches(" (*)").split_once('|') {
            all.entry(package.to_owned()).or_default().insert(features.to_owned());
        }
    }
    all
}

/// Returns the crates that cargo rebuilds for a single package, each with the name of that package. `edges` selects the
/// dependencies.
fn rebuilt(names: &[String], edges_of_all: &str, edges: &str) -> BTreeMap<String, String> {
    let whole = built(&["--workspace", "--edges", edges_of_all]);
    let mut found = BTreeMap::new();
    for name in names {
        for (package, features) in built(&["--package", name, "--edges", edges]) {
            for own in features.difference(&whole[&package]) {
                let text = format!("{package} with the features `{own}`; in the workspace, {:?}", whole[&package]);
                found.entry(text).or_insert(name.clone());
            }
        }
    }
    found
}

#[test]
fn packages_built_alone_share_the_artifacts_of_the_workspace() {
    let members = built(&["--workspace", "--edges", "normal", "--depth", "0"]);
    let names =
        members.keys().filter_map(|package| package.split(' ').next()).filter(|name| !EXTERNAL_PACKAGES.contains(name));
    let names: Vec<String> = names.map(str::to_owned).collect();
    // Libraries are checked separately, because macros may use the same crate with other features.
    let mut found = rebuilt(&names, "normal,dev,no-proc-macro", "normal,no-proc-macro");
    found.extend(rebuilt(&names, "normal,build,dev", "normal,build"));
    assert!(
        found.is_empty(),
        "cargo rebuilds these crates for a single package; name their features in the root manifest (direct dependencies) or \
         in engine/features/Cargo.toml:\n{}",
        found.iter().map(|(text, name)| format!("-p {name}: {text}")).collect::<Vec<_>>().join("\n")
    );
}
