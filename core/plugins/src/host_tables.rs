//! The tables of host functions that plugins get, and the keys that plugins interned.

use std::{
    collections::BTreeMap,
    ffi::{CStr, CString, c_char, c_void},
    sync::Mutex,
};

use tatu_plugin_api::abi::*;

use crate::drafts;

/// The table of host functions with an id, or null.
pub type FindTable = fn(&CStr) -> *const c_void;

/// The tables that plugins of one host get, and the keys that they interned.
pub struct HostTables {
    raw: Box<tatu_host>,
    shared: Box<Shared>,
}

/// What the host's entry function needs.
struct Shared {
    find: FindTable,
    keys: Mutex<Interner>,
}

// SAFETY: the raw table is constant after `new`; the keys are behind a lock.
unsafe impl Send for HostTables {}
// SAFETY: the raw table is constant after `new`; the keys are behind a lock.
unsafe impl Sync for HostTables {}

/// Keys and their numbers; those of the core's rows come first, in their order.
#[derive(Default)]
struct Interner {
    numbers: BTreeMap<String, u32>,
    keys: Vec<String>,
    /// Tables that were asked for and are not offered, since the last call of `forget_refused`.
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
    /// Tables that `find` gives by id. `keys` get the numbers from 0, in their order.
    pub fn new<'a>(find: FindTable, keys: impl IntoIterator<Item = &'a str>) -> Self {
        let mut interner = Interner::default();
        for key in keys {
            interner.number(key);
        }
        let shared = Box::new(Shared { find, keys: Mutex::new(interner) });
        let raw = Box::new(tatu_host {
            size: size_of::<tatu_host>() as u32,
            abi_minor: TATU_ABI_MINOR.into(),
            ctx: (&raw const *shared).cast_mut().cast(),
            service: Some(service),
        });
        HostTables { raw, shared }
    }
    pub(crate) fn raw(&self) -> *const tatu_host {
        &raw const *self.raw
    }
    /// A table, or null.
    pub(crate) fn find(&self, id: &str) -> *const c_void {
        CString::new(id).map_or(std::ptr::null(), |id| (self.shared.find)(&id))
    }
    /// Begins to note which tables are asked for in vain.
    pub(crate) fn forget_refused(&self) {
        if let Ok(mut k) = self.shared.keys.lock() {
            k.refused.clear();
        }
    }
    /// What was asked for since, of another draft, in words.
    pub(crate) fn refused_drafts(&self) -> Vec<String> {
        let Ok(keys) = self.shared.keys.lock() else { return Vec::new() };
        keys.refused.iter().filter_map(|id| drafts::other_draft(id)).collect()
    }
    /// The number of a key.
    pub fn number(&self, key: &str) -> u32 {
        self.shared.number(key)
    }
    /// The key of a number.
    pub fn key(&self, number: u32) -> Option<String> {
        self.shared.keys.lock().ok()?.keys.get(number as usize).cloned()
    }
    /// The number of a key, by the host pointer that plugins hold; `None` for null.
    ///
    /// # Safety
    /// `host` is null or one that living [`HostTables`] gave out.
    pub unsafe fn number_at(host: *const tatu_host, key: &str) -> Option<u32> {
        // SAFETY: the context of such a host is its `Shared`, which lives as long.
        Some(unsafe { host.as_ref()?.ctx.cast::<Shared>().as_ref() }?.number(key))
    }
}

impl Shared {
    fn number(&self, key: &str) -> u32 {
        self.keys.lock().map_or(0, |mut k| k.number(key))
    }
}

unsafe extern "C" fn service(host: *const tatu_host, id: *const c_char) -> *const c_void {
    // SAFETY: the plugin passes the host that it got, whose context is its `Shared`.
    let shared = unsafe { host.as_ref().and_then(|h| h.ctx.cast::<Shared>().as_ref()) };
    let Some(shared) = shared.filter(|_| !id.is_null()) else { return std::ptr::null() };
    // SAFETY: NUL-terminated, by the contract.
    let id = unsafe { CStr::from_ptr(id) };
    let found = (shared.find)(id);
    if found.is_null() {
        // A plugin that asks for ever must not fill the memory.
        if let Some(mut keys) = shared.keys.lock().ok().filter(|k| k.refused.len() < 64) {
            keys.refused.push(id.to_string_lossy().into_owned());
        }
    }
    found
}
