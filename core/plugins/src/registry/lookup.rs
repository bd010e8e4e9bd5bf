//! Lookup by name: resolves names that several plugins claim, and reports unknown names.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::PathBuf,
};

use tatu_errors::{Error, Result, nearest, with_article};

use super::{Registry, ScriptLanguage, SensorKind};

impl Registry {
    /// Returns the id of the command with a name, from 1, and the index of the name among those of the command.
    pub fn command(&self, name: &str) -> Option<(u32, u32)> {
        self.command_offers.names.get(name).copied()
    }
    /// Returns whether the name of any command or constant begins with a prefix.
    pub fn has_namespace(&self, prefix: &str) -> bool {
        let from = prefix.to_owned();
        self.command_offers.names.range(from.clone()..).next().is_some_and(|(n, _)| n.starts_with(prefix))
            || self.scripting.constants.range(from..).next().is_some_and(|(n, _)| n.starts_with(prefix))
    }
    /// Chooses among several plugins that offer the same name. A scene's `[providers]` selects one by the plugin's id.
    pub(super) fn choose(
        &self,
        what: &str,
        id: &str,
        claims: &[(usize, usize)],
        providers: &BTreeMap<String, String>,
    ) -> Result<Option<usize>> {
        let plugin = |claim: &(usize, usize)| self.plugins[claim.1].id.as_str();
        // The provider may be the id itself, which does not select a plugin.
        if let Some(wanted) = providers.get(id).filter(|w| *w != id) {
            return Ok(claims.iter().find(|c| plugin(c) == wanted).map(|c| c.0));
        }
        let [first, second, ..] = claims else { return Ok(claims.first().map(|c| c.0)) };
        let file = |c: &(usize, usize)| self.plugins[c.1].path.display().to_string();
        let text = format!(
            "two plugins offer the {what} `{id}`: `{}` ({}) and `{}` ({})",
            plugin(first),
            file(first),
            plugin(second),
            file(second)
        );
        let help = format!("choose one: [providers] \"{id}\" = \"{}\"", plugin(first));
        Err(Error::new("E322", text).expected("one plugin, named in [providers]").help(help))
    }
    /// Returns the index of a model by id, or `None` if the model in a folder is to be used. `found` is the index of
    /// the plugin that would read the model in the folder, if there is such a folder.
    pub fn model(&self, id: &str, found: Option<usize>, providers: &BTreeMap<String, String>) -> Result<Option<usize>> {
        let of_id = self.model_offers.models.iter().enumerate().filter(|(_, m)| m.id == id);
        let mut claims: Vec<_> = of_id.map(|(i, m)| (i, m.plugin)).collect();
        claims.extend(found.map(|plugin| (usize::MAX, plugin)));
        match self.choose("model", id, &claims, providers)? {
            Some(usize::MAX) => Ok(None),
            Some(index) => Ok(Some(index)),
            None => {
                let found = self.found_models();
                let known =
                    self.model_offers.models.iter().map(|m| m.id.as_str()).chain(found.iter().map(|f| f.id.as_str()));
                Err(self.unknown("E107", "model", id, &known.collect::<Vec<_>>()))
            }
        }
    }
    /// Returns the kinds of sensors with their indices, without the readings of actuators.
    pub fn sensor_kinds(&self) -> impl Iterator<Item = (usize, &SensorKind)> {
        self.sensors.iter().enumerate().filter(|(_, s)| !s.of_actuator)
    }
    /// Returns the index of a kind of sensor by id or by schema. For a schema, this is the kind that `[providers]`
    /// selects, otherwise the first kind that claims the schema.
    pub fn sensor(&self, id_or_schema: &str, providers: &BTreeMap<String, String>) -> Result<usize> {
        let of_id = |id: &str| -> Vec<(usize, usize)> {
            self.sensor_kinds().filter(|(_, s)| s.id == id).map(|(i, s)| (i, s.plugin)).collect()
        };
        if let Some(i) = self.choose("kind of sensor", id_or_schema, &of_id(id_or_schema), providers)? {
            return Ok(i);
        }
        let wanted = providers.get(id_or_schema);
        let fills = |s: &&SensorKind| !s.of_actuator && s.schemas.iter().any(|x| x == id_or_schema);
        let mut found = self
            .sensors
            .iter()
            .filter(fills)
            .filter(|s| wanted.is_none_or(|w| *w == s.id || *w == self.plugins[s.plugin].id));
        let known = || -> Vec<_> {
            let schemas = self.sensor_kinds().flat_map(|(_, s)| &s.schemas);
            let known: BTreeSet<_> =
                self.sensor_kinds().map(|(_, s)| &s.id).chain(schemas).map(String::as_str).collect();
            known.into_iter().collect()
        };
        let found = found.next().ok_or_else(|| self.unknown("E108", "sensor kind", id_or_schema, &known()))?;
        if wanted.is_some_and(|w| *w != found.id) {
            return Ok(self.sensors.iter().position(|s| std::ptr::eq(s, found)).unwrap_or_default());
        }
        let chosen = self.choose("kind of sensor", &found.id, &of_id(&found.id), providers)?;
        chosen.ok_or_else(|| self.unknown("E108", "sensor kind", id_or_schema, &known()))
    }
    /// Returns the permissions without a value that a user can grant to the scripts of a run: those that the host knows,
    /// and those that languages need.
    pub fn permissions(&self) -> Vec<&str> {
        let needed = self.scripting.languages.iter().filter_map(|l| l.permission.as_deref());
        let mut all: Vec<&str> = ["exec", "native"].into_iter().chain(needed).collect();
        all.sort_unstable();
        all.dedup();
        all
    }
    /// Returns the index of a script language by id or by file name. For an id or a suffix, `[providers]` can select a
    /// language or a plugin instead of the first match.
    pub fn language(&self, id_or_file: &str, providers: &BTreeMap<String, String>) -> Result<usize> {
        let key = |l: &ScriptLanguage| match l.id == id_or_file {
            true => Some(l.id.clone()),
            false => l.suffixes.iter().find(|s| id_or_file.ends_with(s.as_str())).cloned(),
        };
        let all = || self.scripting.languages.iter().enumerate();
        let answering: Vec<(usize, &ScriptLanguage, String)> =
            all().filter_map(|(i, l)| key(l).map(|key| (i, l, key))).collect();
        let wanted = providers.get(id_or_file).or_else(|| answering.iter().find_map(|(_, _, key)| providers.get(key)));
        if let Some((i, ..)) = answering.iter().find(|(_, l, _)| wanted == Some(&self.plugins[l.plugin].id)) {
            return Ok(*i);
        }
        let id = wanted.or(answering.first().map(|(_, l, _)| &l.id)).map_or(id_or_file, String::as_str);
        let claims: Vec<_> = all().filter(|(_, l)| l.id == id).map(|(i, l)| (i, l.plugin)).collect();
        self.choose("script language", id, &claims, providers)?.ok_or_else(|| {
            let known: Vec<_> = self.scripting.languages.iter().map(|l| l.id.as_str()).collect();
            self.unknown("E109", "script language", id_or_file, &known)
        })
    }

