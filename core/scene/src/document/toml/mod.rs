//! Scene files. `[scene]` contains the settings of the world. `[[model]]` places models, `[[import]]` files in other
//! formats, and `[[object]]` single objects. `[set]` changes properties by path, and `[providers]` chooses the plugin
//! for a schema or language.
//!
//! - this module: [`load`], and the reader of a file's tables, in order;
//! - `scene`: `[scene]`, `[permissions]` and `[providers]`; `needs`: required plugins;
//! - `parts`: `[[model]]`, `[[import]]` and scenes as models; `models`: lookup of models by name, and models that are
//!   read from text; `naming`: names of models and their files; `changes`: objects that a scene adds to, removes from
//!   and replaces in a model;
//! - `object`: `[[object]]`, poses and `[set]`; `meshes`, `images`: meshes and images in separate files;
//! - `write`: writes a document as a scene file; `patch`: writes an edited scene into the text that it was read from;
//!   `value_text`: formatting of values.

mod changes;
mod images;
mod meshes;
mod models;
mod naming;
mod needs;
mod object;
mod parts;
mod patch;
mod scene;
mod value_text;
mod write;

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use nalgebra::Isometry3;
use tatu_errors::{Error, Result, SourceLocation};
use tatu_plugin_api::safe::Value;
use tatu_plugins::Registry;
use toml_edit::{Item, TableLike};

use super::{
    BuildReport, Document, DocumentBuilder, ReadProgress,
    change::{IMPORTED_FILE, PropertyOverride, ScriptOverride},
    entry::SceneEntry,
    import, keys,
    languages::{self, LanguageOverride},
    overrides,
    reach::{AllowedFile, AllowedFolders},
    services::{self, ServiceOverride, UserSettings},
    sources::SourceFiles,
};

pub use patch::{EditedScene, PatchResult, patch};
pub use write::{SceneFiles, folder_beside, save, write};

/// Options of a run that affect the scene.
#[derive(Debug, Clone, Default)]
pub struct LoadOptions {
    /// Seed that overrides the file's, if any.
    pub seed: Option<u64>,
    /// `--set`: overrides of properties, in order.
    pub set: Vec<PropertyOverride>,
    /// `--script`: scripts that replace the scripts of objects.
    pub scripts: Vec<ScriptOverride>,
    /// `--service`: services to add, or whose parameters are overridden.
    pub services: Vec<ServiceOverride>,
    /// `--language`: settings of script languages.
    pub languages: Vec<LanguageOverride>,
    /// The user's own defaults for parameters of services and script languages.
    pub user_settings: UserSettings,
    /// `--allow`: permissions of scripts to access resources outside the run: "exec" (other programs), "native"
    /// (libraries), "net=HOST:PORT" (sockets), and those that script languages need.
    pub allow: Vec<String>,
    /// Whether importers should describe their files; see [`Document::description`].
    pub describe: bool,
    /// The source files; by default, they are read from disk.
    pub sources: SourceFiles,
    /// The files that the scene may name; by default, [`AllowedFolders::of`] its file.
    pub reach: Option<AllowedFolders>,
}

impl LoadOptions {
    fn reach_of(&self, file: &Path, registry: &Registry) -> AllowedFolders {
        self.reach.clone().unwrap_or_else(|| AllowedFolders::of(file, registry))
    }
}

/// Returns the plugin folders that `[scene]` lists, without checking the rest of the file.
pub fn plugin_folders(file: &Path, sources: &SourceFiles) -> Result<Vec<PathBuf>> {
    // A file in a different format cannot list plugin folders.
    let Ok(text) = String::from_utf8(read_bytes(&AllowedFile::chosen(file), sources)?) else { return Ok(Vec::new()) };
    let Ok(doc) = toml_edit::Document::parse(text.as_str()) else { return Ok(Vec::new()) };
    let here = file.parent().unwrap_or(Path::new(""));
    let list = doc.get("scene").and_then(|s| s.get("plugins")).and_then(Item::as_array);
    Ok(list.into_iter().flatten().filter_map(|v| v.as_str()).map(|s| here.join(s)).collect())
}

