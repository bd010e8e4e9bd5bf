//! Scripts in scene files.

use std::{collections::BTreeSet, path::Path};

use tatu_errors::{Error, Result, SourceLocation};
use tatu_plugins::ScriptLanguage;
use toml_edit::{Item, TableLike};

use super::{DocumentBuilder, PRIORITIES, SCRIPT_KINDS, ScriptSpec, keys::SourceText};

/// Reads `script = "file"`, `script = { ... }` and `scripts = [ ... ]`.
pub(super) fn read(text: &SourceText<'_>, b: &mut DocumentBuilder<'_>, table: &dyn TableLike, owner: usize) -> Result {
    for key in ["script", "scripts"] {
        let Some(item) = table.get(key) else { continue };
        let place = text.value(table, key);
        scripts(text, b, owner, item, place)?;
    }
    Ok(())
}

/// Reads a value of `script` or `scripts` that is written outside the object's own table, as an override.
pub(super) fn read_item(
    b: &mut DocumentBuilder<'_>,
    owner: usize,
    item: &Item,
    place: Option<SourceLocation>,
) -> Result {
    let place = place.unwrap_or_default();
    let file = place.file.clone();
    // Positions within the value are unknown; errors refer to the location of the whole value.
    scripts(&SourceText::new(&file, ""), b, owner, item, place)
}

fn scripts(
    text: &SourceText<'_>,
    b: &mut DocumentBuilder<'_>,
    owner: usize,
    item: &Item,
    place: SourceLocation,
) -> Result {
    match item {
        Item::Value(toml_edit::Value::Array(list)) => {
            list.iter().try_for_each(|v| script(text, b, owner, &Item::Value(v.clone()), place.clone()))
        }
        item => script(text, b, owner, item, place),
    }
}

fn script(
    source: &SourceText<'_>,
    b: &mut DocumentBuilder<'_>,
    owner: usize,
    item: &Item,
    place: SourceLocation,
) -> Result {
    let (text_of, mut dialect_at) = (source, place.clone());
    let mut file = item.as_str().map(str::to_owned);
    let (mut text, mut language, mut dialect, mut kind) = (None, None, String::new(), "child".to_owned());
    let (mut priority, mut side_by_side) = (crate::document::NORMAL_PRIORITY, false);
    if file.is_none() {
        let wanted = "a file name, or { file or text, language, dialect, kind, priority, side_by_side }";
        let wrong = |what: String| Error::new("E102", what).expected(wanted).at(Some(place.clone()));
        let table = item.as_table_like().ok_or_else(|| wrong("a script must be a string or a table".into()))?;
        for (key, item) in table.iter() {
            if key == "side_by_side" {
                side_by_side =
                    item.as_bool().ok_or_else(|| wrong("`side_by_side` of a script must be true or false".into()))?;
                continue;
            }
            let value = item.as_str().ok_or_else(|| wrong(format!("`{key}` of a script must be a string")))?.to_owned();
            match key {
                "file" => file = Some(value),
                "text" => text = Some(value.into_bytes()),
                "language" => language = Some(value),
                "dialect" => (dialect, dialect_at) = (value, text_of.value(table, key)),
                "kind" if SCRIPT_KINDS.contains(&value.as_str()) => kind = value,
                "kind" => {
                    let error = wrong(format!("unknown script kind `{value}`"));
                    return Err(error.expected(SCRIPT_KINDS.join(", ")).nearest(&value, SCRIPT_KINDS.iter().copied()));
                }
                "priority" => match PRIORITIES.iter().position(|p| *p == value) {
                    Some(n) => priority = n as u8,
                    None => {
                        let error = wrong(format!("unknown script priority `{value}`"));
                        return Err(error.expected(PRIORITIES.join(", ")).nearest(&value, PRIORITIES.iter().copied()));
                    }
                },
                other => {
                    let known = ["file", "text", "language", "dialect", "kind", "priority", "side_by_side"];
                    return Err(wrong(format!("unknown key `{other}` of a script")).nearest(other, known));
                }
            }
        }
    }
    let inline = text.is_some();
    let (name, text) = match (file, text) {
        (Some(file), None) => {
            let path = source.file.parent().unwrap_or(Path::new("")).join(&file);
            let allowed = b.allow_file(&path, &file).map_err(|e| e.at(Some(place.clone())))?;
            let bytes = b.document.sources.read(&allowed).map_err(|e| {
                Error::new("E105", format!("cannot read the script `{file}`: {e}"))
                    .expected(format!("a file {}", path.display()))
                    .at(Some(place.clone()))
            })?;
            // The path of a stored file is what the stored document claims.
            if b.reach.contains(&path) {
                b.document.add_modules(&path);
            }
            (path.display().to_string(), bytes)
        }
        (None, Some(text)) => (b.document.objects[owner].alias.clone(), text),
        _ => {
            return Err(Error::new("E104", "a script must have either `file` or `text`, not both")
                .expected("`file` or `text`")
                .at(Some(place)));
        }
    };
    let id = match &language {
        Some(id) => id,
        None if inline => {
            let inferred = inferred_language(&b.registry.scripting.languages, &text);
            inferred.map_err(|e| e.at(Some(place.clone())))?.unwrap_or(&name)
        }
        None => &name,
    };
    let index = b.registry.language(id, &b.document.settings.providers).map_err(|e| e.at(Some(place.clone())))?;
    b.registry.check_dialect(Some(index), &dialect).map_err(|e| e.at(Some(dialect_at)))?;
    b.script(owner, ScriptSpec { language: index, dialect, kind, priority, side_by_side, name, text })
        .map_err(|e| e.at(Some(place)))
}

/// Returns the language of a script without a file that does not specify its language: the one whose id is the first
/// line of the text, as a comment; otherwise the only one whose scripts need no permission. Returns `None` if no language
/// is loaded, and fails if there are several.
fn inferred_language<'l>(languages: &'l [ScriptLanguage], text: &[u8]) -> Result<Option<&'l str>> {
    let line = text.split(|b| *b == b'\n').next().unwrap_or_default().trim_ascii();
    let word = &line[line.iter().position(|b| !b.is_ascii_punctuation()).unwrap_or(line.len())..];
    if word.len() < line.len()
        && let Some(named) = languages.iter().find(|l| l.id.as_bytes() == word.trim_ascii())
    {
        return Ok(Some(&named.id));
    }
    let free = languages.iter().any(|l| l.permission.is_none());
    let ids: BTreeSet<&str> =
        languages.iter().filter(|l| !free || l.permission.is_none()).map(|l| l.id.as_str()).collect();
    if ids.len() < 2 {
        return Ok(ids.first().copied());
    }
    let ids: Vec<_> = ids.iter().map(|id| format!("`{id}`")).collect();
    Err(Error::new("E109", "a script without a file must specify its language, as several languages are loaded")
        .expected(format!("`language = ...`, one of {}", ids.join(", "))))
}
