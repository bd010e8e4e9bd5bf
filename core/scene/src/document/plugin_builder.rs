//! The builder interface for plugins, and the building of models.

use std::{
    cell::RefCell,
    path::{Path, PathBuf},
};

use nalgebra::Isometry3;
use nalgebra::Point3;
use tatu_errors::{Error, Result, SourceLocation};
use tatu_geometry::{MAX_IMAGE_PIXELS, Mesh};
use tatu_plugin_api::{
    abi::*,
    safe::{Owned, Value},
};
use tatu_plugins::{
    BuildFunction, BuildOptions, BuildTarget, BuiltScript, Model, ParameterSpec, border::ErrorSlot, texts,
    watchdog::PluginCall,
};

use super::{BuildReport, DocumentBuilder, SCRIPT_KINDS, ScriptSpec, import_files::BuildSource};

/// A build in progress.
struct BuildContext<'b, 'a> {
    builder: RefCell<&'b mut DocumentBuilder<'a>>,
    /// Index in the document of the object that has the number 1 in the build.
    first: usize,
    parent: Option<usize>,
    error: RefCell<Option<Error>>,
    source: BuildSource,
    /// The file that describes the model, if there is one.
    file: Option<PathBuf>,
}

/// The reason why a build failed.
pub(super) enum BuildFailure {
    /// The plugin broke the contract.
    ContractBreach(Error),
    /// The first error that the host reported.
    HostError(Error),
    /// The error that the plugin reported.
    PluginError(ErrorSlot),
}

/// A call of a plugin's build or import function.
pub(super) struct BuildCall<'a> {
    pub function: BuildFunction<'a>,
    pub call: PluginCall,
    /// Description of what is being built, for messages.
    pub subject: &'a str,
}

impl DocumentBuilder<'_> {
    /// Builds a model with these parameters; returns the index of its base.
    pub fn model(
        &mut self,
        model: &Model,
        params: &[(String, Value)],
        parent: Option<usize>,
        placement: Isometry3<f64>,
    ) -> Result<usize> {
        let first = self.document.objects.len();
        let group = self.document.new_group();
        let outer = std::mem::replace(&mut self.group, group);
        self.record_model(&model.params);
        let built = run_model(self, model, params, parent);
        self.group = outer;
        built?;
        let nothing = || Error::new("E111", format!("the model `{}` built no objects", model.id));
        self.place_model(first, placement).ok_or_else(nothing)
    }
}

/// Calls the build function of a model.
fn run_model(
    builder: &mut DocumentBuilder<'_>,
    info: &Model,
    params: &[(String, Value)],
    parent: Option<usize>,
) -> Result {
    let registry = builder.registry;
    let folder = info.file.as_deref().or(builder.document.file.as_deref()).and_then(Path::parent).map(PathBuf::from);
    let source = BuildSource { name: None, folder, is_scene: false };
    let subject = format!("the model `{}`", info.id);
    let asked = BuildCall { function: BuildFunction::Model(info), call: PluginCall::Build, subject: &subject };
    let first = builder.document.objects.len();
    let done = run_build(builder, asked, source, (&info.params, params), parent);
    let plugin = &registry.plugins[info.plugin].id;
    let built = builder.document.objects.get(first..).unwrap_or_default();
    // A model that is read from text can leave out objects, including those of slots.
    let lost = info.slots.iter().find(|s| !built.iter().any(|o| o.alias == s.alias));
    if let Some(slot) = lost.filter(|_| done.is_ok() && info.file.is_none()) {
        let slot = &slot.alias;
        let text = format!("the model `{}` declares the slot `{slot}`, but builds no object with this alias", info.id);
        return Err(Error::new("E111", format!("{text} [{} of `{plugin}`]", PluginCall::Build.text()))
            .help("report this to the plugin's authors: the model must build an object with this alias, or not declare the slot in `tatu_model.slots`"));
    }
    done.map_err(|failed| match failed {
        BuildFailure::ContractBreach(e) => e,
        // The error is in the text, not in the plugin.
        BuildFailure::HostError(e) if info.file.is_some() && e.place.is_some() => e,
        BuildFailure::PluginError(said) if info.file.is_some() => model_text_error(builder, info, &said),
        BuildFailure::HostError(e) => {
            let text = format!("the model `{}`: {} [{} of `{plugin}`]", info.id, e.text, PluginCall::Build.text());
            Error { text, ..e }
        }
        BuildFailure::PluginError(said) => {
            let text = format!("the model `{}` cannot be built: plugin `{plugin}` {}", info.id, said.text());
            Error::new("E111", format!("{text} [{}]", PluginCall::Build.text()))
        }
    })
}

