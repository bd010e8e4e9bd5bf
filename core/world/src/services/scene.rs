//! `tatu.host.scene`: objects and their properties.

use nalgebra::Isometry3;
use tatu_plugin_api::abi::*;
use tatu_plugins::{PluginHost, texts::label};
use tatu_scene::{
    ALIAS_RULE, ChangeEffect, ObjectKind, ObjectVariant, Scene, is_alias, pose_from_array, pose_to_array,
};

use super::{
    answer::{
        busy, fill, input_slice, on_world, on_world_or_worker, output_slice, require, require_array, slot, write_value,
    },
    properties::{read, read_numbers, refuse_with, write, write_numbers},
};
use crate::cell::{
    HostFunction, WorldCell,
    calls::cost::{LOOKUP_COST, OBJECT_COST},
};

/// Returns the number of a kind of object in the plugin ABI.
fn abi_kind(kind: ObjectKind) -> i32 {
    match kind {
        ObjectKind::Shape => TATU_KIND_SHAPE,
        ObjectKind::Joint => TATU_KIND_JOINT,
        ObjectKind::Dummy => TATU_KIND_DUMMY,
        ObjectKind::Sensor => TATU_KIND_SENSOR,
        ObjectKind::Actuator => TATU_KIND_ACTUATOR,
        ObjectKind::Part => TATU_KIND_PART,
        ObjectKind::ForceSensor => TATU_KIND_FORCE_SENSOR,
        ObjectKind::Graph => TATU_KIND_GRAPH,
        ObjectKind::Camera => TATU_KIND_CAMERA,
        ObjectKind::Light => TATU_KIND_LIGHT,
        ObjectKind::Path => TATU_KIND_PATH,
        ObjectKind::Script => TATU_KIND_SCRIPT,
    }
}

pub static TABLE: tatu_host_scene = tatu_host_scene {
    size: size_of::<tatu_host_scene>() as u32,
    reserved: 0,
    prop: Some(prop),
    get: Some(get),
    set: Some(set),
    get_f64: Some(get_f64),
    set_f64: Some(set_f64),
    get_f64_many: Some(get_f64_many),
    set_f64_many: Some(set_f64_many),
    pose: Some(pose),
    set_pose: Some(set_pose),
    look: Some(look),
    find: Some(find),
    create: Some(create),
    remove: Some(remove),
    list: Some(list),
    copy: Some(super::subtrees::copy),
    load: Some(super::subtrees::load),
    save: Some(super::subtrees::save),
    row: Some(super::ui_data::row),
    model: Some(super::ui_data::model),
};

unsafe extern "C" fn prop(host: *const tatu_host, key: LentCStr<'_>) -> tatu_prop {
    // SAFETY: the header requires `host` to be null or the host pointer that the plugin was given, which is never
    // freed.
    let host = unsafe { PluginHost::at(host) };
    host.zip(key.get()).and_then(|(host, key)| host.number(&key.to_string_lossy())).unwrap_or(0)
}

extern "C" fn get<'a>(
    w: WorldRef<'a>,
    object: tatu_object,
    prop: tatu_prop,
    out: Option<&mut ValueRef<'a>>,
) -> tatu_status {
    on_world_or_worker(w, HostFunction::read_only("scene.get"), |world| {
        let value = read(world, object, prop)?;
        write_value(world, &value, out)
    })
}

extern "C" fn set(w: WorldRef<'_>, object: tatu_object, prop: tatu_prop, value: Option<&ValueRef<'_>>) -> tatu_status {
    on_world_or_worker(w, HostFunction::mutating("scene.set"), |world| {
        let value = require(world, "a value", value)?;
        match value.to_value() {
            Ok(v) => write(world, object, prop, v),
            Err(e) => Err(world.run.calls.refuse(e.code(), e.text())),
        }
    })
}

unsafe extern "C" fn get_f64(
    w: WorldRef<'_>,
    object: tatu_object,
    prop: tatu_prop,
    out: *mut f64,
    n: u32,
) -> tatu_status {
    // SAFETY: the header requires `out` to be null or to have room for `n` numbers for the whole call.
    unsafe {
        on_world_or_worker(w, HostFunction::read_only("scene.get_f64"), |world| {
            read_numbers(world, object, prop, output_slice(world, "room for numbers", out, n)?)
        })
    }
}

unsafe extern "C" fn set_f64(
    w: WorldRef<'_>,
    object: tatu_object,
    prop: tatu_prop,
    values: *const f64,
    n: u32,
) -> tatu_status {
    // SAFETY: the header requires `values` to be null or to hold `n` numbers for the whole call.
    unsafe {
        on_world_or_worker(w, HostFunction::mutating("scene.set_f64"), |world| {
            write_numbers(world, object, prop, input_slice(world, "a list of numbers", values, n)?)
        })
    }
}

