//! Services requested by a scene or on the command line.

use std::{collections::BTreeMap, path::Path};

use tatu_errors::{Error, Result, SourceLocation};
use tatu_plugin_api::safe::Value;
use tatu_plugins::Registry;
use toml_edit::{Item, TableLike};

use super::{
    Document, ServiceSpec,
    keys::{self, SourceText},
};

/// A service on the command line: `ID` or `ID:KEY=VALUE,KEY=VALUE`.
#[derive(Debug, Clone)]
pub struct ServiceOverride {
    id: String,
    params: Vec<(String, Item)>,
}

impl ServiceOverride {
    /// Creates an override with a single string parameter.
    pub fn with_text(id: &str, key: &str, text: &str) -> Self {
        ServiceOverride { id: id.to_owned(), params: vec![(key.to_owned(), Item::Value(text.into()))] }
    }
    /// Parses an override. A value is parsed as TOML; a value that is not valid TOML is taken as a string.
    pub fn parse(text: &str) -> Result<Self> {
        let (id, params) = assignments(text).map_err(|e| e.help("for instance `jsonl:port=7000`"))?;
        Ok(ServiceOverride { id, params })
    }
}

/// Parses `ID` or `ID:KEY=VALUE,KEY=VALUE`. A value is parsed as TOML; a value that is not valid TOML is taken as a string.
pub(super) fn assignments(text: &str) -> Result<(String, Vec<(String, Item)>)> {
    let (id, rest) = text.split_once(':').unwrap_or((text, ""));
    let mut params = Vec::new();
    for part in rest.split(',').filter(|p| !p.trim().is_empty()) {
        let Some((key, value)) = part.split_once('=').filter(|(k, _)| !k.trim().is_empty()) else {
            return Err(Error::new("E102", format!("`{part}` in `{text}` is not of the form KEY=VALUE"))
                .expected("ID:KEY=VALUE,KEY=VALUE"));
        };
        let value = value
            .trim()
            .parse::<toml_edit::Value>()
            .map(Item::Value)
            .unwrap_or_else(|_| Item::Value(toml_edit::Value::from(value)));
        params.push((key.trim().to_owned(), value));
    }
    Ok((id.trim().to_owned(), params))
}

/// Parameters by id of a service or language: the key and TOML value as written, and their source location.
type ParamsById = BTreeMap<String, Vec<(String, Item, Option<SourceLocation>)>>;

/// The user's own settings: defaults for parameters of services and script languages, such as ports, devices and
/// programs of the user's machine.
#[derive(Debug, Clone, Default)]
pub struct UserSettings {
    services: ParamsById,
    languages: ParamsById,
}

impl UserSettings {
    /// Adds a default for a parameter of a language, unless there is one already.
    pub fn add_language_default(&mut self, id: &str, key: &str, text: &str) {
        let params = self.languages.entry(id.to_owned()).or_default();
        if params.iter().all(|(k, ..)| k != key) {
            params.push((key.to_owned(), Item::Value(text.into()), None));
        }
    }

    /// Returns the settings of languages: id, key, value and source location.
    pub(super) fn of_languages(&self) -> impl Iterator<Item = (&str, &str, &Item, Option<&SourceLocation>)> {
        let all = self.languages.iter().flat_map(|(id, params)| params.iter().map(move |param| (id, param)));
        all.map(|(id, (key, item, place))| (id.as_str(), key.as_str(), item, place.as_ref()))
    }

