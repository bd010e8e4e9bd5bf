//! The builder as plugins see it.

use std::{cell::RefCell, ffi::c_char, path::PathBuf};

use nalgebra::Point3;
use tatu_errors::{Error, Result};
use tatu_geometry::Mesh;
use tatu_plugin_api::{
    abi::*,
    safe::{Value, ValueRef},
};
use tatu_plugins::{
    Declared,
    border::{ErrorSlot, answer, bytes, text},
    texts,
    watchdog::Call,
};

use super::{Builder, SCRIPT_KINDS, ScriptSpec, import_files::Source};

/// One build: the builder, and what has gone wrong so far.
struct Build<'b, 'a> {
    builder: RefCell<&'b mut Builder<'a>>,
    /// Index of the plugin's object 1.
    first: usize,
    parent: Option<usize>,
    error: RefCell<Option<Error>>,
    source: Source,
    files: RefCell<Vec<Vec<u8>>>,
}

/// Why a build failed.
pub(super) enum Failed {
    /// The plugin broke the contract.
    Breach(Error),
    /// What the host refused first.
    Refused(Error),
    /// What the plugin said itself.
    Said(ErrorSlot),
}

/// Which function of which plugin runs.
pub(super) struct Asked<'a> {
    pub plugin: usize,
    pub call: Call,
    /// What is built, for messages.
    pub subject: &'a str,
}

/// Runs a model's build function.
pub(super) fn run_model(
    builder: &mut Builder<'_>,
    model: usize,
    params: &[(String, Value)],
    parent: Option<usize>,
) -> Result {
    let registry = builder.registry;
    let info = &registry.models[model];
    let folder = builder.document.file.as_ref().and_then(|f| f.parent().map(PathBuf::from));
    let source = Source { name: None, roots: folder.iter().cloned().collect(), folder, whole: false };
    let me = registry.plugins[info.plugin].me;
    let asked = Asked { plugin: info.plugin, call: Call::Build, subject: &format!("the model `{}`", info.id) };
    let first = builder.document.objects.len();
    let done = run(builder, asked, source, (&info.params, params), parent, |table, params, error| {
        // SAFETY: by the contract; the table and the parameters live through the call.
        info.raw.build.map_or(TATU_OK, |f| unsafe { f(me, table, params, error) })
    });
    let plugin = &registry.plugins[info.plugin].id;
    let built = builder.document.objects.get(first..).unwrap_or_default();
    let lost = info.slots.iter().find(|s| !built.iter().any(|o| o.alias == **s)).filter(|_| done.is_ok());
    if let Some(slot) = lost {
        let text = format!("the model `{}`: it builds no object `{slot}`, which it declares as a slot", info.id);
        return Err(Error::new("E111", format!("{text} [{} of `{plugin}`]", Call::Build.text()))
            .help("build it, or take it out of `tatu_model.slots`; report it to the plugin's authors"));
    }
    done.map_err(|failed| match failed {
        Failed::Breach(e) => e,
        Failed::Refused(e) => {
            let text = format!("the model `{}`: {} [{} of `{plugin}`]", info.id, e.text, Call::Build.text());
            Error { text, ..e }
        }
        Failed::Said(said) => {
            let text = format!("the model `{}` cannot be built: plugin `{plugin}` {}", info.id, said.text());
            Error::new("E111", format!("{text} [{}]", Call::Build.text()))
        }
    })
}

