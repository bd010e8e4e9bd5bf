//! Entries that consist of several objects: models, imports and scenes used as models.

use std::path::{Path, PathBuf};

use nalgebra::Isometry3;
use tatu_errors::{Error, Result, SourceLocation};
use tatu_plugin_api::safe::Value;
use tatu_plugins::{ImporterChoice, Model, ParameterSpec};
use toml_edit::TableLike;

use super::{
    super::{DocumentBuilder, import, keys, reach::AllowedFolders},
    SceneFileReader, canonical,
    changes::MountSlot,
    models::ModelSource,
    table_span,
};

/// The given keys, which identify a model, followed by the keys that every model accepts.
macro_rules! common_keys {
    ($($key:literal),*) => {
        &[
            $($key,)* "alias", "parent", "position_m", "orientation_deg", "quaternion", "script", "scripts", "set",
            "remove", "replace", "slots", "name",
        ]
    };
}
const IMPORT_KEYS: &[&str] = common_keys!("file", "importer");
const MODEL_KEYS: &[&str] = common_keys!("model", "file");

/// Maximum nesting depth of scenes. Without limits, a chain of n files that each include the next one twice would
/// create 2^n scenes.
const MAX_SCENE_DEPTH: usize = 16;
/// Maximum number of models and scenes that are read from files within a scene.
const MAX_INCLUDED_SCENES: usize = 20_000;

