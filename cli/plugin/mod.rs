//! `tatu plugin`: one file per subcommand, and what they share.
//!
//! - [`check`], [`why`], [`install`], [`list`]: the subcommands;
//! - `answer`: which file is meant, and the sentence about it; `show`: prints that;
//! - `examine`: all that can be said about one file; `file`: what sort of file it is; `elf`: what the library in it needs
//!   and exports; `loader`: the libraries and symbols that it needs; `probe`: opens it in a process of its own;
//! - `folders`: the folders that are searched; `names`: names of files; `archive`: packed plugins; `reason`: what is
//!   wrong, and what to do.

mod answer;
mod archive;
mod check;
mod elf;
mod examine;
mod file;
mod folders;
mod install;
mod list;
mod loader;
mod names;
mod probe;
mod reason;
mod show;
mod why;

use std::process::ExitCode;

/// What to do with plugins.
#[derive(clap::Subcommand)]
pub enum PluginCommand {
    /// Test a plugin against the rules of the ABI.
    Check(check::Check),
    /// Explain why a plugin is loaded, or why not, and what to do.
    Why(why::Why),
    /// Install a plugin into your own folder, or remove it from there; nothing is downloaded.
    Install(install::Install),
    /// List all plugin files in the order in which they are searched.
    List(list::List),
}

impl PluginCommand {
    /// Runs it.
    pub fn run(self) -> ExitCode {
        match self {
            PluginCommand::Check(args) => check::check(&args),
            PluginCommand::Why(args) => why::why(&args),
            PluginCommand::Install(args) => install::install(&args),
            PluginCommand::List(args) => list::list(&args),
        }
    }
}
