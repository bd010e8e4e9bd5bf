//! The command line as a library: the program `tatu` is nothing else, and the Python package contains it.

mod addons;
mod args;
mod card;
mod commands;
#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod crash;
mod graphs;
mod new;
mod plot;
mod plugin;
mod report;
mod scripts;
mod state;
mod table;
mod trace;
mod values;
mod watchdog;

use std::{ffi::OsString, process::ExitCode};

use clap::Parser;

pub use commands::generate::python_type;

/// Parses a command line, whose first argument names the program, runs its command, and returns its exit code.
///
/// It acts as the owner of the process: handlers of signals and crashes are installed, and arguments that are wrong end
/// the process with a message. It is meant to be called once.
pub fn main(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    let args = args::Args::parse_from(args);
    report::listen();
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    crash::listen();
    let code = report::finish(match args.command {
        args::Command::Run(run) => commands::run::run(&run),
        args::Command::Serve(serve) => commands::serve::serve(&serve),
        args::Command::Open(open) => commands::serve::open(open),
        args::Command::Check(check) => commands::check::check(&check),
        args::Command::Convert(convert) => commands::convert::convert(&convert),
        args::Command::Describe(describe) => commands::describe::describe(&describe),
        args::Command::List(list) => commands::list::list(&list),
        args::Command::Measure(measure) => commands::measure::measure(&measure),
        args::Command::Sweep(sweep) => commands::sweep::sweep(&sweep),
        args::Command::Look(look) => commands::look::look(&look),
        args::Command::Lock(lock) => commands::lock::lock(&lock).unwrap_or_else(|e| {
            report::error(&e);
            std::process::ExitCode::from(2)
        }),
        args::Command::Diff(diff) => commands::diff::diff(&diff),
        args::Command::New(new) => new::new(&new),
        args::Command::Plugin(plugin) => plugin.run(),
        args::Command::Generate(generate) => commands::generate::generate(&generate),
    });
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    let code = crash::end(code);
    code
}

/// Returns the number of an exit code that [`main`] has returned.
pub fn number(code: ExitCode) -> u8 {
    // `ExitCode` does not tell its number; the commands return only these.
    (0..=u8::MAX).find(|n| ExitCode::from(*n) == code).unwrap_or(1)
}

/// Reports crashes of this process from now on: the plugin, its function and the object.
pub fn report_crashes() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    crash::listen();
}
