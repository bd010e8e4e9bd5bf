//! The tools of plugin authors: `tatu plugin`, with one file per subcommand, and `tatu new`.
//!
//! - `check`, `why`, `install`, `list`: the subcommands;
//! - `answer`: finds the file that a name refers to, and whether it is loaded; `show`: prints that;
//! - [`new`]: creates folders from templates;
//! - `examine`: collects everything known about a file; `file`: its type; `elf`: what its library needs and exports;
//!   `loader`: finds the libraries and symbols that it needs; `probe`: opens it in a separate process;
//! - `folders`: the folders that are searched; `names`: names of files; `archive`: unpacks archives; `reason`: why a
//!   file is not loaded, and what to do;
//! - `beside`: the libraries that lie beside a plugin; `staged`: copies its files and moves them into place.

mod answer;
mod archive;
mod assets;
mod beside;
mod build;
mod check;
mod elf;
mod examine;
mod file;
mod folders;
mod install;
mod list;
mod loader;
mod names;
pub mod new;
mod probe;
mod project;
mod reason;
mod run;
mod show;
mod staged;
mod test;
mod update_sdk;
mod watch;
mod why;

use std::process::ExitCode;

use tatu_core::errors::Result;
use tatu_terminal::report;

/// What to do with plugins.
#[derive(clap::Subcommand)]
pub enum PluginCommand {
    /// Build the library of a project: `build/libtatu_NAME.so` in its folder.
    Build(build::BuildArgs),
    /// Build a project, and run its scene.
    Run(run::PluginRunArgs),
    /// Build a project at each save, while its scene runs.
    Watch(watch::WatchArgs),
    /// Build a project, and run its tests, each in its own process.
    Test(test::TestArgs),
    /// Run one test; used by `test` for its child processes.
    #[command(hide = true)]
    RunTest(test::RunTestArgs),
    /// Replace the headers and the crate in `sdk` with those of this program.
    UpdateSdk(update_sdk::UpdateSdkArgs),
    /// Test a plugin against the rules of the ABI.
    Check(check::PluginCheckArgs),
    /// Explain why a plugin is or is not loaded, and what to do.
    Why(why::WhyArgs),
    /// Install a plugin into your own folder, or remove it from there; nothing is downloaded.
    Install(install::InstallArgs),
    /// List all plugin files in the order in which they are searched.
    List(list::PluginListArgs),
}

impl PluginCommand {
    /// Runs the subcommand.
    pub fn run(self) -> ExitCode {
        match self {
            PluginCommand::Build(args) => code(build::build(&args)),
            PluginCommand::Run(args) => code(run::run(&args)),
            PluginCommand::Watch(args) => code(watch::watch(&args)),
            PluginCommand::Test(args) => code(test::test(&args)),
            PluginCommand::RunTest(args) => code(test::run_test(&args)),
            PluginCommand::UpdateSdk(args) => code(update_sdk::update_sdk(&args)),
            PluginCommand::Check(args) => check::check(&args),
            PluginCommand::Why(args) => why::why(&args),
            PluginCommand::Install(args) => install::install(&args),
            PluginCommand::List(args) => list::list(&args),
        }
    }
}

/// Returns the exit code of a subcommand; reports its error.
fn code(done: Result<ExitCode>) -> ExitCode {
    done.unwrap_or_else(|e| {
        report::error(&e);
        ExitCode::from(2)
    })
}