/// Runs a plugin's function that writes into the builder, with its parameters, defaults filled in.
pub(super) fn run(
    builder: &mut Builder<'_>,
    asked: Asked<'_>,
    source: Source,
    (declared, params): (&[Declared], &[(String, Value)]),
    parent: Option<usize>,
    call: impl FnOnce(*const tatu_builder, *const tatu_value, *mut tatu_error) -> tatu_status,
) -> Result<(), Failed> {
    let registry = builder.registry;
    let mut room: Vec<Vec<u64>> = Vec::new();
    let raw: Vec<tatu_value> = declared
        .iter()
        .map(|p| {
            let given = params.iter().rev().find(|(k, _)| *k == p.key).map_or(&p.fallback, |(_, v)| v);
            let mut alloc = |n: usize| {
                room.push(vec![0; n.div_ceil(8).max(1)]);
                room.last_mut().map_or(std::ptr::null_mut(), |r| r.as_mut_ptr().cast())
            };
            given.to_raw(&mut alloc).unwrap_or(ValueRef::NIL.raw())
        })
        .collect();
    let builder_describes = builder.document.describe;
    let build = Build {
        first: builder.document.objects.len(),
        builder: RefCell::new(builder),
        parent,
        error: RefCell::new(None),
        source,
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
    };
    let mut slot = ErrorSlot::new();
    // SAFETY: the host's own error object.
    let answered = registry.watched(asked.plugin, asked.call, asked.subject, || unsafe {
        answer(call(&table, raw.as_ptr(), slot.raw()), false, slot.raw())
    });
    let refused = build.error.into_inner();
    match (answered, refused) {
        (Err(e), _) => Err(Failed::Breach(e)),
        (_, Some(e)) => Err(Failed::Refused(e)),
        (Ok(status), None) if status < 0 => Err(Failed::Said(slot)),
        _ => Ok(()),
    }
}