/// Checks that each permission that the user grants exists.
fn check_granted(allow: &[String], registry: &Registry) -> Result {
    let known = registry.permissions();
    let is_known = |word: &str| known.contains(&word) || word.starts_with("net=");
    match allow.iter().find(|word| !is_known(word)) {
        None => Ok(()),
        Some(word) => Err(Error::new("E101", format!("unknown permission `{word}`"))
            .expected(format!("{} or net=HOST:PORT", known.join(", ")))
            .nearest(word, known)),
    }
}

/// Loads a scene file as a document.
pub fn load(file: &Path, registry: &Registry, options: &LoadOptions) -> Result<Document> {
    // Parameters of models that overrides have set; the models must be built with these values.
    let mut model_params: Arc<[(usize, String, Value)]> = [].into();
    // Each round determines at least one more parameter, and no realistic scene overrides this many.
    for _ in 0..10_000 {
        let mut document = SceneFileReader::read(file, registry, model_params.clone(), options)?;
        let set = std::mem::take(&mut document.reading.overrides);
        if let Some(seed) = options.seed {
            document.settings.seed = seed;
        }
        check_granted(&options.allow, registry)?;
        document.settings.allow.clone_from(&options.allow);
        let lacks: Vec<&String> =
            document.requests.requested_permissions.iter().filter(|a| !options.allow.contains(a)).collect();
        let lacks: Vec<String> = lacks.into_iter().map(|a| format!("`--allow {a}`")).collect();
        if !lacks.is_empty() {
            let text =
                format!("its scripts request access outside the run, which you can permit with {}", lacks.join(" "));
            document.reports.push(BuildReport::note(text));
        }
        let reach = options.reach_of(file, registry);
        let more = match overrides::apply(&mut document, registry, &set, &model_params, &reach)? {
            None => overrides::apply(&mut document, registry, &options.set, &model_params, &reach)?,
            more => more,
        };
        match more {
            Some(more) => model_params = model_params.iter().cloned().chain([more]).collect(),
            None => {
                overrides::replace_scripts(&mut document, registry, &options.scripts, &reach)?;
                services::apply(&mut document, registry, &options.services)?;
                services::apply_user_settings(&mut document, registry, &options.user_settings)?;
                languages::apply(&mut document, registry, &options.languages)?;
                languages::apply_user_settings(&mut document, registry, &options.user_settings)?;
                document.check()?;
                return Ok(document);
            }
        }
    }
    Err(Error::new("E102", "the overridden model parameters keep changing which models exist"))
}

/// Loads a file that becomes a part of a live scene: a scene file, or a file for an importer. If `file` is the id of a
/// model, loads a scene that contains only this model. The file must be in `reach`, and may name the files in it.
pub fn load_part(file: &Path, registry: &Registry, reach: AllowedFolders) -> Result<Document> {
    let id = file
        .to_str()
        .filter(|id| registry.model_offers.models.iter().any(|m| m.id == *id) || registry.find_model(id).is_some());
    if let Some(id) = id {
        let name = PathBuf::from(format!("{id}.toml"));
        let options = LoadOptions { reach: Some(reach), ..LoadOptions::default() };
        options.sources.add_file(&name, format!("format = 1\n[[model]]\nmodel = {id:?}\n").into_bytes());
        return load(&name, registry, &options);
    }
    let allowed = reach.file(file, &file.display().to_string(), false)?;
    if file.extension().is_some_and(|e| e == "toml") {
        return load(file, registry, &LoadOptions { reach: Some(reach), ..LoadOptions::default() });
    }
    let mut document = Document { file: Some(file.to_owned()), ..Default::default() };
    let bytes = read_bytes(&allowed, &document.sources)?;
    let choice = registry.importer_of(file, &bytes, &BTreeMap::new())?.ok_or_else(|| registry.no_importer(file))?;
    let mut builder = DocumentBuilder::new(registry, &mut document, reach);
    builder.read_text = Some(add_text);
    builder.place = Some(SourceLocation { file: file.to_owned(), ..Default::default() });
    let import = import::ImportRequest { file, bytes: &bytes, choice, params: &[], is_scene: false };
    builder.import(import, None, Isometry3::identity())?;
    Ok(document)
}

