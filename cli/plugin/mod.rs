//! `tatu plugin`: work on the folder of a plugin, as `tatu new plugin` makes it. One file or folder per subcommand.

pub mod build;
pub mod project;
pub mod run;
pub mod test;
pub mod update_sdk;

use std::process::ExitCode;

use clap::Subcommand;
use tatu_core::errors::Result;

use crate::report;

#[derive(clap::Args)]
pub struct Plugin {
    #[command(subcommand)]
    pub command: PluginCommand,
}

#[derive(Subcommand)]
pub enum PluginCommand {
    /// Build the library: `build/libtatu_NAME.so` in the folder.
    Build(build::Build),
    /// Build it, and run its scene.
    Run(run::Run),
    /// Build it, and run its tests, each in a process of its own.
    Test(test::Test),
    /// Run one test: what `test` starts.
    #[command(hide = true)]
    RunTest(test::RunTest),
    /// Replace the headers and the crate in `sdk` by those of this program.
    UpdateSdk(update_sdk::UpdateSdk),
}

/// Exit code 0; what the compiler, the run or a test ended with; 2 if there is nothing to work on.
pub fn plugin(args: &Plugin) -> ExitCode {
    code(match &args.command {
        PluginCommand::Build(args) => build::build(args),
        PluginCommand::Run(args) => run::run(args),
        PluginCommand::Test(args) => test::test(args),
        PluginCommand::RunTest(args) => test::run_test(args),
        PluginCommand::UpdateSdk(args) => update_sdk::update_sdk(args),
    })
}

fn code(done: Result<ExitCode>) -> ExitCode {
    done.unwrap_or_else(|e| {
        report::error(&e);
        ExitCode::from(2)
    })
}