/// Runs one function of the table; an error is kept for the end of the build, the first one.
///
/// # Safety
/// `table` is one that [`run`] made, during its build.
unsafe fn with<T>(table: *const tatu_builder, f: impl FnOnce(&Build, &mut Builder<'_>) -> Result<T>) -> Option<T> {
    // SAFETY: the caller promises it.
    let build = unsafe { &*(*table).ctx.cast::<Build<'_, '_>>() };
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

/// # Safety
/// `s` is null or NUL-terminated.
unsafe fn c_text(s: *const c_char) -> String {
    if s.is_null() {
        return String::new();
    }
    // SAFETY: the caller promises it.
    texts::clean(&unsafe { std::ffi::CStr::from_ptr(s) }.to_string_lossy()).into_owned()
}

/// The index of an object that a plugin names by its number in the build. Whether it is there yet, the builder tells.
fn index(build: &Build, object: u32) -> Result<usize> {
    match object {
        0 => Err(Error::new("E110", "object 0 of a build is the place where it will stand, and cannot be changed")),
        n => Ok(build.first + n as usize - 1),
    }
}

unsafe extern "C" fn object(t: *const tatu_builder, kind: *const c_char, parent: u32, alias: tatu_str) -> u32 {
    // SAFETY: by the contract; likewise in all functions below.
    unsafe {
        let (kind, alias) = (c_text(kind), text(alias));
        with(t, |build, b| {
            let parent = if parent == 0 { build.parent } else { Some(index(build, parent)?) };
            Ok((b.object(&kind, parent, &alias)? - build.first + 1) as u32)
        })
        .unwrap_or(0)
    }
}

unsafe extern "C" fn set(
    t: *const tatu_builder,
    object: u32,
    key: *const c_char,
    value: *const tatu_value,
) -> tatu_status {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    unsafe {
        let key = c_text(key);
        let Some(value) = value.as_ref() else { return TATU_ERR_ARGUMENT };
        let value = ValueRef::new(*value).to_value().unwrap_or_default();
        with(t, |build, b| match object {
            0 if key.starts_with("scene.") => b.setting(&key, value, build.source.whole),
            n => b.set(index(build, n)?, &key, value),
        })
        .map_or(TATU_ERR_ARGUMENT, |()| TATU_OK)
    }
}

unsafe extern "C" fn mesh(
    t: *const tatu_builder,
    points: *const f64,
    n_points: u64,
    triangles: *const u32,
    n_triangles: u64,
) -> u64 {
    if points.is_null() || triangles.is_null() {
        return 0;
    }
    // SAFETY: by the contract, what a plugin passes is valid during the call; 3 numbers per point and triangle.
    unsafe {
        let points = std::slice::from_raw_parts(points.cast::<[f64; 3]>(), n_points as usize);
        let triangles = std::slice::from_raw_parts(triangles.cast::<[u32; 3]>(), n_triangles as usize);
        let mesh = Mesh { vertices: points.iter().map(|p| Point3::from(*p)).collect(), triangles: triangles.to_vec() };
        with(t, |_, b| b.mesh(mesh)).unwrap_or(0) as u64
    }
}

unsafe extern "C" fn image(t: *const tatu_builder, _: *const u8, _: u32, _: u32) -> u64 {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    unsafe {
        with(t, |_, _| Err::<(), _>(Error::new("E112", "this host does not draw images on shapes yet")));
    }
    0
}

unsafe extern "C" fn script(
    t: *const tatu_builder,
    owner: u32,
    language: *const c_char,
    dialect: *const c_char,
    kind: *const c_char,
    name: tatu_str,
    source: tatu_str,
) -> u32 {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    unsafe {
        let (language, dialect, kind) = (c_text(language), c_text(dialect), c_text(kind));
        let (name, source) = (texts::clean(&text(name)).into_owned(), bytes(source).to_vec());
        with(t, |build, b| {
            let owner = index(build, owner)?;
            let language = b
                .registry
                .language(if language.is_empty() { &name } else { &language }, &b.document.settings.providers)?;
            let kind = if kind.is_empty() { "child".into() } else { kind };
            if !SCRIPT_KINDS.contains(&kind.as_str()) {
                let error = Error::new("E102", format!("a script of kind `{kind}`"));
                return Err(error.expected(SCRIPT_KINDS.join(", ")));
            }
            b.registry.check_dialect(Some(language), &dialect)?;
            b.script(
                owner,
                ScriptSpec {
                    language,
                    dialect,
                    kind,
                    priority: crate::document::NORMAL,
                    side_by_side: false,
                    name,
                    text: source,
                },
            )
        })
        .map_or(0, |()| 1)
    }
}

unsafe extern "C" fn device(t: *const tatu_builder, object: u32, kind: *const c_char) -> tatu_status {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    unsafe {
        let kind = c_text(kind);
        with(t, |build, b| b.device(index(build, object)?, &kind)).map_or(TATU_ERR_MISSING, |()| TATU_OK)
    }
}

unsafe extern "C" fn report(t: *const tatu_builder, severity: u32, object: u32, said: tatu_str) {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    unsafe {
        let said = texts::clean(&text(said)).into_owned();
        with(t, |build, b| {
            if severity == TATU_REPORT_ERROR {
                return Err(Error::new("E111", said));
            }
            let whose = index(build, object).ok().and_then(|i| b.document.objects.get(i)).map(|o| o.alias.clone());
            let said = whose.map_or(said.clone(), |w| format!("`{w}`: {said}"));
            b.document.reports.push(build.source.name.as_ref().map_or(said.clone(), |f| format!("{f}: {said}")));
            Ok(())
        });
    }
}

unsafe extern "C" fn describe(t: *const tatu_builder, map: *const tatu_value) -> tatu_status {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    unsafe {
        let Some(map) = map.as_ref() else { return TATU_ERR_ARGUMENT };
        let map = ValueRef::new(*map).to_value().unwrap_or_default();
        with(t, |_, b| match map {
            Value::Map(_) => {
                b.document.description = Some(map);
                Ok(())
            }
            _ => Err(Error::new("E102", "the description of a file is no map")),
        })
        .map_or(TATU_ERR_ARGUMENT, |()| TATU_OK)
    }
}

unsafe extern "C" fn file(t: *const tatu_builder, relative: tatu_str, out: *mut tatu_str) -> tatu_status {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    unsafe {
        let name = text(relative).into_owned();
        let read = with(t, |build, b| {
            let Some(bytes) = build.source.read(&name, &b.document.sources)? else { return Ok(None) };
            let mut files = build.files.borrow_mut();
            files.push(bytes);
            // The bytes of a vector stay where they are when the vector of vectors grows.
            Ok(files.last().map(|b| tatu_plugins::border::raw(b)))
        });
        match read.flatten() {
            Some(s) => {
                *out = s;
                TATU_OK
            }
            None => TATU_ERR_MISSING,
        }
    }
}
