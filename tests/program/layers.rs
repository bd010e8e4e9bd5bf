//! The core's layers: no circle of imports across the folders of a crate. (Cargo itself allows none across crates.)

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

use crate::kit::*;

/// Which folder imports which, and from which file.
type Imports = BTreeMap<(String, String), PathBuf>;

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut out = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            out.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
    out.sort();
    out
}

/// The first names behind each `crate::` (or as many `super::` as lead to the crate's root), also of groups in braces.
fn names_at_root(text: &str, depth: usize) -> BTreeSet<String> {
    let code: String = text.lines().map(|l| l.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n");
    let climb = "super::".repeat(depth);
    let mut out = BTreeSet::new();
    for root in ["crate::", climb.as_str()] {
        for (at, _) in code.match_indices(root) {
            let before = code[..at].chars().next_back();
            if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
                continue;
            }
            let rest = &code[at + root.len()..];
            match rest.strip_prefix('{') {
                Some(group) => out.extend(first_names(group)),
                None => out.extend(name(rest)),
            }
        }
    }
    out
}

fn name(text: &str) -> Option<String> {
    let word: String = text.trim_start().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    (!word.is_empty()).then_some(word)
}

/// The first name of each entry of a group whose opening brace has been read.
fn first_names(group: &str) -> Vec<String> {
    let (mut out, mut level, mut start) = (Vec::new(), 0, 0);
    for (at, c) in group.char_indices() {
        match c {
            '{' => level += 1,
            ',' if level == 0 => {
                out.extend(name(&group[start..at]));
                start = at + 1;
            }
            '}' if level == 0 => {
                out.extend(name(&group[start..at]));
                break;
            }
            '}' => level -= 1,
            _ => {}
        }
    }
    out
}

/// What the folders of a crate import of each other.
fn imports(src: &Path) -> Imports {
    let mut out = Imports::new();
    let folders: BTreeSet<String> = fs::read_dir(src)
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.is_dir())
        .map(|p| p.file_name().unwrap().to_string_lossy().into_owned())
        .collect();
    for file in sources(src) {
        let inside: Vec<String> =
            file.strip_prefix(src).unwrap().iter().map(|p| p.to_string_lossy().into_owned()).collect();
        let Some(own) = inside.first().filter(|f| folders.contains(*f)) else { continue };
        let is_folder_file = inside.last().is_some_and(|f| f == "mod.rs");
        let depth = inside.len() - usize::from(is_folder_file);
        for name in names_at_root(&fs::read_to_string(&file).unwrap(), depth) {
            if name != *own && folders.contains(&name) {
                out.entry((own.clone(), name)).or_insert(file.clone());
            }
        }
    }
    out
}

/// A circle among imports: the folders along it, the first one again at the end.
fn circle(imports: &Imports) -> Option<Vec<String>> {
    fn walk(at: &str, imports: &Imports, path: &mut Vec<String>, done: &mut BTreeSet<String>) -> bool {
        if let Some(start) = path.iter().position(|p| p == at) {
            path.drain(..start);
            path.push(at.to_owned());
            return true;
        }
        if !done.insert(at.to_owned()) {
            return false;
        }
        path.push(at.to_owned());
        let next: Vec<&String> = imports.keys().filter(|(from, _)| from == at).map(|(_, to)| to).collect();
        if next.into_iter().any(|to| walk(to, imports, path, done)) {
            return true;
        }
        path.pop();
        false
    }
    let mut done = BTreeSet::new();
    imports.keys().find_map(|(from, _)| {
        let mut path = Vec::new();
        walk(from, imports, &mut path, &mut done).then_some(path)
    })
}

#[test]
fn imports_are_found_wherever_they_stand() {
    let text = "use crate::{a::{x, y}, b,\n  c::d};\n// crate::comment\nfn f() { crate::e::g(); super::super::h::i() }";
    let found: Vec<String> = names_at_root(text, 2).into_iter().collect();
    assert_eq!(found, ["a", "b", "c", "e", "h"]);
}

#[test]
fn a_circle_is_found() {
    let pair = |a: &str, b: &str| ((a.to_owned(), b.to_owned()), PathBuf::new());
    let open = Imports::from([pair("a", "b"), pair("b", "c"), pair("a", "c")]);
    assert_eq!(circle(&open), None);
    let closed = Imports::from([pair("a", "b"), pair("b", "c"), pair("c", "b")]);
    assert_eq!(circle(&closed).unwrap().len(), 3);
}

#[test]
fn folders_of_the_core_import_downward_only() {
    for folder in crates() {
        let src = folder.join("src");
        let imports = imports(&src);
        if let Some(path) = circle(&imports) {
            let steps = path.windows(2).map(|w| {
                let file = &imports[&(w[0].clone(), w[1].clone())];
                format!("{} imports {} in {}", w[0], w[1], file.strip_prefix(root()).unwrap().display())
            });
            panic!("a circle of imports:\n{}", steps.collect::<Vec<_>>().join("\n"));
        }
    }
}

/// The folders of the core's crates.
fn crates() -> Vec<PathBuf> {
    let all = fs::read_dir(root().join("core")).unwrap().map(|e| e.unwrap().path());
    all.filter(|p| p.join("Cargo.toml").is_file()).collect()
}

#[test]
fn nothing_in_the_core_imports_pictures() {
    for folder in crates() {
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
        let uses = manifest.lines().any(|l| l.starts_with("tatu-render"));
        assert!(!uses, "{} depends on tatu-render, which stands on top of the core", folder.display());
    }
}
