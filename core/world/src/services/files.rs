//! `tatu.host.files`: names that scripts give, within the folders that the run allows.

use std::path::{Component, Path, PathBuf};

use tatu_plugin_api::abi::*;
use tatu_plugins::border::text;

use super::{busy, needs, on};
use crate::cell::{Function, WorldCell};

pub static TABLE: tatu_host_files =
    tatu_host_files { size: size_of::<tatu_host_files>() as u32, reserved: 0, resolve: Some(resolve) };

unsafe extern "C" fn resolve(w: *mut tatu_world, name: tatu_str, mode: u32, out: *mut tatu_str) -> tatu_status {
    // SAFETY: by the contract: pointers are valid during the call.
    unsafe {
        on(w, Function::looks("files.resolve"), |world| {
            needs(world, "a place for the path", out)?;
            let name = text(name);
            let path = match allowed(world, Path::new(name.as_ref()), mode) {
                Ok(p) => p,
                Err(why) => return Err(world.calls.refuse(TATU_ERR_MISSING, &why)),
            };
            if mode == TATU_FILE_READ {
                world.outside.opened.borrow_mut().insert(name.clone().into_owned());
            }
            let Some(path) = path.to_str() else {
                return Err(world.calls.refuse(TATU_ERR_MISSING, "the path is not UTF-8"));
            };
            let mut arena = world.calls.arena.try_borrow_mut().map_err(|_| busy(world))?;
            let room = arena.alloc(path.len());
            if room.is_null() {
                return Err(TATU_ERR_SPACE);
            }
            std::ptr::copy_nonoverlapping(path.as_ptr(), room, path.len());
            *out = tatu_str { ptr: room.cast(), len: path.len() as u64 };
            Ok(())
        })
    }
}

fn allowed(world: &WorldCell, name: &Path, mode: u32) -> Result<PathBuf, String> {
    let working = std::env::current_dir().map_err(|e| format!("the working folder cannot be read: {e}"))?;
    let here = world.outside.files.borrow().as_ref().map_or_else(|| working.clone(), |root| working.join(root));
    let scene = world.document.file.as_ref().and_then(|f| f.parent()).map(|p| working.join(p));
    let roots: Vec<PathBuf> = match mode {
        TATU_FILE_WRITE => vec![here.clone()],
        _ => std::iter::once(here.clone()).chain(scene).collect(),
    };
    // A folder that was given for the files holds all of them; else one root may be left for another.
    let chosen = world.outside.files.borrow().is_some();
    let among = |root: &PathBuf| if chosen { vec![root.clone()] } else { roots.clone() };
    for root in &roots {
        let full = normal(&root.join(name));
        // A link inside must not lead outside.
        let real = full.parent().and_then(|p| std::fs::canonicalize(p).ok()).unwrap_or_default();
        let among = among(root);
        let inside = among.iter().any(|r| full.starts_with(r));
        let real_roots = among.iter().filter_map(|r| std::fs::canonicalize(r).ok());
        let stays = inside && real_roots.into_iter().any(|r| real.starts_with(r));
        if stays && (mode == TATU_FILE_WRITE || full.exists()) {
            return Ok(full);
        }
    }
    let list: Vec<_> = roots.iter().map(|r| r.display().to_string()).collect();
    Err(format!("there is no file `{}` in the folders that scripts may use: {}", name.display(), list.join(", ")))
}

/// Without `.` and `..`.
fn normal(p: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for c in p.components() {
        match c {
            Component::ParentDir => {
                out.pop();
            }
            Component::CurDir => {}
            c => out.push(c),
        }
    }
    out
}
