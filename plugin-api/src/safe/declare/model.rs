//! Models, which build objects from parameters.

use std::{
    ffi::{CString, c_void},
    sync::Arc,
};

use crate::abi::*;
use crate::safe::{
    Fail, Param, Params, Plugin, Result, Value, ValueRef,
    entry::panics,
    value::{list_cache::cached_list, owned::Owned, table_arena::TableArena},
};

/// A model, which builds objects from parameters.
pub trait Model: Sized + 'static {
    /// The plugin that offers this model.
    type Plugin: Plugin;
    /// Id of the model in scene files, such as "pioneer_p3dx".
    const ID: &'static str;
    /// Description for documentation and lists, one sentence.
    const TEXT: &'static str;
    /// Aliases of the objects to which other objects can be attached.
    const SLOTS: &'static [&'static str] = &[];

    /// Heading under which lists show the model, such as "mobile robots", "arms" or "furniture"; may be empty.
    const CATEGORY: &'static str = "";

    /// Names of the mounts with which the model fits a slot of another model; if empty, it fits every slot.
    const MOUNTS: &'static [&'static str] = &[];

    /// Declares the model's parameters.
    fn params() -> Vec<Param>;
    /// Builds the model; the first object is its base, placed such that the model stands on the floor z = 0.
    fn build(builder: &Builder<'_>, params: &Params<'_>) -> Result;
}

/// Builds the document of a model or import.
#[derive(Clone, Copy)]
pub struct Builder<'a> {
    raw: &'a tatu_builder,
}

/// An object that is being built.
#[derive(Clone, Copy)]
pub struct Node<'a> {
    builder: Builder<'a>,
    id: u32,
}

