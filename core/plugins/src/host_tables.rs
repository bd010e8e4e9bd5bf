//! The tables of host functions for plugins, and interned property keys.

use std::{
    collections::BTreeMap,
    ffi::{CStr, CString, c_char, c_void},
    sync::{Arc, Mutex, Weak},
};

use tatu_plugin_api::abi::*;

use crate::drafts;

/// Returns the table of host functions with an id, or null.
pub type FindTable = fn(&CStr) -> *const c_void;

/// The host tables for plugins, and the interned keys.
pub struct HostTables {
    shared: Arc<Shared>,
}

/// The data used by the host's entry function.
struct Shared {
    find: FindTable,
    keys: Mutex<Interner>,
}

/// The plugin that a host pointer was given to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Holder {
    /// Id of the plugin.
    pub plugin: String,
    /// Whether the plugin comes with the program; such plugins prefix their log lines themselves.
    pub of_program: bool,
}

/// The host object of one plugin. Its address identifies the plugin on any thread. It is never freed, because a thread
/// of the plugin may hold the pointer until the process ends.
struct OwnHost {
    raw: tatu_host,
    shared: Weak<Shared>,
    holder: Holder,
}

/// # Safety
/// `host` must be null or a pointer made by [`HostTables`].
unsafe fn own(host: *const tatu_host) -> Option<&'static OwnHost> {
    // SAFETY: `host` is null or was made by `HostTables`, so its `ctx` points to the `OwnHost` that contains it, which
    // is never freed.
    unsafe { host.as_ref()?.ctx.cast::<OwnHost>().as_ref() }
}

/// Keys and their numbers. The keys of the core's rows come first, in order.
#[derive(Default)]
struct Interner {
    numbers: BTreeMap<String, u32>,
    keys: Vec<String>,
    /// Ids of tables that were requested but do not exist, since the last call of `forget_refused`.
    refused: Vec<String>,
}

impl Interner {
    fn number(&mut self, key: &str) -> u32 {
        if let Some(n) = self.numbers.get(key) {
            return *n;
        }
        let n = self.keys.len() as u32;
        self.numbers.insert(key.to_owned(), n);
        self.keys.push(key.to_owned());
        n
    }
}

impl HostTables {
    /// Creates the host. `find` returns tables by id; `keys` are numbered from 0, in order.
    pub fn new<'a>(find: FindTable, keys: impl IntoIterator<Item = &'a str>) -> Self {
        let mut interner = Interner::default();
        for key in keys {
            interner.number(key);
        }
        HostTables { shared: Arc::new(Shared { find, keys: Mutex::new(interner) }) }
    }
    /// Creates the host object for a plugin.
    pub(crate) fn own(&self, plugin: &str, of_program: bool) -> *const tatu_host {
        let raw = tatu_host {
            size: size_of::<tatu_host>() as u32,
            abi_minor: TATU_ABI_MINOR.into(),
            ctx: std::ptr::null_mut(),
            service: Some(service),
        };
        let holder = Holder { plugin: plugin.to_owned(), of_program };
        let new = Box::into_raw(Box::new(OwnHost { raw, shared: Arc::downgrade(&self.shared), holder }));
        // SAFETY: `new` was just allocated and is never freed.
        unsafe {
            (*new).raw.ctx = new.cast();
            &raw const (*new).raw
        }
    }
    /// Returns a table, or null.
    pub(crate) fn find(&self, id: &str) -> *const c_void {
        CString::new(id).map_or(std::ptr::null(), |id| (self.shared.find)(&id))
    }
    /// Clears the list of requests for unknown tables.
    pub(crate) fn forget_refused(&self) {
        if let Ok(mut k) = self.shared.keys.lock() {
            k.refused.clear();
        }
    }
    /// Describes the tables of other drafts that were requested since then.
    pub(crate) fn refused_drafts(&self) -> Vec<String> {
        let Ok(keys) = self.shared.keys.lock() else { return Vec::new() };
        keys.refused.iter().filter_map(|id| drafts::other_draft(id)).collect()
    }
    /// Returns the number of a key, interning it if it is new.
    pub fn number(&self, key: &str) -> u32 {
        self.shared.number(key)
    }
    /// Returns the key with a number.
    pub fn key(&self, number: u32) -> Option<String> {
        self.shared.keys.lock().ok()?.keys.get(number as usize).cloned()
    }
    /// Returns the number of a key, by the host pointer that a plugin holds; `None` for null.
    ///
    /// # Safety
    /// `host` must be null or a pointer made by [`HostTables`].
    pub unsafe fn number_at(host: *const tatu_host, key: &str) -> Option<u32> {
        // SAFETY: the caller guarantees that `host` is valid.
        Some(unsafe { own(host) }?.shared.upgrade()?.number(key))
    }
    /// Returns the plugin of a host pointer; `None` for null.
    ///
    /// # Safety
    /// As for [`number_at`](Self::number_at).
    pub unsafe fn holder_at(host: *const tatu_host) -> Option<&'static Holder> {
        // SAFETY: the caller guarantees that `host` is valid.
        Some(&unsafe { own(host) }?.holder)
    }
}

impl Shared {
    fn number(&self, key: &str) -> u32 {
        self.keys.lock().map_or(0, |mut k| k.number(key))
    }
}

unsafe extern "C" fn service(host: *const tatu_host, id: *const c_char) -> *const c_void {
    // SAFETY: the header requires `host` to be the pointer that the plugin was given.
    let shared = unsafe { own(host) }.and_then(|h| h.shared.upgrade());
    let Some(shared) = shared.filter(|_| !id.is_null()) else { return std::ptr::null() };
    // SAFETY: not null, and the header requires a NUL-terminated string.
    let id = unsafe { CStr::from_ptr(id) };
    let found = (shared.find)(id);
    if found.is_null() {
        // The limit keeps a plugin that asks endlessly from exhausting memory.
        if let Some(mut keys) = shared.keys.lock().ok().filter(|k| k.refused.len() < 64) {
            keys.refused.push(id.to_string_lossy().into_owned());
        }
    }
    found
}
