//! `tatu plugin check`: tests a plugin against the rules of the ABI. Each test runs in a separate process.
//!
//! - this file: the arguments, the list of tests, the exit code; `process`: runs one test in a child process;
//! - `sanitize`: builds a project with sanitizers; `config`: `tatu-check.toml`; `report`: output as text, as JSON, and as GitHub annotations;
//! - `subject`: the plugin under test in the child; `finding`: findings, and how the child sends them;
//! - `inspector`: watches calls at the ABI, with `argument_pages` for the arguments of commands, and `sensor_probes`,
//!   `actuator_probes`, `batch_copy`, `judge` and `units` for the batches of devices; `guard_handler`: names the guard
//!   page of a crash; `libc_calls`: watches calls of the C library;
//! - `stage`: scenes and parameter values for tests; `scripts`: scripts that call commands; `samples`: models, files and
//!   scripts of the plugin; `damage`: malformed files;
//! - one file per group of tests: `declarations`, `commands`, `repeat`, `devices`, `probes`, `snapshots`, `leaks`,
//!   `models`, `sources`, `services`, `cost`.

mod actuator_probes;
mod argument_pages;
mod batch_copy;
mod commands;
mod config;
mod cost;
mod damage;
mod declarations;
mod devices;
mod finding;
mod guard_handler;
mod inspector;
mod judge;
mod leaks;
mod libc_calls;
mod models;
mod probes;
mod process;
mod repeat;
mod report;
mod samples;
mod sanitize;
mod scripts;
mod sensor_probes;
mod services;
mod snapshots;
mod sources;
mod stage;
mod subject;
mod units;

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    process::ExitCode,
    sync::{
        atomic::{AtomicUsize, Ordering::Relaxed},
        mpsc,
    },
};

use tatu_core::errors::{Error, nearest};

use self::{config::CheckConfig, finding::FindingLevel, report::TestOutcome};
use tatu_terminal::report as messages;

/// Arguments of `tatu plugin check`.
#[derive(clap::Args)]
#[command(after_help = HELP)]
pub struct PluginCheckArgs {
    /// The library of a plugin, or a folder that contains it, directly or in `build`.
    #[arg(default_value = ".")]
    pub file: PathBuf,
    /// Run only these tests.
    #[arg(long, value_name = "TEST", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Skip these tests.
    #[arg(long, value_name = "TEST", value_delimiter = ',')]
    pub skip: Vec<String>,
    /// List the tests and exit.
    #[arg(long)]
    pub list: bool,
    /// Print the result as JSON.
    #[arg(long)]
    pub json: bool,
    /// Also write findings as annotations for GitHub workflows [default: if GITHUB_ACTIONS is set].
    #[arg(long)]
    pub github: bool,
    /// Seconds of real time after which a test is killed and reported as failed.
    #[arg(long, value_name = "S", default_value_t = 120, value_parser = clap::value_parser!(u64).range(1..=86400))]
    pub timeout: u64,
    /// Use this file instead of searching for tatu-check.toml.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Build the project with the address and undefined-behaviour sanitizers of its compiler, and test that.
    #[arg(long)]
    pub sanitize: bool,
    /// Run a single test, given by `--only`, in this process, for a debugger.
    #[arg(long)]
    pub in_process: bool,
    /// Run this test in this process; used by the program for its child processes.
    #[arg(long, hide = true)]
    pub run: Option<String>,
}

const HELP: &str = "The exit code is 0 if no test has found an error, 1 otherwise, and 2 if there is no such plugin.

