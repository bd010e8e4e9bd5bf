//! Prints the results of a check as text, as JSON, and as annotations for GitHub workflows.

use std::path::Path;

use serde::Serialize;
use serde_json::json;

use super::finding::{Finding, FindingLevel};
use tatu_terminal::report::out;

/// The result of a test.
#[derive(Debug, Serialize)]
pub struct TestOutcome {
    pub test: &'static str,
    pub text: &'static str,
    /// Whether the plugin provides anything that the test applies to.
    pub tried: bool,
    pub seconds: f64,
    pub findings: Vec<Finding>,
}

impl TestOutcome {
    fn count(&self, level: FindingLevel) -> usize {
        self.findings.iter().filter(|f| f.level == level).count()
    }
    fn verdict(&self) -> &'static str {
        match (self.count(FindingLevel::Error), self.count(FindingLevel::Warning)) {
            (0, 0) if !self.tried => "none",
            (0, 0) => "pass",
            (0, _) => "warn",
            _ => "FAIL",
        }
    }
}

/// Prints the result of a test with its findings.
pub fn print(outcome: &TestOutcome) {
    out!("{}  {:<14}{}", outcome.verdict(), outcome.test, outcome.text);
    for f in &outcome.findings {
        let level = match f.level {
            FindingLevel::Error => "error",
            FindingLevel::Warning => "warning",
            FindingLevel::Note => "note",
        };
        match f.place.as_str() {
            "" => out!("        {level}: {}", f.text),
            place => out!("        {level}: {place}: {}", f.text),
        }
    }
}

/// Prints a summary line with the number of tests that passed.
pub fn sum_up(library: &Path, outcomes: &[TestOutcome]) {
    let failed = outcomes.iter().filter(|o| o.count(FindingLevel::Error) > 0).count();
    let warned: usize = outcomes.iter().map(|o| o.count(FindingLevel::Warning)).sum();
    let warned = match warned {
        0 => String::new(),
        n => format!(", {n} warning{}", if n == 1 { "" } else { "s" }),
    };
    let tried = outcomes.iter().filter(|o| o.tried).count();
    let idle = match outcomes.len() - tried {
        0 => String::new(),
        n => format!("; {n} tests were not applicable"),
    };
    out!("{}: {} of {tried} tests passed{warned}{idle}", library.display(), tried - failed);
}

/// Prints all results as one JSON object.
pub fn print_json(library: &Path, outcomes: &[TestOutcome]) {
    let passed = outcomes.iter().all(|o| o.count(FindingLevel::Error) == 0);
    out!("{}", json!({ "plugin": library.display().to_string(), "passed": passed, "tests": outcomes }));
}

/// Prints errors and warnings as GitHub workflow commands.
pub fn annotate(library: &Path, outcomes: &[TestOutcome]) {
    let escaped = |text: &str| text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A");
    for (o, f) in outcomes.iter().flat_map(|o| o.findings.iter().map(move |f| (o, f))) {
        let level = match f.level {
            FindingLevel::Error => "error",
            FindingLevel::Warning => "warning",
            FindingLevel::Note => continue,
        };
        let place = if f.place.is_empty() { String::new() } else { format!("{}: ", f.place) };
        let text = escaped(&format!("{place}{}", f.text));
        out!("::{level} title=tatu plugin check {}: {}::{text}", library.display(), o.test);
    }
}
