//! `tatu new`: creates folders from templates.
//!
//! - `choice`: the arguments;
//! - `name`: validates names, and inserts them into templates;
//! - `files`: writes the files of a folder without overwriting anything;
//! - `sdk`: the SDK for plugins and the templates, embedded in the program;
//! - `plugin`: creates the folder of a plugin; `others`: that of an add-on, a scene or a robot.

mod choice;
mod files;
mod name;
mod others;
mod plugin;
pub mod sdk;

use std::process::ExitCode;

use clap::Subcommand;

pub use choice::{Lang, word};
use choice::{Named, Plugin};

use crate::report;

#[derive(clap::Args)]
pub struct New {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// A plugin: source, build description, headers, and a scene that checks it.
    Plugin(Plugin),
    /// An add-on: a script that can be started in addition to any scene.
    Addon(Named),
    /// A scene with a robot and its script.
    Scene(Named),
    /// A robot without code: a model folder, and scenes that use it.
    Robot(Named),
}

/// Runs `tatu new`. Returns exit code 0, or 2 after an error.
pub fn new(args: &New) -> ExitCode {
    let made = match &args.what {
        What::Plugin(p) => plugin::plugin(p),
        What::Addon(n) => others::addon(n),
        What::Scene(n) => others::scene(n),
        What::Robot(n) => others::robot(n),
    };
    match made {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}
