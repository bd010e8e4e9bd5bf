//! Scene files.
//!
//! `[scene]` holds the numbers of the world, `[[model]]` places models, `[[import]]` files of other formats, `[[object]]` single objects, `[set]` changes
//! properties by path, `[providers]` tells who is meant by a schema or language.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

use nalgebra::{Isometry3, Vector3};
use tatu_plugin_api::{abi::*, safe::Value};
use toml_edit::{Item, TableLike};

use super::{
    Builder, Document, Settings, import, keys,
    overrides::{self, Override, ScriptOverride},
    scripts,
    services::{self, ServiceOverride},
    settings,
    sources::Sources,
};
use crate::{
    error::{Error, Place, Result},
    host::{Choice, Declared, Registry},
    scene::{from_euler, pose_from_array, rows::KINDS},
};

/// What a run changes in a scene.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Seed, instead of the file's.
    pub seed: Option<u64>,
    /// `--set`
    pub set: Vec<Override>,
    /// `--script`
    pub scripts: Vec<ScriptOverride>,
    /// `--service`
    pub services: Vec<ServiceOverride>,
    /// Where files are read from; the disk by default.
    pub sources: Sources,
}

/// Folders with plugins that a scene names; looked up before anything else is read.
pub fn plugin_folders(file: &Path, sources: &Sources) -> Result<Vec<PathBuf>> {
    // A file of another format names none.
    let Ok(text) = String::from_utf8(read_bytes(file, sources)?) else { return Ok(Vec::new()) };
    let Ok(doc) = toml_edit::Document::parse(text.as_str()) else { return Ok(Vec::new()) };
    let here = file.parent().unwrap_or(Path::new(""));
    let list = doc.get("scene").and_then(|s| s.get("plugins")).and_then(Item::as_array);
    Ok(list.into_iter().flatten().filter_map(|v| v.as_str()).map(|s| here.join(s)).collect())
}

/// Reads a scene file into a document.
pub fn load(file: &Path, registry: &Registry, options: &Options) -> Result<Document> {
    // A property set on a model may be one of its parameters: then the model is built again with it.
    let mut model_params: Vec<(usize, String, Value)> = Vec::new();
    // Each round settles at least one of them; a scene has fewer than this.
    for _ in 0..10_000 {
        let (mut document, set) = Reader::read(file, registry, &model_params, &options.sources)?;
        if let Some(seed) = options.seed {
            document.settings.seed = seed;
        }
        let all: Vec<Override> = set.into_iter().chain(options.set.iter().cloned()).collect();
        match overrides::apply(&mut document, registry, &all, &model_params)? {
            Some(more) => model_params.push(more),
            None => {
                overrides::replace_scripts(&mut document, registry, &options.scripts)?;
                services::apply(&mut document, registry, &options.services)?;
                document.check()?;
                return Ok(document);
            }
        }
    }
    Err(Error::new("E102", "the settings of model parameters change which models there are"))
}

fn read_bytes(file: &Path, sources: &Sources) -> Result<Vec<u8>> {
    sources.read(file).map_err(|e| unreadable(file, &e.to_string()))
}

fn unreadable(file: &Path, why: &str) -> Error {
    Error::new("E105", format!("cannot read the scene {}: {why}", file.display()))
        .help("give the path of a scene file, for instance one in `scenes/`")
}

struct Reader<'a> {
    text: keys::Text<'a>,
    registry: &'a Registry,
    model_params: &'a [(usize, String, Value)],
    set: Vec<Override>,
    /// Files that are being read, outermost first: a scene used as a model must not contain itself.
    chain: Vec<PathBuf>,
}

