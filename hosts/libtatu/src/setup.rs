//! The arguments from which a world is built, as callers pass them.

use std::{ffi::c_char, path::PathBuf};

use tatu_embed::{SceneSource, WorldSetup, search::scene_file};
use tatu_plugin_api::abi::tatu_str;

use crate::{
    answer::CallError,
    arguments::{bytes, text},
};

/// `tatu_world_setup` of the header.
#[repr(C)]
#[allow(non_camel_case_types)]
pub struct tatu_world_setup {
    size: u32,
    threads: u32,
    scene: *const c_char,
    text: tatu_str,
    folder: *const c_char,
    set: *const *const c_char,
    scripts: *const *const c_char,
    allow: *const *const c_char,
    plugins: *const *const c_char,
    seed: u64,
    has_seed: u32,
    reserved: u32,
}

/// Converts a setup that the caller passes.
///
/// # Safety
/// `setup` must be null, or point to a struct as large as its `size`, with strings and null-terminated arrays that live
/// through the call.
pub unsafe fn read(setup: *const tatu_world_setup) -> Result<WorldSetup, CallError> {
    // SAFETY: the caller guarantees null or a valid struct.
    let given = unsafe { setup.as_ref() }.filter(|s| s.size as usize >= size_of::<tatu_world_setup>());
    let given = given.ok_or_else(|| {
        CallError::argument("the setup is null, or its `size` is smaller than sizeof(tatu_world_setup)")
    })?;
    // SAFETY: the caller guarantees that strings live through the call and arrays end with null.
    unsafe {
        let scene = match (given.scene.is_null(), given.text.len) {
            (false, 0) => SceneSource::File(scene_file(&PathBuf::from(text(given.scene, "the scene")?))),
            (true, 1..) => {
                let folder = match given.folder.is_null() {
                    true => std::env::current_dir().unwrap_or_default(),
                    false => PathBuf::from(text(given.folder, "the folder")?),
                };
                let text = std::str::from_utf8(bytes(given.text));
                let text = text.map_err(|_| CallError::argument("the text of the scene is not UTF-8"))?;
                SceneSource::Text(text.to_owned(), folder)
            }
            _ => return Err(CallError::argument("exactly one of `scene` and `text` must be set")),
        };
        Ok(WorldSetup {
            seed: (given.has_seed != 0).then_some(given.seed),
            set: list(given.set, "a change")?,
            scripts: list(given.scripts, "a script")?,
            allow: list(given.allow, "a permission")?,
            plugins: list(given.plugins, "a plugin")?.into_iter().map(PathBuf::from).collect(),
            threads: given.threads.max(1) as usize,
            ..WorldSetup::new(scene)
        })
    }
}

/// Copies a null-terminated array of strings; error messages refer to each of them as `what`.
///
/// # Safety
/// `list` must be null or a null-terminated array; the array and its strings must live through the call.
unsafe fn list(list: *const *const c_char, what: &str) -> Result<Vec<String>, CallError> {
    let mut all = Vec::new();
    let mut next = list;
    // SAFETY: the caller guarantees that the array ends with null and its strings live through the call.
    unsafe {
        while !next.is_null() && !(*next).is_null() {
            all.push(text(*next, what)?.to_owned());
            next = next.add(1);
        }
    }
    Ok(all)
}
