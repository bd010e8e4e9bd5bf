//! The functions of the table in `tatu/test.h`, and the only exported symbol of the library.

use std::{ffi::c_char, mem::MaybeUninit, path::PathBuf, ptr::null_mut};

use tatu_plugin_api::{abi::*, safe::ValueRef};

use crate::{
    answer::{CallError, guarded, last_error, status, string, text},
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
            // SAFETY: by the contract, null or a struct as large as its `size`, which is read first.
            let given = unsafe {
                let size = setup.cast::<u32>().as_ref().map_or(0, |size| *size as usize);
                (size >= size_of::<tatu_test_setup>()).then(|| &*setup)
            };
            let given = given.ok_or_else(|| {
                CallError::argument("the setup is null, or its `size` is smaller than sizeof(tatu_test_setup)")
            })?;
            // SAFETY: by the contract, strings that live through the call, and a null-terminated array.
            let (scene, folder, paths) = unsafe {
                let mut paths = Vec::new();
                let mut next = given.plugins;
                while !next.is_null() && !(*next).is_null() {
                    paths.push(string(*next));
                    next = next.add(1);
                }
                (Lent::new(given.scene).bytes(), string(given.folder), paths)
            };
            let folder = folder.map(|folder| text(Some(folder), "the folder")).transpose()?;
            let plugin = |path| Ok(PathBuf::from(text(path, "the path of a plugin")?));
            let plugins = paths.into_iter().map(plugin).collect::<Result<_, CallError>>()?;
            let setup = TestSetup { scene, folder: open::folder(folder), plugins };
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
    // SAFETY: by the contract, null or strings that live through the call, and null or a place for a value.
    let (path, name, out) = unsafe { (string(path), string(name), place(out)) };
    status(|| {
        worlds::with(world, |open| {
            let (path, name) = (text(path, "the path")?, text(name, "the name of the field")?);
            let value = report::field(&open.world, path, name)?;
            write_out(out, open.lend(&value))
        })
    })
}

unsafe extern "C" fn reading(world: *mut tatu_test_world, path: *const c_char, out: *mut tatu_value) -> tatu_status {
    // SAFETY: by the contract, null or a string that lives through the call, and null or a place for a value.
    let (path, out) = unsafe { (string(path), place(out)) };
    status(|| {
        worlds::with(world, |open| {
            let value = report::reading_map(&report::reading(&open.world, text(path, "the path")?)?);
            write_out(out, open.lend(&value))
        })
    })
}

unsafe extern "C" fn get(
    world: *mut tatu_test_world,
    path: *const c_char,
    key: *const c_char,
    out: *mut tatu_value,
) -> tatu_status {
    // SAFETY: by the contract, null or strings that live through the call, and null or a place for a value.
    let (path, key, out) = unsafe { (string(path), string(key), place(out)) };
    status(|| {
        worlds::with(world, |open| {
            let (path, key) = (text(path, "the path")?, text(key, "the key")?);
            let value = open.world.get(path, key).map_err(|r| CallError(r.0, r.1))?;
            write_out(out, open.lend(&value))
        })
    })
}

unsafe extern "C" fn set(
    world: *mut tatu_test_world,
    path: *const c_char,
    key: *const c_char,
    value: *const tatu_value,
) -> tatu_status {
    // SAFETY: by the contract, null or strings that live through the call, and null or one value.
    let (path, key, values) =
        unsafe { (string(path), string(key), ValueRef::slice(value, usize::from(!value.is_null()))) };
    status(|| {
        worlds::with(world, |open| {
            let (path, key) = (text(path, "the path")?, text(key, "the key")?);
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
    // SAFETY: by the contract, null or a string and `n_args` values that live through the call, and null or places for
    // `cap` values and a number.
    let (name, args, results, n_results) = unsafe {
        let results = match results.is_null() {
            true => &mut [],
            false => std::slice::from_raw_parts_mut(results.cast::<MaybeUninit<tatu_value>>(), cap as usize),
        };
        (string(name), ValueRef::slice(args, n_args as usize), results, place(n_results))
    };
    status(|| {
        worlds::with(world, |open| {
            let name = text(name, "the name of the command")?;
            let args: Result<Vec<_>, _> = args.iter().map(|v| v.to_value()).collect();
            let args = args.map_err(|e| CallError::argument(format!("{name}: {}", e.text())))?;
            let values = open.world.call(name, &args)?;
            let values = open.lend_all(&values);
            for (place, value) in results.iter_mut().zip(&values) {
                place.write(*value);
            }
            if let Some(n) = n_results {
                n.write(values.len() as u32);
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

/// Returns the place for a result that a test passes, which need not be initialised, or `None` for null.
///
/// # Safety
/// `out` must be null or point to memory for a `T` that nothing else uses within `'a`.
unsafe fn place<'a, T>(out: *mut T) -> Option<&'a mut MaybeUninit<T>> {
    // SAFETY: the caller guarantees null or memory for a `T`.
    unsafe { out.cast::<MaybeUninit<T>>().as_mut() }
}

/// Writes a value to a place that a test passes. Fails if there is none.
fn write_out(out: Option<&mut MaybeUninit<tatu_value>>, value: tatu_value) -> Result<(), CallError> {
    let out = out.ok_or_else(|| CallError::argument("`out` is null; expected a pointer to a value"))?;
    out.write(value);
    Ok(())
}
