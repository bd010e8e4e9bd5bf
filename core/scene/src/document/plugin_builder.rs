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
use tatu_plugins::{Model, ParameterSpec, border::ErrorSlot, texts, watchdog::PluginCall};

use super::{BuildReport, DocumentBuilder, SCRIPT_KINDS, ScriptSpec, import_files::BuildSource};

/// A build in progress, to which the `ctx` of the `tatu_builder` table points.
struct BuildContext<'b, 'a> {
    builder: RefCell<&'b mut DocumentBuilder<'a>>,
    /// Index in the document of the object that has the number 1 in the build.
    first: usize,
    parent: Option<usize>,
    error: RefCell<Option<Error>>,
    source: BuildSource,
    /// The file that describes the model, if there is one.
    file: Option<PathBuf>,
    files: RefCell<Vec<Vec<u8>>>,
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
    pub plugin: usize,
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
        let nothing = || Error::new("E111", format!("the model `{}` built nothing", model.id));
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
    let me = registry.plugins[info.plugin].me;
    let asked =
        BuildCall { plugin: info.plugin, call: PluginCall::Build, subject: &format!("the model `{}`", info.id) };
    let first = builder.document.objects.len();
    let done =
        run_build(builder, (asked, Some(info)), source, (&info.params, params), parent, |table, params, error| {
            // SAFETY: `f` is from a plugin that is never unloaded, and `me` is that plugin's own pointer. The table,
            // the parameters and the error object live until the call has returned.
            info.raw.build.map_or(TATU_OK, |f| unsafe { f(me, table, params, error) })
        });
    let plugin = &registry.plugins[info.plugin].id;
    let built = builder.document.objects.get(first..).unwrap_or_default();
    // A model that is read from text can leave out objects, including those of slots.
    let lost = info.slots.iter().find(|s| !built.iter().any(|o| o.alias == s.alias));
    if let Some(slot) = lost.filter(|_| done.is_ok() && info.file.is_none()) {
        let slot = &slot.alias;
        let text = format!("the model `{}` declares the slot `{slot}`, but builds no object with this alias", info.id);
        return Err(Error::new("E111", format!("{text} [{} of `{plugin}`]", PluginCall::Build.text()))
            .help("report this to the plugin's authors: build the object, or remove it from `tatu_model.slots`"));
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
    (asked, of): (BuildCall<'_>, Option<&Model>),
    source: BuildSource,
    (declared, params): (&[ParameterSpec], &[(String, Value)]),
    parent: Option<usize>,
    call: impl FnOnce(*const tatu_builder, *const tatu_value, *mut tatu_error) -> tatu_status,
) -> Result<(), BuildFailure> {
    let registry = builder.registry;
    let given =
        |p: &ParameterSpec| params.iter().rev().find(|(k, _)| *k == p.key).map_or(&p.fallback, |(_, v)| v).clone();
    let given: Vec<Value> = declared.iter().map(given).collect();
    let mut owned = Owned::default();
    let raw = owned.values(&given);
    let builder_describes = builder.document.describe;
    let build = BuildContext {
        first: builder.document.objects.len(),
        builder: RefCell::new(builder),
        parent,
        error: RefCell::new(None),
        source,
        file: of.and_then(|m| m.file.clone()),
        files: RefCell::new(Vec::new()),
    };
    let table = tatu_builder {
        size: size_of::<tatu_builder>() as u32,
        reserved: 0,
        ctx: (&raw const build).cast_mut().cast(),
        object: Some(object),
        set: Some(set),
        mesh: Some(mesh),
        image: Some(image),
        script: Some(script),
        device: Some(device),
        report: Some(report),
        file: Some(file),
        describe: builder_describes.then_some(describe),
        model: of.map_or(std::ptr::null(), |m| m.given),
        scene: Some(scene),
        textured_mesh: Some(textured_mesh),
    };
    let mut slot = ErrorSlot::new();
    let answered = registry
        .call_plugin(asked.plugin, asked.call, asked.subject, || call(&table, raw.as_ptr().cast(), slot.raw()))
        .map(|status| slot.check_status(status, false));
    let refused = build.error.into_inner();
    match (answered, refused) {
        (Err(e), _) => Err(BuildFailure::ContractBreach(e)),
        (_, Some(e)) => Err(BuildFailure::HostError(e)),
        (Ok(status), None) if status < 0 => Err(BuildFailure::PluginError(slot)),
        _ => Ok(()),
    }
}

/// Runs one function of the builder table. Returns `None` if it fails, and stores the first error until the end of the
/// build.
fn with_builder<T>(
    table: Option<&tatu_builder>,
    f: impl FnOnce(&BuildContext, &mut DocumentBuilder<'_>) -> Result<T>,
) -> Option<T> {
    // SAFETY: the header requires the table to be the one passed to the plugin, which `run_build` created; its build
    // lives until the plugin's call has returned.
    let build = unsafe { &*table?.ctx.cast::<BuildContext<'_, '_>>() };
    let mut guard = build.builder.try_borrow_mut().ok()?;
    match f(build, &mut guard) {
        Ok(t) => Some(t),
        Err(e) => {
            let mut first = build.error.borrow_mut();
            if first.is_none() {
                *first = Some(e);
            }
            None
        }
    }
}

fn clean(text: LentCStr<'_>) -> String {
    texts::clean(&text.text()).into_owned()
}

/// Returns the index of an object given by its number in the build. The builder checks whether it exists.
fn index(build: &BuildContext, object: u32) -> Result<usize> {
    match object {
        0 => Err(Error::new("E110", "object 0 of a build is the parent of the model, and cannot be changed")),
        n => Ok(build.first + n as usize - 1),
    }
}

extern "C" fn object(t: Option<&tatu_builder>, kind: LentCStr<'_>, parent: u32, alias: Lent<'_>) -> u32 {
    let made = with_builder(t, |build, b| {
        let parent = if parent == 0 { build.parent } else { Some(index(build, parent)?) };
        Ok((b.object(&clean(kind), parent, &alias.text())? - build.first + 1) as u32)
    });
    made.unwrap_or(0)
}

extern "C" fn set(
    t: Option<&tatu_builder>,
    object: u32,
    key: LentCStr<'_>,
    value: Option<&ValueRef<'_>>,
) -> tatu_status {
    let Some(value) = value else { return TATU_ERR_ARGUMENT };
    let (key, value) = (clean(key), value.to_value().unwrap_or_default());
    let done = with_builder(t, |build, b| match object {
        0 if key.starts_with("scene.") => b.apply_setting(&key, value, build.source.is_scene),
        n => b.set(index(build, n)?, &key, value),
    });
    done.map_or(TATU_ERR_ARGUMENT, |()| TATU_OK)
}

unsafe extern "C" fn mesh(
    t: Option<&tatu_builder>,
    points: *const f64,
    n_points: u64,
    triangles: *const u32,
    n_triangles: u64,
) -> u64 {
    // SAFETY: the caller upholds the requirements on points and triangles, and null coordinates have no requirements.
    unsafe { textured_mesh(t, points, std::ptr::null(), n_points, triangles, n_triangles) }
}

unsafe extern "C" fn textured_mesh(
    t: Option<&tatu_builder>,
    points: *const f64,
    coordinates: *const f32,
    n_points: u64,
    triangles: *const u32,
    n_triangles: u64,
) -> u64 {
    if points.is_null() || triangles.is_null() {
        let lacks = if points.is_null() { "points" } else { "triangles" };
        let text = format!("a mesh of {n_points} points and {n_triangles} triangles has a null pointer for {lacks}");
        with_builder(t, |_, _| Err::<(), _>(Error::new("E111", text)));
        return 0;
    }
    // SAFETY: both pointers are not null, and the header requires 3 numbers per point and per triangle, valid during
    // the call.
    let (points, triangles) = unsafe {
        (
            std::slice::from_raw_parts(points.cast::<[f64; 3]>(), n_points as usize),
            std::slice::from_raw_parts(triangles.cast::<[u32; 3]>(), n_triangles as usize),
        )
    };
    let coordinates = match coordinates.is_null() {
        true => Vec::new(),
        // SAFETY: the pointer is not null, and the header requires 2 numbers per point, valid during the call.
        false => unsafe { std::slice::from_raw_parts(coordinates.cast::<[f32; 2]>(), points.len()) }.to_vec(),
    };
    let vertices = points.iter().map(|p| Point3::from(*p)).collect();
    let mesh = Mesh { vertices, triangles: triangles.to_vec(), coordinates };
    with_builder(t, |_, b| b.mesh(mesh)).unwrap_or(0) as u64
}

unsafe extern "C" fn image(t: Option<&tatu_builder>, rgba: *const u8, width: u32, height: u32) -> u64 {
    let pixels = u64::from(width) * u64::from(height);
    if rgba.is_null() || pixels > MAX_IMAGE_PIXELS as u64 {
        let lacks =
            if rgba.is_null() { "its pointer is null".into() } else { format!("the limit is {MAX_IMAGE_PIXELS}") };
        let error = Error::new("E111", format!("an image of {width} x {height} pixels was refused: {lacks}"));
        with_builder(t, |_, _| Err::<(), _>(error));
        return 0;
    }
    // SAFETY: the pointer is not null, and the header requires 4 bytes per pixel, valid during the call.
    let rgba = unsafe { std::slice::from_raw_parts(rgba, 4 * pixels as usize) };
    with_builder(t, |_, b| b.image(width, height, rgba.to_vec())).unwrap_or(0) as u64
}

extern "C" fn script(
    t: Option<&tatu_builder>,
    owner: u32,
    language: LentCStr<'_>,
    dialect: LentCStr<'_>,
    kind: LentCStr<'_>,
    name: Lent<'_>,
    source: Lent<'_>,
) -> u32 {
    let (language, dialect, kind) = (clean(language), clean(dialect), clean(kind));
    let (name, text) = (texts::clean(&name.text()).into_owned(), source.bytes().to_vec());
    let added = with_builder(t, |build, b| {
        let owner = index(build, owner)?;
        let language =
            b.registry.language(if language.is_empty() { &name } else { &language }, &b.document.settings.providers)?;
        let kind = if kind.is_empty() { "child".into() } else { kind };
        if !SCRIPT_KINDS.contains(&kind.as_str()) {
            let error = Error::new("E102", format!("unknown script kind `{kind}`"));
            return Err(error.expected(SCRIPT_KINDS.join(", ")));
        }
        b.registry.check_dialect(Some(language), &dialect)?;
        let priority = crate::document::NORMAL_PRIORITY;
        b.script(owner, ScriptSpec { language, dialect, kind, priority, side_by_side: false, name, text })
    });
    added.map_or(0, |()| 1)
}

extern "C" fn device(t: Option<&tatu_builder>, object: u32, kind: LentCStr<'_>) -> tatu_status {
    with_builder(t, |build, b| b.device(index(build, object)?, &clean(kind))).map_or(TATU_ERR_MISSING, |()| TATU_OK)
}

extern "C" fn report(t: Option<&tatu_builder>, severity: u32, object: u32, said: Lent<'_>) {
    let said = texts::clean(&said.text()).into_owned();
    with_builder(t, |build, b| {
        if severity == TATU_REPORT_ERROR {
            return Err(Error::new("E111", said));
        }
        let whose = index(build, object).ok().and_then(|i| b.document.objects.get(i)).map(|o| o.alias.clone());
        let said = whose.map_or(said.clone(), |w| format!("`{w}`: {said}"));
        let text = build.source.name.as_ref().map_or(said.clone(), |f| format!("{f}: {said}"));
        match severity {
            TATU_REPORT_LACK => b.document.settings.lacks.push(text),
            _ => b.document.reports.push(BuildReport { severity, text }),
        }
        Ok(())
    });
}

extern "C" fn describe(t: Option<&tatu_builder>, map: Option<&ValueRef<'_>>) -> tatu_status {
    let Some(map) = map else { return TATU_ERR_ARGUMENT };
    let told = with_builder(t, |_, b| match map.to_value().unwrap_or_default() {
        map @ Value::Map(_) => {
            b.document.description = Some(map);
            Ok(())
        }
        _ => Err(Error::new("E102", "the description of a file must be a map")),
    });
    told.map_or(TATU_ERR_ARGUMENT, |()| TATU_OK)
}

extern "C" fn scene(t: Option<&tatu_builder>, parent: u32, name: Lent<'_>, text: Lent<'_>) -> tatu_status {
    let added = with_builder(t, |build, b| {
        let parent = if parent == 0 { build.parent } else { Some(index(build, parent)?) };
        let lacks = || Error::new("E112", "this build cannot read text in the scene format");
        let read = b.read_text.ok_or_else(lacks)?;
        let file = match name.text() {
            name if name.is_empty() => build.file.clone(),
            name => build.source.folder.as_ref().map(|folder| folder.join(&*name)),
        };
        read(b, &file.ok_or_else(lacks)?, &text.text(), parent)
    });
    added.map_or(TATU_ERR_ARGUMENT, |()| TATU_OK)
}

extern "C" fn file<'a>(t: Option<&'a tatu_builder>, relative: Lent<'_>, out: Option<&mut Lent<'a>>) -> tatu_status {
    let name = relative.text();
    let read = with_builder(t, |build, b| {
        let Some(folder) = &build.source.folder else { return Ok(None) };
        let Some(bytes) = b.read_named_file(folder, &name)? else { return Ok(None) };
        let mut files = build.files.borrow_mut();
        files.push(bytes);
        // The bytes of each inner vector keep their address when the outer vector grows.
        Ok(files.last().map(|b| tatu_plugins::border::raw(b)))
    });
    match (read.flatten(), out) {
        (Some(bytes), Some(out)) => {
            // SAFETY: `files` of the build owns the bytes, which are not changed, and lives as long as the table.
            *out = unsafe { Lent::new(bytes) };
            TATU_OK
        }
        (Some(_), None) => TATU_ERR_ARGUMENT,
        (None, _) => TATU_ERR_MISSING,
    }
}
