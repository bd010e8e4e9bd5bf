//! `tatu test`: runs scenes as tests, each in a process of its own.

use std::{
    ffi::OsString,
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
    time::Duration,
};

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use serde_json::{Value, json};
use tatu_core::errors::{Error, Result};
use tatu_embed::pack;
use tatu_plugin_api::safe::{MAX_FILE_BYTES, read_plain_text};
use tatu_terminal::report;
use toml_edit::{Document, Item, TableLike};

use crate::{
    child_run::{self, FinishedRun},
    test_args::TestArgs,
};

/// Exit code if a scene has errors.
const ERRORS: u8 = 1;
/// Exit code if goals were not reached, but nothing else went wrong.
const GOALS: u8 = 3;
/// How deep scenes may be below a folder that is searched for tests.
const MAX_DEPTH: usize = 8;

/// A scene that is run as a test.
struct SceneTest {
    /// Path as the user sees it.
    name: String,
    scene: PathBuf,
    /// Arguments of `tatu run` that follow from the scene.
    args: Vec<OsString>,
}

/// What a test has shown.
enum Outcome {
    Passed,
    /// The texts of the goals that were not reached, and the time at which the first was decided, s.
    GoalsFailed(Vec<String>, f64),
    /// Errors and warnings, and everything that ended the run.
    Error(String),
}

struct TestResult {
    outcome: Outcome,
    wall: f64,
    /// The record of a failed run.
    capsule: Option<PathBuf>,
}

