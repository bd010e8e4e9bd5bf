//! `tatu.host.scripts`: scripts of objects, and calls of their functions.

use tatu_plugin_api::{abi::*, safe::Value};
use tatu_scene::document::ScriptSpec;

use super::answer::{busy, fill, input_slice, on_world, require, require_frame, slot, status_to_result, write_value};
use crate::{cell::HostFunction, scripts as inner};

pub static TABLE: tatu_host_scripts = tatu_host_scripts {
    size: size_of::<tatu_host_scripts>() as u32,
    reserved: 0,
    list: Some(list),
    call: Some(call),
    broadcast: Some(broadcast),
    options: Some(options),
    add: Some(add),
    call_below: Some(call_below),
    text: Some(super::ui_data::text),
    change: Some(super::ui_data::change),
};

unsafe extern "C" fn list(
    w: WorldRef<'_>,
    owner: tatu_object,
    out: *mut tatu_object,
    cap: u32,
    n: Option<&mut u32>,
) -> tatu_status {
    // SAFETY: the header requires `out` to be null or to have room for `cap` handles for the whole call.
    unsafe {
        on_world(w, HostFunction::read_only("scripts.list"), |world| {
            let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
            let owner = match owner {
                0 => 0,
                o => slot(world, &scene, o)?,
            };
            let all: Vec<_> =
                scene.scripts(owner).into_iter().filter(|s| !world.run.calls.hides(*s)).map(|s| scene.id(s)).collect();
            fill(&all, out, cap, n)
        })
    }
}

unsafe extern "C" fn call(
    w: WorldRef<'_>,
    script: tatu_object,
    function: Lent<'_>,
    frame: *mut tatu_call,
) -> tatu_status {
    // SAFETY: the header requires `frame` to be null or valid, with its arrays, for the whole call.
    unsafe {
        on_world(w, HostFunction::mutating("scripts.call"), |world| {
            require_frame(world, frame)?;
            let s = {
                let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
                slot(world, &scene, script)?
            };
            status_to_result(inner::call_function(world, s, function.bytes(), frame))
        })
    }
}

unsafe extern "C" fn broadcast(
    w: WorldRef<'_>,
    callback: Lent<'_>,
    args: *const tatu_value,
    n_args: u32,
    except: tatu_object,
) -> tatu_status {
    // SAFETY: the header requires `args` to be null or to hold `n_args` values for the whole call.
    unsafe {
        on_world(w, HostFunction::mutating("scripts.broadcast"), |world| {
            let args = input_slice(world, "a list of arguments", args, n_args)?;
            crate::cell::Scripts::broadcast(world, callback.bytes(), args, tatu_slot(except));
            Ok(())
        })
    }
}

extern "C" fn options<'a>(w: WorldRef<'a>, script: tatu_object, out: Option<&mut ValueRef<'a>>) -> tatu_status {
    on_world(w, HostFunction::read_only("scripts.options"), |world| {
        let s = {
            let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
            slot(world, &scene, script)?
        };
        let options = world.run.connections.options.try_borrow().map_err(|_| busy(world))?;
        write_value(world, options.get(&s).unwrap_or(&Value::Map(Vec::new())), out)
    })
}

extern "C" fn add(
    w: WorldRef<'_>,
    owner: tatu_object,
    language: Lent<'_>,
    dialect: Lent<'_>,
    kind: Lent<'_>,
    name: Lent<'_>,
    source: Lent<'_>,
    out: Option<&mut tatu_object>,
) -> tatu_status {
    on_world(w, HostFunction::mutating("scripts.add"), |world| {
        let out = require(world, "a pointer for the script", out)?;
        let refuse = |text: String| world.run.calls.refuse(TATU_ERR_ARGUMENT, &text);
        let owner = {
            let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
            slot(world, &scene, owner)?
        };
        let providers = world.model.settings.try_borrow().map_err(|_| busy(world))?.providers.clone();
        let language = world.model.registry.language(&language.text(), &providers).map_err(|e| refuse(e.text))?;
        let (dialect, kind) = (dialect.text().into_owned(), kind.text().into_owned());
        world.model.registry.check_dialect(Some(language), &dialect).map_err(|e| refuse(e.text))?;
        if !["child", "customization", "threaded"].contains(&kind.as_str()) {
            return Err(refuse(format!("unknown script kind `{kind}`; expected child, threaded or customization")));
        }
        let (name, text) = (name.text().into_owned(), source.bytes().to_vec());
        let spec = ScriptSpec {
            language,
            dialect,
            kind,
            priority: tatu_scene::document::NORMAL_PRIORITY,
            side_by_side: false,
            name,
            text,
        };
        let Some(slot) = crate::cell::Scripts::add(world, owner, &spec) else { return Err(busy(world)) };
        let id = world.state.scene.try_borrow().map_err(|_| busy(world))?.id(slot);
        *out = id;
        Ok(())
    })
}

unsafe extern "C" fn call_below(
    w: WorldRef<'_>,
    above: tatu_object,
    stage: u32,
    args: *const tatu_value,
    n_args: u32,
    n: Option<&mut u32>,
) -> tatu_status {
    // SAFETY: the header requires `args` to be null or to hold `n_args` values for the whole call.
    unsafe {
        on_world(w, HostFunction::mutating("scripts.call_below"), |world| {
            let above = {
                let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
                slot(world, &scene, above)?
            };
            let args = input_slice(world, "a list of arguments", args, n_args)?;
            let called = crate::cell::Scripts::call_below(world, above, stage, args);
            if let Some(n) = n {
                *n = called;
            }
            Ok(())
        })
    }
}