fn read_bytes(file: &AllowedFile, sources: &SourceFiles) -> Result<Vec<u8>> {
    sources.read(file).map_err(|e| unreadable(file.path(), &e.to_string()))
}

fn unreadable(file: &Path, why: &str) -> Error {
    Error::new("E105", format!("cannot read the scene {}: {why}", file.display()))
        .help("specify the path of a scene file, or the name of a scene that comes with Tatu")
}

struct SceneFileReader<'a> {
    text: keys::SourceText<'a>,
    registry: &'a Registry,
    /// Numbers of the meshes that have been read from files, by path.
    meshes: BTreeMap<PathBuf, i64>,
    /// Numbers of the images that have been read from files, by path.
    images: BTreeMap<PathBuf, i64>,
}

/// Adds the objects that a text in the scene format describes. If the text differs from the contents of its file,
/// errors refer to whole lines of the file.
fn add_text(b: &mut DocumentBuilder<'_>, file: &Path, text: &str, parent: Option<usize>) -> Result {
    let mut reader = SceneFileReader::new(file, text, b.registry);
    let place = b.place.clone();
    let (objects, sets) = (b.document.objects.len(), b.document.reading.overrides.len());
    let read = reader.read_tables(b, parent, false);
    b.place = place;
    // Errors found later are located without this text, whose byte offsets differ from those of the file.
    let added = b.document.objects.iter_mut().skip(objects).filter_map(|o| o.place.as_mut());
    let set = b.document.reading.overrides.iter_mut().skip(sets).filter_map(|o| o.place.as_mut());
    for place in added.chain(set).filter(|p| p.file == file) {
        *place = SourceLocation::of_line(file.to_owned(), &[], place.line);
    }
    read.map_err(|mut e| {
        if let Some(place) = e.place.as_mut().filter(|p| p.file == file) {
            let bytes = b.document.sources.cached(file).unwrap_or_default();
            if *bytes != *text.as_bytes() {
                **place = SourceLocation::of_line(file.to_owned(), &bytes, place.line);
            }
        }
        e
    })
}

impl<'a> SceneFileReader<'a> {
    fn new(file: &'a Path, text: &'a str, registry: &'a Registry) -> Self {
        SceneFileReader {
            text: keys::SourceText::new(file, text),
            registry,
            meshes: BTreeMap::new(),
            images: BTreeMap::new(),
        }
    }