/// Runs tests. The exit code is 0 if all pass, 1 if a scene has errors, 3 if only goals were not reached, and 2 if there
/// is no test.
pub fn test(args: &TestArgs) -> ExitCode {
    match run(args) {
        Ok(code) => code,
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

fn run(args: &TestArgs) -> Result<ExitCode> {
    let tests = find_all(&args.paths)?;
    if tests.is_empty() {
        let error = Error::new("E105", "there is no scene to test")
            .expected("scene files, or folders with scenes that state `duration_s` in `[scene]` or have goals");
        return Err(error);
    }
    let place = tempfile::tempdir().map_err(|e| Error::new("E105", format!("cannot create a folder: {e}")))?;
    let bar = report::progress(tests.len() as u64, "test", !args.json);
    let mut results = Vec::new();
    let threads = child_run::threads(args.jobs);
    child_run::in_order(
        tests.len(),
        threads,
        |i| run_one(&tests[i], args, &place.path().join(i.to_string())),
        |i, result| {
            bar.inc(1);
            if !args.json {
                bar.suspend(|| print(&tests[i], &result));
            }
            results.push(result);
        },
    );
    bar.finish_and_clear();
    let results = results.into_iter().collect::<Result<Vec<_>>>()?;
    if let Some(file) = &args.junit {
        write_junit(file, &tests, &results)?;
    }
    let passed = results.iter().filter(|r| matches!(r.outcome, Outcome::Passed)).count();
    match args.json {
        true => report::out!("{}", summary(&tests, &results)),
        false => report::out!("{passed} of {} tests pass", tests.len()),
    }
    Ok(match results.iter().any(|r| matches!(r.outcome, Outcome::Error(_))) {
        true => ExitCode::from(ERRORS),
        false if passed < tests.len() => ExitCode::from(GOALS),
        false => ExitCode::SUCCESS,
    })
}

/// Runs a test. A run that fails is run again and recorded, which changes nothing in it.
fn run_one(test: &SceneTest, args: &TestArgs, folder: &Path) -> Result<TestResult> {
    let mut words: Vec<OsString> = vec![test.scene.clone().into(), "--strict".into(), "--no-addons".into()];
    words.extend(test.args.iter().cloned());
    for (flag, values) in [("--allow", &args.allow), ("--set", &args.set)] {
        words.extend(values.iter().flat_map(|value| [flag.into(), value.into()]));
    }
    if let Some(seed) = args.seed {
        words.extend(["--seed".into(), seed.to_string().into()]);
    }
    let timeout = Duration::from_secs_f64(args.timeout);
    let finished = child_run::run(&words, folder, timeout, None)?;
    let outcome = judge(&finished, args.timeout);
    // A scene that did not start has no run to record, and one that never ends would take as long again.
    let may_record = finished.summary.is_some() && !matches!(outcome, Outcome::Passed) && !pack::is_pack(&test.scene);
    let capsule = may_record.then(|| record(test, args, &words, folder)).transpose()?.flatten();
    Ok(TestResult { outcome, wall: finished.wall, capsule })
}

fn judge(finished: &FinishedRun, timeout: f64) -> Outcome {
    let Some(summary) = &finished.summary else {
        return Outcome::Error(match (finished.timed_out, finished.output.as_str()) {
            (true, _) => format!("it was ended after {timeout} s, before its run was complete"),
            (false, "") => "the program ended without a word".to_owned(),
            (false, said) => said.to_owned(),
        });
    };
    let goals: Vec<&Value> = summary["goals"].as_array().into_iter().flatten().collect();
    let failed: Vec<&Value> = goals.into_iter().filter(|g| g["state"] != "reached").collect();
    match finished.code {
        Some(0) => Outcome::Passed,
        Some(3) => {
            let texts = failed.iter().map(|g| {
                let time = g["time"].as_f64().unwrap_or(-1.0);
                let text = g["text"].as_str().unwrap_or_default();
                if time < 0.0 { text.to_owned() } else { format!("{text} (at {time:.2} s)") }
            });
            let times = failed.iter().filter_map(|g| g["time"].as_f64()).filter(|t| *t >= 0.0);
            Outcome::GoalsFailed(texts.collect(), times.fold(f64::INFINITY, f64::min))
        }
        _ => {
            let errors = summary["errors"].as_array().into_iter().flatten().filter_map(|e| e["message"].as_str());
            let warnings = summary["warnings"].as_array().into_iter().flatten().filter_map(Value::as_str);
            let all: Vec<&str> = errors.chain(warnings).collect();
            Outcome::Error(if all.is_empty() { finished.output.clone() } else { all.join("\n") })
        }
    }
}

/// Runs a failed test again, and records it. Returns the file, or `None` if the run cannot be recorded.
fn record(test: &SceneTest, args: &TestArgs, words: &[OsString], folder: &Path) -> Result<Option<PathBuf>> {
    let lost = |e: std::io::Error| Error::new("E105", format!("cannot write into {}: {e}", args.failed.display()));
    fs::create_dir_all(&args.failed).map_err(lost)?;
    let name: String = test.name.chars().map(|c| if c.is_alphanumeric() || c == '_' { c } else { '-' }).collect();
    let name = name.trim_matches('-').trim_end_matches("-toml");
    let file = fs::canonicalize(&args.failed).map_err(lost)?.join(format!("{name}.tatu"));
    let mut words = words.to_vec();
    words.extend(["--capsule".into(), file.clone().into()]);
    child_run::run(&words, &folder.join("record"), Duration::from_secs_f64(2.0 * args.timeout), None)?;
    Ok(file.is_file().then(|| args.failed.join(format!("{name}.tatu"))))
}

fn print(test: &SceneTest, result: &Result<TestResult>) {
    let Ok(result) = result else { return };
    let word = if matches!(result.outcome, Outcome::Passed) { "pass" } else { "FAIL" };
    report::out!("{word}  {}  {:.1} s", test.name, result.wall);
    match &result.outcome {
        Outcome::Passed => {}
        Outcome::GoalsFailed(all, _) => all.iter().for_each(|goal| report::out!("      not reached: {goal}")),
        Outcome::Error(text) => text.lines().for_each(|line| report::out!("      {line}")),
    }
    if let Some(line) = opening_line(result) {
        report::out!("      {line}");
    }
}

/// Returns the command line that shows a failed run.
fn opening_line(result: &TestResult) -> Option<String> {
    let capsule = result.capsule.as_ref()?.display();
    Some(match result.outcome {
        Outcome::GoalsFailed(_, time) if time.is_finite() => {
            format!("to see it: tatu look {capsule} --at {time:.2} -o failed.png; to run it: tatu open {capsule}")
        }
        _ => format!("to run it: tatu open {capsule}"),
    })
}

fn summary(tests: &[SceneTest], results: &[TestResult]) -> Value {
    let row = |(test, result): (&SceneTest, &TestResult)| {
        let mut row = json!({ "scene": test.name, "wall_s": result.wall, "capsule": result.capsule });
        match &result.outcome {
            Outcome::Passed => row["result"] = "passed".into(),
            Outcome::GoalsFailed(all, _) => (row["result"], row["goals"]) = ("goals failed".into(), json!(all)),
            Outcome::Error(text) => (row["result"], row["error"]) = ("error".into(), json!(text)),
        }
        row
    };
    json!(tests.iter().zip(results).map(row).collect::<Vec<_>>())
}

fn write_junit(file: &Path, tests: &[SceneTest], results: &[TestResult]) -> Result {
    let mut suite = TestSuite::new("tatu test");
    for (test, result) in tests.iter().zip(results) {
        let failed = |kind, text: &str| {
            let mut status = TestCaseStatus::non_success(kind);
            status.set_message(text.lines().next().unwrap_or_default());
            status.set_description(opening_line(result).map_or(text.to_owned(), |line| format!("{text}\n{line}")));
            status
        };
        let status = match &result.outcome {
            Outcome::Passed => TestCaseStatus::success(),
            Outcome::GoalsFailed(all, _) => failed(NonSuccessKind::Failure, &all.join("\n")),
            Outcome::Error(text) => failed(NonSuccessKind::Error, text),
        };
        let mut case = TestCase::new(&*test.name, status);
        case.set_time(Duration::from_secs_f64(result.wall));
        suite.add_test_case(case);
    }
    let mut all = Report::new("tatu");
    all.add_test_suite(suite);
    let lost = |e: String| Error::new("E105", format!("cannot write {}: {e}", file.display()));
    let text = all.to_string().map_err(|e| lost(e.to_string()))?;
    fs::write(file, text).map_err(|e| lost(e.to_string()))
}

/// Returns the tests in files and below folders, in the order of the arguments, and by name within a folder.
fn find_all(paths: &[PathBuf]) -> Result<Vec<SceneTest>> {
    let mut all = Vec::new();
    for path in paths {
        match path.is_dir() {
            true => find_below(path, 0, &mut all)?,
            false => all.push(test_of(path, read_scene(path)?.as_ref())),
        }
    }
    Ok(all)
}

/// Adds the tests below a folder. Hidden folders and links are skipped.
fn find_below(folder: &Path, depth: usize, all: &mut Vec<SceneTest>) -> Result {
    let lost = |e: std::io::Error| Error::new("E105", format!("cannot read the folder {}: {e}", folder.display()));
    let mut entries = fs::read_dir(folder).map_err(lost)?.collect::<std::io::Result<Vec<_>>>().map_err(lost)?;
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries.iter().filter(|e| !e.file_name().to_string_lossy().starts_with('.')) {
        let (path, kind) = (entry.path(), entry.file_type().map_err(lost)?);
        if kind.is_dir() && depth < MAX_DEPTH {
            find_below(&path, depth + 1, all)?;
        } else if kind.is_file()
            && let Some(scene) = read_scene(&path)?.filter(is_test)
        {
            all.push(test_of(&path, Some(&scene)));
        }
    }
    Ok(())
}

/// Reads a scene file; `None` if the file is not one, but perhaps a scene of another format.
fn read_scene(path: &Path) -> Result<Option<Document<String>>> {
    if path.extension().is_none_or(|e| e != "toml") {
        return match path.is_file() {
            true => Ok(None),
            false => Err(Error::new("E105", format!("there is no scene {}", path.display()))),
        };
    }
    let text = read_plain_text(path, MAX_FILE_BYTES)
        .map_err(|e| Error::new("E105", format!("cannot read {}: {e}", path.display())))?;
    // A file that is not valid is run all the same if the user names it, which reports what is wrong with it.
    Ok(Document::parse(text).ok())
}

/// Returns whether a scene in a folder is a test: it states how long it runs, or has goals.
fn is_test(scene: &Document<String>) -> bool {
    let states_duration =
        scene.get("scene").and_then(Item::as_table_like).is_some_and(|s| s.contains_key("duration_s"));
    states_duration || tables(scene, "object").any(has_goals)
}

fn has_goals(object: &dyn TableLike) -> bool {
    let data = object.get("data").and_then(Item::as_table_like);
    let kind = object.get("script").and_then(Item::as_table_like).and_then(|s| s.get("kind"));
    data.is_some_and(|d| d.contains_key("exercise.goals")) || kind.and_then(Item::as_str) == Some("referee")
}

fn tables<'a>(scene: &'a Document<String>, key: &str) -> impl Iterator<Item = &'a dyn TableLike> {
    let all = scene.get(key).and_then(Item::as_array_of_tables);
    all.into_iter().flatten().map(|table| table as &dyn TableLike)
}

fn test_of(path: &Path, scene: Option<&Document<String>>) -> SceneTest {
    let mut args = Vec::new();
    let services: Vec<&str> =
        scene.into_iter().flat_map(|s| tables(s, "service")).filter_map(|t| t.get("id")?.as_str()).collect();
    // The ports of the scene's services may be in use, and with services, a run has no end of its own.
    for id in &services {
        args.extend(["--service".into(), format!("{id}:port=0").into()]);
    }
    if !services.is_empty() {
        let stated = scene
            .and_then(|s| s.get("scene")?.get("duration_s"))
            .and_then(|v| v.as_float().or_else(|| v.as_integer().map(|i| i as f64)));
        args.extend(["--seconds".into(), stated.unwrap_or(10.0).to_string().into()]);
    }
    let scene = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    SceneTest { name: path.display().to_string(), scene, args }
}
