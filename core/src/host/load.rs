//! Opens one library and reads its descriptor.

use std::{
    ffi::c_void,
    path::{Path, PathBuf},
    sync::Arc,
};

use libloading::Library;
use tatu_plugin_api::abi::*;

use super::{services::HostTables, tables};
use crate::error::{Error, Result};

/// A loaded and started plugin. Never unloaded: threads and thread-locals of the library may outlive any wish.
pub struct Loaded {
    /// Its id.
    pub id: String,
    /// For people.
    pub name: String,
    /// Its version.
    pub version: String,
    /// Its licence.
    pub licence: String,
    /// ABI that it was built against.
    pub abi: (u16, u16),
    /// The library.
    pub path: PathBuf,
    pub(crate) me: *mut c_void,
    raw: tatu_plugin_t,
    /// The host's tables, to which the plugin keeps pointers.
    _host: Arc<HostTables>,
}

impl Loaded {
    /// Opens and starts a plugin.
    pub fn open(path: &Path, host: &Arc<HostTables>) -> Result<Self> {
        let fail = |text: String| Error::new("E301", format!("cannot load the plugin {}: {text}", path.display()));
        super::elf::check(path).map_err(&fail)?;
        // SAFETY: running a library's constructors is what loading a plugin means.
        let library = unsafe { Library::new(path) }.map_err(|e| {
            // The loader's own words are behind libloading's.
            let reason = std::error::Error::source(&e).map_or(String::new(), |s| format!(": {s}"));
            fail(format!("{e}{reason}"))
        })?;
        // SAFETY: the symbol is a constant of this type by the contract.
        let descriptor: *const tatu_plugin_t =
            unsafe { library.get::<*const tatu_plugin_t>(b"tatu_plugin\0").map(|s| s.try_as_raw_ptr()) }
                .ok()
                .flatten()
                .map_or(std::ptr::null(), |p| p.cast::<tatu_plugin_t>().cast_const());
        // Never unload, see above.
        std::mem::forget(library);
        // SAFETY: the descriptor lives as long as the library.
        let raw = unsafe { tables::read(descriptor) }.ok_or_else(|| {
            fail("it exports no `tatu_plugin`".into())
                .help("a plugin exports a `tatu_plugin_t` of that name; in C++ include tatu.h before defining it")
        })?;
        if raw.abi_major != TATU_ABI_MAJOR {
            return Err(fail(format!(
                "it was built for ABI {}.{}, this host has {TATU_ABI_MAJOR}.{TATU_ABI_MINOR}",
                raw.abi_major, raw.abi_minor
            ))
            .help("rebuild it against this release's plugin-api"));
        }
        // SAFETY: strings of the descriptor live as long as the library.
        let text = |p| unsafe { tables::text(p) };
        let id = text(raw.id).filter(|s| !s.is_empty()).ok_or_else(|| fail("it has no id".into()))?;
        Self::check_needs(&raw, host).map_err(&fail)?;
        let mut me = std::ptr::null_mut();
        let mut error = crate::calls::ErrorSlot::new();
        if let Some(init) = raw.init {
            // SAFETY: by the contract; the host's table lives as long as `_host`.
            let status = unsafe { init(host.raw(), &mut me, error.raw()) };
            if status < 0 {
                return Err(fail(format!("its start failed: {}", error.text())));
            }
        }
        let loaded = Loaded {
            id,
            name: text(raw.name).unwrap_or_default(),
            version: text(raw.version).unwrap_or_default(),
            licence: text(raw.licence).unwrap_or_default(),
            abi: (raw.abi_major, raw.abi_minor),
            path: path.to_owned(),
            me,
            raw,
            _host: host.clone(),
        };
        loaded.check_layouts().map_err(fail)?;
        Ok(loaded)
    }

    fn check_needs(raw: &tatu_plugin_t, host: &HostTables) -> Result<(), String> {
        // SAFETY: a null-terminated list of tables, by the contract.
        for need in unsafe { tables::pointers(raw.needs) } {
            // SAFETY: as above.
            let (optional, id) = unsafe { ((*need).optional, (*need).id) };
            // SAFETY: NUL-terminated, by the contract.
            let Some(id) = (unsafe { tables::text(id) }) else { continue };
            if optional == 0 && host.find(&id).is_null() {
                return Err(format!("it needs `{id}`, which this host does not offer; rebuild it for this release"));
            }
        }
        Ok(())
    }

    /// The layouts of the frozen types, if the plugin is in Rust and offers them.
    fn check_layouts(&self) -> Result<(), String> {
        let theirs: *const tatu_rust_layout = self.extension(TATU_RUST_LAYOUT);
        if theirs.is_null() {
            return Ok(());
        }
        // SAFETY: the extension of that id is such a table.
        unsafe { compare_layouts(theirs) }.map(drop).map_err(|e| format!("{e}; rebuild it against this plugin-api"))
    }

    /// The table of one of its extensions, or null.
    pub(crate) fn extension<T>(&self, id: &std::ffi::CStr) -> *const T {
        // SAFETY: by the contract.
        self.raw.extension.map_or(std::ptr::null(), |f| unsafe { f(self.me, id.as_ptr()) }.cast())
    }
}

impl Drop for Loaded {
    fn drop(&mut self) {
        if let Some(shutdown) = self.raw.shutdown {
            // SAFETY: no instance is left, since worlds hold the registry that holds this.
            unsafe { shutdown(self.me) };
        }
    }
}
