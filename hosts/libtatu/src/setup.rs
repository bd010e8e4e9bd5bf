//! The arguments from which a world is built, as callers pass them.

use std::path::PathBuf;

use tatu_embed::{SceneSource, WorldSetup, search::scene_file};
use tatu_plugin_api::abi::{Lent, LentCStr};

use crate::{answer::CallError, arguments::text};

/// `tatu_world_setup` of the header.
#[repr(C)]
#[allow(non_camel_case_types)]
pub struct tatu_world_setup<'a> {
    size: u32,
    threads: u32,
    scene: LentCStr<'a>,
    text: Lent<'a>,
    folder: LentCStr<'a>,
    set: *const LentCStr<'a>,
    scripts: *const LentCStr<'a>,
    allow: *const LentCStr<'a>,
    plugins: *const LentCStr<'a>,
    seed: u64,
    has_seed: u32,
    reserved: u32,
}

/// Converts a setup that the caller passes.
///
/// # Safety
/// `setup` must be null, or point to a struct as large as its `size`, with strings and null-terminated arrays that live
/// through the call.
pub unsafe fn read(setup: *const tatu_world_setup<'_>) -> Result<WorldSetup, CallError> {
    // SAFETY: the caller guarantees null or a struct as large as its `size`, which is read first.
    let given = unsafe {
        let size = setup.cast::<u32>().as_ref().map_or(0, |size| *size as usize);
        (size >= size_of::<tatu_world_setup<'_>>()).then(|| &*setup)
    };
    let given = given.ok_or_else(|| {
        CallError::argument("the setup is null, or its `size` is smaller than sizeof(tatu_world_setup)")
    })?;
    let scene = match (given.scene.get(), given.text.bytes()) {
        (Some(_), b"") => SceneSource::File(scene_file(&PathBuf::from(text(given.scene, "the scene")?))?),
        (None, bytes @ [_, ..]) => {
            let folder = match given.folder.get() {
                None => std::env::current_dir().unwrap_or_default(),
                Some(_) => PathBuf::from(text(given.folder, "the folder")?),
            };
            let text = std::str::from_utf8(bytes);
            let text = text.map_err(|_| CallError::argument("the text of the scene is not UTF-8"))?;
            SceneSource::Text(text.to_owned(), folder)
        }
        _ => return Err(CallError::argument("exactly one of `scene` and `text` must be set")),
    };
    // SAFETY: the caller guarantees that the arrays end with null and live through the call.
    let [set, scripts, allow, plugins] = unsafe {
        [
            list(given.set, "a change")?,
            list(given.scripts, "a script")?,
            list(given.allow, "a permission")?,
            list(given.plugins, "a plugin")?,
        ]
    };
    Ok(WorldSetup {
        seed: (given.has_seed != 0).then_some(given.seed),
        set,
        scripts,
        allow,
        plugins: plugins.into_iter().map(PathBuf::from).collect(),
        threads: given.threads.max(1) as usize,
        ..WorldSetup::new(scene)
    })
}

/// Copies a null-terminated array of strings; error messages refer to each of them as `what`.
///
/// # Safety
/// `list` must be null or a null-terminated array that lives through the call.
unsafe fn list(list: *const LentCStr<'_>, what: &str) -> Result<Vec<String>, CallError> {
    let mut all = Vec::new();
    let mut next = list;
    // SAFETY: the caller guarantees that the array ends with null, so `next` is within it.
    while let Some(element) = unsafe { next.as_ref() }.filter(|s| s.get().is_some()) {
        all.push(text(*element, what)?.to_owned());
        next = next.wrapping_add(1);
    }
    Ok(all)
}