impl<'a> Reader<'a> {
    fn read(
        file: &Path,
        registry: &'a Registry,
        model_params: &'a [(usize, String, Value)],
        sources: &Sources,
    ) -> Result<(Document, Vec<Override>)> {
        let mut document = Document { file: Some(file.to_owned()), sources: sources.clone(), ..Default::default() };
        let mut builder = Builder { registry, document: &mut document, group: 0, place: None };
        let bytes = read_bytes(file, sources)?;
        let named = file.extension().is_some_and(|e| e == "toml");
        let choice = if named { None } else { registry.importer_of(file, &bytes, &BTreeMap::new())? };
        if let Some(choice) = choice {
            let params = model_params.iter().map(|(_, k, v)| (k.clone(), v.clone())).collect::<Vec<_>>();
            builder.place = Some(Place { file: file.to_owned(), ..Default::default() });
            let import = import::Import { file, bytes: &bytes, choice, params: &params };
            builder.import(import, None, Isometry3::identity())?;
            return Ok((document, Vec::new()));
        }
        let text = String::from_utf8(bytes).map_err(|_| match named {
            true => unreadable(file, "it is not UTF-8 text"),
            false => registry.no_importer(file).help("a scene is a TOML file"),
        })?;
        let mut reader = Reader {
            text: keys::Text::new(file, &text),
            registry,
            model_params,
            set: Vec::new(),
            chain: vec![canonical(file)],
        };
        reader.file(&mut builder, None, true)?;
        let set = std::mem::take(&mut reader.set);
        Ok((document, set))
    }

    /// Reads the file at hand; objects without a parent go below `parent`.
    fn file(&mut self, b: &mut Builder<'_>, parent: Option<usize>, top: bool) -> Result {
        let doc = toml_edit::Document::parse(self.text.text).map_err(|e| {
            Error::new("E100", format!("not a TOML file: {}", e.message())).at(Some(self.text.place(e.span())))
        })?;
        let root = doc.as_table();
        const KNOWN: &[&str] = &["format", "scene", "providers", "service", "model", "import", "object", "set"];
        for (key, _) in root.iter() {
            if !KNOWN.contains(&key) {
                return Err(Error::new("E101", format!("unknown key `{key}`"))
                    .expected(KNOWN.join(", "))
                    .nearest(key, KNOWN.iter().copied())
                    .at(Some(self.text.key(root, key))));
            }
        }
        match root.get("format").and_then(Item::as_integer) {
            Some(1) => {}
            Some(n) => {
                return Err(Error::new("E102", format!("format {n} is not known"))
                    .expected("format = 1")
                    .at(Some(self.text.value(root, "format"))));
            }
            None => {
                return Err(Error::new("E104", "the file does not tell its format")
                    .expected("format = 1")
                    .help("write `format = 1` on top")
                    .at(Some(self.text.place(None))));
            }
        }
        if let Some(scene) = self.table(root, "scene")? {
            self.scene(scene, &mut b.document.settings, top)?;
        }
        if let Some(providers) = self.table(root, "providers")? {
            for (key, item) in providers.iter() {
                let value = self.string(providers, key, item)?;
                self.check_provider(key, &value).map_err(|e| e.at(Some(self.text.value(providers, key))))?;
                b.document.settings.providers.insert(key.to_owned(), value);
            }
        }
        for (what, table) in self.in_order(root)? {
            b.place = Some(self.text.place(table_span(table)));
            match what {
                "model" => self.model(b, table, parent)?,
                "import" => self.import(b, table, parent)?,
                _ => self.object(b, table, parent)?,
            };
        }
        if let Some(set) = self.table(root, "set")? {
            self.overrides(set, parent)?;
        }
        // What runs beside a world is the business of the scene, not of its models.
        for table in self.list(root, "service")?.into_iter().flatten().filter(|_| top) {
            let place = self.text.place(table_span(table));
            let spec = services::read(&self.text, self.registry, &b.document.settings.providers, table, place)?;
            if b.document.services.iter().any(|s| s.kind == spec.kind) {
                let text = format!("the service `{}` is asked for twice", self.registry.services[spec.kind].id);
                return Err(Error::new("E102", text).expected("one of each").at(spec.place));
            }
            b.document.services.push(spec);
        }
        Ok(())
    }

