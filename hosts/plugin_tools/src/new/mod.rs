//! `tatu new`: creates folders from templates.
//!
//! - `choice`: the arguments;
//! - `name`: validates names, and inserts them into templates;
//! - `files`: writes the files of a folder without overwriting anything;
//! - `sdk`: the SDK for plugins and the templates, embedded in the program;
//! - `plugin`: creates the folder of a plugin; `templates`: that of an add-on, a scene or a robot.

mod choice;
mod files;
mod name;
mod plugin;
pub mod sdk;
mod templates;

use std::process::ExitCode;

use clap::Subcommand;

pub use choice::{Lang, value_name};
use choice::{NewItemArgs, NewPluginArgs};
use tatu_terminal::report;

/// What to create.
#[derive(clap::Args)]
pub struct NewArgs {
    #[command(subcommand)]
    what: NewItem,
}

#[derive(Subcommand)]
enum NewItem {
    /// A plugin: source, build description, headers, and a scene that checks it.
    Plugin(NewPluginArgs),
    /// An add-on: a script that can be started in addition to any scene.
    Addon(NewItemArgs),
    /// A scene with a robot and its script.
    Scene(NewItemArgs),
    /// A robot without code: a model folder, and scenes that use it.
    Robot(NewItemArgs),
    /// An exercise for a class: a scene, a script to start from, goals, and criteria for `tatu grade`.
    Course(NewItemArgs),
}

/// Runs `tatu new`. Returns exit code 0, or 2 after an error.
pub fn new(args: &NewArgs) -> ExitCode {
    let made = match &args.what {
        NewItem::Plugin(p) => plugin::plugin(p),
        NewItem::Addon(n) => templates::addon(n),
        NewItem::Scene(n) => templates::scene(n),
        NewItem::Robot(n) => templates::robot(n),
        NewItem::Course(n) => templates::course(n),
    };
    match made {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}
