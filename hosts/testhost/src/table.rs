//! The functions of the table in `tatu/test.h`, and the only exported symbol of the library.

use std::{ffi::c_char, path::PathBuf, ptr::null_mut};

use tatu_plugin_api::{abi::*, safe::ValueRef};

use crate::{
    answer::{self, CallError, guarded, last_error, status},
    open::{self, TestSetup},
    report, worlds,
};

/// The functions that tests call.
pub static TABLE: tatu_test_host = tatu_test_host {
    size: size_of::<tatu_test_host>() as u32,
    reserved: 0,
    open: Some(open),
    close: Some(close),
    step: Some(step),
    time: Some(time),
    field: Some(field),
    reading: Some(reading),
    get: Some(get),
    set: Some(set),
    call: Some(call),
    lines: Some(lines),
    faults: Some(faults),
    last_error: Some(last_error),
};

/// Returns the table of the test host.
#[unsafe(no_mangle)]
pub extern "C" fn tatu_test_host_get() -> *const tatu_test_host {
    &raw const TABLE
}

unsafe extern "C" fn open(setup: *const tatu_test_setup) -> *mut tatu_test_world {
    guarded(
        |_| null_mut(),
        || {
            // SAFETY: by the contract, null or a struct as large as its `size`.
            let given = unsafe { setup.as_ref() }.filter(|s| s.size as usize >= size_of::<tatu_test_setup>());
            let given = given.ok_or_else(|| {
                CallError::argument("the setup is null, or its `size` is smaller than sizeof(tatu_test_setup)")
            })?;
            // SAFETY: by the contract, strings that live through the call, and a null-terminated array.
            let setup = unsafe {
                let mut plugins = Vec::new();
                let mut next = given.plugins;
                while !next.is_null() && !(*next).is_null() {
                    plugins.push(PathBuf::from(answer::text(*next, "the path of a plugin")?));
                    next = next.add(1);
                }
                let folder = match given.folder.is_null() {
                    true => None,
                    false => Some(answer::text(given.folder, "the folder")?),
                };
                TestSetup { scene: Lent::new(given.scene).bytes(), folder: open::folder(folder), plugins }
            };
            worlds::add(&setup)
        },
    )
}

unsafe extern "C" fn close(world: *mut tatu_test_world) -> tatu_status {
    status(|| if world.is_null() { Ok(()) } else { worlds::remove(world) })
}

unsafe extern "C" fn step(world: *mut tatu_test_world, n: u64) -> tatu_status {
    status(|| {
        worlds::with(world, |open| {
            for _ in 0..n {
                if open.world.stop_requested() {
                    let text = format!("a stop was requested after {} steps", open.world.steps());
                    return Err(CallError(TATU_ERR_GONE, text));
                }
                open.world.step();
            }
            Ok(())
        })
    })
}

unsafe extern "C" fn time(world: *mut tatu_test_world) -> f64 {
    guarded(|_| -1.0, || worlds::with(world, |open| Ok(open.world.time())))
}

unsafe extern "C" fn field(
    world: *mut tatu_test_world,
    path: *const c_char,
    name: *const c_char,
    out: *mut tatu_value,
) -> tatu_status {
    status(|| {
        worlds::with(world, |open| {
            // SAFETY: by the contract, null or strings that live through the call.
            let (path, name) =
                unsafe { (answer::text(path, "the path")?, answer::text(name, "the name of the field")?) };
            let value = report::field(&open.world, path, name)?;
            // SAFETY: by the contract, `out` is null or writable.
            unsafe { write_out(out, open.lend(&value)) }
        })
    })
}

unsafe extern "C" fn reading(world: *mut tatu_test_world, path: *const c_char, out: *mut tatu_value) -> tatu_status {
    status(|| {
        worlds::with(world, |open| {
            // SAFETY: by the contract, null or a string that lives through the call.
            let path = unsafe { answer::text(path, "the path")? };
            let value = report::reading_map(&report::reading(&open.world, path)?);
            // SAFETY: by the contract, `out` is null or writable.
            unsafe { write_out(out, open.lend(&value)) }
        })
    })
}

