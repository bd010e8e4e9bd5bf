//! Add-ons: scripts of the session, in a folder `addons`, found without any menu.
//!
//! - [`Flags`]: what the command line says of them;
//! - `find`: which folders are searched, and what is an add-on;
//! - `name`: what a file's name means; `about`: what its text declares;
//! - `wanted`: `--addon NAME:KEY=VALUE,...`;
//! - `start`: asking whether they start by themselves, and attaching them to a world.

mod about;
mod find;
mod name;
mod start;
mod wanted;

use std::path::PathBuf;

pub use find::find;
pub use start::{Started, choose, replayed, starts_by_itself};

/// What a command line says of add-ons.
#[derive(Clone, clap::Args, Default)]
pub struct Flags {
    /// Start an add-on by its name or file, with options: `NAME`, `FILE:KEY=VALUE,KEY=VALUE`.
    #[arg(long = "addon", value_name = "NAME|FILE")]
    pub addons: Vec<String>,
    /// Start no add-on but those that `--addon` names.
    #[arg(long)]
    pub no_addons: bool,
    /// Leave out this add-on, by its name; may be given several times.
    #[arg(long = "no-addon", value_name = "NAME")]
    pub without: Vec<String>,
}

/// How a text is called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// By functions, one for each callback.
    Callbacks,
    /// As a whole, with a variable that says why.
    CallType,
    /// Once, when it is started.
    Function,
}

impl Style {
    /// For people.
    pub fn text(self) -> &'static str {
        match self {
            Style::Callbacks => "callbacks",
            Style::CallType => "call type",
            Style::Function => "function",
        }
    }
}

/// Whether an add-on starts by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// Its name or manifest says so.
    ByItself,
    /// Only by `--addon`.
    ByName,
    /// Its script is asked.
    Asked,
}

/// An add-on that was found.
#[derive(Debug, Clone)]
pub struct AddOn {
    /// What `--addon` takes.
    pub name: String,
    /// Its script.
    pub file: PathBuf,
    /// Index of its language.
    pub language: usize,
    /// The version that it was written for; empty: from its text.
    pub dialect: String,
    /// How its text is called.
    pub style: Style,
    /// Whether it starts by itself.
    pub start: Start,
    /// What it does: the first line of its comment.
    pub about: String,
}
