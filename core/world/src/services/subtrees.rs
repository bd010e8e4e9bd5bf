//! Copies, loads and saves parts of a scene with their sensors, actuators and scripts.

use std::{
    io::Error,
    path::{Path, PathBuf},
};

use tatu_plugin_api::abi::*;
use tatu_scene::{
    ObjectVariant, Scene,
    document::{self, Document, MAIN_KIND, REFEREE_KIND, ScriptSpec},
};

use super::answer::{busy, input_slice, on_world, output_slice, require, slot};
use crate::{
    cell::{
        HostFunction, ScriptKind, Scripts, WorldCell,
        calls::cost::{FILE_COST, OBJECT_COST},
    },
    instances::create_device,
    state::{
        save::{device_of, document_of, scripts_of},
        saving::is_own,
        write_atomically,
    },
};

/// Copies objects, and keeps their world poses. The parent of a copy is the copy of the original's parent if the parent
/// is copied as well; otherwise, the copy has no parent.
pub(super) unsafe extern "C" fn copy(
    w: WorldRef<'_>,
    objects: *const tatu_object,
    n: u32,
    out: *mut tatu_object,
) -> tatu_status {
    // SAFETY: the header requires `objects` and `out` to be null or to hold `n` elements for the whole call.
    unsafe {
        on_world(w, HostFunction::mutating("scene.copy"), |world| {
            let objects = input_slice(world, "a list of objects", objects, n)?;
            let out = output_slice(world, "room for the copies", out, n)?;
            let (from, to) = {
                let mut scene = world.state.scene.try_borrow_mut().map_err(|_| busy(world))?;
                let mut from = Vec::with_capacity(objects.len());
                for o in objects {
                    from.push(slot(world, &scene, *o)?);
                }
                let script =
                    from.iter().find(|s| scene.get(**s).is_some_and(|o| matches!(o.data, ObjectVariant::Script)));
                if let Some(s) = script {
                    let text = format!("object {s} is a script, which is copied with the object that it belongs to");
                    return Err(world.run.calls.refuse(TATU_ERR_UNSUPPORTED, &text));
                }
                let to = copy_objects(&mut scene, &from).ok_or_else(|| refuse_full(world))?;
                (from, to)
            };
            world.run.calls.cost.charge(OBJECT_COST * from.len() as u64);
            require_unborrowed(world)?;
            for (old, new) in from.iter().zip(&to) {
                // No borrow is held while a plugin creates an instance.
                if let Some(device) = device_of(world, *old) {
                    create_device(world, *new, &device, None).map_err(|e| world.run.calls.refuse(TATU_ERR, &e.text))?;
                }
                add_scripts(world, *new, &scripts_of(world, *old));
            }
            let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
            for (place, s) in out.iter_mut().zip(&to) {
                *place = scene.id(*s);
            }
            Ok(())
        })
    }
}

/// Adds the objects of a scene file or a model to the world.
pub(super) extern "C" fn load(
    w: WorldRef<'_>,
    file: Lent<'_>,
    parent: tatu_object,
    out: Option<&mut tatu_object>,
) -> tatu_status {
    on_world(w, HostFunction::mutating("scene.load"), |world| {
        let out = require(world, "a pointer for the object", out)?;
        let path = PathBuf::from(file.text().into_owned());
        let parent = parent_of(world, parent)?;
        require_unborrowed(world)?;
        let read = document::load_part(&path, &world.model.registry, world.run.folders.reach(&world.model.registry))
            .map_err(|e| refuse(world, e))?;
        world.run.calls.cost.charge(FILE_COST + OBJECT_COST * read.objects.len() as u64);
        let slots = add_document(world, &read, parent)?;
        let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
        // A model is saved as a reference by its id, with the differences from it. The contents of a file become part
        // of the scene.
        let is_model = path.to_str().filter(|id| read.models.iter().any(|m| m.base == 0) && !id.ends_with(".toml"));
        if let (Some(id), Some(base)) = (is_model, slots.first().and_then(|s| scene.get(*s))) {
            world.model.history.borrow_mut().models.insert(base.uid, id.to_owned());
        }
        *out = slots.first().map_or(0, |s| scene.id(*s));
        Ok(())
    })
}

fn refuse(world: &WorldCell, e: tatu_errors::Error) -> tatu_status {
    let help = e.help.map_or(String::new(), |h| format!(" ({h})"));
    world.run.calls.refuse(TATU_ERR_ARGUMENT, &format!("{}{help}", e.text))
}

/// Returns the slot of a parent, given by its handle, or 0 for the world.
pub(super) fn parent_of(world: &WorldCell, parent: tatu_object) -> Result<u32, tatu_status> {
    if parent == 0 {
        return Ok(0);
    }
    let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
    slot(world, &scene, parent)
}

