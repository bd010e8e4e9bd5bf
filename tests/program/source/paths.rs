//! A test that the files which the documents name exist.

use std::{fs, path::Path};

use regex::Regex;

use super::tree::files;
use crate::kit::*;

/// Decisions and release notes describe the state at the time of writing, and the pages of commands are generated.
const HISTORY: [&str; 3] = ["docs/decisions/", "docs/releases/", "docs/reference/commands"];
/// Files of the examples in the guides.
const EXAMPLES: [&str; 1] = ["tests/scene.rs"];

#[test]
fn files_that_the_documents_name_exist() {
    let short = |file: &Path| file.strip_prefix(root()).unwrap_or(file).to_string_lossy().replace('\\', "/");
    let all: Vec<String> = files(root()).iter().map(|file| short(file)).collect();
    let named = Regex::new(r"`([\w./-]+/[\w.-]+\.(?:rs|h|lua|py))`").unwrap();
    let is_checked = |page: &&String| {
        let top = ["CONTRIBUTING.md", "ARCHITECTURE.md", "README.md"].contains(&page.as_str());
        let is_guide = page.starts_with("docs/") && !HISTORY.iter().any(|folder| page.starts_with(folder));
        page.ends_with(".md") && (top || is_guide)
    };
    let mut missing = Vec::new();
    for page in all.iter().filter(is_checked) {
        let text = fs::read_to_string(root().join(page)).unwrap();
        for (i, line) in text.lines().enumerate() {
            for path in named.captures_iter(line).map(|c| c[1].to_owned()) {
                let ending = format!("/{path}");
                let beside = root().join(page).parent().unwrap_or(Path::new("")).join(&path);
                let exists = all.iter().any(|file| *file == path || file.ends_with(&ending)) || beside.exists();
                if !exists && !EXAMPLES.contains(&path.as_str()) {
                    missing.push(format!("{page}:{}: {path}", i + 1));
                }
            }
        }
    }
    assert!(missing.is_empty(), "these files were moved or removed: {missing:#?}");
}
