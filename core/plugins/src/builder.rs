//! The builder table, through which the functions of models and importers add objects to a document.

use std::{cell::RefCell, ffi::c_void};

use tatu_plugin_api::{abi::*, safe::Value};

use crate::{Importer, Model, Registry, border::ErrorSlot};

/// The implementation of the functions of the builder table. A function that fails returns `None` and stores the
/// reason.
pub trait BuildTarget {
    /// Adds an object; returns its number in the build.
    fn object(&self, kind: LentCStr<'_>, parent: u32, alias: Lent<'_>) -> Option<u32>;
    /// Sets a property of an object or, for object 0, a setting.
    fn set(&self, object: u32, key: LentCStr<'_>, value: Value) -> Option<()>;
    /// Adds a mesh; returns its number. `coordinates` is empty or has one entry per point.
    fn mesh(&self, points: &[[f64; 3]], coordinates: &[[f32; 2]], triangles: &[[u32; 3]]) -> Option<u64>;
    /// Adds an image of 4 bytes per pixel; returns its number.
    fn image(&self, width: u32, height: u32, rgba: &[u8]) -> Option<u64>;
    /// Adds a script to an object.
    fn script(&self, owner: u32, script: BuiltScript<'_>) -> Option<()>;
    /// Makes an object a sensor or an actuator of this kind.
    fn device(&self, object: u32, kind: LentCStr<'_>) -> Option<()>;
    /// Stores a message about the build. If the severity is that of an error, the build fails.
    fn report(&self, severity: u32, object: u32, text: Lent<'_>) -> Option<()>;
    /// Stores the description of the file.
    fn describe(&self, map: Value) -> Option<()>;
    /// Adds the objects that a text in the scene format describes.
    fn scene(&self, parent: u32, name: Lent<'_>, text: Lent<'_>) -> Option<()>;
    /// Reads a file in the folder of the build.
    fn file(&self, relative: Lent<'_>) -> Option<Vec<u8>>;
    /// Makes the build fail with this message.
    fn refuse(&self, text: String);
}

/// A script that is added to an object.
pub struct BuiltScript<'a> {
    /// Language; may be empty.
    pub language: LentCStr<'a>,
    /// Dialect; may be empty.
    pub dialect: LentCStr<'a>,
    /// Kind of the script; may be empty.
    pub kind: LentCStr<'a>,
    /// Name for messages.
    pub name: Lent<'a>,
    /// Source code.
    pub source: Lent<'a>,
}

/// The plugin function that builds a document or a part of one.
#[derive(Clone, Copy)]
pub enum BuildFunction<'a> {
    /// The function that builds a model.
    Model(&'a Model),
    /// The function that imports a file, with the contents of the file.
    Importer(&'a Importer, &'a [u8]),
}

/// Limits and options of a build.
#[derive(Debug, Clone, Copy)]
pub struct BuildOptions {
    /// Maximum number of pixels of an image.
    pub max_image_pixels: u64,
    /// Whether the importer should also describe the file.
    pub describes: bool,
}

/// The data to which the `ctx` of the table points.
struct BuildContext<'a> {
    target: &'a dyn BuildTarget,
    max_image_pixels: u64,
    /// The files that were read, which plugins may use until the end of the build.
    files: RefCell<Vec<Vec<u8>>>,
}

impl Registry {
    /// Calls the function of a model or an importer with the values of its parameters. The caller must record the call
    /// for the watchdog.
    pub fn build(
        &self,
        function: BuildFunction<'_>,
        target: &dyn BuildTarget,
        options: BuildOptions,
        params: &[ValueRef<'_>],
        error: &mut ErrorSlot,
    ) -> tatu_status {
        let context =
            BuildContext { target, max_image_pixels: options.max_image_pixels, files: RefCell::new(Vec::new()) };
        let table = tatu_builder {
            size: size_of::<tatu_builder>() as u32,
            reserved: 0,
            ctx: (&raw const context).cast_mut().cast::<c_void>(),
            object: Some(object),
            set: Some(set),
            mesh: Some(mesh),
            image: Some(image),
            script: Some(script),
            device: Some(device),
            report: Some(report),
            file: Some(file),
            describe: options.describes.then_some(describe),
            model: match function {
                BuildFunction::Model(model) => model.given,
                BuildFunction::Importer(..) => std::ptr::null(),
            },
            scene: Some(scene),
            textured_mesh: Some(textured_mesh),
        };
        let params = params.as_ptr().cast();
        // SAFETY: the function is from a plugin of this registry, which is not shut down while the registry is borrowed,
        // and gets the plugin's own pointer. The bytes, the table, the parameters and the error object live until the
        // call has returned.
        let status = unsafe {
            match function {
                BuildFunction::Model(model) => {
                    let me = self.plugins[model.plugin].me;
                    model.raw.build.map_or(TATU_OK, |f| f(me, &table, params, error.raw()))
                }
                BuildFunction::Importer(importer, bytes) => {
                    let me = self.plugins[importer.plugin].me;
                    let copy = self.inspector.as_ref().and_then(|i| i.copy_of_source(importer.plugin, bytes));
                    let bytes = copy.as_ref().map_or(bytes, |c| c.bytes());
                    importer.raw.load.map_or(TATU_OK, |f| f(me, Lent::from(bytes).raw(), &table, params, error.raw()))
                }
            }
        };
        error.check_status(status, false)
    }
}

/// Returns the build that a table belongs to.
fn context(table: Option<&tatu_builder>) -> Option<&BuildContext<'_>> {
    // SAFETY: the header requires the table to be the one that was passed to the plugin, which `build` created; the
    // build lives until the plugin's call has returned, as does the borrow of the table.
    Some(unsafe { &*table?.ctx.cast::<BuildContext<'_>>() })
}

fn target(table: Option<&tatu_builder>) -> Option<&dyn BuildTarget> {
    context(table).map(|build| build.target)
}

fn status(done: Option<()>, failed: tatu_status) -> tatu_status {
    done.map_or(failed, |()| TATU_OK)
}

extern "C" fn object(t: Option<&tatu_builder>, kind: LentCStr<'_>, parent: u32, alias: Lent<'_>) -> u32 {
    target(t).and_then(|to| to.object(kind, parent, alias)).unwrap_or(0)
}

extern "C" fn set(
    t: Option<&tatu_builder>,
    object: u32,
    key: LentCStr<'_>,
    value: Option<&ValueRef<'_>>,
) -> tatu_status {
    let Some(value) = value else { return TATU_ERR_ARGUMENT };
    let value = value.to_value().unwrap_or_default();
    status(target(t).and_then(|to| to.set(object, key, value)), TATU_ERR_ARGUMENT)
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
    let Some(target) = target(t) else { return 0 };
    if points.is_null() || triangles.is_null() {
        let lacks = if points.is_null() { "points" } else { "triangles" };
        target
            .refuse(format!("a mesh of {n_points} points and {n_triangles} triangles has a null pointer for {lacks}"));
        return 0;
    }
    // SAFETY: the header requires 3 numbers per point and per triangle, and 2 coordinates per point unless the pointer is
    // null, valid during the call.
    let (points, coordinates, triangles) = unsafe {
        let n = n_points as usize;
        let coordinates = match coordinates.is_null() {
            true => &[],
            false => std::slice::from_raw_parts(coordinates.cast::<[f32; 2]>(), n),
        };
        (
            std::slice::from_raw_parts(points.cast::<[f64; 3]>(), n),
            coordinates,
            std::slice::from_raw_parts(triangles.cast::<[u32; 3]>(), n_triangles as usize),
        )
    };
    target.mesh(points, coordinates, triangles).unwrap_or(0)
}

unsafe extern "C" fn image(t: Option<&tatu_builder>, rgba: *const u8, width: u32, height: u32) -> u64 {
    let Some(build) = context(t) else { return 0 };
    let pixels = u64::from(width) * u64::from(height);
    if rgba.is_null() || pixels > build.max_image_pixels {
        let most = build.max_image_pixels;
        let why = if rgba.is_null() { "its pointer is null".into() } else { format!("the limit is {most} pixels") };
        build.target.refuse(format!("an image of {width} x {height} pixels was refused: {why}"));
        return 0;
    }
    // SAFETY: the pointer is not null, and the header requires 4 bytes per pixel, valid during the call.
    let rgba = unsafe { std::slice::from_raw_parts(rgba, 4 * pixels as usize) };
    build.target.image(width, height, rgba).unwrap_or(0)
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
    let script = BuiltScript { language, dialect, kind, name, source };
    target(t).and_then(|to| to.script(owner, script)).map_or(0, |()| 1)
}

extern "C" fn device(t: Option<&tatu_builder>, object: u32, kind: LentCStr<'_>) -> tatu_status {
    status(target(t).and_then(|to| to.device(object, kind)), TATU_ERR_MISSING)
}

extern "C" fn report(t: Option<&tatu_builder>, severity: u32, object: u32, said: Lent<'_>) {
    target(t).and_then(|to| to.report(severity, object, said));
}

extern "C" fn describe(t: Option<&tatu_builder>, map: Option<&ValueRef<'_>>) -> tatu_status {
    let Some(map) = map else { return TATU_ERR_ARGUMENT };
    let map = map.to_value().unwrap_or_default();
    status(target(t).and_then(|to| to.describe(map)), TATU_ERR_ARGUMENT)
}

extern "C" fn scene(t: Option<&tatu_builder>, parent: u32, name: Lent<'_>, text: Lent<'_>) -> tatu_status {
    status(target(t).and_then(|to| to.scene(parent, name, text)), TATU_ERR_ARGUMENT)
}

extern "C" fn file<'a>(t: Option<&'a tatu_builder>, relative: Lent<'_>, out: Option<&mut Lent<'a>>) -> tatu_status {
    let Some(build) = context(t) else { return TATU_ERR_MISSING };
    let Some(bytes) = build.target.file(relative) else { return TATU_ERR_MISSING };
    let Some(out) = out else { return TATU_ERR_ARGUMENT };
    let mut files = build.files.borrow_mut();
    files.push(bytes);
    let bytes = files.last().map_or(Lent::EMPTY, |bytes| Lent::from(bytes.as_slice())).raw();
    // SAFETY: `files` of the build owns the bytes, which do not move when it grows and are not changed. It lives until
    // the plugin's call has returned, as does the borrow of the table.
    *out = unsafe { Lent::new(bytes) };
    TATU_OK
}
