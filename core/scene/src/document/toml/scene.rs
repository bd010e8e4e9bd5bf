//! `[scene]`, `[permissions]` and `[providers]`.

use std::collections::BTreeSet;

use tatu_errors::{Error, Result};
use tatu_plugin_api::safe::Value;
use tatu_plugins::ParameterSpec;
use toml_edit::TableLike;

use super::{
    super::{Document, SourceFiles, WorldSettings, keys, settings},
    SceneFileReader, naming,
};

impl SceneFileReader<'_> {
    /// Checks that a provider offers the role that it is selected for: a schema of readings, an id, or a file suffix of
    /// a language or importer.
    pub(super) fn check_provider(&self, key: &str, value: &str, sources: &SourceFiles) -> Result {
        let plugin = |i: usize| self.registry.plugins[i].id.as_str();
        let sensors = self.registry.sensors.iter().filter(|s| s.id == key || s.schemas.iter().any(|x| x == key));
        let actuators = self.registry.actuators.iter().filter(|a| a.id == key);
        let importers = self.registry.importers.iter().filter(|i| i.id == key || i.suffixes.iter().any(|x| x == key));
        let models = self.registry.model_offers.models.iter().filter(|m| m.id == key);
        let found = naming::find_model_file(key, self.registry, sources).and_then(|file| self.plugin_for(&file));
        let services = self.registry.services.iter().filter(|s| s.id == key);
        let languages =
            self.registry.scripting.languages.iter().filter(|l| l.id == key || l.suffixes.iter().any(|x| x == key));
        let offers: Vec<&str> = sensors
            .flat_map(|s| [s.id.as_str(), plugin(s.plugin)])
            .chain(languages.flat_map(|l| [l.id.as_str(), plugin(l.plugin)]))
            .chain(importers.flat_map(|i| [i.id.as_str(), plugin(i.plugin)]))
            .chain(actuators.map(|a| plugin(a.plugin)))
            .chain(models.map(|m| plugin(m.plugin)))
            .chain(found.into_iter().map(plugin))
            .chain(services.map(|s| plugin(s.plugin)))
            .collect();
        if offers.contains(&value) {
            return Ok(());
        }
        let error = Error::new("E113", format!("`{value}` does not provide `{key}`"));
        let roles: BTreeSet<&str> = (self.registry.sensors.iter().flat_map(|s| &s.schemas))
            .chain(self.registry.scripting.languages.iter().flat_map(|l| l.suffixes.iter().chain([&l.id])))
            .chain(self.registry.importers.iter().flat_map(|i| &i.suffixes))
            .map(String::as_str)
            .collect();
        Err(match offers.is_empty() {
            true => error
                .expected(format!("a role that a plugin offers: {}", Vec::from_iter(roles.iter().copied()).join(", ")))
                .nearest(key, roles.iter().copied()),
            false => error.expected(format!("one of {}", offers.join(", "))).nearest(value, offers.iter().copied()),
        })
    }

    pub(super) fn scene(&self, table: &dyn TableLike, settings: &mut WorldSettings, top: bool) -> Result {
        self.settings(table, "", settings, top)
    }

    /// Reads `[permissions]`, which lists the permissions that the scene requests. Only the user who runs it can grant
    /// them.
    pub(super) fn permissions(&self, table: &dyn TableLike, document: &mut Document) -> Result {
        let words = self.registry.permissions();
        const ADDRESS_FORM: &str = "an array of strings of the form \"HOST:PORT\"; `*` stands for any host or any port";
        for (key, item) in table.iter() {
            let wrong = |expected: &str| {
                let error = Error::new("E102", format!("invalid value of the permission `{key}`"));
                Err(error.expected(expected).at(Some(self.text.value(table, key))))
            };
            match (key, item.as_bool(), item.as_array()) {
                (word, Some(asked), _) if words.contains(&word) => {
                    document.requests.requested_permissions.extend(asked.then(|| key.to_owned()))
                }
                (word, ..) if words.contains(&word) => return wrong("true or false"),
                ("net", _, Some(all)) => {
                    for one in all {
                        let Some(place) = one.as_str().filter(|s| s.contains(':') && !s.contains(',')) else {
                            return wrong(ADDRESS_FORM);
                        };
                        document.requests.requested_permissions.push(format!("net={place}"));
                    }
                }
                ("net", ..) => return wrong(ADDRESS_FORM),
                _ => {
                    let known: Vec<&str> = words.iter().copied().chain(["net"]).collect();
                    return Err(Error::new("E101", format!("unknown permission `{key}`"))
                        .expected(known.join(", "))
                        .nearest(key, known)
                        .at(Some(self.text.key(table, key))));
                }
            }
        }
        Ok(())
    }

    /// Reads a table of settings; `within` is the prefix of its keys. The settings are applied only if `top` is set.
    fn settings(&self, table: &dyn TableLike, within: &str, settings: &mut WorldSettings, top: bool) -> Result {
        let declared = settings::keys();
        for (key, item) in table.iter().filter(|(key, _)| !(within.is_empty() && *key == "data")) {
            if let (Some(inner), "", true) = (item.as_table_like(), within, settings::TABLES.contains(&key)) {
                self.settings(inner, &format!("{key}."), settings, top)?;
                continue;
            }
            let place = || Some(self.text.value(table, key));
            let owner = match within.strip_suffix('.') {
                None => "[scene]".to_owned(),
                Some(table) => format!("[scene.{table}]"),
            };
            let known: Vec<_> = declared
                .iter()
                .filter_map(|(d, ())| match within {
                    "" if d.key.contains('.') => None,
                    _ => Some((ParameterSpec { key: d.key.strip_prefix(within)?.to_owned(), ..d.clone() }, ())),
                })
                .collect();
            let (entry, factor) = keys::find(key, &known, &owner).map_err(|e| e.at(Some(self.text.key(table, key))))?;
            let name = format!("{within}{}", entry.0.key);
            let value = keys::to_value(item, factor).map_err(|e| e.at(place()))?;
            let value = keys::check(&entry.0, key, value).map_err(|e| e.at(place()))?;
            if let ("dialect", Value::Text(t)) = (entry.0.key.as_str(), &value) {
                let dialect = String::from_utf8_lossy(t);
                self.registry.check_dialect(None, &dialect).map_err(|e| e.at(place()))?;
            }
            if top {
                settings::apply(settings, &name, &value).map_err(|e| e.at(place()))?;
            }
        }
        Ok(())
    }
}
