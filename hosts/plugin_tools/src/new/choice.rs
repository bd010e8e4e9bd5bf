//! Arguments of `tatu new`: names, languages and kinds.

use std::path::PathBuf;

use clap::ValueEnum;
use tatu_core::errors::Error;

/// The name of the new folder, and where to create it.
#[derive(clap::Args)]
pub struct NewItemArgs {
    /// Name of the new item and of its folder: lower-case letters, digits and `_`.
    pub name: String,
    /// The folder in which the new folder is created [default: the working folder].
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub to: PathBuf,
}

#[derive(clap::Args)]
pub struct NewPluginArgs {
    #[command(flatten)]
    pub named: NewItemArgs,
    /// Programming language of the plugin.
    #[arg(long, value_enum)]
    pub lang: Lang,
    /// What the plugin provides.
    #[arg(long, value_enum, default_value = "command")]
    pub kind: ExtensionKind,
}

/// A programming language for which there are plugin templates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Lang {
    /// C11.
    C,
    /// C++17.
    Cpp,
    /// Rust.
    Rust,
}

/// The kind of extension that a plugin provides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ExtensionKind {
    /// Functions for scripts, remote clients and other plugins.
    Command,
    /// A kind of sensor.
    Sensor,
    /// A kind of actuator.
    Actuator,
    /// A controller of an object or of the world.
    Part,
    /// A robot or another subtree of objects.
    Model,
    /// A file format.
    Importer,
    /// A component that runs alongside worlds: a remote API, a bridge, a view.
    Service,
    /// A script language.
    Script,
}

/// Returns the spelling of a value on the command line and in `tatu.toml`.
pub fn value_name(value: impl ValueEnum) -> String {
    value.to_possible_value().map(|v| v.get_name().to_owned()).unwrap_or_default()
}

/// Returns an error that explains why the new folder is not created.
pub fn refused(text: impl Into<String>) -> Error {
    Error::new("E610", text)
}