unsafe extern "C" fn get_f64_many(
    w: WorldRef<'_>,
    objects: *const tatu_object,
    count: u32,
    prop: tatu_prop,
    out: *mut f64,
    n: u32,
) -> tatu_status {
    // SAFETY: the header requires `objects` to hold `count` handles and `out` to have room for `n` numbers each, for
    // the whole call; null pointers are refused before use.
    unsafe {
        on_world_or_worker(w, HostFunction::read_only("scene.get_f64_many"), |world| {
            let objects = input_slice(world, "a list of objects", objects, count)?;
            if n > 0 && count > 0 {
                require_array(world, "room for numbers", out)?;
            }
            for (i, object) in objects.iter().enumerate() {
                read_numbers(world, *object, prop, output_slice(world, "room", out.add(i * n as usize), n)?)?;
            }
            Ok(())
        })
    }
}

unsafe extern "C" fn set_f64_many(
    w: WorldRef<'_>,
    objects: *const tatu_object,
    count: u32,
    prop: tatu_prop,
    values: *const f64,
    n: u32,
) -> tatu_status {
    // SAFETY: the header requires `objects` to hold `count` handles and `values` `n` numbers each, for the whole call;
    // null pointers are refused before use.
    unsafe {
        on_world_or_worker(w, HostFunction::mutating("scene.set_f64_many"), |world| {
            let objects = input_slice(world, "a list of objects", objects, count)?;
            if n > 0 && count > 0 {
                require_array(world, "a list of numbers", values)?;
            }
            for (i, object) in objects.iter().enumerate() {
                write_numbers(world, *object, prop, input_slice(world, "numbers", values.add(i * n as usize), n)?)?;
            }
            Ok(())
        })
    }
}

/// Returns the frame of an object, given by its handle. 0 stands for the world frame, and a joint for its moving frame.
fn frame_of(world: &WorldCell, scene: &Scene, frame: tatu_object) -> Result<Isometry3<f64>, tatu_status> {
    if frame == 0 {
        return Ok(Isometry3::identity());
    }
    let slot = slot(world, scene, frame)?;
    Ok(scene.frame(slot))
}

extern "C" fn pose(
    w: WorldRef<'_>,
    object: tatu_object,
    frame: tatu_object,
    out: Option<&mut [f64; 7]>,
) -> tatu_status {
    on_world_or_worker(w, HostFunction::read_only("scene.pose"), |world| {
        let scene = world.borrow_part(|w| &w.state.scene).ok_or_else(|| busy(world))?;
        let (s, f) = match (slot(world, &scene, object), frame_of(world, &scene, frame)) {
            (Ok(s), Ok(f)) => (s, f),
            (Err(status), _) | (_, Err(status)) => return Err(status),
        };
        let world_pose = scene.world(s);
        let relative = if frame == 0 { world_pose } else { f.inverse() * world_pose };
        *require(world, "room for 7 numbers", out)? = pose_to_array(&relative);
        Ok(())
    })
}

extern "C" fn set_pose(
    w: WorldRef<'_>,
    object: tatu_object,
    frame: tatu_object,
    pose: Option<&[f64; 7]>,
) -> tatu_status {
    on_world(w, HostFunction::mutating("scene.set_pose"), |world| {
        let pose = require(world, "a pose of 7 numbers", pose)?;
        let Some(p) = pose_from_array(pose) else {
            let text = "a pose must be 7 finite numbers with a quaternion that is not 0";
            return Err(world.run.calls.refuse(TATU_ERR_ARGUMENT, text));
        };
        let mut scene = world.state.scene.try_borrow_mut().map_err(|_| busy(world))?;
        let (s, f) = match (slot(world, &scene, object), frame_of(world, &scene, frame)) {
            (Ok(s), Ok(f)) => (s, f),
            (Err(status), _) | (_, Err(status)) => return Err(status),
        };
        scene.set_world(s, f * p);
        world.apply_effect(s, ChangeEffect::Moved).map_err(|r| refuse_with(world, r))
    })
}

extern "C" fn look(
    w: WorldRef<'_>,
    object: tatu_object,
    full: Option<&mut tatu_object>,
    kind: Option<&mut i32>,
) -> tatu_status {
    on_world_or_worker(w, HostFunction::read_only("scene.look"), |world| {
        let scene = world.borrow_part(|w| &w.state.scene).ok_or_else(|| busy(world))?;
        match slot(world, &scene, object) {
            Ok(s) => {
                if let Some(full) = full {
                    *full = scene.id(s);
                }
                if let Some(kind) = kind {
                    *kind = scene.get(s).map_or(-1, |o| abi_kind(o.kind()));
                }
                Ok(())
            }
            Err(status) => Err(status),
        }
    })
}

