//! The plugin itself: entry, start, end, and the macro that exports it.

use std::ffi::{CStr, c_char, c_void};

use super::{
    Fail, Host, Offer, Result, World, guard,
    life::{Info, Life},
    offer::Tables,
};
use crate::abi::*;

/// A plugin. One value per host; it has no globals, and its world instances hold what belongs to a world.
pub trait Plugin: Sized + Send + Sync + 'static {
    /// What the plugin keeps per world; `()` if nothing. Commands get it as `&` and may be entered again while they call a
    /// function: cells, borrowed for as short as can be.
    type World: 'static;

    /// Starts it. Services can be found now, and called once a world exists.
    fn start(host: &Host) -> Result<Self>;
    /// Makes the instance for a new world.
    fn world(&self, world: &World<'_>) -> Result<Self::World>;
    /// Version of what [`Plugin::save`] writes; count it when that changes.
    const STATE_VERSION: u32 = 0;
    /// What `world` keeps, for a snapshot. Without this function a plugin that keeps something is named as what a
    /// snapshot lacks, and the run comes back by replay.
    fn save(world: &Self::World) -> Result<Vec<u8>> {
        let _ = world;
        if size_of::<Self::World>() == 0 {
            return Ok(Vec::new());
        }
        Err(Fail::unsupported("it cannot write what it keeps for the world"))
    }
    /// Takes back what `save` of a plugin of `version` wrote, into a new instance.
    fn load(world: &Self::World, bytes: &[u8], version: u32) -> Result<()> {
        let _ = (world, version);
        if bytes.is_empty() { Ok(()) } else { Err(Fail::unsupported("it reads no state")) }
    }
    /// Declares what it offers.
    fn offer(offer: &mut Offer<Self>);
}

/// What an instance is told about itself when it is made.
#[derive(Debug, Clone, Copy)]
pub struct Instance {
    /// The sensor, actuator or script object.
    pub owner: tatu_object,
    /// Unique in its world.
    pub id: u64,
    /// From the scene's seed and the owner: the same in every run.
    pub seed: u64,
}

/// What a plugin keeps for a world.
pub(crate) struct Kept<P: Plugin>(pub(crate) P::World);

impl<P: Plugin> Life for Kept<P> {
    type Plugin = P;
    const STATE_VERSION: u32 = P::STATE_VERSION;

    fn create(started: &Started<P>, info: &Info<'_>) -> Result<Self> {
        started.plugin.world(&info.world).map(Kept)
    }
    fn save(&self) -> Result<Vec<u8>> {
        P::save(&self.0)
    }
    fn load(&self, bytes: &[u8], version: u32) -> Result {
        P::load(&self.0, bytes, version)
    }
}

/// A started plugin, as the host's `self` pointer knows it.
pub(crate) struct Started<P: Plugin> {
    pub(crate) plugin: P,
    pub(crate) host: Host,
    tables: Tables,
}

/// A constant table whose pointers lead to constants.
#[doc(hidden)]
#[repr(transparent)]
pub struct Entry<T>(pub T);
// SAFETY: nobody writes through the pointers.
unsafe impl<T> Sync for Entry<T> {}

/// A host at least as new as this crate: the traits read what it fills without asking how much it has.
static HOST: Entry<tatu_need> = Entry(tatu_need {
    size: size_of::<tatu_need>() as u32,
    optional: 0,
    id: TATU_HOST_LOG.as_ptr(),
    bytes: 0,
    minor: TATU_ABI_MINOR as u32,
});
#[doc(hidden)]
pub static NEEDS: Entry<[*const tatu_need; 2]> = Entry([&raw const HOST.0, std::ptr::null()]);

#[doc(hidden)]
pub unsafe extern "C" fn init<P: Plugin>(
    host: *const tatu_host,
    me: *mut *mut c_void,
    error: *mut tatu_error,
) -> tatu_status {
    guard::run(error, || {
        // SAFETY: the host lives until shutdown.
        let host = unsafe { Host::new(host) }.ok_or_else(|| Fail::new("the host gave no table"))?;
        let plugin = P::start(&host)?;
        let mut offer = Offer::new();
        P::offer(&mut offer);
        let started = Box::new(Started { plugin, host, tables: offer.finish() });
        // SAFETY: the host gives a place for the pointer.
        unsafe { *me = Box::into_raw(started).cast() };
        Ok(TATU_OK)
    })
}

#[doc(hidden)]
pub unsafe extern "C" fn shutdown<P: Plugin>(me: *mut c_void) {
    guard::quiet(|| {
        if !me.is_null() {
            // SAFETY: made by `init`, given back once.
            drop(unsafe { Box::from_raw(me.cast::<Started<P>>()) });
        }
    });
}

#[doc(hidden)]
pub unsafe extern "C" fn extension<P: Plugin>(me: *mut c_void, id: *const c_char) -> *const c_void {
    if me.is_null() || id.is_null() {
        return std::ptr::null();
    }
    // SAFETY: made by `init`; `id` is NUL-terminated.
    let (tables, id) = unsafe { (&(*me.cast::<Started<P>>()).tables, CStr::from_ptr(id)) };
    match id {
        id if id == TATU_COMMAND => tables.command.cast(),
        id if id == TATU_SENSOR => tables.sensor.cast(),
        id if id == TATU_ACTUATOR => tables.actuator.cast(),
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

/// Exports a [`Plugin`](crate::safe::Plugin) as the library's one symbol.
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
