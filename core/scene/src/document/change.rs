//! Overrides of properties and scripts, as written in a file or on the command line.

use std::path::PathBuf;

use tatu_errors::{Error, Result, SourceLocation};
use toml_edit::Item;

use super::reach::AllowedFolders;

/// An override of a property.
#[derive(Debug, Clone)]
pub struct PropertyOverride {
    /// Index of the object that relative paths start from; `None` for the world.
    pub from: Option<usize>,
    /// Path of the object, or "scene", or "file" for the parameters of the importer that reads the file.
    pub path: String,
    /// Key, including its unit.
    pub key: String,
    /// The TOML value, in the unit of the key.
    pub item: Item,
    /// The source location; `None` for an override from the command line.
    pub place: Option<SourceLocation>,
    /// The files that the value may name; `None` for those that the scene may name.
    pub(super) reach: Option<AllowedFolders>,
}

/// The path that denotes the file itself, if an importer reads it: its keys are the parameters of the importer.
pub(super) const IMPORTED_FILE: &str = "file";

impl PropertyOverride {
    /// Parses "PATH.KEY=VALUE". The value is parsed as TOML; a value that is not valid TOML is taken as a string.
    pub fn parse(text: &str) -> Result<Self> {
        let wrong = || {
            Error::new("E102", format!("`{text}` is not a setting"))
                .expected("PATH.PROPERTY=VALUE")
                .help("for instance `/Robot/leftMotor.max_force_nm=2`, or `scene.dt_s=0.01`")
        };
        let (left, value) = text.split_once('=').ok_or_else(wrong)?;
        // Names of settings and paths of objects can both contain dots.
        let scene = left.split_once('.').filter(|(path, _)| matches!(path.trim(), "scene" | IMPORTED_FILE));
        let (path, key) = scene.or_else(|| left.rsplit_once('.')).ok_or_else(wrong)?;
        let item = value
            .trim()
            .parse::<toml_edit::Value>()
            .map(Item::Value)
            .unwrap_or_else(|_| Item::Value(toml_edit::Value::from(value)));
        Ok(PropertyOverride {
            from: None,
            path: path.trim().into(),
            key: key.trim().into(),
            item,
            place: None,
            reach: None,
        })
    }
}

/// A script that replaces all scripts of an object.
#[derive(Debug, Clone)]
pub struct ScriptOverride {
    /// Path of the object that owns the scripts.
    pub path: String,
    /// Path of the script file.
    pub file: PathBuf,
}

impl ScriptOverride {
    /// Parses "OBJECT=FILE".
    pub fn parse(text: &str) -> Result<Self> {
        let (path, file) = text.split_once('=').ok_or_else(|| {
            Error::new("E102", format!("`{text}` does not specify an object and a file")).expected("OBJECT=FILE")
        })?;
        Ok(ScriptOverride { path: path.into(), file: file.into() })
    }
}
