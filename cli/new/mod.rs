//! `tatu new`: folders to begin with.
//!
//! - `choice`: what can be made;
//! - `name`: which names are taken, and how they get into the files;
//! - `files`: the files of a folder, written only where nothing is;
//! - `sdk`: what plugins are built with, and the templates, embedded in the program;
//! - `plugin`: the folder of a plugin; `others`: of an add-on, a scene, a robot.

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
    /// An add-on: a script that any run can start beside its scene.
    Addon(Named),
    /// A scene with a robot and its script.
    Scene(Named),
    /// A robot without code: a folder that scenes use as a model, and scenes that do so.
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