extern "C" fn find(w: WorldRef<'_>, from: tatu_object, path: Lent<'_>, out: Option<&mut tatu_object>) -> tatu_status {
    on_world(w, HostFunction::read_only("scene.find"), |world| {
        let out = require(world, "a pointer for the object", out)?;
        let path = path.text();
        let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
        let base = scene.resolve(from).unwrap_or(0);
        match scene.find(base, &path) {
            Some(s) => {
                *out = scene.id(s);
                Ok(())
            }
            None => {
                world.run.calls.cost.charge(LOOKUP_COST * scene.slots().count() as u64);
                let near = scene.nearest(&path).map_or(String::new(), |n| format!("; did you mean `{n}`?"));
                Err(world.run.calls.refuse(TATU_ERR_MISSING, &format!("there is no object `{path}`{near}")))
            }
        }
    })
}

extern "C" fn create(
    w: WorldRef<'_>,
    kind: LentCStr<'_>,
    parent: tatu_object,
    alias: Lent<'_>,
    out: Option<&mut tatu_object>,
) -> tatu_status {
    on_world(w, HostFunction::mutating("scene.create"), |world| {
        let out = require(world, "a pointer for the object", out)?;
        let kind = kind.text();
        let data = match ObjectKind::parse(&kind) {
            Some(ObjectKind::Sensor | ObjectKind::Actuator | ObjectKind::Part) => {
                let text = format!("an object of kind {kind} cannot be created during a run");
                return Err(world.run.calls.refuse(TATU_ERR_UNSUPPORTED, &text));
            }
            Some(kind) => ObjectVariant::of_kind(kind, 0),
            None => {
                return Err(world.run.calls.refuse(TATU_ERR_ARGUMENT, &format!("unknown object kind `{kind}`")));
            }
        };
        let mut scene = world.state.scene.try_borrow_mut().map_err(|_| busy(world))?;
        let parent = if parent == 0 { 0 } else { slot(world, &scene, parent)? };
        let alias = alias.text();
        let alias = if alias.is_empty() { kind } else { alias };
        if !is_alias(&alias) {
            let shown = label(alias.as_bytes());
            let said = format!("`scene.create`: `{shown}` cannot be an alias: expected {ALIAS_RULE}");
            return Err(world.run.calls.refuse(TATU_ERR_ARGUMENT, &said));
        }
        world.run.calls.cost.charge(OBJECT_COST);
        match scene.add(parent, &alias, Isometry3::identity(), data) {
            Some(s) => {
                scene.make_unique(&[s]);
                *out = scene.id(s);
                world.publish_object_event("object_added", &scene, s);
                Ok(())
            }
            None => Err(world
                .run
                .calls
                .refuse(TATU_ERR_SPACE, "the world already has a million objects, which is the limit")),
        }
    })
}

unsafe extern "C" fn remove(w: WorldRef<'_>, objects: *const tatu_object, n: u32) -> tatu_status {
    // SAFETY: the header requires `objects` to be null or to hold `n` handles for the whole call.
    unsafe {
        on_world(w, HostFunction::mutating("scene.remove"), |world| {
            let mut scene = world.state.scene.try_borrow_mut().map_err(|_| busy(world))?;
            let objects = input_slice(world, "a list of objects", objects, n)?;
            let mut slots = Vec::with_capacity(objects.len());
            for o in objects {
                match slot(world, &scene, *o) {
                    Ok(s) => slots.push(s),
                    Err(status) => return Err(status),
                }
            }
            world.run.calls.cost.charge(OBJECT_COST * slots.len() as u64);
            for s in slots {
                if scene.get(s).is_some() {
                    world.publish_object_event("object_removed", &scene, s);
                }
                for script in scene.scripts(s) {
                    match world.run.calls.hides(script) {
                        true => drop(scene.set_parent(script, 0)),
                        false => drop(scene.remove(script)),
                    }
                }
                scene.remove(s);
            }
            Ok(())
        })
    }
}

unsafe extern "C" fn list(
    w: WorldRef<'_>,
    base: tatu_object,
    kinds: u32,
    flags: u32,
    out: *mut tatu_object,
    cap: u32,
    n: Option<&mut u32>,
) -> tatu_status {
    // SAFETY: the header requires `out` to be null or to have room for `cap` handles for the whole call.
    unsafe {
        on_world(w, HostFunction::read_only("scene.list"), |world| {
            let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
            let base = if base == 0 { 0 } else { slot(world, &scene, base)? };
            let mut slots = if flags & TATU_LIST_CHILDREN != 0 {
                let own = if base == 0 { None } else { Some(base) };
                own.into_iter().chain(scene.children(base).iter().copied()).collect()
            } else {
                scene.subtree(base)
            };
            world.run.calls.cost.charge(LOOKUP_COST * slots.len() as u64);
            if flags & TATU_LIST_SKIP_BASE != 0 && base != 0 {
                slots.remove(0);
            }
            slots.retain(|s| !world.run.calls.hides(*s));
            let wanted = |s: &u32| kinds == 0 || scene.get(*s).is_some_and(|o| kinds & (1 << abi_kind(o.kind())) != 0);
            let ids: Vec<_> = slots.into_iter().filter(wanted).map(|s| scene.id(s)).collect();
            fill(&ids, out, cap, n)
        })
    }
}