    fn read(
        file: &Path,
        registry: &'a Registry,
        model_params: Arc<[(usize, String, Value)]>,
        options: &LoadOptions,
    ) -> Result<Document> {
        let sources = &options.sources;
        let mut document = Document {
            file: Some(file.to_owned()),
            sources: sources.clone(),
            reading: ReadProgress { describe: options.describe, model_params, ..Default::default() },
            ..Default::default()
        };
        let mut builder = DocumentBuilder::new(registry, &mut document, options.reach_of(file, registry));
        builder.read_text = Some(add_text);
        let bytes = read_bytes(&AllowedFile::chosen(file), sources)?;
        let named = file.extension().is_some_and(|e| e == "toml");
        let choice = if named { None } else { registry.importer_of(file, &bytes, &BTreeMap::new())? };
        if let Some(choice) = choice {
            let mut params = overrides::import_params(&registry.importers[choice.importer], &options.set)?;
            params.extend(builder.document.reading.model_params.iter().map(|(_, k, v)| (k.clone(), v.clone())));
            builder.place = Some(SourceLocation { file: file.to_owned(), ..Default::default() });
            let import = import::ImportRequest { file, bytes: &bytes, choice, params: &params, is_scene: true };
            builder.import(import, None, Isometry3::identity())?;
            return Ok(document);
        }
        if let Some(o) = options.set.iter().find(|o| o.path == IMPORTED_FILE) {
            let text =
                format!("`file.{}` is a parameter of an importer, but no importer reads {}", o.key, file.display());
            return Err(Error::new("E101", text).help("set parameters of an `[[import]]` by the path of its object"));
        }
        let text = String::from_utf8(bytes).map_err(|_| match named {
            true => unreadable(file, "it is not UTF-8 text"),
            false => registry.no_importer(file).help("a scene is a TOML file"),
        })?;
        if let Some(root) = xml_root(&text).filter(|_| !named) {
            let help = format!("it is an XML file with the root element <{root}>; convert it to one of these formats");
            return Err(registry.no_importer(file).help(help));
        }
        let mut reader = SceneFileReader::new(file, &text, registry);
        match naming::describes_model(&text) {
            true => reader.build_as_scene(&mut builder)?,
            false => {
                builder.document.reading.open_files.push(canonical(file));
                reader.read_tables(&mut builder, None, true)?;
            }
        }
        Ok(document)
    }

