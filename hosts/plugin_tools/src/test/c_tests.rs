//! Runs tests in C and C++: each file is compiled to a library, and each test runs in a separate process.

use std::{
    fs,
    path::{Path, PathBuf},
    time::Duration,
};

use serde_json::Value;
use tatu_core::errors::{Error, Result};
use tatu_embed::restart_command;

use super::{
    outcome::{Failure, TestResults},
    process::{self, ProcessResult},
    tools,
};

/// Time limit for the compiler.
const COMPILE_TIMEOUT: Duration = Duration::from_secs(3600);

/// Runs all tests of the folder.
pub fn run(folder: &Path, plugins: &[PathBuf], limit: Duration, out: &mut TestResults) -> Result {
    let place = folder.join("build/tests");
    fs::create_dir_all(&place).map_err(|e| Error::new("E621", format!("cannot create {}: {e}", place.display())))?;
    for source in tools::files(&folder.join("tests"), &["c", "cpp", "cc", "cxx"]) {
        let file = tools::shown(folder, &source);
        let stem = source.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let library = place.join(tools::library_name(&format!("test_{stem}")));
        let mut command = tools::compiler(folder, &source)?;
        command.arg("-o").arg(&library).arg(&source);
        if cfg!(target_os = "linux") {
            command.arg("-lm");
        }
        // The compiler runs in the project's folder, so that paths in its messages are relative to it.
        let built = process::run(command.current_dir(folder), COMPILE_TIMEOUT)?;
        if !built.status.is_some_and(|s| s.success()) {
            out.add(&file, &stem, vec![Failure::new("the tests cannot be compiled")], &built.output);
            continue;
        }
        let test = TestLibrary { folder, library, report: place.join("report.jsonl"), plugins, limit };
        match test.names()? {
            Ok(names) => {
                for name in &names {
                    if !out.wants(name) {
                        continue;
                    }
                    let (failures, output) = test.run(name)?;
                    out.add(&file, name, failures, &output);
                }
            }
            Err((failure, output)) => out.add(&file, &stem, vec![failure], &output),
        }
    }
    Ok(())
}

/// The tests of one file.
struct TestLibrary<'a> {
    folder: &'a Path,
    library: PathBuf,
    report: PathBuf,
    plugins: &'a [PathBuf],
    limit: Duration,
}

impl TestLibrary<'_> {
    /// Starts this program as a child process that runs this library; returns how it ended, and its report.
    fn start(&self, name: Option<&str>) -> Result<(ProcessResult, Vec<Value>)> {
        // Remove the report of an earlier test. This fails if there is no such report, which is not a problem.
        let _ = fs::remove_file(&self.report);
        let command = restart_command();
        let mut command =
            command.map_err(|e| Error::new("E621", format!("the path of this program is unknown: {e}")))?;
        command.args(["plugin", "run-test"]).arg(&self.library).arg("--report").arg(&self.report);
        command.arg("--files").arg(self.folder.join("tests"));
        if let Some(name) = name {
            command.arg("--name").arg(name);
        }
        for plugin in self.plugins {
            command.arg("--plugin").arg(plugin);
        }
        let ended = process::run(command.current_dir(self.folder), self.limit)?;
        let text = fs::read_to_string(&self.report).unwrap_or_default();
        Ok((ended, text.lines().filter_map(|l| serde_json::from_str(l).ok()).collect()))
    }

    /// Returns the names of the tests, or a failure with the output if the library cannot be loaded.
    fn names(&self) -> Result<Result<Vec<String>, (Failure, String)>> {
        let (ended, report) = self.start(None)?;
        if let Some(Value::Array(names)) = report.first() {
            return Ok(Ok(names.iter().filter_map(Value::as_str).map(str::to_owned).collect()));
        }
        let why = process::abnormal_end(&ended, self.limit).unwrap_or_else(|| "the tests cannot be loaded".into());
        Ok(Err((Failure::new(why), ended.output)))
    }

    /// Runs one test; returns its failures and its output.
    fn run(&self, name: &str) -> Result<(Vec<Failure>, String)> {
        let (ended, report) = self.start(Some(name))?;
        let failure = |v: &Value| {
            let text = |key: &str| v[key].as_str().map(str::to_owned);
            let line = v["line"].as_u64().unwrap_or(0);
            Some(Failure { file: text("file")?, line: u32::try_from(line).unwrap_or(0), text: text("text")? })
        };
        let mut failures: Vec<Failure> = report.iter().filter_map(failure).collect();
        for f in &mut failures {
            f.file = tools::shown(self.folder, Path::new(&f.file));
        }
        let ended_well = report.last().is_some_and(|v| v == "end");
        match process::abnormal_end(&ended, self.limit) {
            Some(why) => failures.push(Failure::new(why)),
            None if !ended_well => {
                failures.push(Failure::new("the test ended the process before the test was complete"))
            }
            None => {}
        }
        Ok((failures, ended.output))
    }
}
