//! Results of tests: prints a line for each, and a summary.

use serde::Serialize;
use tatu_terminal::report;

/// A reason for the failure of a test.
#[derive(Debug, Clone, Serialize)]
pub struct Failure {
    /// The file in which the failure occurred; empty if it is unknown.
    pub file: String,
    /// Line in the file, counted from 1; 0 if it is unknown.
    pub line: u32,
    /// Description of the failure, as shown to the user.
    pub text: String,
}

impl Failure {
    /// Creates a failure without a file and a line.
    pub fn new(text: impl Into<String>) -> Self {
        Failure { file: String::new(), line: 0, text: text.into() }
    }
}

/// The result of one test.
#[derive(Debug, Serialize)]
struct TestResult {
    /// The file of the test, relative to the plugin's folder.
    file: String,
    name: String,
    passed: bool,
    failures: Vec<Failure>,
    /// The output of the test.
    output: String,
}

/// The results of all tests.
pub struct TestResults {
    all: Vec<TestResult>,
    only: Option<String>,
    /// Whether each result is printed as soon as it is known.
    prints: bool,
}

/// Maximum number of output lines shown for a failed test. The last lines are shown.
const MAX_LINES: usize = 40;

impl TestResults {
    /// Creates an empty list of results.
    pub fn new(only: Option<String>, prints: bool) -> Self {
        TestResults { all: Vec::new(), only, prints }
    }

    /// Returns whether a test is selected by its name.
    pub fn wants(&self, name: &str) -> bool {
        self.only.as_ref().is_none_or(|only| name.contains(only.as_str()))
    }

    /// Adds the result of a test, which has passed if there are no failures.
    pub fn add(&mut self, file: &str, name: &str, failures: Vec<Failure>, output: &str) {
        let passed = failures.is_empty();
        if self.prints {
            report::out!("{}  {file}  {name}", if passed { "ok  " } else { "FAIL" });
            failures.iter().for_each(print_failure);
            if !passed {
                print_output(output);
            }
        }
        self.all.push(TestResult { file: file.into(), name: name.into(), passed, failures, output: output.into() });
    }

    /// Returns the number of failed tests.
    pub fn failed(&self) -> usize {
        self.all.iter().filter(|o| !o.passed).count()
    }

    /// Returns whether no test was run.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Prints a summary line, or all results as JSON.
    pub fn summary(&self, json: bool) {
        let (failed, all) = (self.failed(), self.all.len());
        if json {
            let out = serde_json::json!({ "passed": all - failed, "failed": failed, "tests": self.all });
            return report::out!("{}", serde_json::to_string_pretty(&out).unwrap_or_default());
        }
        report::out!("{} passed, {failed} failed", all - failed);
    }
}

fn print_failure(failure: &Failure) {
    let place = match (failure.file.as_str(), failure.line) {
        ("", _) => String::new(),
        (file, 0) => format!("{file}: "),
        (file, line) => format!("{file}:{line}: "),
    };
    for (i, line) in failure.text.lines().enumerate() {
        report::out!("      {}{line}", if i == 0 { place.as_str() } else { "" });
    }
}

fn print_output(output: &str) {
    let lines: Vec<&str> = output.lines().collect();
    let first = lines.len().saturating_sub(MAX_LINES);
    if first > 0 {
        report::out!("      | ({first} earlier lines omitted)");
    }
    lines[first..].iter().for_each(|line| report::out!("      | {line}"));
}
