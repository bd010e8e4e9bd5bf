//! `tatu.host.log`: lines, and why a service refused.

use tatu_plugin_api::abi::*;
use tatu_plugins::{border::text, guard};

use crate::cell::WorldCell;

pub static TABLE: tatu_host_log = tatu_host_log {
    size: size_of::<tatu_host_log>() as u32,
    reserved: 0,
    write: Some(write),
    last_error: Some(last_error),
};

unsafe extern "C" fn write(_: *const tatu_host, w: *mut tatu_world, level: u32, line: tatu_str) {
    // SAFETY: by the contract: the text is valid during the call.
    unsafe {
        let line = text(line);
        match WorldCell::at(w) {
            Some(world) => world.log(level, &line),
            None => match level {
                // The host tells it once, with the function that it was in.
                TATU_LOG_ERROR if guard::say(&line) => {}
                TATU_LOG_ERROR => tracing::error!("{line}"),
                TATU_LOG_WARNING => tracing::warn!("{line}"),
                TATU_LOG_DEBUG => tracing::debug!("{line}"),
                _ => tracing::info!("{line}"),
            },
        }
    }
}

unsafe extern "C" fn last_error(w: *mut tatu_world) -> *const tatu_error {
    let world = WorldCell::at(w);
    world
        .and_then(|world| world.calls.last.try_borrow_mut().ok().map(|mut l| l.raw().cast_const()))
        .unwrap_or(std::ptr::null())
}
