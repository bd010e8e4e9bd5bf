//! Catches panics, which must not leave a plugin. The functions that the host calls run inside these guards, except the
//! lookup of extensions, which cannot panic.

use std::{
    any::Any,
    cell::RefCell,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::OnceLock,
};

use crate::abi::*;
use crate::safe::{Fail, Result};

/// Runs `f` and returns its status; an error or panic is written to the host's error object.
pub(crate) fn run(error: *mut tatu_error, f: impl FnOnce() -> Result<tatu_status>) -> tatu_status {
    let fail = match catch_unwind(AssertUnwindSafe(f)) {
        Ok(Ok(status)) => return status,
        Ok(Err(fail)) => fail,
        Err(panic) => Fail::with_code(TATU_ERR_PANIC, format!("panicked: {}", panic_text(&*panic))),
    };
    // SAFETY: the host passes null or an error object that is live during the call.
    unsafe { fail.write(error) }
}

/// Runs `f`, for plugins that fill tables of the ABI themselves; an error or panic is written to the host's error
/// object. The traits of this crate need no such guard.
///
/// # Safety
/// `error` must be null, or point to an error object of the host that is alive during the call.
pub unsafe fn guarded(error: *mut tatu_error, f: impl FnOnce() -> Result<tatu_status>) -> tatu_status {
    run(error, f)
}

/// Runs `f` where no error can be returned. If it panics, the panic is logged as an error and the default is returned.
pub fn quiet<T: Default>(f: impl FnOnce() -> T) -> T {
    catch_unwind(AssertUnwindSafe(f)).unwrap_or_else(|panic| {
        if let Some(log) = LOG.get() {
            log(TATU_LOG_ERROR, &format!("panicked: {}", panic_text(&*panic)));
        }
        T::default()
    })
}

/// The log of the host that first started a plugin of this library. Each library has its own copy of this static.
static LOG: OnceLock<LogFn> = OnceLock::new();
type LogFn = Box<dyn Fn(u32, &str) + Send + Sync>;

thread_local! {
    /// The position of the last panic of this thread, as ` at file:line`.
    static LAST_PANIC_PLACE: RefCell<String> = const { RefCell::new(String::new()) };
}

fn panic_text(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied();
    let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no text");
    text.to_owned() + &LAST_PANIC_PLACE.take()
}

/// Sends panic messages to the host's `log` instead of the terminal. Each library has a separate panic hook.
pub fn set_panic_hook(log: impl Fn(u32, &str) + Send + Sync + 'static) {
    if LOG.set(Box::new(log)).is_ok() {
        std::panic::set_hook(Box::new(|info| {
            let place = info.location().map_or(String::new(), |at| format!(" at {}:{}", at.file(), at.line()));
            // When a thread ends, its thread-locals may have been destroyed already.
            let _ = LAST_PANIC_PLACE.try_with(|last| last.replace(place));
            if let Some(log) = LOG.get() {
                log(TATU_LOG_DEBUG, &format!("plugin {info}"));
            }
        }));
    }
}
