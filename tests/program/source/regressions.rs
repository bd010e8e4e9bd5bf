//! Tests of the list of regressions, `tests/regressions.md`.

use std::fs;

use regex::Regex;

use super::tree::files;
use crate::kit::*;

#[test]
fn tests_of_reported_faults_exist() {
    let list = fs::read_to_string(root().join("tests/regressions.md")).unwrap();
    let rows = list.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| report "));
    let name = Regex::new(r"`([a-z0-9]+(?:_[a-z0-9]+){2,})`").unwrap();
    let sources: String = files(root())
        .into_iter()
        .filter(|path| path.extension().is_some_and(|e| e == "rs"))
        .map(|path| fs::read_to_string(path).unwrap())
        .collect();
    let mut missing = Vec::new();
    for row in rows {
        let tests: Vec<_> =
            name.captures_iter(row.rsplit('|').nth(1).unwrap_or_default()).map(|c| c[1].to_owned()).collect();
        assert!(!tests.is_empty(), "this report has no test: {row}");
        missing.extend(tests.into_iter().filter(|test| !sources.contains(&format!("fn {test}()"))));
    }
    assert!(missing.is_empty(), "tests/regressions.md names tests that do not exist: {missing:#?}");
}
