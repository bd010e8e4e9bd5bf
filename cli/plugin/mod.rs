//! `tatu plugin`: one file per subcommand, and shared code.
//!
//! - [`check`], [`why`], [`install`], [`list`]: the subcommands;
//! - `answer`: finds the file that a name refers to, and whether it is loaded; `show`: prints that;
//! - `examine`: collects everything known about a file; `file`: its type; `elf`: what its library needs and exports;
//!   `loader`: finds the libraries and symbols that it needs; `probe`: opens it in a separate process;
//! - `folders`: the folders that are searched; `names`: names of files; `archive`: unpacks archives; `reason`: why a
//!   file is not loaded, and what to do.

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
    /// Tell why a plugin is loaded, or why not, and what to do.
    Why(why::Why),
    /// Install a plugin into your own folder, or remove it from there; nothing is downloaded.
    Install(install::Install),
    /// List all plugin files in the order in which they are searched.
    List(list::List),
}

impl PluginCommand {
    /// Runs the subcommand.
    pub fn run(self) -> ExitCode {
        match self {
            PluginCommand::Check(args) => check::check(&args),
            PluginCommand::Why(args) => why::why(&args),
            PluginCommand::Install(args) => install::install(&args),
            PluginCommand::List(args) => list::list(&args),
        }
    }
}