impl SceneFileReader<'_> {
    /// Reads a table that places a model. `mounted` is the slot in which the model is mounted, if any. Returns the
    /// index of the model's base.
    pub(super) fn model(
        &mut self,
        b: &mut DocumentBuilder<'_>,
        table: &dyn TableLike,
        parent: Option<usize>,
        mounted: Option<MountSlot<'_>>,
    ) -> Result<usize> {
        let key = if table.contains_key("file") { "file" } else { "model" };
        let Some(item) = table.get(key).filter(|_| key == "model" || !table.contains_key("model")) else {
            return Err(Error::new("E104", "a [[model]] must have either `model` or `file`")
                .expected("model = \"<id>\", or file = \"<name>\" of a saved model")
                .at(Some(self.text.place(table_span(table)))));
        };
        let id = self.string(table, key, item)?;
        let at = Some(self.text.value(table, key));
        if key == "file" && !id.ends_with(".toml") {
            return self.import(b, table, parent);
        }
        let placement = self.placement(table)?;
        let parent = self.parent(b, table, parent)?;
        let (named, reach) = self.resolve_model(b, &id).map_err(|e| e.at(at.clone()))?;
        let model = match &named {
            ModelSource::Plugin(index) => &self.registry.model_offers.models[*index],
            ModelSource::Text(model) => model,
            ModelSource::Scene(file) => return self.include_scene(b, table, (&id, file), placement, parent, at),
            ModelSource::File(file) => return self.place_import(b, table, (&id, file, reach), "model", parent),
        };
        if let Some(mounted) = &mounted {
            mounted.check(model).map_err(|e| e.at(at.clone()))?;
        }
        let params = self.params(b, table, &model.params, ("model", &model.id), MODEL_KEYS)?;
        let base = self.build_model(b, (model, reach), &params, parent, placement, at)?;
        self.apply_common_keys(b, table, base, (&model.id, &model.slots))
    }

    /// Builds a model, which may name the files in `reach`. For an error in the text of the model, the help includes
    /// the location of the table that places the model.
    pub(super) fn build_model(
        &self,
        b: &mut DocumentBuilder<'_>,
        (model, reach): (&Model, AllowedFolders),
        params: &[(String, Value)],
        parent: Option<usize>,
        placement: Isometry3<f64>,
        at: Option<SourceLocation>,
    ) -> Result<usize> {
        let Some(file) = &model.file else {
            return b.model(model, params, parent, placement).map_err(|e| e.at(at));
        };
        self.enter_model_file(b, &model.id, file, at.clone())?;
        let outer = std::mem::replace(&mut b.reach, reach);
        let built = b.model(model, params, parent, placement);
        b.reach = outer;
        b.document.reading.open_files.pop();
        built.map_err(|e| {
            let inside = e.place.as_ref().is_some_and(|p| p.file != self.text.file);
            let from = at.as_ref().filter(|p| inside && p.line > 0);
            let from = from.map(|p| format!("`{}` is placed in {}:{}", model.id, p.file.display(), p.line));
            let e = match (e.help.clone(), from) {
                (_, None) => e,
                (None, Some(from)) => e.help(from),
                (Some(help), Some(from)) if help.ends_with('?') => e.help(format!("{help} {from}")),
                (Some(help), Some(from)) => e.help(format!("{help}; {from}")),
            };
            e.at(at)
        })
    }

    /// Records that the file of a model is being read. Fails if the file is already being read, which means that the
    /// model contains itself, or if the scene exceeds the limits of nested models.
    fn enter_model_file(
        &self,
        b: &mut DocumentBuilder<'_>,
        id: &str,
        file: &Path,
        at: Option<SourceLocation>,
    ) -> Result {
        let full = canonical(file);
        if b.document.reading.open_files.contains(&full) {
            let chain: Vec<String> =
                b.document.reading.open_files.iter().chain([&full]).map(|p| p.display().to_string()).collect();
            return Err(Error::new("E106", format!("the model `{id}` contains itself"))
                .expected("models without a cycle")
                .help(format!("the chain is {}", chain.join(" > ")))
                .at(at));
        }
        b.document.reading.included_scenes += 1;
        if b.document.reading.open_files.len() >= MAX_SCENE_DEPTH
            || b.document.reading.included_scenes > MAX_INCLUDED_SCENES
        {
            return Err(Error::new("E124", format!("the model `{id}` exceeds the limits of nested scenes"))
                .expected(format!(
                    "scenes nested at most {MAX_SCENE_DEPTH} deep, and at most {MAX_INCLUDED_SCENES} of them"
                ))
                .at(at));
        }
        b.document.reading.open_files.push(full);
        Ok(())
    }

    /// Reads an `[[import]]`: a file in another format, placed like a model.
    pub(super) fn import(
        &mut self,
        b: &mut DocumentBuilder<'_>,
        table: &dyn TableLike,
        parent: Option<usize>,
    ) -> Result<usize> {
        let Some(item) = table.get("file") else {
            return Err(Error::new("E104", "an [[import]] has no `file`")
                .expected("file = \"<name>\"")
                .at(Some(self.text.place(table_span(table)))));
        };
        let name = self.string(table, "file", item)?;
        let file = self.text.file.parent().unwrap_or(Path::new("")).join(&name);
        let parent = self.parent(b, table, parent)?;
        let reach = b.reach.clone();
        self.place_import(b, table, (&name, &file, reach), "file", parent)
    }

    /// Places a file in another format, which is in `reach` and may name the files in it. The value of `key` in the
    /// table is the name of the file.
    fn place_import(
        &mut self,
        b: &mut DocumentBuilder<'_>,
        table: &dyn TableLike,
        (name, file, reach): (&str, &PathBuf, AllowedFolders),
        key: &str,
        parent: Option<usize>,
    ) -> Result<usize> {
        let at = self.text.value(table, key);
        let placement = self.placement(table)?;
        let outer = std::mem::replace(&mut b.reach, reach);
        let bytes = import::read_import_file(b, file, name);
        let reach = std::mem::replace(&mut b.reach, outer);
        let bytes = bytes.map_err(|e| e.at(Some(at.clone())))?;
        let providers = &b.document.settings.providers;
        let choice = match table.get("importer") {
            Some(item) => {
                let id = self.string(table, "importer", item)?;
                let found = self.registry.importer(&id, providers);
                let importer = found.map_err(|e| e.at(Some(self.text.value(table, "importer"))))?;
                ImporterChoice { importer, notes: Vec::new() }
            }
            None => {
                let found = self.registry.importer_of(file, &bytes, providers).map_err(|e| e.at(Some(at.clone())))?;
                found.ok_or_else(|| self.registry.no_importer(Path::new(name)).at(Some(at.clone())))?
            }
        };
        let info = &self.registry.importers[choice.importer];
        let own = if key == "file" { IMPORT_KEYS } else { MODEL_KEYS };
        let params = self.params(b, table, &info.params, ("importer", &info.id), own)?;
        let import = import::ImportRequest { file, bytes: &bytes, choice, params: &params, is_scene: false };
        let outer = std::mem::replace(&mut b.reach, reach);
        let base = b.import(import, parent, placement);
        b.reach = outer;
        let base = base.map_err(|e| e.at(Some(at)))?;
        self.apply_common_keys(b, table, base, (name, &[]))
    }

    /// Returns the parameters that a table specifies for a model or importer, followed by those that overrides set for
    /// it.
    pub(super) fn params(
        &self,
        b: &DocumentBuilder<'_>,
        table: &dyn TableLike,
        declared: &[ParameterSpec],
        (what, id): (&str, &str),
        own: &[&str],
    ) -> Result<Vec<(String, Value)>> {
        let declared: Vec<(ParameterSpec, ())> = declared.iter().map(|p| (p.clone(), ())).collect();
        let mut params = Vec::new();
        for (key, item) in table.iter().filter(|(k, _)| !own.contains(k)) {
            let owner = format!("the {what} `{id}`");
            let (entry, factor) = keys::find(key, &declared, &owner).map_err(|e| {
                let also = own.join(", ");
                let expected = match e.expected.as_deref() {
                    None => also,
                    Some("") => format!("of every {what}: {also}"),
                    Some(x) => format!("{x}; of every {what}: {also}"),
                };
                // A misspelt key may be one of the common keys.
                let e = if e.help.is_none() { e.nearest(key, own.iter().copied()) } else { e };
                Error { expected: Some(expected), ..e }.at(Some(self.text.key(table, key)))
            })?;
            let place = || Some(self.text.value(table, key));
            let value = keys::to_value(item, factor).map_err(|e| e.at(place()))?;
            let value = keys::check(&entry.0, key, value).map_err(|e| e.at(place()))?;
            params.push((entry.0.key.clone(), value));
        }
        // The model of this table is the next one to be built, which determines its number.
        let number = b.document.reading.next_model;
        let changed = b.document.reading.model_params.iter().filter(|(n, _, _)| *n == number);
        params.extend(changed.map(|(_, k, v)| (k.clone(), v.clone())));
        Ok(params)
    }

    /// Reads a scene file as a model: its objects are placed below a new base.
    fn include_scene(
        &mut self,
        b: &mut DocumentBuilder<'_>,
        table: &dyn TableLike,
        (id, file): (&str, &PathBuf),
        placement: Isometry3<f64>,
        parent: Option<usize>,
        at: Option<SourceLocation>,
    ) -> Result<usize> {
        self.enter_model_file(b, id, file, at.clone())?;
        let allowed = b.allow_file(file, id).map_err(|e| e.at(at.clone()))?;
        let text =
            b.document.sources.read_text(&allowed).map_err(|e| super::naming::unreadable(id, file, &e).at(at))?;
        let alias = Path::new(id).file_stem().map_or("model".into(), |s| s.to_string_lossy().into_owned());
        let group = b.document.new_group();
        let outer = std::mem::replace(&mut b.group, group);
        let base = b.object("dummy", parent, &alias)?;
        b.document.objects[base].placement = placement;
        b.set(base, "model_base", Value::Bool(true))?;
        SceneFileReader::new(file, &text, self.registry).read_tables(b, Some(base), false)?;
        b.group = outer;
        b.document.reading.open_files.pop();
        if let Some((key, _)) = table.iter().find(|(k, _)| !MODEL_KEYS.contains(k)) {
            return Err(Error::new("E101", format!("unknown key `{key}`: a scene file has no parameters"))
                .expected(MODEL_KEYS.join(", "))
                .help("a file with a table [model] can declare parameters")
                .at(Some(self.text.key(table, key))));
        }
        self.apply_common_keys(b, table, base, (id, &[]))
    }
}
