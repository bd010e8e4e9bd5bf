//! The simulator as a C library. `include/tatu_world.h` declares and documents its functions.
//!
//! - `answer`: errors, and the guard around each function; `open`: the table of open worlds;
//! - `given`: conversion of arguments and results; `setup`: the arguments from which a world is built; this module: the
//!   exported functions.

mod answer;
mod given;
mod open;
mod setup;

use std::{ffi::c_char, ptr::null_mut};

use tatu_core::{LogLine, state::Snapshot};
use tatu_embed::View;
use tatu_plugin_api::{
    abi::*,
    safe::{Value, ValueRef},
};

use crate::{
    answer::{Wrong, guarded, status},
    given::{bytes, give, text},
    open::{Handle, Lent, with},
    setup::tatu_world_setup,
};

#[unsafe(no_mangle)]
unsafe extern "C" fn tatu_world_open(setup: *const tatu_world_setup) -> *mut Handle {
    // SAFETY: by the contract, null or a struct as large as its `size`, with strings that live through the call.
    guarded(|_| null_mut(), || unsafe { setup::read(setup) }.and_then(open::add))
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_fork(world: *mut Handle) -> *mut Handle {
    guarded(|_| null_mut(), || open::fork(world))
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_close(world: *mut Handle) -> tatu_status {
    status(|| if world.is_null() { Ok(()) } else { open::remove(world) })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn tatu_world_step(world: *mut Handle, n: u64, done: *mut u64) -> tatu_status {
    status(|| {
        let stepped = with(world, |seat, _| Ok(seat.step(n)?))?;
        // SAFETY: by the contract, `done` is null or writable.
        unsafe { give(done, stepped.steps) };
        Ok(())
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn tatu_world_reset(world: *mut Handle, seed: *const u64) -> tatu_status {
    // SAFETY: by the contract, `seed` is null or points to a number.
    let seed = unsafe { seed.as_ref() }.copied();
    status(|| with(world, |seat, _| Ok(seat.reset(seed, None)?)))
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_time(world: *mut Handle) -> f64 {
    guarded(|_| -1.0, || with(world, |seat, _| Ok(seat.world()?.time())))
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_dt(world: *mut Handle) -> f64 {
    guarded(|_| -1.0, || with(world, |seat, _| Ok(seat.world()?.dt())))
}

#[unsafe(no_mangle)]
unsafe extern "C" fn tatu_world_hash(world: *mut Handle, hash: *mut u64) -> tatu_status {
    status(|| {
        let total = with(world, |seat, _| Ok(seat.world()?.hash().total))?;
        // SAFETY: by the contract, `hash` is null or writable.
        unsafe { give(hash, total) };
        Ok(())
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn tatu_world_read(
    world: *mut Handle,
    path: *const c_char,
    name: *const c_char,
    out: *mut f64,
    cap: u64,
    count: *mut u64,
) -> tatu_status {
    status(|| {
        // SAFETY: by the contract, null or strings that live through the call.
        let (path, name) = unsafe { (text(path, "the path")?, text(name, "the name")?) };
        let numbers = with(world, |seat, _| {
            let world = seat.world()?;
            let channel = world.channel(path, name)?;
            let mut numbers = vec![0.0; channel.shape.iter().product()];
            world.read_channel(&channel, &mut numbers)?;
            Ok(numbers)
        })?;
        let n = numbers.len().min(usize::try_from(cap).unwrap_or(usize::MAX));
        if !out.is_null() {
            // SAFETY: by the contract, `out` has room for `cap` numbers; it cannot overlap `numbers`, which is local.
            unsafe { out.copy_from_nonoverlapping(numbers.as_ptr(), n) };
        }
        // SAFETY: by the contract, `count` is null or writable.
        unsafe { give(count, numbers.len() as u64) };
        Ok(())
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn tatu_world_write(
    world: *mut Handle,
    path: *const c_char,
    name: *const c_char,
    numbers: *const f64,
    count: u64,
) -> tatu_status {
    status(|| {
        // SAFETY: by the contract, null or strings that live through the call.
        let (path, name) = unsafe { (text(path, "the path")?, text(name, "the name")?) };
        let count = usize::try_from(count).map_err(|_| Wrong::argument(format!("`count` is too large: {count}")))?;
        let numbers: &[f64] = match (numbers.is_null(), count) {
            (_, 0) => &[],
            (true, _) => return Err(Wrong::argument("`numbers` is null, but `count` is not 0")),
            // SAFETY: by the contract, `numbers` points to `count` numbers.
            (false, _) => unsafe { std::slice::from_raw_parts(numbers, count) },
        };
        with(world, |seat, _| {
            let world = seat.world()?;
            let channel = world.channel(path, name)?;
            let wanted: usize = channel.shape.iter().product();
            if numbers.len() != wanted {
                let text = format!("`{name}` of {path} has {wanted} values, but {} were given", numbers.len());
                return Err(Wrong::argument(text));
            }
            Ok(world.write_channel(&channel, numbers)?)
        })
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn tatu_world_get(
    world: *mut Handle,
    path: *const c_char,
    name: *const c_char,
    out: *mut tatu_value,
) -> tatu_status {
    status(|| {
        // SAFETY: by the contract, null or strings that live through the call.
        let (path, name) = unsafe { (text(path, "the path")?, text(name, "the name")?) };
        let value = with(world, |seat, lent| Ok(lent.value(&seat.world()?.get(path, name)?)))?;
        // SAFETY: by the contract, `out` is null or writable.
        unsafe { give(out, value.0) };
        Ok(())
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn tatu_world_set(
    world: *mut Handle,
    path: *const c_char,
    name: *const c_char,
    value: *const tatu_value,
) -> tatu_status {
    status(|| {
        // SAFETY: by the contract, strings that live through the call, and null or one value.
        let (path, name, value) = unsafe {
            let value = values(value, u32::from(!value.is_null()), name)?;
            (text(path, "the path")?, text(name, "the name")?, value)
        };
        let value = value.into_iter().next().ok_or_else(|| Wrong::argument("the value is null"))?;
        with(world, |seat, _| Ok(seat.world()?.set(path, name, &value)?))
    })
}

/// Copies values that the caller passes; error messages refer to them as `name`.
///
/// # Safety
/// `values` must point to `n` values, and `name` must be null or a zero-terminated string. Both must live through the
/// call.
unsafe fn values(values: *const tatu_value, n: u32, name: *const c_char) -> Result<Vec<Value>, Wrong> {
    // SAFETY: the caller guarantees `n` values and a string that live through the call.
    let (values, name) = unsafe { (ValueRef::slice(values, n as usize), text(name, "the name")?) };
    let all: Result<Vec<_>, _> = values.iter().map(|v| v.to_value()).collect();
    all.map_err(|e| Wrong::argument(format!("{name}: {}", e.text())))
}

#[unsafe(no_mangle)]
unsafe extern "C" fn tatu_world_call(
    world: *mut Handle,
    name: *const c_char,
    args: *const tatu_value,
    n_args: u32,
    results: *mut tatu_value,
    cap: u32,
    n_results: *mut u32,
) -> tatu_status {
    status(|| {
        // SAFETY: by the contract, a string and `n_args` values that live through the call.
        let (name, args) = unsafe { (text(name, "the name of the command")?, values(args, n_args, name)?) };
        let lent = with(world, |seat, lent| {
            let results = seat.world()?.call(name, &args)?;
            Ok(lent.values(&results))
        })?;
        for (i, value) in lent.0.iter().enumerate().take(if results.is_null() { 0 } else { cap as usize }) {
            // SAFETY: by the contract, `results` has room for `cap` values.
            unsafe { results.add(i).write(*value) };
        }
        // SAFETY: by the contract, `n_results` is null or writable.
        unsafe { give(n_results, lent.0.len() as u32) };
        Ok(())
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn tatu_world_snapshot(world: *mut Handle, out: *mut tatu_str) -> tatu_status {
    status(|| {
        let bytes = with(world, |seat, lent| Ok(lent.bytes(seat.snapshot()?.to_bytes()?)))?;
        // SAFETY: by the contract, `out` is null or writable.
        unsafe { give(out, bytes.0) };
        Ok(())
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn tatu_world_restore(world: *mut Handle, snapshot: tatu_str) -> tatu_status {
    status(|| {
        // SAFETY: by the contract, `len` bytes that live through the call.
        let snapshot = Snapshot::from_bytes(unsafe { bytes(snapshot) })?;
        with(world, |seat, _| Ok(seat.restore(&snapshot)?))
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn tatu_world_render(
    world: *mut Handle,
    camera: *const c_char,
    columns: u32,
    rows: u32,
    rgb: *mut u8,
) -> tatu_status {
    status(|| {
        let view = match camera.is_null() {
            true => View::Own,
            // SAFETY: by the contract, a string that lives through the call.
            false => View::Camera(unsafe { text(camera, "the camera") }?.to_owned()),
        };
        if rgb.is_null() {
            return Err(Wrong::argument("`rgb` is null; expected a buffer for the picture"));
        }
        let picture = with(world, |seat, _| Ok(tatu_embed::picture(seat.world()?, &view, [columns, rows], None)?))?;
        // SAFETY: by the contract, `rgb` has room for the picture, which has 3 bytes per pixel.
        unsafe { rgb.copy_from_nonoverlapping(picture.rgb.as_ptr(), picture.rgb.len()) };
        Ok(())
    })
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_lines(world: *mut Handle) -> tatu_str {
    let lines = || {
        with(world, |seat, lent| {
            let lines: Vec<String> = seat.world()?.take_lines().iter().filter_map(LogLine::shown).collect();
            Ok(lent.bytes(lines.join("\n").into_bytes()))
        })
    };
    guarded(|_| Lent::EMPTY, lines).0
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_error() -> *const c_char {
    answer::last()
}