/// Adds the objects of a document with their devices and scripts; returns their slots.
pub(super) fn add_document(world: &WorldCell, read: &Document, parent: u32) -> Result<Vec<u32>, tatu_status> {
    for report in &read.reports {
        world.log(TATU_LOG_DEBUG, &report.text);
    }
    let slots = {
        let mut scene = world.state.scene.try_borrow_mut().map_err(|_| busy(world))?;
        let slots = read.add_to_scene(&mut scene, parent);
        if slots.contains(&0) {
            return Err(refuse_full(world));
        }
        scene.make_unique(&slots);
        slots
    };
    world.run.folders.allow_modules_of(read);
    for (spec, slot) in read.objects.iter().zip(&slots) {
        if let Some(device) = &spec.device {
            create_device(world, *slot, device, None).map_err(|e| refuse(world, e))?;
        }
        add_scripts(world, *slot, &spec.scripts);
    }
    let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
    for s in &slots {
        world.publish_object_event("object_added", &scene, *s);
    }
    Ok(slots)
}

/// Saves an object with all its descendants, or the whole scene.
pub(super) extern "C" fn save(w: WorldRef<'_>, file: Lent<'_>, base: tatu_object) -> tatu_status {
    on_world(w, HostFunction::mutating("scene.save"), |world| {
        let path = PathBuf::from(file.text().into_owned());
        let fail = |text: String| world.run.calls.refuse(TATU_ERR, &text);
        if path.extension().is_none_or(|e| e != "toml") {
            let text = format!("`{}` must end with `.toml`, as all scene files do", path.display());
            return Err(world.run.calls.refuse(TATU_ERR_ARGUMENT, &text));
        }
        // Otherwise, the page could not save its edits, because the file has changed.
        if world.run.calls.caller.get().script != 0 && is_own(world, &path) {
            let text = "only the page, remote clients and the program can save to the scene's own file; choose a different file";
            return Err(world.run.calls.refuse(TATU_ERR_UNSUPPORTED, text));
        }
        let base = match base {
            0 => 0,
            base => {
                let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
                slot(world, &scene, base)?
            }
        };
        require_unborrowed(world)?;
        let objects = world.state.scene.try_borrow().map_err(|_| busy(world))?.subtree(base).len();
        world.run.calls.cost.charge(FILE_COST + OBJECT_COST * objects as u64);
        let written =
            document::write(&document_of(world, base), &world.model.registry, &document::folder_beside(&path));
        let written = written.map_err(|e| fail(e.text))?;
        // The path or its folder may have become a link in the meantime, so it is resolved again.
        let whole = |path: &Path, bytes: &[u8]| {
            let path = world.run.folders.resolve(path, TATU_FILE_WRITE).map_err(|why| Error::other(why.text()))?;
            write_atomically(&path, bytes)
        };
        document::save(&path, &written, &whole).map_err(|e| fail(e.text))
    })
}

/// Checks that no caller further up the stack has borrowed a part of the world.
pub(super) fn require_unborrowed(world: &WorldCell) -> Result<(), tatu_status> {
    let busy_now = world.state.scene.try_borrow_mut().is_err()
        || world.devices.sensing.try_borrow_mut().is_err()
        || world.devices.actuators.try_borrow_mut().is_err()
        || world.run.scripts.try_borrow_mut().is_err()
        || world.model.settings.try_borrow().is_err();
    if busy_now { Err(busy(world)) } else { Ok(()) }
}

fn refuse_full(world: &WorldCell) -> tatu_status {
    world.run.calls.refuse(TATU_ERR_SPACE, "the world already has a million objects, which is the limit")
}

/// Adds scripts to an object, except main scripts and referees, which copies must not multiply.
fn add_scripts(world: &WorldCell, owner: u32, scripts: &[ScriptSpec]) {
    for spec in
        scripts.iter().filter(|s| s.kind != MAIN_KIND && s.kind != REFEREE_KIND && ScriptKind::parse(&s.kind).is_some())
    {
        Scripts::add(world, owner, spec);
    }
}

fn copy_objects(scene: &mut Scene, from: &[u32]) -> Option<Vec<u32>> {
    // Parents must be copied before their children, regardless of the order of the list.
    let mut order: Vec<usize> = (0..from.len()).collect();
    let depth = |scene: &Scene, mut s: u32| {
        let mut n = 0;
        while let Some(o) = scene.get(s) {
            (s, n) = (o.parent, n + 1);
        }
        n
    };
    order.sort_by_key(|i| depth(scene, from[*i]));
    let mut to = vec![0; from.len()];
    for i in order {
        let o = scene.get(from[i])?;
        let (alias, world, mut data) = (o.alias().to_owned(), scene.world(from[i]), o.data.clone());
        let (model_base, visible, layer, notes) = (scene.is_model_base(from[i]), o.visible, o.layer, o.notes.clone());
        let parent = from.iter().position(|s| *s == o.parent).map_or(0, |p| to[p]);
        match &mut data {
            ObjectVariant::Shape(s) => s.body = tatu_scene::ShapeBody(None),
            ObjectVariant::Joint(j) => (j.id, j.callback_called) = (None, false),
            _ => {}
        }
        to[i] = scene.add(parent, &alias, scene.frame(parent).inverse() * world, data)?;
        scene.set_model_base(to[i], model_base);
        let o = scene.get_mut(to[i])?;
        (o.visible, o.layer, o.notes) = (visible, layer, notes);
    }
    scene.make_unique(&to);
    Some(to)
}
