//! The folder of a plugin: what its `tatu.toml` says.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use tatu_core::errors::{Error, Place, Result};
use tatu_plugin_api::safe::{MOST_BYTES, read_plain_text};

use crate::{
    new::{Lang, sdk, word},
    report,
};

/// The file in it that says what it is.
pub const SETTINGS: &str = "tatu.toml";

/// A plugin's folder.
pub struct Project {
    /// The folder.
    pub folder: PathBuf,
    /// Its name, also of the library.
    pub name: String,
    /// What it is written in.
    pub lang: Lang,
    /// The version of Tatu that its SDK is from.
    pub sdk: String,
}

impl Project {
    /// Reads the settings of a folder.
    pub fn open(folder: &Path) -> Result<Self> {
        let file = folder.join(SETTINGS);
        let text = read_plain_text(&file, MOST_BYTES).map_err(|e| {
            Error::new("E611", format!("{} is not the folder of a plugin: {e}", folder.display()))
                .expected(format!("a file {SETTINGS}, as `tatu new plugin` writes it"))
                .help("give the folder: `tatu plugin build FOLDER`; or make one: `tatu new plugin NAME --lang c --kind sensor`")
        })?;
        let place = |line| Place { file: file.clone(), line, ..Place::default() };
        let wrong = |text: String| Error::new("E611", text).at(Some(place(0)));
        let settings: toml_edit::DocumentMut = text.parse().map_err(|e: toml_edit::TomlError| {
            let line = e.span().map_or(0, |s| text[..s.start].lines().count().max(1));
            Error::new("E611", format!("{SETTINGS} cannot be read: {}", e.message())).at(Some(place(line)))
        })?;
        let get = |key: &str| {
            let value = settings.get(key).and_then(toml_edit::Item::as_str).map(str::to_owned);
            value.ok_or_else(|| wrong(format!("{SETTINGS} has no text `{key}`")))
        };
        let (name, lang) = (get("name")?, get("lang")?);
        // It becomes part of file names.
        if name.is_empty() || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            return Err(wrong(format!("`{name}` is no name")).expected("letters, digits and `_`"));
        }
        let known: Vec<String> = Lang::value_variants().iter().map(|l| word(*l)).collect();
        let lang = Lang::from_str(&lang, false).map_err(|_| {
            wrong(format!("unknown language `{lang}`"))
                .expected(known.join(", "))
                .nearest(&lang, known.iter().map(String::as_str))
        })?;
        let project = Project { folder: folder.to_owned(), name, lang, sdk: get("sdk")? };
        if project.sdk != sdk::VERSION {
            report::note(&format!(
                "the SDK in {} is of Tatu {}, this is {}: `tatu plugin update-sdk` replaces it",
                folder.display(),
                project.sdk,
                sdk::VERSION
            ));
        }
        Ok(project)
    }

    /// The folder of the library.
    pub fn build(&self) -> PathBuf {
        self.folder.join("build")
    }

    /// The library.
    pub fn library(&self) -> PathBuf {
        self.build().join(self.library_name())
    }

    /// The name of its file.
    pub fn library_name(&self) -> String {
        format!("{}tatu_{}{}", std::env::consts::DLL_PREFIX, self.name, std::env::consts::DLL_SUFFIX)
    }
}
