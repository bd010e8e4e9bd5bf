//! The simulator as a C library. `include/tatu_world.h` declares and documents its functions.
//!
//! - `answer`: errors, and the guard around each function; `open`: the table of open worlds;
//! - `arguments`: conversion of arguments and results; `setup`: the arguments from which a world is built; this module:
//!   the exported functions.

mod answer;
mod arguments;
mod open;
mod setup;

use std::{ffi::c_char, ptr::null_mut};

use tatu_core::{LogLine, state::Snapshot};
use tatu_embed::CameraView;
use tatu_plugin_api::abi::*;

use crate::{
    answer::{CallError, guarded, status},
    arguments::{Out, copied, text, values, write_all, write_out},
    open::{LentPointer, OpaqueWorld, with_world},
    setup::tatu_world_setup,
};

#[unsafe(no_mangle)]
unsafe extern "C" fn tatu_world_open(setup: *const tatu_world_setup<'_>) -> *mut OpaqueWorld {
    // SAFETY: by the contract, null or a struct as large as its `size`, with strings that live through the call.
    guarded(|_| null_mut(), || unsafe { setup::read(setup) }.and_then(open::add))
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_fork(world: *mut OpaqueWorld) -> *mut OpaqueWorld {
    guarded(|_| null_mut(), || open::fork(world))
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_close(world: *mut OpaqueWorld) -> tatu_status {
    status(|| if world.is_null() { Ok(()) } else { open::remove(world) })
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_step(world: *mut OpaqueWorld, n: u64, done: Out<'_, u64>) -> tatu_status {
    status(|| {
        let stepped = with_world(world, |seat, _| Ok(seat.step(n)?))?;
        write_out(done, stepped.steps);
        Ok(())
    })
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_reset(world: *mut OpaqueWorld, seed: Option<&u64>) -> tatu_status {
    status(|| with_world(world, |seat, _| Ok(seat.reset(seed.copied(), None)?)))
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_time(world: *mut OpaqueWorld) -> f64 {
    guarded(|_| -1.0, || with_world(world, |seat, _| Ok(seat.world()?.time())))
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_dt(world: *mut OpaqueWorld) -> f64 {
    guarded(|_| -1.0, || with_world(world, |seat, _| Ok(seat.world()?.dt())))
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_hash(world: *mut OpaqueWorld, hash: Out<'_, u64>) -> tatu_status {
    status(|| {
        let total = with_world(world, |seat, _| Ok(seat.world()?.hash().total))?;
        write_out(hash, total);
        Ok(())
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn tatu_world_read(
    world: *mut OpaqueWorld,
    path: LentCStr<'_>,
    name: LentCStr<'_>,
    out: *mut f64,
    cap: u64,
    count: Out<'_, u64>,
) -> tatu_status {
    status(|| {
        let (path, name) = (text(path, "the path")?, text(name, "the name")?);
        let numbers = with_world(world, |seat, _| {
            let world = seat.world()?;
            let channel = world.channel(path, name)?;
            let mut numbers = vec![0.0; channel.shape.iter().product()];
            world.read_channel(&channel, &mut numbers)?;
            Ok(numbers)
        })?;
        // SAFETY: by the contract, `out` is null or has room for `cap` numbers.
        unsafe { write_all(out, usize::try_from(cap).unwrap_or(usize::MAX), &numbers) };
        write_out(count, numbers.len() as u64);
        Ok(())
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn tatu_world_write(
    world: *mut OpaqueWorld,
    path: LentCStr<'_>,
    name: LentCStr<'_>,
    numbers: *const f64,
    count: u64,
) -> tatu_status {
    status(|| {
        let (path, name) = (text(path, "the path")?, text(name, "the name")?);
        let count =
            usize::try_from(count).map_err(|_| CallError::argument(format!("`count` is too large: {count}")))?;
        let numbers: &[f64] = match (numbers.is_null(), count) {
            (_, 0) => &[],
            (true, _) => return Err(CallError::argument("`numbers` is null, but `count` is not 0")),
            // SAFETY: by the contract, `numbers` points to `count` numbers.
            (false, _) => unsafe { std::slice::from_raw_parts(numbers, count) },
        };
        with_world(world, |seat, _| {
            let world = seat.world()?;
            let channel = world.channel(path, name)?;
            let wanted: usize = channel.shape.iter().product();
            if numbers.len() != wanted {
                let text = format!("`{name}` of {path} has {wanted} values, but {} were given", numbers.len());
                return Err(CallError::argument(text));
            }
            Ok(world.write_channel(&channel, numbers)?)
        })
    })
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_get(
    world: *mut OpaqueWorld,
    path: LentCStr<'_>,
    name: LentCStr<'_>,
    out: Out<'_, tatu_value>,
) -> tatu_status {
    status(|| {
        let (path, name) = (text(path, "the path")?, text(name, "the name")?);
        let value = with_world(world, |seat, lent| Ok(lent.value(&seat.world()?.get(path, name)?)))?;
        write_out(out, value.0);
        Ok(())
    })
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_set(
    world: *mut OpaqueWorld,
    path: LentCStr<'_>,
    name: LentCStr<'_>,
    value: Option<&ValueRef<'_>>,
) -> tatu_status {
    status(|| {
        let (path, name) = (text(path, "the path")?, text(name, "the name")?);
        let value = value.ok_or_else(|| CallError::argument("the value is null"))?;
        let value = copied(*value, name)?;
        with_world(world, |seat, _| Ok(seat.world()?.set(path, name, &value)?))
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn tatu_world_call(
    world: *mut OpaqueWorld,
    name: LentCStr<'_>,
    args: *const tatu_value,
    n_args: u32,
    results: *mut tatu_value,
    cap: u32,
    n_results: Out<'_, u32>,
) -> tatu_status {
    status(|| {
        let name = text(name, "the name of the command")?;
        // SAFETY: by the contract, null or `n_args` values that live through the call.
        let args = unsafe { values(args, n_args, name)? };
        let lent = with_world(world, |seat, lent| {
            let results = seat.world()?.call(name, &args)?;
            Ok(lent.values(&results))
        })?;
        // SAFETY: by the contract, `results` is null or has room for `cap` values.
        unsafe { write_all(results, cap as usize, &lent.0) };
        write_out(n_results, lent.0.len() as u32);
        Ok(())
    })
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_snapshot(world: *mut OpaqueWorld, out: Out<'_, tatu_str>) -> tatu_status {
    status(|| {
        let bytes = with_world(world, |seat, lent| Ok(lent.bytes(seat.snapshot()?.to_bytes()?)))?;
        write_out(out, bytes.0);
        Ok(())
    })
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_restore(world: *mut OpaqueWorld, snapshot: Lent<'_>) -> tatu_status {
    status(|| {
        let snapshot = Snapshot::from_bytes(snapshot.bytes())?;
        with_world(world, |seat, _| Ok(seat.restore(&snapshot)?))
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn tatu_world_render(
    world: *mut OpaqueWorld,
    camera: LentCStr<'_>,
    columns: u32,
    rows: u32,
    rgb: *mut u8,
) -> tatu_status {
    status(|| {
        let view = match camera.get() {
            None => CameraView::SceneCamera,
            Some(_) => CameraView::Camera(text(camera, "the camera")?.to_owned()),
        };
        if rgb.is_null() {
            return Err(CallError::argument("`rgb` is null; expected a buffer for the picture"));
        }
        let picture =
            with_world(world, |seat, _| Ok(tatu_embed::picture(seat.world()?, &view, [columns, rows], None)?))?;
        // SAFETY: by the contract, `rgb` has room for the picture, which has 3 bytes per pixel.
        unsafe { write_all(rgb, picture.rgb.len(), &picture.rgb) };
        Ok(())
    })
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_lines(world: *mut OpaqueWorld) -> tatu_str {
    let lines = || {
        with_world(world, |seat, lent| {
            let lines: Vec<String> = seat.world()?.take_lines().iter().filter_map(LogLine::formatted).collect();
            Ok(lent.bytes(lines.join("\n").into_bytes()))
        })
    };
    guarded(|_| LentPointer::EMPTY, lines).0
}

#[unsafe(no_mangle)]
extern "C" fn tatu_world_error() -> *const c_char {
    answer::last_error()
}
