//! The tables of host functions that plugins get, and the keys that plugins interned.

use std::{
    collections::BTreeMap,
    ffi::{CStr, CString, c_char, c_void},
    sync::{Arc, Mutex, Weak},
};

use tatu_plugin_api::abi::*;

use crate::drafts;

/// The table of host functions with an id, or null.
pub type FindTable = fn(&CStr) -> *const c_void;

/// The tables that plugins of one host get, and the keys that they interned.
pub struct HostTables {
    shared: Arc<Shared>,
}

/// What the host's entry function needs.
struct Shared {
    find: FindTable,
    keys: Mutex<Interner>,
}

/// The owner of a host pointer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Holder {
    /// Id of the plugin.
    pub plugin: String,
    /// Whether it comes with the program, whose plugins prefix their own log lines.
    pub of_program: bool,
}

/// The host as one plugin sees it: its address identifies the plugin, on whatever thread it comes back. It is never
/// given back, for a thread of the plugin may have the pointer for as long as the process lives.
struct OwnHost {
    raw: tatu_host,
    shared: Weak<Shared>,
    holder: Holder,
}

/// # Safety
/// `host` is null or one that [`HostTables`] gave out.
unsafe fn own(host: *const tatu_host) -> Option<&'static OwnHost> {
    // SAFETY: the context of such a host is the `OwnHost` that it lies in.
    unsafe { host.as_ref()?.ctx.cast::<OwnHost>().as_ref() }
}

/// Keys and their numbers; those of the core's rows come first, in their order.
#[derive(Default)]
struct Interner {
    numbers: BTreeMap<String, u32>,
    keys: Vec<String>,
    /// Tables that were requested and are not offered, since the last call of `forget_refused`.
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
        HostTables { shared: Arc::new(Shared { find, keys: Mutex::new(interner) }) }
    }
    /// The host for a plugin.
    pub(crate) fn own(&self, plugin: &str, of_program: bool) -> *const tatu_host {
        let raw = tatu_host {
            size: size_of::<tatu_host>() as u32,
            abi_minor: TATU_ABI_MINOR.into(),
            ctx: std::ptr::null_mut(),
            service: Some(service),
        };
        let holder = Holder { plugin: plugin.to_owned(), of_program };
        let new = Box::into_raw(Box::new(OwnHost { raw, shared: Arc::downgrade(&self.shared), holder }));
        // SAFETY: just made, and never given back.
        unsafe {
            (*new).raw.ctx = new.cast();
            &raw const (*new).raw
        }
    }
    /// A table, or null.
    pub(crate) fn find(&self, id: &str) -> *const c_void {
        CString::new(id).map_or(std::ptr::null(), |id| (self.shared.find)(&id))
    }
    /// Starts to record requests for unknown tables.
    pub(crate) fn forget_refused(&self) {
        if let Ok(mut k) = self.shared.keys.lock() {
            k.refused.clear();
        }
    }
    /// The tables of another draft that were requested since, in words.
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
    /// `host` is null or one that [`HostTables`] gave out.
    pub unsafe fn number_at(host: *const tatu_host, key: &str) -> Option<u32> {
        // SAFETY: the caller promises it.
        Some(unsafe { own(host) }?.shared.upgrade()?.number(key))
    }
    /// The owner of a host pointer; `None` for null.
    ///
    /// # Safety
    /// As for [`number_at`](Self::number_at).
    pub unsafe fn holder_at(host: *const tatu_host) -> Option<&'static Holder> {
        // SAFETY: the caller promises it.
        Some(&unsafe { own(host) }?.holder)
    }
}

impl Shared {
    fn number(&self, key: &str) -> u32 {
        self.keys.lock().map_or(0, |mut k| k.number(key))
    }
}

unsafe extern "C" fn service(host: *const tatu_host, id: *const c_char) -> *const c_void {
    // SAFETY: the plugin passes the host that it got.
    let shared = unsafe { own(host) }.and_then(|h| h.shared.upgrade());
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
