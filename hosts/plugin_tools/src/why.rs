//! `tatu plugin why`: explains why a plugin is loaded, or why it is not.

use std::{path::PathBuf, process::ExitCode};

use tatu_core::document::SourceFiles;

use super::{answer, examine::FileExaminer, folders, probe, show};
use tatu_embed::search::search_folders;
use tatu_terminal::report;

#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct WhyArgs {
    /// A plugin's id, the name of its library in any form, or a file: a path that contains a `/`.
    #[arg(value_name = "NAME|FILE", required_unless_present = "probe")]
    pub what: Option<PathBuf>,
    /// A scene whose plugin folders are searched too.
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// `plugins`: load plugins from the folders that the scene names.
    #[arg(long, value_name = "WHAT", value_delimiter = ',', value_parser = ["plugins"])]
    pub allow: Vec<String>,
    /// Print a JSON object.
    #[arg(long)]
    pub json: bool,
    /// Seconds of real time after which a plugin that has not started is abandoned; 0: never.
    #[arg(long, value_name = "S", default_value_t = 10.0, value_parser = probe::limit)]
    pub watchdog: f64,
    /// Load only this file, and print the result; used by `why` for its child process.
    #[arg(long, hide = true, value_name = "FILE")]
    pub probe: Option<PathBuf>,
}

const EXAMPLES: &str = "Examples:
  tatu plugin why hello                  the plugin whose file is libtatu_hello.so
  tatu plugin why org.example.hello      the plugin with this id
  tatu plugin why build/libtatu_hello.so this file

Exit code 0: it is loaded; 1: it is not.";

/// Prints the explanation; the exit code is 0 if the plugin is loaded, 1 if not, and 2 if the scene cannot be read.
pub fn why(args: &WhyArgs) -> ExitCode {
    if let Some(file) = &args.probe {
        return probe::run(file, args.watchdog);
    }
    let folders = match search_folders(args.scene.as_deref(), &SourceFiles::default(), &args.allow) {
        Ok(all) => all,
        Err(e) => {
            report::error(&e);
            return ExitCode::from(2);
        }
    };
    let what = args.what.clone().unwrap_or_default();
    let folders = folders::list_folders(&folders);
    let mut examiner = FileExaminer::new(args.watchdog);
    let is_file = what.components().count() > 1;
    let answer = match is_file {
        true => answer::search_file(&what, folders, &mut examiner),
        false => answer::search_name(&what.to_string_lossy(), folders, &mut examiner),
    };
    if args.json {
        report::out!("{}", serde_json::to_string_pretty(&show::json(&answer)).unwrap_or_default());
    } else {
        show::print(&answer);
    }
    if answer.verdict.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