/// Returns the error that a plugin reported about the text of a model.
fn model_text_error(builder: &DocumentBuilder<'_>, info: &Model, said: &ErrorSlot) -> Error {
    let (said, file) = (said.contents(), info.file.clone().unwrap_or_default());
    let why = said.text.unwrap_or_else(|| "its plugin gave no reason".to_owned());
    let error = Error::new("E111", format!("the model `{}` cannot be built: {why}", info.id));
    let error = match said.help {
        Some(help) => error.help(help),
        None => error,
    };
    let bytes = builder.document.sources.cached(&file).unwrap_or_default();
    error.at(Some(SourceLocation::of_line(file, &bytes, said.line as usize)))
}

/// Calls a plugin function that writes to the builder, with its parameters and defaults filled in.
pub(super) fn run_build(
    builder: &mut DocumentBuilder<'_>,
    asked: BuildCall<'_>,
    source: BuildSource,
    (declared, params): (&[ParameterSpec], &[(String, Value)]),
    parent: Option<usize>,
) -> Result<(), BuildFailure> {
    let registry = builder.registry;
    let (plugin, file) = match asked.function {
        BuildFunction::Model(model) => (model.plugin, model.file.clone()),
        BuildFunction::Importer(importer, _) => (importer.plugin, None),
    };
    let given =
        |p: &ParameterSpec| params.iter().rev().find(|(k, _)| *k == p.key).map_or(&p.fallback, |(_, v)| v).clone();
    let given: Vec<Value> = declared.iter().map(given).collect();
    let mut owned = Owned::default();
    let raw = owned.values(&given);
    let options =
        BuildOptions { max_image_pixels: MAX_IMAGE_PIXELS as u64, describes: builder.document.reading.describe };
    let build = BuildContext {
        first: builder.document.objects.len(),
        builder: RefCell::new(builder),
        parent,
        error: RefCell::new(None),
        source,
        file,
    };
    let mut slot = ErrorSlot::new();
    let answered = registry.call_plugin(plugin, asked.call, asked.subject, || {
        registry.build(asked.function, &build, options, &raw, &mut slot)
    });
    let refused = build.error.into_inner();
    match (answered, refused) {
        (Err(e), _) => Err(BuildFailure::ContractBreach(e)),
        (_, Some(e)) => Err(BuildFailure::HostError(e)),
        (Ok(status), None) if status < 0 => Err(BuildFailure::PluginError(slot)),
        _ => Ok(()),
    }
}

fn clean(text: LentCStr<'_>) -> String {
    texts::clean(&text.text()).into_owned()
}

impl BuildContext<'_, '_> {
    /// Runs one function of the builder. Returns `None` if it fails, and stores the first error until the end of the
    /// build.
    fn run<T>(&self, f: impl FnOnce(&mut DocumentBuilder<'_>) -> Result<T>) -> Option<T> {
        let mut guard = self.builder.try_borrow_mut().ok()?;
        match f(&mut guard) {
            Ok(t) => Some(t),
            Err(e) => {
                self.error.borrow_mut().get_or_insert(e);
                None
            }
        }
    }

    /// Returns the index of an object given by its number in the build. The builder checks whether it exists.
    fn index(&self, object: u32) -> Result<usize> {
        match object {
            0 => Err(Error::new("E110", "object 0 of a build is the parent of the model, and cannot be changed")),
            n => Ok(self.first + n as usize - 1),
        }
    }

    fn parent(&self, object: u32) -> Result<Option<usize>> {
        if object == 0 { Ok(self.parent) } else { self.index(object).map(Some) }
    }
}

impl BuildTarget for BuildContext<'_, '_> {
    fn object(&self, kind: LentCStr<'_>, parent: u32, alias: Lent<'_>) -> Option<u32> {
        self.run(|b| {
            let parent = self.parent(parent)?;
            Ok((b.object(&clean(kind), parent, &alias.text())? - self.first + 1) as u32)
        })
    }

