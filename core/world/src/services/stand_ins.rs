//! `tatu.host.stand_ins`: creates stand-ins for objects and values that scripts look up and that do not exist.

use tatu_plugin_api::abi::*;

use super::answer::world_only;
use crate::cell::{HostFunction, OptionalObject, WorldCell, scripts::stand_in_use};

pub static TABLE: tatu_host_stand_ins = tatu_host_stand_ins {
    size: size_of::<tatu_host_stand_ins>() as u32,
    reserved: 0,
    made: Some(made),
    object: Some(object),
    used: Some(used),
    parent: Some(parent),
    child: Some(child),
    script: Some(script),
    value: Some(value),
};

/// Returns the world, if its run creates stand-ins.
fn recording_world<'a>(w: WorldRef<'a>, name: &'static str) -> Option<&'a WorldCell> {
    world_only(w, HostFunction::mutating(name)).filter(|world| world.run.stand_ins.is_on())
}

/// Converts a result to a status, without recording a message.
fn status_of(is: bool) -> tatu_status {
    if is { TATU_OK } else { TATU_ERR_MISSING }
}

/// Records that the script requested an optional object. Always returns the status of a missing object.
fn note_optional(w: WorldRef<'_>, name: &'static str, object: tatu_object, wish: OptionalObject) -> tatu_status {
    if let Some(world) = recording_world(w, name)
        && let Some(id) = world.state.scene.try_borrow().ok().and_then(|s| Some(s.id(s.resolve(object).ok()?)))
    {
        world.run.stand_ins.note_optional(id, wish);
    }
    TATU_ERR_MISSING
}

extern "C" fn made(w: WorldRef<'_>) -> tatu_status {
    status_of(recording_world(w, "stand_ins.made").is_some())
}

extern "C" fn object(
    w: WorldRef<'_>,
    from: tatu_object,
    name: Lent<'_>,
    kind: LentCStr<'_>,
    out: Option<&mut tatu_object>,
) -> tatu_status {
    let Some(world) = recording_world(w, "stand_ins.object") else { return TATU_ERR_MISSING };
    let (name, kind) = (name.text(), kind.text());
    let base = world.state.scene.try_borrow().ok().and_then(|s| s.resolve(from).ok()).unwrap_or(0);
    let Some(id) = (!name.is_empty()).then(|| stand_in_use::find_or_create(world, base, &name)).flatten() else {
        return TATU_ERR_MISSING;
    };
    if !kind.is_empty() {
        stand_in_use::infer_kind(world, id, &kind);
    }
    if let Some(out) = out {
        *out = id;
    }
    TATU_OK
}

extern "C" fn used(w: WorldRef<'_>, object: tatu_object, kind: LentCStr<'_>) -> tatu_status {
    let kind = kind.text();
    status_of(recording_world(w, "stand_ins.used").is_some_and(|world| stand_in_use::infer_kind(world, object, &kind)))
}

extern "C" fn parent(w: WorldRef<'_>, object: tatu_object) -> tatu_status {
    note_optional(w, "stand_ins.parent", object, OptionalObject::Parent)
}

extern "C" fn child(w: WorldRef<'_>, object: tatu_object, kind: LentCStr<'_>) -> tatu_status {
    let kind = kind.text();
    note_optional(w, "stand_ins.child", object, OptionalObject::Child(kind.into_owned()))
}

extern "C" fn script(w: WorldRef<'_>, object: tatu_object) -> tatu_status {
    note_optional(w, "stand_ins.script", object, OptionalObject::Script)
}

extern "C" fn value(w: WorldRef<'_>, _: tatu_object, name: Lent<'_>) -> tatu_status {
    let name = name.text();
    status_of(recording_world(w, "stand_ins.value").is_some_and(|world| world.run.stand_ins.has_value(&name)))
}