    /// Reads the current file. Objects without a parent are placed below `parent`. If `top` is set, the file is the
    /// scene itself, and its settings and services apply.
    fn read_tables(&mut self, b: &mut DocumentBuilder<'_>, parent: Option<usize>, top: bool) -> Result {
        let doc = toml_edit::Document::parse(self.text.text).map_err(|e| {
            let error = Error::new("E100", format!("not a TOML file: {}", e.message()));
            let has = |line: &str| self.text.text.lines().any(|l| l.trim() == line);
            let both = has("[[model]]") && has("[model]");
            let error = match both {
                true => error.help("in a file with `[model]`, models are placed by `[[object]]` with `model = ...`"),
                false => error,
            };
            error.at(Some(self.text.place(e.span())))
        })?;
        let root = doc.as_table();
        const KNOWN_KEYS: &[&str] = &[
            "format",
            "scene",
            "env",
            "providers",
            "permissions",
            "service",
            "language",
            "model",
            "import",
            "object",
            "set",
        ];
        for (key, _) in root.iter() {
            if !KNOWN_KEYS.contains(&key) {
                return Err(Error::new("E101", format!("unknown key `{key}`"))
                    .expected(KNOWN_KEYS.join(", "))
                    .nearest(key, KNOWN_KEYS.iter().copied())
                    .at(Some(self.text.key(root, key))));
            }
        }
        match root.get("format").and_then(Item::as_integer) {
            Some(1) => {}
            Some(n) => {
                return Err(Error::new("E102", format!("unsupported scene format {n}"))
                    .expected("format = 1")
                    .at(Some(self.text.value(root, "format"))));
            }
            None => {
                return Err(Error::new("E104", "the file does not state its format")
                    .expected("format = 1")
                    .help("write `format = 1` as the first line")
                    .at(Some(self.text.place(None))));
            }
        }
        if let Some(scene) = self.table(root, "scene")? {
            self.check_needs(scene)?;
            self.scene(scene, &mut b.document.settings, top)?;
            if let Some(item) = scene.get("data") {
                let at = |e: Error| e.at(Some(self.text.value(scene, "data")));
                let data = keys::to_map(item).map_err(at)?;
                b.apply_setting("data", data, top).map_err(at)?;
            }
        }
        if let Some(item) = root.get("env").filter(|_| top) {
            self.table(root, "env")?;
            let mut kept = toml_edit::DocumentMut::new();
            kept.insert("env", item.clone());
            b.document.requests.env = Some(kept.to_string());
        }
        if let Some(providers) = self.table(root, "providers")? {
            for (key, item) in providers.iter() {
                let value = self.string(providers, key, item)?;
                self.check_provider(key, &value, &b.document.sources)
                    .map_err(|e| e.at(Some(self.text.value(providers, key))))?;
                b.document.settings.providers.insert(key.to_owned(), value);
            }
        }
        if let Some(permissions) = self.table(root, "permissions")? {
            self.permissions(permissions, b.document)?;
        }
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for (what, table) in self.entries_in_order(root)? {
            b.place = Some(self.text.place(table_span(table)));
            if top {
                let places = what != "object" || !table.contains_key("kind") && !is_device(table);
                let count = counts.entry(what).or_default();
                b.document.entries.push(SceneEntry {
                    table: what,
                    index: *count,
                    first: b.document.objects.len(),
                    is_placement: places,
                });
                *count += 1;
            }
            match what {
                "model" => drop(self.model(b, table, parent, None)?),
                "import" => drop(self.import(b, table, parent)?),
                _ => self.object(b, table, parent)?,
            };
        }
        if let Some(set) = self.table(root, "set")? {
            self.read_overrides(b, set, parent)?;
        }
        if let Some(table) = self.table(root, "language")?.filter(|_| top) {
            languages::read(&self.text, self.registry, table, &mut b.document.requests.languages)?;
        }
        // Services belong to the scene itself, not to scenes used as models.
        for table in self.list(root, "service")?.into_iter().flatten().filter(|_| top) {
            let place = self.text.place(table_span(table));
            let spec = services::read(&self.text, self.registry, &b.document.settings.providers, table, place)?;
            if b.document.requests.services.iter().any(|s| s.kind == spec.kind) {
                let text = format!("the service `{}` is listed twice", self.registry.services[spec.kind].id);
                return Err(Error::new("E102", text).expected("each service at most once").at(spec.place));
            }
            b.document.requests.services.push(spec);
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

    /// Returns `[[model]]`, `[[import]]` and `[[object]]` tables in file order. An object can thus have a preceding
    /// model as its parent, and vice versa.
    fn entries_in_order<'t>(&self, root: &'t toml_edit::Table) -> Result<Vec<(&'static str, &'t dyn TableLike)>> {
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

    fn string(&self, table: &dyn TableLike, key: &str, item: &Item) -> Result<String> {
        item.as_str().map(str::to_owned).ok_or_else(|| {
            Error::new("E102", format!("`{key}`: expected a string")).at(Some(self.text.value(table, key)))
        })
    }
}

/// Returns whether a table describes a sensor, an actuator or a part, for which the key `kind` can be omitted.
fn is_device(table: &dyn TableLike) -> bool {
    ["sensor", "actuator", "part"].iter().any(|k| table.contains_key(k))
}

fn table_span(table: &dyn TableLike) -> Option<std::ops::Range<usize>> {
    // The span of a table begins at its header; errors are easier to find at its first key.
    let first = table.iter().next().map(|(k, _)| k.to_owned())?;
    table.key(&first).and_then(|k| k.span())
}

fn canonical(p: &Path) -> PathBuf {
    std::fs::canonicalize(p).unwrap_or_else(|_| p.to_owned())
}

/// Returns the name of the root element of a text that looks like XML.
fn xml_root(text: &str) -> Option<&str> {
    let mut rest = text.trim_start_matches('\u{feff}').trim_start();
    while let Some(end) = [("<?", "?>"), ("<!--", "-->"), ("<!", ">")].iter().find_map(|(open, close)| {
        rest.starts_with(open).then(|| rest.find(close).map_or(rest.len(), |i| i + close.len()))
    }) {
        rest = rest[end..].trim_start();
    }
    let name = rest.strip_prefix('<')?;
    let end = name.find(|c: char| c.is_whitespace() || matches!(c, '/' | '>')).filter(|end| *end > 0)?;
    Some(&name[..end])
}
