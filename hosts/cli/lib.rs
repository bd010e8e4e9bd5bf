//! The command line as a library, which is used by the program `tatu` and by the Python package.

mod addons;
mod args;
mod card;
mod child_run;
mod commands;
mod graphs;
mod hashes;
mod plot;
mod scripts;
mod state;
mod test_args;
mod trace;
mod values;

use std::{ffi::OsString, process::ExitCode};

use clap::Parser;
use tatu_plugin_tools::new;
use tatu_terminal::report;

pub use commands::generate::python_type;

/// Parses a command line, whose first argument is the name of the program, runs its command, and returns its exit code.
///
/// Installs handlers for signals and crashes in the process, and exits with a message if an argument is invalid. Must
/// be called at most once per process.
pub fn main(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    let args = args::CliArgs::parse_from(args);
    tatu_terminal::report::install_log_printer();
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    tatu_terminal::crash::install_handlers();
    let code = report::finish(match args.command {
        args::Command::Run(run) => commands::run::run(&run),
        args::Command::Serve(serve) => commands::serve::serve(&serve),
        args::Command::Open(open) => commands::serve::open(open),
        args::Command::Check(check) => commands::check::check(&check),
        args::Command::Convert(convert) => commands::convert::convert(&convert),
        args::Command::Pack(pack) => commands::pack::pack(&pack),
        args::Command::Unpack(unpack) => commands::pack::unpack(&unpack),
        args::Command::Verify(verify) => commands::verify::verify(&verify),
        args::Command::Test(test) => commands::test::test(&test),
        args::Command::Grade(grade) => commands::grade::grade(&grade),
        args::Command::Import(import) => commands::import::import(&import),
        args::Command::Export(export) => commands::export::export(&export),
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
        args::Command::Of(words) => commands::subcommand::subcommand(&words),
        args::Command::New(new) => new::new(&new),
        args::Command::Plugin(plugin) => plugin.run(),
        args::Command::Generate(generate) => commands::generate::generate(&generate),
    });
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    let code = tatu_terminal::crash::limit_exit_time(code);
    code
}

/// Returns the numeric value of an exit code returned by [`main`].
pub fn number(code: ExitCode) -> u8 {
    // `ExitCode` has no accessor for its value.
    (0..=u8::MAX).find(|n| ExitCode::from(*n) == code).unwrap_or(1)
}

/// Installs handlers that report crashes of this process, with the plugin, its function and the object.
pub fn report_crashes() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    tatu_terminal::crash::install_handlers();
}
