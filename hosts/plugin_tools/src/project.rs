//! The folder of a plugin, and its settings in `tatu.toml`.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use tatu_core::errors::{Error, Result, SourceLocation};
use tatu_plugin_api::safe::{MAX_FILE_BYTES, read_plain_text};
use tatu_terminal::report;

use crate::new::{Lang, sdk, value_name};

/// Name of the file with a project's settings.
pub const SETTINGS_FILE: &str = "tatu.toml";
/// Name of the scene with which a project is checked.
pub const SCENE_FILE: &str = "scene.toml";

/// The folder of a plugin, created by `tatu new plugin`.
pub struct Project {
    /// The path of the folder.
    pub folder: PathBuf,
    /// The base name of the library: `hello` for `libtatu_hello.so`.
    pub name: String,
    /// The programming language of the plugin.
    pub lang: Lang,
    /// The version of Tatu to which the SDK in the folder belongs.
    pub sdk: String,
}

impl Project {
    /// Reads the settings of a folder. Fails with E611 if they are missing or invalid.
    pub fn open(folder: &Path) -> Result<Self> {
        let file = folder.join(SETTINGS_FILE);
        let text = read_plain_text(&file, MAX_FILE_BYTES).map_err(|e| {
            Error::new("E611", format!("{} is not the folder of a plugin: {e}", folder.display()))
                .expected(format!("a file {SETTINGS_FILE}, as `tatu new plugin` writes it"))
                .help("pass its folder (`tatu plugin build FOLDER`), or create one: `tatu new plugin NAME --lang c`")
        })?;
        let place = |line| SourceLocation { file: file.clone(), line, ..SourceLocation::default() };
        let wrong = |text: String| Error::new("E611", text).at(Some(place(0)));
        let settings: toml_edit::DocumentMut = text.parse().map_err(|e: toml_edit::TomlError| {
            let line = e.span().map_or(0, |s| text[..s.start].matches('\n').count() + 1);
            Error::new("E611", format!("{SETTINGS_FILE} cannot be read: {}", e.message())).at(Some(place(line)))
        })?;
        let get = |key: &str| {
            let value = settings.get(key).and_then(toml_edit::Item::as_str).map(str::to_owned);
            value.ok_or_else(|| wrong(format!("{SETTINGS_FILE} has no key `{key}`, or its value is not a string")))
        };
        let (name, lang) = (get("name")?, get("lang")?);
        // The name becomes part of file names.
        if name.is_empty() || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            return Err(wrong(format!("`{name}` is not a valid name")).expected("letters, digits and `_`"));
        }
        let known: Vec<String> = Lang::value_variants().iter().map(|l| value_name(*l)).collect();
        let lang = Lang::from_str(&lang, false).map_err(|_| {
            wrong(format!("unknown language `{lang}`"))
                .expected(known.join(", "))
                .nearest(&lang, known.iter().map(String::as_str))
        })?;
        let project = Project { folder: folder.to_owned(), name, lang, sdk: get("sdk")? };
        if project.sdk != sdk::VERSION {
            report::note(&format!(
                "the SDK in {} is from Tatu {}, but this is Tatu {}: `tatu plugin update-sdk` updates it",
                folder.display(),
                project.sdk,
                sdk::VERSION
            ));
        }
        Ok(project)
    }

    /// Returns the folder in which the library is built.
    pub fn build(&self) -> PathBuf {
        self.folder.join("build")
    }

    /// Returns the path of the library.
    pub fn library(&self) -> PathBuf {
        self.build().join(self.library_name())
    }

    /// Returns the file name of the library.
    pub fn library_name(&self) -> String {
        format!("{}tatu_{}{}", std::env::consts::DLL_PREFIX, self.name, std::env::consts::DLL_SUFFIX)
    }
}
