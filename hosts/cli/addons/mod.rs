//! Add-ons: scripts that run in addition to those of the scene, found in folders named `addons`.
//!
//! - [`AddonFlags`]: command-line options;
//! - `find`: searches folders for add-ons;
//! - `name`: parses file names; `declarations`: extracts declarations from the source;
//! - `request`: parses `--addon NAME:KEY=VALUE,...`;
//! - `start`: chooses the add-ons that run, and attaches them to a world.

mod declarations;
mod find;
mod name;
mod request;
mod start;

use std::path::PathBuf;

pub use find::find;
pub use start::{StartedAddons, choose_addons, replayed_addons, starts_by_itself};

/// Command-line options about add-ons.
#[derive(Clone, clap::Args, Default)]
pub struct AddonFlags {
    /// Start an add-on by its name or file, optionally with options: `NAME`, `FILE:KEY=VALUE,KEY=VALUE`.
    #[arg(long = "addon", value_name = "NAME|FILE")]
    pub addons: Vec<String>,
    /// Start only the add-ons that `--addon` names.
    #[arg(long)]
    pub no_addons: bool,
    /// Do not start this add-on, by its name; may be given several times.
    #[arg(long = "no-addon", value_name = "NAME")]
    pub without: Vec<String>,
}

/// How the script of an add-on is called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CallStyle {
    /// The script has a function for each callback.
    Callbacks,
    /// The whole script is run for each callback, with a variable that names the callback.
    CallType,
    /// The script is run once, when the add-on is started.
    Function,
}

impl CallStyle {
    /// Returns the name of the style that `tatu list addons` prints.
    pub fn text(self) -> &'static str {
        match self {
            CallStyle::Callbacks => "callbacks",
            CallStyle::CallType => "call type",
            CallStyle::Function => "function",
        }
    }
}

/// Whether an add-on starts automatically.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StartMode {
    /// It starts automatically, according to its name or manifest.
    Automatic,
    /// It starts only by `--addon`.
    OnRequest,
    /// The script's function `info` decides.
    ScriptDecides,
}

/// An add-on found in a folder.
#[derive(Debug, Clone)]
pub struct AddOn {
    /// The name that `--addon` accepts.
    pub name: String,
    /// The file of its script.
    pub file: PathBuf,
    /// Index of its script language in the registry.
    pub language: usize,
    /// Version of the API that the script was written for; if empty, it is inferred from the source.
    pub dialect: String,
    /// How the add-on's script is called.
    pub style: CallStyle,
    /// Whether the add-on starts automatically.
    pub start: StartMode,
    /// Description: `text` of the manifest, or the first line of the script's first comment.
    pub about: String,
}
