//! `tatu.host.edits`: begins, ends, undoes and saves edits.

use std::path::{Path, PathBuf};

use tatu_errors::Error;
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_scene::document::{self, LoadOptions, SourceFiles};

use super::{
    answer::{lend, on_world, require, write_value},
    session::{one_line, switch_to},
    subtrees::{add_document, parent_of, require_unborrowed},
};
use crate::{
    cell::{HostFunction, WorldCell},
    state::{edits, recovery, saving},
};

pub static TABLE: tatu_host_edits = tatu_host_edits {
    size: size_of::<tatu_host_edits>() as u32,
    reserved: 0,
    begin: Some(begin),
    end: Some(end),
    step_back: Some(step_back),
    state: Some(state),
    save: Some(save),
    copy: Some(copy),
    open: Some(open),
    add: Some(add),
    kind: Some(kind),
};

/// File name that stands for an added text in error messages.
const ADDED_FILE_NAME: &str = "added.toml";

fn refuse(world: &WorldCell, e: &Error) -> tatu_status {
    let status = if e.code == "E305" { TATU_ERR_UNSUPPORTED } else { TATU_ERR };
    world.run.calls.refuse(status, &one_line(e))
}

extern "C" fn begin(w: WorldRef<'_>, label: Lent<'_>, merge: Lent<'_>) -> tatu_status {
    on_world(w, HostFunction::mutating("edits.begin"), |world| {
        require_unborrowed(world)?;
        if label.bytes().is_empty() {
            return Err(world.run.calls.refuse(TATU_ERR_ARGUMENT, "the label of an edit must not be empty"));
        }
        edits::begin(world, &label.text(), &merge.text());
        Ok(())
    })
}

extern "C" fn end(w: WorldRef<'_>, keep: u32) -> tatu_status {
    on_world(w, HostFunction::mutating("edits.end"), |world| {
        require_unborrowed(world)?;
        edits::end(world, keep != 0).map_err(|e| refuse(world, &e))
    })
}

extern "C" fn step_back<'a>(w: WorldRef<'a>, redo: u32, label: Option<&mut Lent<'a>>) -> tatu_status {
    on_world(w, HostFunction::mutating("edits.step_back"), |world| {
        let out = require(world, "a pointer for the label", label)?;
        require_unborrowed(world)?;
        match edits::step_back(world, redo != 0).map_err(|e| refuse(world, &e))? {
            Some(label) => {
                *out = lend(world, label.as_bytes())?;
                Ok(())
            }
            None => Err(TATU_ERR_MISSING),
        }
    })
}

extern "C" fn state<'a>(w: WorldRef<'a>, out: Option<&mut ValueRef<'a>>) -> tatu_status {
    on_world(w, HostFunction::read_only("edits.state"), |world| {
        let told = edits::edits_value(world);
        write_value(world, &told, out)
    })
}

extern "C" fn save(w: WorldRef<'_>, file: Lent<'_>, flags: u32) -> tatu_status {
    on_world(w, HostFunction::mutating("edits.save"), |world| {
        require_unborrowed(world)?;
        let is_script = world.run.calls.caller.get().script != 0;
        let path = PathBuf::from(file.text().into_owned());
        if is_script && (file.bytes().is_empty() || saving::is_own(world, &path)) {
            let text = "only the page, remote clients and the program can save to the scene's own file; choose a different file";
            return Err(world.run.calls.refuse(TATU_ERR_UNSUPPORTED, text));
        }
        // A replay recomputes the run and does not write files. The save is still recorded, because it separates edits.
        if world.run.connections.record.replay.borrow().is_some() {
            world.model.history.borrow_mut().note_saved();
            return Ok(());
        }
        saving::save(world, &path, flags & TATU_SAVE_OVER != 0).map_err(|e| refuse(world, &e))
    })
}

extern "C" fn copy(w: WorldRef<'_>, discard: u32) -> tatu_status {
    on_world(w, HostFunction::mutating("edits.copy"), |world| {
        require_unborrowed(world)?;
        if discard != 0 && world.run.calls.caller.get().script != 0 {
            let text = "only the page, remote clients and the program can discard the copy of unsaved edits";
            return Err(world.run.calls.refuse(TATU_ERR_UNSUPPORTED, text));
        }
        if world.run.connections.record.replay.borrow().is_some() {
            return Ok(());
        }
        match discard {
            0 => recovery::write(world),
            _ => recovery::discard(world),
        }
        .map_err(|e| refuse(world, &e))
    })
}

extern "C" fn open(w: WorldRef<'_>, file: Lent<'_>, how: u32) -> tatu_status {
    on_world(w, HostFunction::mutating("edits.open"), |world| {
        let file = PathBuf::from(file.text().into_owned());
        let sources = match how {
            TATU_OPEN_FILE => None,
            TATU_OPEN_NEW => Some(recovery::new_scene(&file).map_err(|e| refuse(world, &e))?),
            TATU_OPEN_RECOVERED => Some(recovery::read(world, &file).map_err(|e| refuse(world, &e))?),
            _ => {
                return Err(world
                    .run
                    .calls
                    .refuse(TATU_ERR_ARGUMENT, &format!("unknown mode {how}; expected one of TATU_OPEN_*")));
            }
        };
        switch_to(world, file, sources)
    })
}

extern "C" fn kind<'a>(w: WorldRef<'a>, index: u32, out: Option<&mut ValueRef<'a>>) -> tatu_status {
    on_world(w, HostFunction::read_only("edits.kind"), |world| {
        let registry = &world.model.registry;
        let sensors = registry.sensor_kinds().map(|(_, k)| ("sensor", &k.id, &k.text));
        let what = |part: bool| if part { "part" } else { "actuator" };
        let actuators = registry.actuators.iter().map(|k| (what(k.part.is_some()), &k.id, &k.text));
        let (object, id, text) = sensors.chain(actuators).nth(index as usize).ok_or(TATU_ERR_MISSING)?;
        let told = [("object", object), ("id", id), ("text", text)].map(|(k, v)| (Value::text(k), Value::text(v)));
        write_value(world, &Value::Map(told.into()), out)
    })
}

extern "C" fn add(w: WorldRef<'_>, text: Lent<'_>, parent: tatu_object, out: Option<&mut tatu_object>) -> tatu_status {
    on_world(w, HostFunction::mutating("edits.add"), |world| {
        let out = require(world, "a pointer for the object", out)?;
        let parent = parent_of(world, parent)?;
        require_unborrowed(world)?;
        let folder = world.model.document.file.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
        let file = folder.join(ADDED_FILE_NAME);
        let options = LoadOptions {
            sources: SourceFiles::with_replacements([(file.clone(), text.bytes().to_vec())], false),
            reach: Some(world.run.folders.reach(&world.model.registry)),
            ..LoadOptions::default()
        };
        let read = document::load(&file, &world.model.registry, &options).map_err(|e| refuse(world, &e))?;
        let slots = add_document(world, &read, parent)?;
        *out = slots.first().map_or(0, |s| world.state.scene.borrow().id(*s));
        Ok(())
    })
}
