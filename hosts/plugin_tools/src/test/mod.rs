//! `tatu plugin test`: builds a plugin, and runs the scene of its project and the tests in its folder `tests`: tests in C
//! and C++, scenes, and for a crate the tests of cargo.
//!
//! - `library`: builds the plugin under test; `c_tests`, `rust_tests`, `scenes`: run the three types of tests;
//! - `child`: runs one test in C in its process; `process`: starts a process and interprets its end;
//! - `outcome`: results of tests, as text and JSON; `tools`: compilers.

mod c_tests;
mod child;
mod library;
mod outcome;
mod process;
mod rust_tests;
mod scenes;
mod tools;

use std::{path::PathBuf, process::ExitCode, time::Duration};

use tatu_core::errors::{Error, Result};

use self::outcome::TestResults;
pub use child::{RunTestArgs, run_test};

#[derive(clap::Args)]
pub struct TestArgs {
    /// The plugin's folder.
    #[arg(default_value = ".")]
    pub folder: PathBuf,
    /// Run only tests whose names contain this string.
    #[arg(long, value_name = "NAME")]
    pub only: Option<String>,
    /// Print a JSON object on standard output at the end, instead of a line per test.
    #[arg(long)]
    pub json: bool,
    /// Seconds of real time after which a test is killed and reported as failed.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = limit)]
    pub timeout: f64,
}

fn limit(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|s: &f64| s.is_finite() && (0.1..=1e6).contains(s));
    found.ok_or_else(|| "expected a number of seconds from 0.1 to 1000000".into())
}

/// Runs the tests. The exit code is 0 if all pass, 1 if one fails or the plugin could not be built, and 2 if there is
/// nothing to test.
pub fn test(args: &TestArgs) -> Result<ExitCode> {
    let outcomes = run(args)?;
    outcomes.summary(args.json);
    Ok(if outcomes.failed() == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn run(args: &TestArgs) -> Result<TestResults> {
    let folder = args.folder.canonicalize().map_err(|e| {
        Error::new("E620", format!("cannot use the folder {}: {e}", args.folder.display()))
            .expected("the folder of a plugin, with its tests in the folder `tests`")
    })?;
    let limit = Duration::from_secs_f64(args.timeout);
    let mut out = TestResults::new(args.only.clone(), !args.json);
    let Some(plugins) = library::make(&folder, &mut out)? else { return Ok(out) };
    rust_tests::run(&folder, limit, &mut out)?;
    c_tests::run(&folder, &plugins, limit, &mut out)?;
    scenes::run(&folder, &plugins, limit, &mut out)?;
    if out.is_empty() {
        let only = args.only.as_ref().map_or(String::new(), |name| format!(" with `{name}` in its name"));
        return Err(Error::new("E620", format!("{} has no tests{only}", folder.display()))
            .expected("tests in C (`tests/*.c`), test scenes (`tests/*.toml`), or a crate with tests (`Cargo.toml`)"));
    }
    Ok(out)
}
