//! Services requested by a scene or on the command line.

use std::{collections::BTreeMap, path::Path};

use tatu_errors::{Error, Result, SourceLocation};
use tatu_plugin_api::safe::Value;
use tatu_plugins::{ParameterSpec, Registry, check_value};
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
        let (id, rest) = text.split_once(':').unwrap_or((text, ""));
        let mut params = Vec::new();
        for part in rest.split(',').filter(|p| !p.trim().is_empty()) {
            let Some((key, value)) = part.split_once('=').filter(|(k, _)| !k.trim().is_empty()) else {
                return Err(Error::new("E102", format!("`{part}` in `{text}` is not of the form KEY=VALUE"))
                    .expected("ID:KEY=VALUE,KEY=VALUE")
                    .help("for instance `jsonl:port=7000`"));
            };
            let value = value
                .trim()
                .parse::<toml_edit::Value>()
                .map(Item::Value)
                .unwrap_or_else(|_| Item::Value(toml_edit::Value::from(value)));
            params.push((key.trim().to_owned(), value));
        }
        Ok(ServiceOverride { id: id.trim().to_owned(), params })
    }
}

/// The user's own settings: defaults for parameters of services, such as ports and devices of the user's machine. They
/// do not affect the results of a simulation.
#[derive(Debug, Clone, Default)]
pub struct UserSettings {
    /// Parameters by id of the service: the key and TOML value as written, and their source location.
    services: BTreeMap<String, Vec<(String, Item, SourceLocation)>>,
}

impl UserSettings {
    /// Parses the text of a settings file, which has a table `[service.ID]` for each service.
    pub fn parse(file: &Path, text: &str) -> Result<Self> {
        let reader = SourceText::new(file, text);
        let document = toml_edit::Document::parse(text).map_err(|e| {
            Error::new("E100", format!("not a TOML file: {}", e.message())).at(Some(reader.place(e.span())))
        })?;
        let mut services = BTreeMap::new();
        for (key, item) in document.iter() {
            let wrong = |text: String| Error::new("E101", text).expected("[service.ID] with parameters of the service");
            let table = item.as_table_like().filter(|_| key == "service");
            let table = table.ok_or_else(|| wrong(format!("unknown key `{key}` in the user's settings")));
            for (id, item) in table.map_err(|e| e.at(Some(reader.key(document.as_table(), key))))?.iter() {
                let Some(params) = item.as_table_like() else {
                    return Err(wrong(format!("`service.{id}` is not a table")).at(Some(reader.place(item.span()))));
                };
                let params = params.iter().map(|(k, v)| (k.to_owned(), v.clone(), reader.key(params, k))).collect();
                services.insert(id.to_owned(), params);
            }
        }
        Ok(UserSettings { services })
    }
}

/// Sets parameters of services from the user's settings, unless the scene or the command line has set them.
pub(super) fn apply_user_settings(document: &mut Document, registry: &Registry, settings: &UserSettings) -> Result {
    for spec in &mut document.requests.services {
        let id = &registry.services[spec.kind].id;
        for (key, item, place) in settings.services.get(id).into_iter().flatten() {
            let found = read_param(registry, spec.kind, key, item).map_err(|e| e.at(Some(place.clone())))?;
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
    let declared: Vec<(ParameterSpec, ())> = info.params.iter().map(|p| (p.clone(), ())).collect();
    let (entry, factor) = keys::find(key, &declared, &format!("the service `{}`", info.id))?;
    let value = keys::to_value(item, factor)?;
    let value = check_value(&entry.0, value).map_err(|e| Error::new("E102", format!("`{key}`: {e}")))?;
    Ok((entry.0.key.clone(), value))
}