impl<'a> Builder<'a> {
    pub(crate) fn new(raw: &'a tatu_builder) -> Self {
        Builder { raw }
    }
    /// Returns the builder in the form of the ABI, for functions without a wrapper.
    pub fn raw(&self) -> &'a tatu_builder {
        self.raw
    }
    /// Adds an object of a kind, such as "shape", "joint", "dummy", "sensor" or "force_sensor", below `parent`, or at the
    /// top level of the build if that is `None`.
    pub fn object(&self, kind: &str, parent: Option<Node<'a>>, alias: &str) -> Result<Node<'a>> {
        let text = CString::new(kind).unwrap_or_default();
        let parent = parent.map_or(0, |p| p.id);
        match self.raw.object.map_or(0, |f| f(Some(self.raw), text.as_c_str().into(), parent, alias.into())) {
            0 => Err(Fail::new(format!("the host rejected the {kind} `{alias}`"))),
            id => Ok(Node { builder: *self, id }),
        }
    }
    /// Adds a triangle mesh; returns its number for the property "mesh".
    pub fn mesh(&self, points: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<i64> {
        let (n, m) = (points.len() as u64, triangles.len() as u64);
        let (points, triangles) = (points.as_ptr().cast(), triangles.as_ptr().cast());
        // SAFETY: the pointers and counts are those of the slices, with 3 numbers per element.
        match self.raw.mesh.map_or(0, |f| unsafe { f(Some(self.raw), points, n, triangles, m) }) {
            0 => Err(Fail::new(format!("the host rejected a mesh of {n} points and {m} triangles"))),
            id => Ok(id as i64),
        }
    }
    /// Adds a triangle mesh with texture coordinates, for textures whose mapping is "mesh": the position of each point
    /// in the image, 0 to 1 to the right and up. Without coordinates, or in a host that only projects images, this is
    /// the same as [`Builder::mesh`].
    pub fn textured_mesh(&self, points: &[[f64; 3]], coordinates: &[[f32; 2]], triangles: &[[u32; 3]]) -> Result<i64> {
        let end = std::mem::offset_of!(tatu_builder, textured_mesh) + size_of::<usize>();
        let known = !coordinates.is_empty() && self.raw.size as usize >= end;
        let Some(add) = self.raw.textured_mesh.filter(|_| known) else {
            return self.mesh(points, triangles);
        };
        let (n, m) = (points.len() as u64, triangles.len() as u64);
        if coordinates.len() != points.len() {
            return Err(Fail::argument(format!(
                "a mesh must have one texture coordinate per point, but has {} for {n} points",
                coordinates.len()
            )));
        }
        let (points, triangles) = (points.as_ptr().cast(), triangles.as_ptr().cast());
        // SAFETY: the pointers and counts are those of the slices, with 3 numbers per point and triangle, and 2 per
        // coordinate.
        match unsafe { add(Some(self.raw), points, coordinates.as_ptr().cast(), n, triangles, m) } {
            0 => Err(Fail::new(format!("the host rejected a mesh of {n} points and {m} triangles"))),
            id => Ok(id as i64),
        }
    }
    /// Adds an image of 4 bytes per pixel, top row first; returns its number for the property "texture" of shapes.
    pub fn image(&self, rgba: &[u8], columns: u32, rows: u32) -> Result<i64> {
        let refused = || Fail::new(format!("the host rejected an image of {columns} x {rows} pixels"));
        if rgba.len() as u64 != 4 * u64::from(columns) * u64::from(rows) {
            return Err(refused());
        }
        // SAFETY: the slice has 4 bytes per pixel.
        match self.raw.image.map_or(0, |f| unsafe { f(Some(self.raw), rgba.as_ptr(), columns, rows) }) {
            0 => Err(refused()),
            id => Ok(id as i64),
        }
    }
    /// Reads a file, whose path is relative to the folder of the source; the bytes are valid during the build. Returns
    /// `None` if the file cannot be read, for example because it does not exist. A path outside the folders that may be
    /// read makes the build fail.
    pub fn file(&self, relative: &str) -> Option<&'a [u8]> {
        let mut out = Lent::EMPTY;
        let status = self.raw.file?(Some(self.raw), relative.into(), Some(&mut out));
        (status >= 0).then(|| out.bytes())
    }
    /// Sets a parameter of the world, such as "scene.dt", in SI units, or its free data, "scene.data". Such a setting
    /// has an effect only if an importer's file is opened as the scene.
    pub fn setting(&self, key: &str, value: impl Into<Value>) -> Result {
        (Node { builder: *self, id: 0 }).set(key, value).map(drop)
    }
    /// Returns whether the host requested a description of the source: see [`Builder::describe`].
    pub fn is_asked(&self) -> bool {
        self.raw.describe.is_some()
    }
    /// Passes the host a description of the source, a map with text keys, if the host requested one.
    pub fn describe(&self, map: &Value) -> Result {
        let Some(f) = self.raw.describe else { return Ok(()) };
        match f(Some(self.raw), Some(&Owned::default().value(map))) {
            status if status < 0 => Err(Fail::with_code(status, "the host rejected the description of the source")),
            _ => Ok(()),
        }
    }
    /// Adds the objects that a text in the scene format describes; those without a parent are added below `parent`.
    /// `name` is the name of the file that contains the text, relative to the folder of the source.
    pub fn scene(&self, parent: Option<Node<'a>>, name: &str, text: &str) -> Result {
        let parent = parent.map_or(0, |p| p.id);
        match self.raw.scene.map_or(TATU_ERR_UNSUPPORTED, |f| f(Some(self.raw), parent, name.into(), text.into())) {
            status if status < 0 => Err(Fail::with_code(status, format!("the host rejected the text of `{name}`"))),
            _ => Ok(()),
        }
    }
    /// Returns the base of the model or import that is being built, which is its first object.
    pub fn base(&self) -> Node<'a> {
        Node { builder: *self, id: 1 }
    }
    /// Reports a problem of the source; `severity` is one of `TATU_REPORT_*`.
    pub fn report(&self, severity: u32, node: Option<Node<'a>>, text: &str) {
        if let Some(f) = self.raw.report {
            f(Some(self.raw), severity, node.map_or(0, |n| n.id), text.into());
        }
    }
}