    fn set(&self, object: u32, key: LentCStr<'_>, value: Value) -> Option<()> {
        let key = clean(key);
        self.run(|b| match object {
            0 if key.starts_with("scene.") => b.apply_setting(&key, value, self.source.is_scene),
            n => b.set(self.index(n)?, &key, value),
        })
    }

    fn mesh(&self, points: &[[f64; 3]], coordinates: &[[f32; 2]], triangles: &[[u32; 3]]) -> Option<u64> {
        let vertices = points.iter().map(|p| Point3::from(*p)).collect();
        let mesh = Mesh { vertices, triangles: triangles.to_vec(), coordinates: coordinates.to_vec() };
        self.run(|b| b.mesh(mesh)).map(|n| n as u64)
    }

    fn image(&self, width: u32, height: u32, rgba: &[u8]) -> Option<u64> {
        self.run(|b| b.image(width, height, rgba.to_vec())).map(|n| n as u64)
    }

    fn script(&self, owner: u32, script: BuiltScript<'_>) -> Option<()> {
        let (language, dialect, kind) = (clean(script.language), clean(script.dialect), clean(script.kind));
        let (name, text) = (texts::clean(&script.name.text()).into_owned(), script.source.bytes().to_vec());
        let added = self.run(|b| {
            let owner = self.index(owner)?;
            let language = b
                .registry
                .language(if language.is_empty() { &name } else { &language }, &b.document.settings.providers)?;
            let kind = if kind.is_empty() { "child".into() } else { kind };
            if !SCRIPT_KINDS.contains(&kind.as_str()) {
                let error = Error::new("E102", format!("unknown script kind `{kind}`"));
                return Err(error.expected(SCRIPT_KINDS.join(", ")));
            }
            b.registry.check_dialect(Some(language), &dialect)?;
            let priority = crate::document::NORMAL_PRIORITY;
            b.script(owner, ScriptSpec { language, dialect, kind, priority, side_by_side: false, name, text })
        });
        added.map(drop)
    }

    fn device(&self, object: u32, kind: LentCStr<'_>) -> Option<()> {
        self.run(|b| b.device(self.index(object)?, &clean(kind)))
    }

    fn report(&self, severity: u32, object: u32, said: Lent<'_>) -> Option<()> {
        let said = texts::clean(&said.text()).into_owned();
        self.run(|b| {
            if severity == TATU_REPORT_ERROR {
                return Err(Error::new("E111", said));
            }
            let whose = self.index(object).ok().and_then(|i| b.document.objects.get(i)).map(|o| o.alias.clone());
            let said = whose.map_or(said.clone(), |w| format!("`{w}`: {said}"));
            let text = self.source.name.as_ref().map_or(said.clone(), |f| format!("{f}: {said}"));
            match severity {
                TATU_REPORT_LACK => b.document.settings.lacks.push(text),
                _ => b.document.reports.push(BuildReport { severity, text }),
            }
            Ok(())
        })
    }

    fn describe(&self, map: Value) -> Option<()> {
        self.run(|b| match map {
            map @ Value::Map(_) => {
                b.document.description = Some(map);
                Ok(())
            }
            _ => Err(Error::new("E102", "the description of a file must be a map")),
        })
    }

    fn scene(&self, parent: u32, name: Lent<'_>, text: Lent<'_>) -> Option<()> {
        self.run(|b| {
            let parent = self.parent(parent)?;
            let lacks = || Error::new("E112", "this build cannot read text in the scene format");
            let read = b.read_text.ok_or_else(lacks)?;
            let file = match name.text() {
                name if name.is_empty() => self.file.clone(),
                name => self.source.folder.as_ref().map(|folder| folder.join(&*name)),
            };
            read(b, &file.ok_or_else(lacks)?, &text.text(), parent)
        })
    }

    fn file(&self, relative: Lent<'_>) -> Option<Vec<u8>> {
        let folder = self.source.folder.as_ref()?;
        let is_import = self.source.name.is_some();
        let read = self.run(|b| match is_import {
            true => b.read_file_of_import(folder, &relative.text()),
            false => b.read_named_file(folder, &relative.text()),
        });
        read.flatten()
    }

    fn refuse(&self, text: String) {
        self.run(|_| Err::<(), _>(Error::new("E111", text)));
    }
}