A file tatu-check.toml next to the plugin, in its project's folder or in the working folder lists further tests to skip
and findings to allow, with a reason:
  skip = [\"cost\"]
  [[allow]]
  test = \"repeat\"
  place = \"command `clock.now`\"
  reason = \"reads the clock, and records it as an input\"";

/// A test: its name, the property that it tests, and its function in the child process.
struct CheckTest {
    name: &'static str,
    text: &'static str,
    run: fn(&Path) -> Result<(), Error>,
}

/// All tests, in the order in which they run.
const TESTS: &[CheckTest] = &[
    CheckTest {
        name: "declarations",
        text: "the plugin's declarations are complete and consistent",
        run: declarations::run,
    },
    CheckTest { name: "examples", text: "the examples of commands compile and run", run: commands::examples },
    CheckTest {
        name: "arguments",
        text: "commands withstand valid and invalid arguments, placed before guard pages",
        run: commands::arguments,
    },
    CheckTest {
        name: "repeat",
        text: "equal runs in two processes with different clocks produce equal results",
        run: repeat::repeat,
    },
    CheckTest { name: "worlds", text: "calls in one world do not affect another world", run: commands::worlds },
    CheckTest {
        name: "readings",
        text: "readings are finite, and the same on 1 and 2 threads, bit for bit",
        run: devices::readings,
    },
    CheckTest {
        name: "batches",
        text: "devices depend neither on others nor on anything outside of their state",
        run: probes::batches,
    },
    CheckTest { name: "extremes", text: "devices withstand unusual inputs", run: probes::extremes },
    CheckTest { name: "units", text: "parameters, readings and forces are in the declared units", run: probes::units },
    CheckTest {
        name: "actuators",
        text: "actuators and parts act the same on 1 and 2 threads, bit for bit",
        run: devices::actuators,
    },
    CheckTest {
        name: "configure",
        text: "a parameter that is changed during a run has the same effect as one set at the start",
        run: devices::configure,
    },
    CheckTest {
        name: "snapshots",
        text: "a run that is saved, killed and restored continues as if it had not been interrupted",
        run: snapshots::resume,
    },
    CheckTest {
        name: "reload",
        text: "a plugin that is reloaded during a run continues where it was",
        run: snapshots::reload,
    },
    CheckTest { name: "load", text: "`load` refuses unknown bytes, and survives damaged ones", run: snapshots::load },
    CheckTest { name: "leaks", text: "memory, descriptors, threads and processes are released", run: leaks::leaks },
    CheckTest {
        name: "models",
        text: "models can be built with the values that they allow, and stand on the floor",
        run: models::models,
    },
    CheckTest {
        name: "importers",
        text: "valid files are read equally, and malformed ones refused with errors",
        run: sources::importers,
    },
    CheckTest {
        name: "languages",
        text: "script languages run scripts equally, withstand malformed ones, and own the memory that they return",
        run: sources::languages,
    },
    CheckTest {
        name: "services",
        text: "services never block, their runs can be replayed, and their threads do not access worlds",
        run: services::run,
    },
    CheckTest { name: "cost", text: "reports the cost of calls; never fails", run: cost::run },
];

/// Runs the tests on a plugin.
pub fn check(args: &PluginCheckArgs) -> ExitCode {
    if args.list {
        TESTS.iter().for_each(|t| messages::out!("{:<14}{}", t.name, t.text));
        return ExitCode::SUCCESS;
    }
    let file = &args.file;
    let mut sanitized = None;
    if args.sanitize {
        match sanitize::build_sanitized(file) {
            Ok(built) => sanitized = Some(built),
            Err(e) => {
                messages::error(&e);
                return ExitCode::from(2);
            }
        }
    }
    let preload = sanitized.as_ref().map(|s| s.preload.as_path());
    let library = sanitized.as_ref().map_or_else(|| process::library(file), |s| Ok(s.library.clone()));
    let ready = library.and_then(|library| {
        if let Some(name) = &args.run {
            return Ok((library, CheckConfig::default(), vec![test(name)?]));
        }
        let config = CheckConfig::find(file, args.config.as_deref())?;
        let chosen = chosen(args, &config)?;
        Ok((library, config, chosen))
    });
    let (library, config, tests) = match ready {
        Ok(ready) => ready,
        Err(e) => {
            messages::error(&e);
            return ExitCode::from(2);
        }
    };
    if args.run.is_some() {
        return process::run_in_child(tests[0].run, &library);
    }
    if args.in_process {
        return in_process(&tests, &library);
    }
    let outcomes = run_all(
        &tests,
        |test| {
            let mut outcome = process::run(test.name, test.text, &library, args.timeout, preload);
            outcome.findings.retain(|f| !config.allows(test.name, f));
            outcome
        },
        |outcome| {
            if !args.json {
                report::print(outcome);
            }
        },
    );
    if args.json {
        report::print_json(&library, &outcomes);
    } else {
        report::sum_up(&library, &outcomes);
    }
    if args.github || std::env::var_os("GITHUB_ACTIONS").is_some() {
        report::annotate(&library, &outcomes);
    }
    let failed = outcomes.iter().any(|o| o.findings.iter().any(|f| f.level == FindingLevel::Error));
    if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// Runs a single test in this process, where a debugger can follow it.
fn in_process(tests: &[&CheckTest], library: &Path) -> ExitCode {
    let [test] = tests else {
        let error = Error::new("E102", format!("`--in-process` runs one test, but {} are chosen", tests.len()));
        messages::error(&error.help("choose it by `--only TEST`"));
        return ExitCode::from(2);
    };
    finding::print_for_people();
    match (test.run)(library) {
        Err(e) => {
            messages::error(&e);
            ExitCode::FAILURE
        }
        Ok(()) if finding::has_errors() => ExitCode::FAILURE,
        Ok(()) => ExitCode::SUCCESS,
    }
}

/// Number of tests that run at the same time.
const AT_ONCE: usize = 2;

/// Runs tests, several at a time. Calls `done` for the outcomes in the order of the tests.
fn run_all(
    tests: &[&CheckTest],
    run: impl Fn(&CheckTest) -> TestOutcome + Sync,
    mut done: impl FnMut(&TestOutcome),
) -> Vec<TestOutcome> {
    let (next, (send, receive)) = (AtomicUsize::new(0), mpsc::channel());
    let mut outcomes: BTreeMap<usize, TestOutcome> = BTreeMap::new();
    let mut printed = 0;
    std::thread::scope(|scope| {
        for _ in 0..AT_ONCE {
            let (send, next, run) = (send.clone(), &next, &run);
            scope.spawn(move || {
                while let Some((i, test)) = Some(next.fetch_add(1, Relaxed)).and_then(|i| Some((i, tests.get(i)?))) {
                    let _ = send.send((i, run(test)));
                }
            });
        }
        drop(send);
        for (i, outcome) in receive {
            outcomes.insert(i, outcome);
            while let Some(outcome) = outcomes.get(&printed) {
                done(outcome);
                printed += 1;
            }
        }
    });
    outcomes.into_values().collect()
}

/// Returns the test of this name. Fails with E102 if there is no such test.
fn test(name: &str) -> Result<&'static CheckTest, Error> {
    TESTS.iter().find(|t| t.name == name).ok_or_else(|| {
        let names = TESTS.iter().map(|t| t.name);
        let error = Error::new("E102", format!("there is no test `{name}`"));
        match nearest(name, names) {
            Some(near) => error.help(format!("did you mean `{near}`?")),
            None => error.help("`tatu plugin check --list` lists the tests"),
        }
    })
}

fn chosen(args: &PluginCheckArgs, config: &CheckConfig) -> Result<Vec<&'static CheckTest>, Error> {
    for name in args.only.iter().chain(&args.skip).chain(&config.skip) {
        test(name)?;
    }
    for allowed in config.tests() {
        test(allowed)?;
    }
    let wanted = |t: &&CheckTest| {
        let is_in = |list: &[String]| list.iter().any(|n| n == t.name);
        (args.only.is_empty() || is_in(&args.only)) && !is_in(&args.skip) && (is_in(&args.only) || !is_in(&config.skip))
    };
    let all: Vec<_> = TESTS.iter().filter(wanted).collect();
    if all.is_empty() {
        return Err(Error::new("E102", "all tests are excluded by `--only`, `--skip` or the configuration file")
            .help("`tatu plugin check --list` lists all tests"));
    }
    Ok(all)
}