    /// Returns the rejected file that most likely contains something with this name: one whose error mentions it, one
    /// with a similar name, or the only one.
    fn closest(&self, name: &str) -> Option<&(PathBuf, String)> {
        let named = |(_, why): &&(PathBuf, String)| why.contains(&format!("`{name}`"));
        let holds = |(file, _): &&(PathBuf, String)| stem(file).contains(name) || name.contains(&stem(file));
        let near = |(file, _): &&(PathBuf, String)| nearest(name, [stem(file).as_str()]).is_some();
        let mut all = self.load_report.rejected_files.iter();
        all.clone().find(named).or_else(|| all.clone().find(holds)).or_else(|| all.clone().find(near)).or_else(|| {
            let first = all.next()?;
            all.all(|(file, _)| *file == first.0).then_some(first)
        })
    }

    /// Returns the error for an unknown name. It suggests the nearest name or, if no plugin offers anything of this
    /// kind, lists the searched folders.
    pub(super) fn unknown(&self, code: &'static str, what: &str, name: &str, known: &[&str]) -> Error {
        let mut text = format!("there is no {what} `{name}`");
        if let Some((file, why)) = self.closest(name) {
            let file = file.display().to_string();
            // The reason usually contains the file name already.
            let why = if why.contains(&file) { why.clone() } else { format!("{file}: {why}") };
            text += &format!("; the closest match was rejected: {why}");
        }
        let error = Error::new(code, text);
        if known.is_empty() {
            return error.expected(format!("a plugin that offers {what}s; none was found in{}", self.search.describe())).help(
                "build the plugins beside the program (`cargo build`), copy the program together with its libraries, or set TATU_PLUGIN_PATH to their folder",
            );
        }
        let error = match known.len() > MAX_LISTED_NAMES {
            true => {
                error.expected(format!("the id of {}: `tatu list {}` shows them", with_article(what), listing(what)))
            }
            false => error.expected(format!("one of {}", known.join(", "))),
        };
        match nearest(name, known.iter().copied()) {
            Some(near) => error.help(format!("did you mean `{near}`?")),
            None => error.help("`tatu list plugins` shows what was found and where"),
        }
    }
}

/// Maximum number of names that an error lists.
const MAX_LISTED_NAMES: usize = 30;

/// Returns the plugin's own part of a file name: "gripper" for "libtatu_gripper.so".
fn stem(path: &std::path::Path) -> String {
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let stem = stem.strip_prefix(std::env::consts::DLL_PREFIX).unwrap_or(&stem);
    stem.strip_prefix("tatu_").unwrap_or(stem).to_owned()
}

/// Returns the word by which `tatu list` shows what there is of a kind.
fn listing(what: &str) -> &'static str {
    match what {
        "model" => "models",
        "sensor kind" => "sensors",
        "actuator kind" => "actuators",
        "service" => "services",
        "importer" => "importers",
        _ => "plugins",
    }
}
