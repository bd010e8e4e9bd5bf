//! `tatu plugin`: work on the folder of a plugin. One file or folder per subcommand.

pub mod test;

use std::process::ExitCode;

use clap::Subcommand;

#[derive(clap::Args)]
pub struct Plugin {
    #[command(subcommand)]
    pub command: PluginCommand,
}

#[derive(Subcommand)]
pub enum PluginCommand {
    /// Build a plugin and run its tests, each in a process of its own.
    Test(test::Test),
    /// Run one test: what `test` starts.
    #[command(hide = true)]
    RunTest(test::RunTest),
}

/// The exit code of a subcommand.
pub fn plugin(args: &Plugin) -> ExitCode {
    match &args.command {
        PluginCommand::Test(args) => test::test(args),
        PluginCommand::RunTest(args) => test::run_test(args),
    }
}
