//! Importers, which convert the bytes of a file to objects.

use std::{ffi::c_void, sync::Arc};

use crate::abi::*;
use crate::safe::{
    Builder, Param, Params, Plugin, Result, ValueRef,
    entry::panics,
    value::{fail::bytes_of, list_cache::cached_list, table_arena::TableArena},
};

/// An importer, which reads files of one format.
pub trait Importer: Sized + 'static {
    /// The plugin that offers this importer.
    type Plugin: Plugin;
    /// Id of the importer in scene files, such as "urdf".
    const ID: &'static str;
    /// Description for documentation and lists, one sentence.
    const TEXT: &'static str;
    /// Suffixes of file names, such as ".urdf".
    const SUFFIXES: &'static [&'static str];

    /// Declares the parameters of an import.
    fn params() -> Vec<Param>;
    /// Returns the confidence, 0 to 100, that the importer can read a file that begins with `head`; 0 if such files are
    /// recognized only by their suffix.
    fn sniff(head: &[u8]) -> u32;
    /// Reads a file; the first object is the base. Malformed input must cause an error, never a crash. Errors should
    /// state their line with `Fail::at("", line)`.
    fn load(bytes: &[u8], builder: &Builder<'_>, params: &Params<'_>) -> Result;
}

struct ImporterParams<I>(I);

fn params_of<I: Importer>() -> Arc<[Param]> {
    cached_list::<ImporterParams<I>, _>(I::params)
}

pub(crate) fn table<I: Importer>(keep: &mut TableArena) -> *const tatu_importer {
    let params = params_of::<I>().iter().map(|p| p.to_table(keep)).collect();
    let raw = tatu_importer {
        size: size_of::<tatu_importer>() as u32,
        reserved: 0,
        id: keep.text(I::ID),
        text: keep.text(I::TEXT),
        suffixes: keep.texts(I::SUFFIXES),
        params: keep.list(params),
        sniff: Some(sniff::<I>),
        load: Some(load::<I>),
    };
    keep.table(raw)
}

unsafe extern "C" fn sniff<I: Importer>(_: *mut c_void, head: tatu_str) -> u32 {
    // SAFETY: `head` points to bytes that the host keeps valid during the call.
    panics::quiet(|| I::sniff(unsafe { bytes_of(head) }))
}

unsafe extern "C" fn load<I: Importer>(
    _: *mut c_void,
    bytes: tatu_str,
    builder: *const tatu_builder,
    params: *const tatu_value,
    error: *mut tatu_error,
) -> tatu_status {
    panics::run(error, || {
        let declared = params_of::<I>();
        // SAFETY: the host passes bytes and a builder that are valid during the call, and one value per declared
        // parameter.
        let (bytes, raw, values) = unsafe { (bytes_of(bytes), &*builder, ValueRef::slice(params, declared.len())) };
        I::load(bytes, &Builder::new(raw), &Params::new(values, &declared))?;
        Ok(TATU_OK)
    })
}