    /// Parses the text of a settings file, which has a table `[service.ID]` for each service and a table `[language.ID]`
    /// for each script language.
    pub fn parse(file: &Path, text: &str) -> Result<Self> {
        let reader = SourceText::new(file, text);
        let document = toml_edit::Document::parse(text).map_err(|e| {
            Error::new("E100", format!("not a TOML file: {}", e.message())).at(Some(reader.place(e.span())))
        })?;
        let mut settings = UserSettings::default();
        for (key, item) in document.iter() {
            let wrong =
                |text: String| Error::new("E101", text).expected("[service.ID] or [language.ID], with parameters");
            let of_kind = match key {
                "service" => Some(&mut settings.services),
                "language" => Some(&mut settings.languages),
                _ => None,
            };
            let Some((table, of_kind)) = item.as_table_like().zip(of_kind) else {
                let place = reader.key(document.as_table(), key);
                return Err(wrong(format!("unknown key `{key}` in the user's settings")).at(Some(place)));
            };
            for (id, item) in table.iter() {
                let Some(params) = item.as_table_like() else {
                    return Err(wrong(format!("`{key}.{id}` is not a table")).at(Some(reader.place(item.span()))));
                };
                let param = |(k, v): (&str, &Item)| (k.to_owned(), v.clone(), Some(reader.key(params, k)));
                of_kind.insert(id.to_owned(), params.iter().map(param).collect());
            }
        }
        Ok(settings)
    }
}

/// Sets parameters of services from the user's settings, unless the scene or the command line has set them.
pub(super) fn apply_user_settings(document: &mut Document, registry: &Registry, settings: &UserSettings) -> Result {
    for spec in &mut document.requests.services {
        let id = &registry.services[spec.kind].id;
        for (key, item, place) in settings.services.get(id).into_iter().flatten() {
            let found = read_param(registry, spec.kind, key, item).map_err(|e| e.at(place.clone()))?;
            if spec.params.iter().all(|(k, _)| *k != found.0) {
                spec.params.push(found);
            }
        }
    }
    Ok(())
}

/// Reads a `[[service]]` table of a scene file.
pub(super) fn read(
    text: &SourceText<'_>,
    registry: &Registry,
    providers: &BTreeMap<String, String>,
    table: &dyn TableLike,
    place: SourceLocation,
) -> Result<ServiceSpec> {
    let Some(id) = table.get("id").and_then(Item::as_str) else {
        return Err(Error::new("E104", "a [[service]] has no `id`")
            .expected("id = \"<service>\"")
            .help("`tatu list services` shows the available services")
            .at(Some(place)));
    };
    let kind = registry.service(id, providers).map_err(|e| e.at(Some(text.value(table, "id"))))?;
    let mut params = Vec::new();
    for (key, item) in table.iter().filter(|(k, _)| *k != "id") {
        let found = read_param(registry, kind, key, item).map_err(|e| {
            let at = if e.code == "E102" { text.value(table, key) } else { text.key(table, key) };
            e.at(Some(at))
        })?;
        params.push(found);
    }
    Ok(ServiceSpec { kind, params, place: Some(place) })
}

/// Applies the services of a command line: overrides parameters of those that the scene requests, and adds the others. A
/// service that is given again with another value of the same parameter, such as a port, is started once more.
pub(super) fn apply(document: &mut Document, registry: &Registry, given: &[ServiceOverride]) -> Result {
    let mut applied: Vec<(usize, Vec<(String, Value)>)> = Vec::new();
    for o in given {
        let kind = registry.service(&o.id, &document.settings.providers)?;
        let params =
            o.params.iter().map(|(key, item)| read_param(registry, kind, key, item)).collect::<Result<Vec<_>>>()?;
        let all = &mut document.requests.services;
        let differs =
            |before: &[(String, Value)]| params.iter().any(|(k, v)| before.iter().any(|(l, w)| k == l && v != w));
        let is_other = |i: usize| applied.iter().any(|(at, before)| *at == i && differs(before));
        let known = (0..all.len()).find(|i| all[*i].kind == kind && !is_other(*i));
        let at = known.unwrap_or(all.len());
        if known.is_none() {
            all.push(ServiceSpec { kind, params: Vec::new(), place: None });
        }
        all[at].params.extend(params.iter().cloned());
        applied.push((at, params));
    }
    Ok(())
}

fn read_param(registry: &Registry, kind: usize, key: &str, item: &Item) -> Result<(String, Value)> {
    let info = &registry.services[kind];
    keys::param(&info.params, &format!("the service `{}`", info.id), key, item)
}
