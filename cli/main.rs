//! The program: parses the command line, runs a command, and returns its exit code.

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
mod search;
mod state;
mod table;
mod trace;
mod values;
mod watchdog;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    let args = args::Args::parse();
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
        args::Command::Look(look) => commands::look::look(&look),
        args::Command::Lock(lock) => commands::lock::lock(&lock).unwrap_or_else(|e| {
            report::error(&e);
            std::process::ExitCode::from(2)
        }),
        args::Command::Diff(diff) => commands::diff::diff(&diff),
        args::Command::New(new) => new::new(&new),
        args::Command::Plugin(plugin) => plugin.run(),
    });
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    let code = crash::end(code);
    code
}