    fn list<'t>(&self, root: &'t toml_edit::Table, what: &str) -> Result<Option<&'t toml_edit::ArrayOfTables>> {
        match root.get(what) {
            None => Ok(None),
            Some(Item::ArrayOfTables(list)) => Ok(Some(list)),
            Some(_) => Err(Error::new("E102", format!("`{what}` is not a list of tables"))
                .expected(format!("[[{what}]]"))
                .at(Some(self.text.key(root, what)))),
        }
    }

    /// `[[model]]`, `[[import]]` and `[[object]]` in the order in which they stand, so that objects can hang on models
    /// and back.
    fn in_order<'t>(&self, root: &'t toml_edit::Table) -> Result<Vec<(&'static str, &'t dyn TableLike)>> {
        let mut out: Vec<(usize, &'static str, &dyn TableLike)> = Vec::new();
        for what in ["model", "import", "object"] {
            let list = self.list(root, what)?.into_iter().flatten();
            out.extend(list.map(|t| (t.span().map_or(0, |s| s.start), what, t as &dyn TableLike)));
        }
        out.sort_by_key(|(at, _, _)| *at);
        Ok(out.into_iter().map(|(_, w, t)| (w, t)).collect())
    }

    fn table<'t>(&self, root: &'t toml_edit::Table, key: &str) -> Result<Option<&'t dyn TableLike>> {
        match root.get(key) {
            None => Ok(None),
            Some(item) => item.as_table_like().map(Some).ok_or_else(|| {
                Error::new("E102", format!("`{key}` is not a table"))
                    .expected(format!("[{key}]"))
                    .at(Some(self.text.key(root, key)))
            }),
        }
    }

    /// Whether a provider offers what it is named for: a schema of readings, or the suffix of a language's files.
    fn check_provider(&self, key: &str, value: &str) -> Result {
        let plugin = |i: usize| self.registry.plugins[i].id.as_str();
        let sensors = self.registry.sensors.iter().filter(|s| s.id == key || s.schemas.iter().any(|x| x == key));
        let actuators = self.registry.actuators.iter().filter(|a| a.id == key);
        let importers = self.registry.importers.iter().filter(|i| i.id == key || i.suffixes.iter().any(|x| x == key));
        let models = self.registry.models.iter().filter(|m| m.id == key);
        let services = self.registry.services.iter().filter(|s| s.id == key);
        let languages = self.registry.languages.iter().filter(|l| l.id == key || l.suffixes.iter().any(|x| x == key));
        let offers: Vec<&str> = sensors
            .flat_map(|s| [s.id.as_str(), plugin(s.plugin)])
            .chain(languages.flat_map(|l| [l.id.as_str(), plugin(l.plugin)]))
            .chain(importers.flat_map(|i| [i.id.as_str(), plugin(i.plugin)]))
            .chain(actuators.map(|a| plugin(a.plugin)))
            .chain(models.map(|m| plugin(m.plugin)))
            .chain(services.map(|s| plugin(s.plugin)))
            .collect();
        if offers.contains(&value) {
            return Ok(());
        }
        let error = Error::new("E113", format!("`{value}` does not provide `{key}`"));
        let roles: BTreeSet<&str> = (self.registry.sensors.iter().flat_map(|s| &s.schemas))
            .chain(self.registry.languages.iter().flat_map(|l| l.suffixes.iter().chain([&l.id])))
            .chain(self.registry.importers.iter().flat_map(|i| &i.suffixes))
            .map(String::as_str)
            .collect();
        Err(match offers.is_empty() {
            true => error
                .expected(format!("what a loaded plugin offers: {}", Vec::from_iter(roles.iter().copied()).join(", ")))
                .nearest(key, roles.iter().copied()),
            false => error.expected(format!("one of {}", offers.join(", "))).nearest(value, offers.iter().copied()),
        })
    }

    fn string(&self, table: &dyn TableLike, key: &str, item: &Item) -> Result<String> {
        item.as_str().map(str::to_owned).ok_or_else(|| {
            Error::new("E102", format!("`{key}`: expected a text")).at(Some(self.text.value(table, key)))
        })
    }

    fn scene(&self, table: &dyn TableLike, settings: &mut Settings, top: bool) -> Result {
        let declared = settings::keys();
        for (key, item) in table.iter() {
            let place = || Some(self.text.value(table, key));
            let (entry, factor) =
                keys::find(key, &declared, "[scene]").map_err(|e| e.at(Some(self.text.key(table, key))))?;
            let value = keys::to_value(item, factor).map_err(|e| e.at(place()))?;
            let value = keys::check(&entry.0, key, value).map_err(|e| e.at(place()))?;
            if let ("dialect", Value::Text(t)) = (entry.0.key.as_str(), &value) {
                let dialect = String::from_utf8_lossy(t);
                self.registry.check_dialect(None, &dialect).map_err(|e| e.at(place()))?;
            }
            if top {
                settings::apply(settings, &entry.0.key, &value);
            }
        }
        Ok(())
    }

    fn model(&mut self, b: &mut Builder<'_>, table: &dyn TableLike, parent: Option<usize>) -> Result {
        let Some(item) = table.get("model") else {
            return Err(Error::new("E104", "a [[model]] without `model`")
                .expected("model = \"<id>\"")
                .at(Some(self.text.place(table_span(table)))));
        };
        let id = self.string(table, "model", item)?;
        let at = Some(self.text.value(table, "model"));
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

    /// `[[import]]`: a file of another format, placed as a model is.
    fn import(&mut self, b: &mut Builder<'_>, table: &dyn TableLike, parent: Option<usize>) -> Result {
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
        let import = import::Import { file: &file, bytes: &bytes, choice, params: &params };
        let base = b.import(import, parent, placement).map_err(|e| e.at(Some(at)))?;
        self.finish(b, table, base)
    }

    /// The parameters that a table gives to a model or importer, and those that a run gives to this one.
    fn params(
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
                // A misspelt key may be one that all have.
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

    /// A scene file as a model: its objects below a base of their own.
    fn included(
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
        let text = b.document.sources.read_text(&file).map_err(|e| {
            Error::new("E105", format!("cannot read the model `{id}`: {e}"))
                .expected(format!("a file {}", file.display()))
                .at(at)
        })?;
        let alias = Path::new(id).file_stem().map_or("model".into(), |s| s.to_string_lossy().into_owned());
        let group = b.document.objects.iter().map(|o| o.group).max().unwrap_or(0) + 1;
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

    /// What every model may have: another alias, scripts, changed properties.
    fn finish(&mut self, b: &mut Builder<'_>, table: &dyn TableLike, base: usize) -> Result {
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

    fn object(&mut self, b: &mut Builder<'_>, table: &dyn TableLike, parent: Option<usize>) -> Result {
        let Some(item) = table.get("kind") else {
            let known: Vec<_> = KINDS.iter().map(|(n, _)| *n).collect();
            return Err(Error::new("E104", "an [[object]] without `kind`")
                .expected(format!("kind = one of {}", known.join(", ")))
                .at(Some(self.text.place(table_span(table)))));
        };
        let kind = self.string(table, "kind", item)?;
        let alias = match table.get("alias") {
            Some(item) => self.string(table, "alias", item)?,
            None => String::new(),
        };
        let parent = self.parent(b, table, parent)?;
        let at = self.text.value(table, "kind");
        let object = b.object(&kind, parent, &alias).map_err(|e| e.at(Some(at.clone())))?;
        let device = match b.document.objects[object].kind {
            TATU_KIND_SENSOR => Some(("sensor", "<kind or schema>")),
            TATU_KIND_ACTUATOR => Some(("actuator", "<kind>")),
            _ => None,
        };
        if let Some((key, wanted)) = device {
            let Some(item) = table.get(key) else {
                return Err(Error::new(
                    "E104",
                    format!("a{} {key} without its kind", if key == "actuator" { "n" } else { "" }),
                )
                .expected(format!("{key} = \"{wanted}\""))
                .help(format!("`tatu list {key}s` shows the kinds"))
                .at(Some(at)));
            };
            let kind = self.string(table, key, item)?;
            b.device(object, &kind).map_err(|e| e.at(Some(self.text.value(table, key))))?;
        }
        // First what a joint leaves free: it tells the units of its other keys.
        if let Some(Item::Value(v)) = table.get("type").filter(|_| b.document.objects[object].kind == TATU_KIND_JOINT) {
            let value = Value::text(v.as_str().unwrap_or_default());
            b.set(object, "joint.type", value).map_err(|e| e.at(Some(self.text.value(table, "type"))))?;
        }
        let owner = format!("{} {kind}", if kind == "actuator" { "an" } else { "a" });
        let declared = b.declared(object);
        for (key, item) in table.iter() {
            const OTHERS: &[&str] = &["kind", "alias", "parent", "script", "scripts"];
            if OTHERS.contains(&key) || device.is_some_and(|(d, _)| d == key) {
                continue;
            }
            let place = || Some(self.text.value(table, key));
            let ((declared, target), factor) =
                keys::find(key, &declared, &owner).map_err(|e| e.at(Some(self.text.key(table, key))))?;
            let value = keys::to_value(item, factor).map_err(|e| e.at(place()))?;
            b.put(object, declared, target, value).map_err(|e| e.at(place()))?;
        }
        scripts::read(&self.text, b, table, object)
    }

    fn placement(&self, table: &dyn TableLike) -> Result<Isometry3<f64>> {
        let numbers =
            |key: &str, n: usize, factor: f64| -> Result<Option<Vec<f64>>> {
                let Some(item) = table.get(key) else { return Ok(None) };
                match keys::to_value(item, factor) {
                    Ok(Value::Floats(v)) if v.len() == n => Ok(Some(v)),
                    _ => Err(Error::new("E102", format!("`{key}`: expected {n} numbers"))
                        .at(Some(self.text.value(table, key)))),
                }
            };
        let mut pose = Isometry3::identity();
        if let Some(v) = numbers("position_m", 3, 1.0)? {
            pose.translation.vector = Vector3::new(v[0], v[1], v[2]);
        }
        if let Some(v) = numbers("orientation_deg", 3, std::f64::consts::PI / 180.0)? {
            pose.rotation = from_euler([v[0], v[1], v[2]]);
        }
        if let Some(v) = numbers("quaternion", 4, 1.0)? {
            pose.rotation = pose_from_array(&[0.0, 0.0, 0.0, v[0], v[1], v[2], v[3]])
                .ok_or_else(|| {
                    Error::new("E102", "`quaternion`: expected x y z w, not all 0")
                        .at(Some(self.text.value(table, "quaternion")))
                })?
                .rotation;
        }
        Ok(pose)
    }

    fn parent(&self, b: &Builder<'_>, table: &dyn TableLike, outer: Option<usize>) -> Result<Option<usize>> {
        let Some(item) = table.get("parent") else { return Ok(outer) };
        let path = self.string(table, "parent", item)?;
        overrides::find(b.document, outer, &path).map(Some).map_err(|e| {
            let e = e.expected("an object that stands above it in the file");
            e.at(Some(self.text.value(table, "parent")))
        })
    }

    fn overrides(&mut self, table: &dyn TableLike, from: Option<usize>) -> Result {
        for (key, item) in table.iter() {
            let place = self.text.key(table, key);
            let Some((path, written)) = key.rsplit_once('.') else {
                return Err(Error::new("E101", format!("`{key}` names no property"))
                    .expected("\"path.property\"")
                    .at(Some(place)));
            };
            self.set.push(Override {
                from,
                path: path.to_owned(),
                key: written.to_owned(),
                item: item.clone(),
                place: Some(place),
            });
        }
        Ok(())
    }
}

const IMPORT_KEYS: &[&str] =
    &["file", "importer", "alias", "parent", "position_m", "orientation_deg", "quaternion", "script", "scripts", "set"];

const MODEL_KEYS: &[&str] =
    &["model", "alias", "parent", "position_m", "orientation_deg", "quaternion", "script", "scripts", "set"];

fn table_span(table: &dyn TableLike) -> Option<std::ops::Range<usize>> {
    // The span of a table begins at its header; its first key is the better place to point to.
    let first = table.iter().next().map(|(k, _)| k.to_owned())?;
    table.key(&first).and_then(|k| k.span())
}

fn canonical(p: &Path) -> PathBuf {
    std::fs::canonicalize(p).unwrap_or_else(|_| p.to_owned())
}
