//! `tatu.host.files`: names that scripts give, within the folders that the run allows.

use std::path::{Component, Path, PathBuf};

use tatu_plugin_api::abi::*;

use super::{lend, on, place};
use crate::cell::{Function, WorldCell};

pub static TABLE: tatu_host_files =
    tatu_host_files { size: size_of::<tatu_host_files>() as u32, reserved: 0, resolve: Some(resolve) };

extern "C" fn resolve<'a>(w: WorldRef<'a>, name: Lent<'_>, mode: u32, out: Option<&mut Lent<'a>>) -> tatu_status {
    on(w, Function::looks("files.resolve"), |world| {
        let out = place(world, "a place for the path", out)?;
        let name = name.text();
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
        *out = lend(world, path.as_bytes())?;
        Ok(())
    })
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
