//! Entries that consist of several objects: models, imports, scenes used as models.

use std::{collections::BTreeMap, path::Path};

use nalgebra::Isometry3;
use tatu_errors::{Error, Place, Result};
use tatu_plugin_api::safe::Value;
use tatu_plugins::{Choice, Declared};
use toml_edit::TableLike;

use super::{
    super::{Builder, import, keys, scripts},
    Reader, canonical, table_span,
};

const IMPORT_KEYS: &[&str] =
    &["file", "importer", "alias", "parent", "position_m", "orientation_deg", "quaternion", "script", "scripts", "set"];

/// Maximum nesting depth of scenes. Without it, a chain of n files that each include the next one twice would give 2^n
/// scenes.
const DEEPEST: usize = 16;
/// Maximum number of scenes within a scene.
const MOST_SCENES: usize = 20_000;

const MODEL_KEYS: &[&str] =
    &["model", "file", "alias", "parent", "position_m", "orientation_deg", "quaternion", "script", "scripts", "set"];

impl Reader<'_> {
    pub(super) fn model(&mut self, b: &mut Builder<'_>, table: &dyn TableLike, parent: Option<usize>) -> Result {
        let key = if table.contains_key("file") { "file" } else { "model" };
        let Some(item) = table.get(key).filter(|_| key == "model" || !table.contains_key("model")) else {
            return Err(Error::new("E104", "a [[model]] has either `model` or `file`")
                .expected("model = \"<id>\", or file = \"<name>\" of a model that was saved")
                .at(Some(self.text.place(table_span(table)))));
        };
        let id = self.string(table, key, item)?;
        let at = Some(self.text.value(table, key));
        if key == "file" && !id.ends_with(".toml") {
            return self.import(b, table, parent);
        }
        let placement = self.placement(table)?;
        let parent = self.parent(b, table, parent)?;
        if id.ends_with(".toml") {
            return self.included(b, table, &id, placement, parent, at);
        }
        let index = self.registry.model(&id, &b.document.settings.providers).map_err(|e| e.at(at.clone()))?;
        let model = &self.registry.models[index];
        let params = self.params(b, table, &model.params, ("model", &id), MODEL_KEYS)?;
        let base = b.model(index, &params, parent, placement).map_err(|e| e.at(at))?;
        self.finish(b, table, base)
    }

    /// Reads an `[[import]]`: a file of another format, placed like a model.
    pub(super) fn import(&mut self, b: &mut Builder<'_>, table: &dyn TableLike, parent: Option<usize>) -> Result {
        let Some(item) = table.get("file") else {
            return Err(Error::new("E104", "an [[import]] without `file`")
                .expected("file = \"<name>\"")
                .at(Some(self.text.place(table_span(table)))));
        };
        let name = self.string(table, "file", item)?;
        let at = self.text.value(table, "file");
        let placement = self.placement(table)?;
        let parent = self.parent(b, table, parent)?;
        let file = self.text.file.parent().unwrap_or(Path::new("")).join(&name);
        let bytes = import::source(&file, &name, &b.document.sources).map_err(|e| e.at(Some(at.clone())))?;
        let providers = &b.document.settings.providers;
        let choice = match table.get("importer") {
            Some(item) => {
                let id = self.string(table, "importer", item)?;
                let found = self.registry.importer(&id, providers);
                let importer = found.map_err(|e| e.at(Some(self.text.value(table, "importer"))))?;
                Choice { importer, notes: Vec::new() }
            }
            None => {
                let found = self.registry.importer_of(&file, &bytes, providers).map_err(|e| e.at(Some(at.clone())))?;
                found.ok_or_else(|| self.registry.no_importer(Path::new(&name)).at(Some(at.clone())))?
            }
        };
        let info = &self.registry.importers[choice.importer];
        let params = self.params(b, table, &info.params, ("importer", &info.id), IMPORT_KEYS)?;
        let import = import::Import { file: &file, bytes: &bytes, choice, params: &params, whole: false };
        let base = b.import(import, parent, placement).map_err(|e| e.at(Some(at)))?;
        self.finish(b, table, base)
    }

    /// Returns the parameters that a table specifies for a model or importer, and those set for it on the command line.
    pub(super) fn params(
        &self,
        b: &Builder<'_>,
        table: &dyn TableLike,
        declared: &[Declared],
        (what, id): (&str, &str),
        own: &[&str],
    ) -> Result<Vec<(String, Value)>> {
        let declared: Vec<(Declared, ())> = declared.iter().map(|p| (p.clone(), ())).collect();
        let mut params = Vec::new();
        for (key, item) in table.iter().filter(|(k, _)| !own.contains(k)) {
            let owner = format!("the {what} `{id}`");
            let (entry, factor) = keys::find(key, &declared, &owner).map_err(|e| {
                let also = own.join(", ");
                let expected = e.expected.clone().map_or(also.clone(), |x| format!("{x}; of every {what}: {also}"));
                // A misspelt key may be one of the keys that all of them have.
                let e = if e.help.is_none() { e.nearest(key, own.iter().copied()) } else { e };
                Error { expected: Some(expected), ..e }.at(Some(self.text.key(table, key)))
            })?;
            let place = || Some(self.text.value(table, key));
            let value = keys::to_value(item, factor).map_err(|e| e.at(place()))?;
            let value = keys::check(&entry.0, key, value).map_err(|e| e.at(place()))?;
            params.push((entry.0.key.clone(), value));
        }
        let number = b.document.models.len();
        params
            .extend(self.model_params.iter().filter(|(n, _, _)| *n == number).map(|(_, k, v)| (k.clone(), v.clone())));
        Ok(params)
    }

    /// Reads a scene file as a model: its objects are placed below a new base.
    pub(super) fn included(
        &mut self,
        b: &mut Builder<'_>,
        table: &dyn TableLike,
        id: &str,
        placement: Isometry3<f64>,
        parent: Option<usize>,
        at: Option<Place>,
    ) -> Result {
        let file = self.text.file.parent().unwrap_or(Path::new("")).join(id);
        let full = canonical(&file);
        if self.chain.contains(&full) {
            let chain: Vec<String> = self.chain.iter().chain([&full]).map(|p| p.display().to_string()).collect();
            return Err(Error::new("E106", format!("the model `{id}` contains itself"))
                .expected("models without a cycle")
                .help(format!("the chain is {}", chain.join(" > ")))
                .at(at));
        }
        b.document.scenes_within += 1;
        if self.chain.len() >= DEEPEST || b.document.scenes_within > MOST_SCENES {
            return Err(Error::new("E124", format!("the model `{id}` exceeds the limits of nested scenes"))
                .expected(format!("scenes nested at most {DEEPEST} deep, and at most {MOST_SCENES} of them"))
                .at(at));
        }
        let text = b.document.sources.read_text(&file).map_err(|e| {
            Error::new("E105", format!("cannot read the model `{id}`: {e}"))
                .expected(format!("a file {}", file.display()))
                .at(at)
        })?;
        let alias = Path::new(id).file_stem().map_or("model".into(), |s| s.to_string_lossy().into_owned());
        let group = b.document.new_group();
        let outer = std::mem::replace(&mut b.group, group);
        let base = b.object("dummy", parent, &alias)?;
        b.document.objects[base].placement = placement;
        b.set(base, "model_base", Value::Bool(true))?;
        let mut inner = Reader {
            text: keys::Text::new(&file, &text),
            registry: self.registry,
            model_params: &[],
            set: Vec::new(),
            chain: self.chain.iter().cloned().chain([full]).collect(),
            meshes: BTreeMap::new(),
        };
        inner.file(b, Some(base), false)?;
        self.set.append(&mut inner.set);
        b.group = outer;
        if let Some((key, _)) = table.iter().find(|(k, _)| !MODEL_KEYS.contains(k)) {
            return Err(Error::new("E101", format!("unknown key `{key}`: a scene file has no parameters"))
                .expected(MODEL_KEYS.join(", "))
                .at(Some(self.text.key(table, key))));
        }
        self.finish(b, table, base)
    }

    /// Applies the keys that every model may have: an alias, scripts, changed properties.
    pub(super) fn finish(&mut self, b: &mut Builder<'_>, table: &dyn TableLike, base: usize) -> Result {
        if let Some(item) = table.get("alias") {
            b.rename(base, &self.string(table, "alias", item)?);
        }
        scripts::read(&self.text, b, table, base)?;
        if let Some(set) = table.get("set") {
            let set = set
                .as_table_like()
                .ok_or_else(|| Error::new("E102", "`set` is not a table").at(Some(self.text.key(table, "set"))))?;
            self.overrides(set, Some(base))?;
        }
        Ok(())
    }
}
