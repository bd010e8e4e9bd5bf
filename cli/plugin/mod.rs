//! `tatu plugin`: writing, checking and installing plugins. One file or folder per subcommand.

mod check;

use std::process::ExitCode;

use clap::Subcommand;

/// The arguments of `tatu plugin`.
#[derive(clap::Args)]
pub struct Plugin {
    #[command(subcommand)]
    pub command: PluginCommand,
}

#[derive(Subcommand)]
pub enum PluginCommand {
    /// Test a plugin against the rules of the ABI.
    Check(check::Check),
}

/// Runs a subcommand.
pub fn plugin(command: &PluginCommand) -> ExitCode {
    match command {
        PluginCommand::Check(args) => check::check(args),
    }
}
