//! Models that a plugin reads from text files.

use std::{ffi::c_void, ptr::null, sync::PoisonError};

use crate::abi::*;
use crate::safe::{
    Builder, Fail, Param, Params, Plugin, Result, Value, ValueRef,
    declare::plugin::StartedPlugin,
    entry::panics,
    value::{fail::bytes_of, table_arena::TableArena},
};

/// A reader of models that are described by text.
pub trait ModelReader: Sized + 'static {
    /// The plugin that offers this reader.
    type Plugin: Plugin;
    /// The reader's own representation of a model.
    type Model: 'static;

    /// Reads a model from the text of its file; `name` is the name of the file's folder. After [`Fail::unsupported`],
    /// the host calls the next reader; all other errors must state the line with [`Fail::at`].
    fn read(plugin: &Self::Plugin, name: &str, text: &str) -> Result<(ModelInfo, Self::Model)>;
    /// Builds the model; the first object is its base. [`Builder::scene`] may call this function recursively.
    fn build(model: &Self::Model, builder: &Builder<'_>, params: &Params<'_>) -> Result;
}

/// The declaration of a model that was read.
#[derive(Debug, Clone, Default)]
pub struct ModelInfo {
    /// Description of the model, one sentence.
    pub text: String,
    /// Heading under which lists show the model; may be empty.
    pub category: String,
    /// Licence as an SPDX expression; if empty, that of the plugin.
    pub licence: String,
    /// Names of the mounts with which the model fits a slot of another model; if empty, it fits every slot.
    pub mounts: Vec<String>,
    /// Its parameters, in the order in which they are documented.
    pub params: Vec<Param>,
    /// Objects to which other models can be attached.
    pub slots: Vec<ModelSlot>,
    /// Its constants with their sources, for the documentation.
    pub numbers: Vec<ModelNumber>,
}

/// An object of a model to which other models can be attached.
#[derive(Debug, Clone, Default)]
pub struct ModelSlot {
    /// Alias of the object.
    pub alias: String,
    /// Name of the mount that fits, such as "iso9409-50-4-m6"; if empty, every mount fits.
    pub mount: String,
    /// One sentence that describes where the slot is.
    pub text: String,
    /// Attached mass, kg, above which the host warns; 0 if it is not stated.
    pub payload: f64,
}

/// A constant of a model, with the source of its value.
#[derive(Debug, Clone)]
pub struct ModelNumber {
    /// Name, as documented.
    pub name: String,
    /// Value, in SI units.
    pub value: Value,
    /// Unit; may be empty.
    pub unit: String,
    /// The document that states the value, or the reasoning behind an estimate.
    pub source: String,
}

/// A model that was read. The table must be the first field, because `build` casts its address to that of the struct.
#[repr(C)]
struct StoredModel<R: ModelReader> {
    raw: tatu_model,
    params: Vec<Param>,
    model: R::Model,
}

pub(crate) unsafe extern "C" fn read<R: ModelReader>(
    me: *mut c_void,
    name: tatu_str,
    text: tatu_str,
    out: *mut *const tatu_model,
    error: *mut tatu_error,
) -> tatu_status {
    panics::run(error, || {
        // SAFETY: `me` was created by `init` and is live until shutdown; the texts and `out` are valid during the call.
        let (started, name, text, out) =
            unsafe { (&*me.cast::<StartedPlugin<R::Plugin>>(), bytes_of(name), bytes_of(text), out.as_mut()) };
        let utf8 = |bytes| std::str::from_utf8(bytes).map_err(|_| Fail::argument("the text is not UTF-8"));
        let (name, text) = (utf8(name)?, utf8(text)?);
        let out = out.ok_or_else(|| Fail::argument("the host passed no address for the model"))?;
        let lock = || started.model_cache.lock().unwrap_or_else(PoisonError::into_inner);
        let known = lock().models.iter().find(|(n, t, _)| n == name && t == text).map(|(_, _, model)| *model);
        let model = match known {
            Some(model) => model,
            None => {
                let (info, model) = R::read(&started.plugin, name, text)?;
                let mut read = lock();
                let raw = table::<R>(&mut read.arena, name, &info);
                let kept = read.arena.table(StoredModel::<R> { raw, params: info.params, model }).cast();
                read.models.push((name.to_owned(), text.to_owned(), kept));
                kept
            }
        };
        *out = model;
        Ok(TATU_OK)
    })
}

fn table<R: ModelReader>(keep: &mut TableArena, name: &str, info: &ModelInfo) -> tatu_model {
    let optional = |keep: &mut TableArena, text: &str| if text.is_empty() { null() } else { keep.text(text) };
    let params = info.params.iter().map(|p| p.to_table(keep)).collect();
    let slot = |keep: &mut TableArena, s: &ModelSlot| {
        let raw = tatu_model_slot {
            size: size_of::<tatu_model_slot>() as u32,
            reserved: 0,
            alias: keep.text(&s.alias),
            mount: optional(keep, &s.mount),
            text: optional(keep, &s.text),
            payload: s.payload,
        };
        keep.table(raw)
    };
    let slots = info.slots.iter().map(|s| slot(keep, s)).collect();
    let number = |keep: &mut TableArena, n: &ModelNumber| {
        let raw = tatu_model_number {
            size: size_of::<tatu_model_number>() as u32,
            reserved: 0,
            name: keep.text(&n.name),
            value: keep.value(&n.value),
            unit: optional(keep, &n.unit),
            source: optional(keep, &n.source),
        };
        keep.table(raw)
    };
    let numbers = info.numbers.iter().map(|n| number(keep, n)).collect();
    let aliases: Vec<&str> = info.slots.iter().map(|s| s.alias.as_str()).collect();
    tatu_model {
        size: size_of::<tatu_model>() as u32,
        flags: 0,
        id: keep.text(name),
        text: keep.text(&info.text),
        params: keep.list(params),
        slots: keep.texts(&aliases),
        build: Some(build::<R>),
        category: optional(keep, &info.category),
        licence: optional(keep, &info.licence),
        mounts: keep.texts(&info.mounts),
        slot_infos: keep.list(slots),
        numbers: keep.list(numbers),
    }
}

unsafe extern "C" fn build<R: ModelReader>(
    _: *mut c_void,
    builder: *const tatu_builder,
    params: *const tatu_value,
    error: *mut tatu_error,
) -> tatu_status {
    panics::run(error, || {
        // SAFETY: the host passes a builder that is valid during the call. Its `model` is the one that is built;
        // `model_cache` stored it at the start of a `StoredModel<R>`, because no other table has this function.
        let (raw, model) = unsafe { (&*builder, (*builder).model.cast::<StoredModel<R>>().as_ref()) };
        let model = model.ok_or_else(|| Fail::new("the host did not pass the model to build"))?;
        // SAFETY: the host passes one value per declared parameter.
        let values = unsafe { ValueRef::slice(params, model.params.len()) };
        R::build(&model.model, &Builder::new(raw), &Params::new(values, &model.params))?;
        Ok(TATU_OK)
    })
}
