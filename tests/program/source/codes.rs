//! Tests of error codes: each one is described on exactly one page, and no page describes one that does not exist.

use std::{collections::BTreeMap, fs};

use regex::Regex;

use super::tree::files;
use crate::kit::*;

/// Returns the codes that a pattern finds below some folders, each with the files in which it occurs.
fn codes(folders: &[&str], extension: &str, pattern: &str) -> BTreeMap<String, Vec<String>> {
    let pattern = Regex::new(pattern).unwrap();
    let mut codes = BTreeMap::<String, Vec<String>>::new();
    for path in folders.iter().flat_map(|f| files(&root().join(f))) {
        if path.extension().is_some_and(|e| e == extension) {
            let name = path.strip_prefix(root()).unwrap().display().to_string();
            for found in pattern.captures_iter(&fs::read_to_string(&path).unwrap()) {
                codes.entry(found[1].to_owned()).or_default().push(name.clone());
            }
        }
    }
    codes
}

#[test]
fn every_error_code_is_described_on_one_page() {
    let raised = codes(&["engine", "core", "hosts", "plugins", "plugin-api/src"], "rs", r#""([EF][0-9]{3})""#);
    // Codes are in headings, or in bold at the beginning of a paragraph.
    let described = codes(&["docs"], "md", r"(?m)^(?:#+ |\*\*)([EF][0-9]{3}): ");
    let missing: Vec<_> = raised.iter().filter(|(code, _)| !described.contains_key(*code)).collect();
    assert!(missing.is_empty(), "describe these codes in docs/reference/errors.md: {missing:#?}");
    let unused: Vec<_> = described.iter().filter(|(code, _)| !raised.contains_key(*code)).collect();
    assert!(unused.is_empty(), "nothing raises these codes: {unused:#?}");
    let repeated: Vec<_> = described.iter().filter(|(_, pages)| pages.len() > 1).collect();
    assert!(repeated.is_empty(), "describe each of these codes in one place: {repeated:#?}");
}
