//! Runs the tests of a crate: cargo builds them, and each runs in a separate process, so that a test that crashes or
//! hangs does not affect the others.

use std::{
    path::{Path, PathBuf},
    process::Command,
    time::Duration,
};

use serde_json::Value;
use tatu_core::errors::Result;

use super::{
    library::without_json_lines,
    outcome::{Failure, TestResults},
    process, tools,
};

/// Time limit for cargo.
const CARGO_TIMEOUT: Duration = Duration::from_secs(3600);

/// Runs all tests of the crate in the folder, if there is one, except for doc tests, which only `cargo test` can run.
pub fn run(folder: &Path, limit: Duration, out: &mut TestResults) -> Result {
    let manifest = folder.join("Cargo.toml");
    if !manifest.is_file() {
        return Ok(());
    }
    let mut command = Command::new(tools::cargo());
    command.args(["test", "--no-run", "--message-format=json-render-diagnostics", "--manifest-path"]).arg(&manifest);
    let built = process::run(&mut command, CARGO_TIMEOUT)?;
    if !built.status.is_some_and(|s| s.success()) {
        out.add(
            "Cargo.toml",
            "cargo test",
            vec![Failure::new("the tests cannot be compiled")],
            &without_json_lines(&built.output),
        );
        return Ok(());
    }
    for program in built.output.lines().filter_map(|l| TestProgram::of(l, &manifest)) {
        let file = tools::shown(folder, &program.source);
        let ignored = program.names(folder, limit, &["--ignored"])?;
        for name in program.names(folder, limit, &[])? {
            if ignored.contains(&name) || !out.wants(&name) {
                continue;
            }
            let ended = process::run(program.command(folder).args(["--exact", &name, "--test-threads=1"]), limit)?;
            let good = ended.status.is_some_and(|s| s.success());
            let (failures, output) =
                match (process::abnormal_end(&ended, limit), failed_test_output(&ended.output, &name)) {
                    (None, _) if good => (Vec::new(), ""),
                    (Some(why), _) => (vec![Failure::new(why)], ended.output.as_str()),
                    (None, Some(said)) => (vec![Failure::new(said)], ""),
                    (None, None) => (vec![Failure::new("the test failed")], ended.output.as_str()),
                };
            out.add(&file, &name, failures, output);
        }
    }
    Ok(())
}

/// A test program built by cargo.
struct TestProgram {
    file: PathBuf,
    source: PathBuf,
}

impl TestProgram {
    /// Returns the test program that a message of cargo reports, or `None` if it reports something else.
    fn of(message: &str, manifest: &Path) -> Option<Self> {
        let message: Value = serde_json::from_str(message).ok()?;
        let own = message["manifest_path"].as_str().is_some_and(|p| Path::new(p) == manifest);
        let is_test = message["profile"]["test"].as_bool().unwrap_or(false);
        let path = |v: &Value| v.as_str().map(PathBuf::from);
        let program =
            TestProgram { file: path(&message["executable"])?, source: path(&message["target"]["src_path"])? };
        (own && is_test).then_some(program)
    }

    /// Returns a command that runs the tests as cargo does, but with this program as the host of plugins.
    fn command(&self, folder: &Path) -> Command {
        let mut command = Command::new(&self.file);
        command.current_dir(folder).env("CARGO_MANIFEST_DIR", folder);
        if let Some(home) = tools::home().filter(|_| std::env::var_os("TATU_TESTHOST").is_none()) {
            command.env("TATU_HOME", home);
        }
        command
    }

    /// Returns the names of the program's tests.
    fn names(&self, folder: &Path, limit: Duration, which: &[&str]) -> Result<Vec<String>> {
        let listed = process::run(self.command(folder).args(["--list", "--format", "terse"]).args(which), limit)?;
        let names = listed.output.lines().filter_map(|l| l.strip_suffix(": test"));
        Ok(names.map(str::to_owned).collect())
    }
}

/// Extracts the output of a failed test from the output of libtest, without the backtrace.
fn failed_test_output(output: &str, name: &str) -> Option<String> {
    let begin = format!("---- {name} stdout ----");
    let (_, rest) = output.split_once(begin.as_str())?;
    let (own, _) = rest.split_once("\nfailures:\n")?;
    let own = own.split("\nstack backtrace:").next().unwrap_or(own);
    let lines: Vec<&str> = own.trim().lines().filter(|l| !l.starts_with("note: run with")).collect();
    (!lines.is_empty()).then(|| lines.join("\n"))
}
