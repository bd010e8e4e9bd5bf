//! Panics stay inside: every function that the host calls goes through here.

use std::{
    any::Any,
    ffi::c_void,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::OnceLock,
};

use super::{Fail, Host, Plugin, Result, World, fail::bytes_of, plugin::Started};
use crate::abi::*;

/// Runs `f`; an error or panic is written into the host's error object.
pub(crate) fn run(error: *mut tatu_error, f: impl FnOnce() -> Result<tatu_status>) -> tatu_status {
    match catch_unwind(AssertUnwindSafe(f)) {
        Ok(Ok(status)) => status,
        // SAFETY: the host gives null or a live error.
        Ok(Err(fail)) => unsafe { fail.write(error) },
        Err(panic) => {
            let fail = Fail::with_code(TATU_ERR_PANIC, format!("panicked: {}", panic_text(&*panic)));
            // SAFETY: the host gives null or a live error.
            unsafe { fail.write(error) }
        }
    }
}

/// The same for functions that a plugin writes into a table of the ABI on its own: no panic may leave these. The traits
/// of this crate do so themselves.
///
/// # Safety
/// `error` is null or what the host gave.
pub unsafe fn guarded(error: *mut tatu_error, f: impl FnOnce() -> Result<tatu_status>) -> tatu_status {
    run(error, f)
}

/// Runs `f` where no error can be returned: a panic goes to the host's log as an error, and the host names the function
/// that it called.
pub fn quiet<T: Default>(f: impl FnOnce() -> T) -> T {
    catch_unwind(AssertUnwindSafe(f)).unwrap_or_else(|panic| {
        if let Some(log) = LOG.get() {
            log(TATU_LOG_ERROR, &format!("panicked: {}", panic_text(&*panic)));
        }
        T::default()
    })
}

/// The log of the host that started this library first: each library has its own.
static LOG: OnceLock<Log> = OnceLock::new();
type Log = Box<dyn Fn(u32, &str) + Send + Sync>;

fn panic_text(panic: &(dyn Any + Send)) -> &str {
    panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no text")
}

/// Sends panic messages to the host's log instead of the terminal. Each library has a panic hook of its own.
pub fn set_panic_hook(host: &Host) {
    if LOG.set(Box::new(host.logger())).is_ok() {
        std::panic::set_hook(Box::new(|info| {
            if let Some(log) = LOG.get() {
                log(TATU_LOG_DEBUG, &format!("plugin {info}"));
            }
        }));
    }
}

/// The life of a plugin's world instances.
pub(crate) fn life<P: Plugin>() -> tatu_life {
    tatu_life {
        size: size_of::<tatu_life>() as u32,
        state_bytes: 0,
        create: Some(create::<P>),
        destroy: Some(destroy::<P>),
        configure: None,
        save: Some(save::<P>),
        load: Some(load::<P>),
        version: P::STATE_VERSION,
        reserved: 0,
    }
}

unsafe extern "C" fn create<P: Plugin>(
    me: *mut c_void,
    info: *const tatu_instance,
    data: *mut *mut c_void,
    error: *mut tatu_error,
) -> tatu_status {
    run(error, || {
        // SAFETY: `me` was made by `init`; the host gives valid pointers.
        unsafe {
            let started = &*me.cast::<Started<P>>();
            let world = World::new((*info).world, &started.host);
            let instance: P::World = started.plugin.world(&world)?;
            *data = Box::into_raw(Box::new(instance)).cast();
        }
        Ok(TATU_OK)
    })
}

unsafe extern "C" fn save<P: Plugin>(
    data: *mut c_void,
    writer: *const tatu_writer,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: made by `create`; the host gives a valid writer.
    run(error, || unsafe { write(writer, &P::save(&*data.cast::<P::World>())?) })
}

unsafe extern "C" fn load<P: Plugin>(
    data: *mut c_void,
    bytes: tatu_str,
    version: u32,
    error: *mut tatu_error,
) -> tatu_status {
    run(error, || {
        // SAFETY: made by `create`; the bytes are valid during the call.
        unsafe { P::load(&*data.cast::<P::World>(), bytes_of(bytes), version)? };
        Ok(TATU_OK)
    })
}

/// Hands what an instance saved to the host.
///
/// # Safety
/// The writer is the host's.
pub(crate) unsafe fn write(writer: *const tatu_writer, bytes: &[u8]) -> Result<tatu_status> {
    // SAFETY: the caller promises it.
    let write = unsafe { writer.as_ref() }.and_then(|w| w.write);
    let write = write.ok_or_else(|| Fail::new("the host gave no writer"))?;
    // SAFETY: the caller promises it; the bytes are copied.
    unsafe { write(writer, bytes.as_ptr().cast(), bytes.len() as u64) };
    Ok(TATU_OK)
}

unsafe extern "C" fn destroy<P: Plugin>(data: *mut c_void) {
    quiet(|| {
        // SAFETY: made by `create`, given back once.
        drop(unsafe { Box::from_raw(data.cast::<P::World>()) });
    });
}
