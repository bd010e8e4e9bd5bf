//! What came of tests: a line each, and a summary.

use serde::Serialize;

use crate::report;

/// Why a test failed.
#[derive(Debug, Clone, Serialize)]
pub struct Failure {
    /// The file of the test; empty: none is known.
    pub file: String,
    /// Line in it, from 1; 0: none is known.
    pub line: u32,
    /// The sentence.
    pub text: String,
}

impl Failure {
    /// One that has no place.
    pub fn new(text: impl Into<String>) -> Self {
        Failure { file: String::new(), line: 0, text: text.into() }
    }
}

/// What came of one test.
#[derive(Debug, Serialize)]
struct Outcome {
    /// The file that it stands in, from the plugin's folder.
    file: String,
    name: String,
    passed: bool,
    failures: Vec<Failure>,
    /// What it printed.
    output: String,
}

/// What came of all of them.
pub struct Outcomes {
    all: Vec<Outcome>,
    only: Option<String>,
    /// Whether each is printed as it ends.
    tells: bool,
}

/// Lines that a failed test has printed, at most; the last ones are shown.
const MOST_LINES: usize = 40;

impl Outcomes {
    /// None yet.
    pub fn new(only: Option<String>, tells: bool) -> Self {
        Outcomes { all: Vec::new(), only, tells }
    }

    /// Whether a test is to be run.
    pub fn wants(&self, name: &str) -> bool {
        self.only.as_ref().is_none_or(|only| name.contains(only.as_str()))
    }

    /// Adds a test; without failures it has passed.
    pub fn add(&mut self, file: &str, name: &str, failures: Vec<Failure>, output: &str) {
        let passed = failures.is_empty();
        if self.tells {
            report::out!("{}  {file}  {name}", if passed { "ok  " } else { "FAIL" });
            failures.iter().for_each(tell);
            if !passed {
                shown(output);
            }
        }
        self.all.push(Outcome { file: file.into(), name: name.into(), passed, failures, output: output.into() });
    }

    /// How many have failed.
    pub fn failed(&self) -> usize {
        self.all.iter().filter(|o| !o.passed).count()
    }

    /// Whether none was run.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// The last line, or all as JSON.
    pub fn summary(&self, json: bool) {
        let (failed, all) = (self.failed(), self.all.len());
        if json {
            let out = serde_json::json!({ "passed": all - failed, "failed": failed, "tests": self.all });
            return report::out!("{}", serde_json::to_string_pretty(&out).unwrap_or_default());
        }
        report::out!("{} passed, {failed} failed", all - failed);
    }
}

fn tell(failure: &Failure) {
    let place = match (failure.file.as_str(), failure.line) {
        ("", _) => String::new(),
        (file, 0) => format!("{file}: "),
        (file, line) => format!("{file}:{line}: "),
    };
    for (i, line) in failure.text.lines().enumerate() {
        report::out!("      {}{line}", if i == 0 { place.as_str() } else { "" });
    }
}

fn shown(output: &str) {
    let lines: Vec<&str> = output.lines().collect();
    let first = lines.len().saturating_sub(MOST_LINES);
    if first > 0 {
        report::out!("      | ({first} lines before)");
    }
    lines[first..].iter().for_each(|line| report::out!("      | {line}"));
}
