//! What can be made: names, languages and kinds, as the command line has them.

use std::path::PathBuf;

use clap::ValueEnum;
use tatu_core::errors::Error;

/// What is to be made, and where.
#[derive(clap::Args)]
pub struct Named {
    /// Its name, of lower-case letters, digits and `_`; the folder is called so.
    pub name: String,
    /// The folder in which it is made [default: the working folder].
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub to: PathBuf,
}

#[derive(clap::Args)]
pub struct Plugin {
    #[command(flatten)]
    pub named: Named,
    /// The language that it is written in.
    #[arg(long, value_enum)]
    pub lang: Lang,
    /// What it offers.
    #[arg(long, value_enum)]
    pub kind: Kind,
}

/// A language of plugins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Lang {
    C,
    Cpp,
    Rust,
}

/// What a plugin offers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// Functions for scripts, remote clients and other plugins.
    Command,
    /// A kind of sensor.
    Sensor,
    /// A kind of actuator.
    Actuator,
    /// A robot, or another thing built of objects.
    Model,
    /// A file format.
    Importer,
    /// What runs beside worlds: a remote API, a bridge, a view.
    Service,
    /// A script language.
    Script,
}

/// A value as the command line and `tatu.toml` have it.
pub fn word(value: impl ValueEnum) -> String {
    value.to_possible_value().map(|v| v.get_name().to_owned()).unwrap_or_default()
}

/// Why nothing was made.
pub fn refused(text: impl Into<String>) -> Error {
    Error::new("E610", text)
}
