//! Settings of script languages, from a scene, the command line and the user's own settings.

use std::path::{Path, PathBuf};

use tatu_errors::{Error, Result};
use tatu_plugin_api::{abi::TATU_PARAM_PROGRAM, safe::Value};
use tatu_plugins::{ParameterSpec, Registry};
use toml_edit::{Item, TableLike};

use super::{
    Document, LanguageSetting,
    keys::{self, SourceText},
    services::{UserSettings, assignments},
};

/// Settings of a language on the command line: `ID:KEY=VALUE,KEY=VALUE`.
#[derive(Debug, Clone)]
pub struct LanguageOverride {
    id: String,
    params: Vec<(String, Item)>,
}

impl LanguageOverride {
    /// Parses settings. A value is parsed as TOML; a value that is not valid TOML is taken as a string.
    pub fn parse(text: &str) -> Result<Self> {
        let (id, params) = assignments(text)?;
        if params.is_empty() {
            return Err(Error::new("E102", format!("`{text}` sets nothing")).expected("ID:KEY=VALUE,KEY=VALUE"));
        }
        Ok(LanguageOverride { id, params })
    }
}

/// Reads the table `[language]` of a scene file, which contains a table for each language.
pub(super) fn read(
    text: &SourceText<'_>,
    registry: &Registry,
    table: &dyn TableLike,
    found: &mut Vec<LanguageSetting>,
) -> Result {
    for (id, item) in table.iter() {
        let language = find(registry, id).map_err(|e| e.at(Some(text.key(table, id))))?;
        let Some(params) = item.as_table_like() else {
            return Err(Error::new("E102", format!("`language.{id}` is not a table"))
                .expected(format!("[language.{id}]"))
                .at(Some(text.value(table, id))));
        };
        for (key, item) in params.iter() {
            let (key, value) = param(registry, language, key, item).map_err(|e| {
                let at = if e.code == "E102" { text.value(params, key) } else { text.key(params, key) };
                e.at(Some(at))
            })?;
            found.push(LanguageSetting { language, key, value, is_of_scene: true });
        }
    }
    Ok(())
}

/// Applies the settings of a command line, which take precedence over those of the scene.
pub(super) fn apply(document: &mut Document, registry: &Registry, given: &[LanguageOverride]) -> Result {
    for one in given {
        let language = find(registry, &one.id)?;
        for (key, item) in &one.params {
            let (key, value) = param(registry, language, key, item)?;
            document.requests.languages.push(LanguageSetting { language, key, value, is_of_scene: false });
        }
    }
    Ok(())
}

/// Applies the user's own settings, unless the scene or the command line has set the same. Settings of languages that no
/// plugin offers have no effect.
pub(super) fn apply_user_settings(document: &mut Document, registry: &Registry, settings: &UserSettings) -> Result {
    for (id, key, item, place) in settings.of_languages() {
        let Some(language) = position(registry, id) else { continue };
        let (key, value) = param(registry, language, key, item).map_err(|e| e.at(place.cloned()))?;
        let all = &mut document.requests.languages;
        if all.iter().all(|s| (s.language, &s.key) != (language, &key)) {
            all.push(LanguageSetting { language, key, value, is_of_scene: false });
        }
    }
    Ok(())
}

impl Document {
    /// Returns a value for each setting that a language declares, in the order of declaration.
    pub fn language_params(&self, registry: &Registry, language: usize) -> Vec<Value> {
        let set = |p: &ParameterSpec| {
            let mut all = self.requests.languages.iter().rev();
            all.find(|s| s.language == language && s.key == p.key)
        };
        let value = |p: &ParameterSpec| match set(p) {
            Some(s) if p.flags & TATU_PARAM_PROGRAM != 0 => self.program(s),
            Some(s) => s.value.clone(),
            None => p.fallback.clone(),
        };
        registry.scripting.languages[language].params.iter().map(value).collect()
    }

    /// Returns the absolute path of a program, unless the setting is a name without a folder.
    fn program(&self, setting: &LanguageSetting) -> Value {
        let Some(given) = text_of(&setting.value).map(PathBuf::from).filter(|p| p.components().count() > 1) else {
            return setting.value.clone();
        };
        let folder = self.file.as_deref().and_then(Path::parent).filter(|_| setting.is_of_scene);
        let path = folder.unwrap_or(Path::new("")).join(&given);
        Value::text(std::path::absolute(&path).unwrap_or(path).to_string_lossy().as_ref())
    }
}

fn text_of(value: &Value) -> Option<String> {
    match value {
        Value::Text(text) => String::from_utf8(text.clone()).ok(),
        _ => None,
    }
}

fn position(registry: &Registry, id: &str) -> Option<usize> {
    registry.scripting.languages.iter().position(|l| l.id == id)
}

fn find(registry: &Registry, id: &str) -> Result<usize> {
    position(registry, id).ok_or_else(|| {
        let known: Vec<&str> = registry.scripting.languages.iter().map(|l| l.id.as_str()).collect();
        Error::new("E101", format!("there is no script language `{id}`")).expected(known.join(", ")).nearest(id, known)
    })
}

fn param(registry: &Registry, language: usize, key: &str, item: &Item) -> Result<(String, Value)> {
    let language = &registry.scripting.languages[language];
    keys::param(&language.params, &format!("the language `{}`", language.id), key, item)
}