unsafe extern "C" fn get(
    world: *mut tatu_test_world,
    path: *const c_char,
    key: *const c_char,
    out: *mut tatu_value,
) -> tatu_status {
    status(|| {
        worlds::with(world, |open| {
            // SAFETY: by the contract, null or strings that live through the call.
            let (path, key) = unsafe { (answer::text(path, "the path")?, answer::text(key, "the key")?) };
            let value = open.world.get(path, key).map_err(|r| CallError(r.0, r.1))?;
            // SAFETY: by the contract, `out` is null or writable.
            unsafe { write_out(out, open.lend(&value)) }
        })
    })
}

unsafe extern "C" fn set(
    world: *mut tatu_test_world,
    path: *const c_char,
    key: *const c_char,
    value: *const tatu_value,
) -> tatu_status {
    status(|| {
        worlds::with(world, |open| {
            // SAFETY: by the contract, strings that live through the call, and null or one value.
            let (path, key, values) = unsafe {
                let values = ValueRef::slice(value, usize::from(!value.is_null()));
                (answer::text(path, "the path")?, answer::text(key, "the key")?, values)
            };
            let value = values.first().ok_or_else(|| CallError::argument("the value is null"))?;
            let value = value.to_value().map_err(|e| CallError::argument(format!("`{key}`: {}", e.text())))?;
            open.world.set(path, key, &value).map_err(|r| CallError(r.0, r.1))
        })
    })
}

unsafe extern "C" fn call(
    world: *mut tatu_test_world,
    name: *const c_char,
    args: *const tatu_value,
    n_args: u32,
    results: *mut tatu_value,
    cap: u32,
    n_results: *mut u32,
) -> tatu_status {
    status(|| {
        worlds::with(world, |open| {
            // SAFETY: by the contract, a string and `n_args` values that live through the call.
            let (name, args) =
                unsafe { (answer::text(name, "the name of the command")?, ValueRef::slice(args, n_args as usize)) };
            let args: Result<Vec<_>, _> = args.iter().map(|v| v.to_value()).collect();
            let args = args.map_err(|e| CallError::argument(format!("{name}: {}", e.text())))?;
            let values = open.world.call(name, &args)?;
            let values = open.lend_all(&values);
            for (i, value) in values.iter().enumerate().take(if results.is_null() { 0 } else { cap as usize }) {
                // SAFETY: by the contract, `results` has room for `cap` values.
                unsafe { results.add(i).write(*value) };
            }
            // SAFETY: by the contract, `n_results` is null or points to a number.
            if let Some(n) = unsafe { n_results.as_mut() } {
                *n = values.len() as u32;
            }
            Ok(())
        })
    })
}

unsafe extern "C" fn lines(world: *mut tatu_test_world) -> tatu_str {
    let all = || {
        worlds::with(world, |open| {
            let lines: Vec<String> = open.world.take_lines().iter().map(report::log_line).collect();
            Ok(open.lend_text(lines.join("\n")))
        })
    };
    guarded(|_| Lent::EMPTY.raw(), all)
}

unsafe extern "C" fn faults(world: *mut tatu_test_world) -> tatu_str {
    let all = || worlds::with(world, |open| Ok(open.lend_text(open.new_faults().join("\n"))));
    guarded(|_| Lent::EMPTY.raw(), all)
}

/// Writes a value through a pointer that a test passes. Fails if the pointer is null.
///
/// # Safety
/// `out` must be null or point to a value.
unsafe fn write_out(out: *mut tatu_value, value: tatu_value) -> Result<(), CallError> {
    // SAFETY: the caller guarantees null or a pointer to a value.
    match unsafe { out.as_mut() } {
        Some(out) => {
            *out = value;
            Ok(())
        }
        None => Err(CallError::argument("`out` is null; expected a pointer to a value")),
    }
}
