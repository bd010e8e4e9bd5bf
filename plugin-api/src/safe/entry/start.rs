//! The single symbol that a library exports, with its functions for start and shutdown, and the macro that defines it.

use std::{
    ffi::{CStr, c_char, c_void},
    sync::Mutex,
};

use crate::abi::*;
use crate::safe::{Fail, Host, Offer, Plugin, declare::plugin::StartedPlugin, entry::panics};

/// A constant table, which points only to constants and can therefore be shared between threads.
#[doc(hidden)]
#[repr(transparent)]
pub struct Entry<T>(pub T);
// SAFETY: the table and everything it points to are constant, so sharing it between threads is sound.
unsafe impl<T> Sync for Entry<T> {}

/// Requires a host at least as new as this crate, because the traits read most of its tables without checking their
/// size.
static HOST_NEED: Entry<tatu_need> = Entry(tatu_need {
    size: size_of::<tatu_need>() as u32,
    optional: 0,
    id: TATU_HOST_LOG.as_ptr(),
    bytes: 0,
    minor: TATU_ABI_MINOR as u32,
});
#[doc(hidden)]
pub static NEEDS: Entry<[*const tatu_need; 2]> = Entry([&raw const HOST_NEED.0, std::ptr::null()]);

#[doc(hidden)]
pub unsafe extern "C" fn init<P: Plugin>(
    host: *const tatu_host,
    me: *mut *mut c_void,
    error: *mut tatu_error,
) -> tatu_status {
    panics::run(error, || {
        // SAFETY: the host passes null or its table, which lives until shutdown.
        let host = unsafe { Host::new(host) }.ok_or_else(|| Fail::new("the host passed no tatu_host"))?;
        let plugin = P::start(&host)?;
        let mut offer = Offer::new();
        P::offer(&mut offer);
        let heard = offer.events.listener.as_ref().map(|(heard, _)| *heard);
        let tables = offer.finish();
        let started = Box::new(StartedPlugin { plugin, host, tables, heard, model_cache: Mutex::default() });
        // SAFETY: `me` is valid for a write, as the header requires.
        unsafe { *me = Box::into_raw(started).cast() };
        Ok(TATU_OK)
    })
}

#[doc(hidden)]
pub unsafe extern "C" fn shutdown<P: Plugin>(me: *mut c_void) {
    panics::quiet(|| {
        if !me.is_null() {
            // SAFETY: `me` was created by `Box::into_raw` in `init`, and the host calls shutdown only once.
            drop(unsafe { Box::from_raw(me.cast::<StartedPlugin<P>>()) });
        }
    });
}

#[doc(hidden)]
pub unsafe extern "C" fn extension<P: Plugin>(me: *mut c_void, id: *const c_char) -> *const c_void {
    if me.is_null() || id.is_null() {
        return std::ptr::null();
    }
    // SAFETY: `me` was created by `init` and is live until shutdown; `id` is NUL-terminated. Null was excluded above.
    let (tables, id) = unsafe { (&(*me.cast::<StartedPlugin<P>>()).tables, CStr::from_ptr(id)) };
    match id {
        id if id == TATU_COMMAND => tables.command.cast(),
        id if id == TATU_SENSOR => tables.sensor.cast(),
        id if id == TATU_ACTUATOR => tables.actuator.cast(),
        id if id == TATU_PART => tables.part.cast(),
        id if id == TATU_MODEL => tables.model.cast(),
        id if id == TATU_IMPORTER => tables.importer.cast(),
        id if id == TATU_SCRIPT => tables.script.cast(),
        id if id == TATU_SERVICE => tables.service.cast(),
        id if id == TATU_EVENT => tables.event.cast(),
        #[cfg(feature = "layout-check")]
        id if id == TATU_RUST_LAYOUT => layout_table().cast(),
        _ => std::ptr::null(),
    }
}

/// Exports a [`Plugin`](crate::safe::Plugin) as the library's single symbol.
#[macro_export]
macro_rules! tatu_plugin {
    (plugin: $plugin:ty, id: $id:literal, name: $name:literal, version: $version:expr, licence: $licence:literal $(,)?) => {
        #[doc(hidden)]
        #[allow(non_upper_case_globals, missing_docs)]
        #[unsafe(no_mangle)]
        pub static tatu_plugin: $crate::safe::macro_support::Entry<$crate::abi::tatu_plugin_t> =
            $crate::safe::macro_support::Entry($crate::abi::tatu_plugin_t {
                size: ::core::mem::size_of::<$crate::abi::tatu_plugin_t>() as u32,
                abi_major: $crate::abi::TATU_ABI_MAJOR,
                abi_minor: $crate::abi::TATU_ABI_MINOR,
                id: ::core::concat!($id, "\0").as_ptr().cast(),
                name: ::core::concat!($name, "\0").as_ptr().cast(),
                version: ::core::concat!($version, "\0").as_ptr().cast(),
                licence: ::core::concat!($licence, "\0").as_ptr().cast(),
                needs: (&raw const $crate::safe::macro_support::NEEDS.0).cast(),
                init: ::core::option::Option::Some($crate::safe::macro_support::init::<$plugin>),
                shutdown: ::core::option::Option::Some($crate::safe::macro_support::shutdown::<$plugin>),
                extension: ::core::option::Option::Some($crate::safe::macro_support::extension::<$plugin>),
            });
    };
}