impl<'a> Node<'a> {
    /// Returns the object's number in this build; the base is 1.
    pub fn id(&self) -> u32 {
        self.id
    }
    /// Sets a property, such as "mass", "position" or "color", in SI units. Returns the node.
    pub fn set(self, key: &str, value: impl Into<Value>) -> Result<Self> {
        let text = CString::new(key).unwrap_or_default();
        let (raw, mut owned) = (self.builder.raw, Owned::default());
        let value = owned.value(&value.into());
        match raw.set.map_or(TATU_ERR_UNSUPPORTED, |f| f(Some(raw), self.id, text.as_c_str().into(), Some(&value))) {
            status if status < 0 => Err(Fail::with_code(status, format!("the host rejected the property `{key}`"))),
            _ => Ok(self),
        }
    }
    /// Sets the device of an object of kind "sensor" or "actuator": its kind, or a schema that the kind must fill.
    pub fn device(self, kind_or_schema: &str) -> Result<Self> {
        let text = CString::new(kind_or_schema).unwrap_or_default();
        let raw = self.builder.raw;
        match raw.device.map_or(TATU_ERR_UNSUPPORTED, |f| f(Some(raw), self.id, text.as_c_str().into())) {
            status if status < 0 => {
                Err(Fail::with_code(status, format!("the host rejected the device `{kind_or_schema}`")))
            }
            _ => Ok(self),
        }
    }
    /// Adds a script. `language` is the id of its language; `dialect` may be "", to be inferred from the source `text`;
    /// `kind` is "child", "customization" or "main".
    pub fn script(self, language: &str, dialect: &str, kind: &str, name: &str, text: &[u8]) -> Result<Self> {
        let [language, dialect, kind] = [language, dialect, kind].map(|s| CString::new(s).unwrap_or_default());
        let raw = self.builder.raw;
        let dialect = if dialect.is_empty() { LentCStr::NULL } else { dialect.as_c_str().into() };
        let (language, kind) = (language.as_c_str().into(), kind.as_c_str().into());
        match raw.script.map_or(0, |f| f(Some(raw), self.id, language, dialect, kind, name.into(), text.into())) {
            0 => Err(Fail::new(format!("the host rejected the script `{name}`"))),
            _ => Ok(self),
        }
    }
}

struct ModelParams<M>(M);

fn params_of<M: Model>() -> Arc<[Param]> {
    cached_list::<ModelParams<M>, _>(M::params)
}

pub(crate) fn table<M: Model>(keep: &mut TableArena) -> *const tatu_model {
    let params = params_of::<M>().iter().map(|p| p.to_table(keep)).collect();
    let raw = tatu_model {
        size: size_of::<tatu_model>() as u32,
        flags: 0,
        id: keep.text(M::ID),
        text: keep.text(M::TEXT),
        params: keep.list(params),
        slots: keep.texts(M::SLOTS),
        build: Some(build::<M>),
        category: if M::CATEGORY.is_empty() { std::ptr::null() } else { keep.text(M::CATEGORY) },
        licence: std::ptr::null(),
        mounts: keep.texts(M::MOUNTS),
        slot_infos: std::ptr::null(),
        numbers: std::ptr::null(),
    };
    keep.table(raw)
}

unsafe extern "C" fn build<M: Model>(
    _: *mut c_void,
    builder: *const tatu_builder,
    params: *const tatu_value,
    error: *mut tatu_error,
) -> tatu_status {
    panics::run(error, || {
        let declared = params_of::<M>();
        // SAFETY: the host passes a builder that is valid during the call, and one value per declared parameter.
        let (raw, values) = unsafe { (&*builder, ValueRef::slice(params, declared.len())) };
        M::build(&Builder::new(raw), &Params::new(values, &declared))?;
        Ok(TATU_OK)
    })
}
