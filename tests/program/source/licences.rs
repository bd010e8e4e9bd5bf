//! Tests that the licences of all dependencies are among those that `deny.toml` allows.

use std::{fs, process::Command};

use crate::kit::*;

/// Returns whether an expression such as `MIT OR Apache-2.0` has an alternative of which all parts are allowed.
fn is_allowed(expression: &str, allowed: &[String]) -> bool {
    let plain = expression.replace('/', " OR ").replace(['(', ')'], "");
    // In `(A OR B) AND C` with the parentheses removed, every part must be allowed on its own.
    if expression.contains('(') {
        return plain.split(" OR ").flat_map(|p| p.split(" AND ")).all(|p| allowed.iter().any(|a| a == p.trim()));
    }
    plain.split(" OR ").any(|one| one.split(" AND ").all(|p| allowed.iter().any(|a| a == p.trim())))
}

#[test]
fn every_dependency_has_an_allowed_licence() {
    let deny: toml_edit::DocumentMut = fs::read_to_string(root().join("deny.toml")).unwrap().parse().unwrap();
    let list = deny["licenses"]["allow"].as_array().unwrap();
    let allowed: Vec<String> = list.iter().map(|l| l.as_str().unwrap().to_owned()).collect();
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let host = format!("{}-unknown-linux-gnu", std::env::consts::ARCH);
    let args = ["metadata", "--format-version", "1", "--offline", "--locked", "--filter-platform", &host];
    let told = Command::new(cargo).args(args).current_dir(root()).output().unwrap();
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
    let metadata: serde_json::Value = serde_json::from_slice(&told.stdout).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    let of = |p: &serde_json::Value| p["license"].as_str().unwrap_or("no licence").to_owned();
    let wrong = packages.iter().filter(|p| !is_allowed(&of(p), &allowed));
    let wrong: Vec<String> = wrong.map(|p| format!("{}: {}", p["name"], of(p))).collect();
    assert!(packages.len() > 100 && wrong.is_empty(), "not in deny.toml:\n{}", wrong.join("\n"));
}

#[test]
fn expressions_are_read() {
    let allowed = ["MIT".to_owned(), "Apache-2.0 WITH LLVM-exception".to_owned()];
    for (expression, is) in [
        ("MIT", true),
        ("GPL-3.0 OR MIT", true),
        ("GPL-3.0/MIT", true),
        ("GPL-3.0 AND MIT", false),
        ("Apache-2.0 WITH LLVM-exception OR GPL-3.0", true),
        ("Apache-2.0", false),
        ("(MIT OR GPL-3.0) AND MIT", false),
    ] {
        assert_eq!(is_allowed(expression, &allowed), is, "{expression}");
    }
}
