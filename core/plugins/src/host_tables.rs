//! The tables of host functions that plugins get, and the keys that plugins interned.

use std::{
    collections::BTreeMap,
    ffi::{CStr, CString, c_char, c_void},
    sync::{Arc, Mutex, Weak},
};

use tatu_plugin_api::abi::*;

use crate::{drafts, guard_page};

/// The table of host functions with an id, or null.
pub type FindTable = fn(&CStr) -> *const c_void;

/// The tables that plugins of one host get, and the keys that they interned.
pub struct HostTables {
    shared: Arc<Shared>,
}

/// What the host's entry function needs.
struct Shared {
    find: FindTable,
    /// Plugins of others get tables that end where their needs say.
    cut: bool,
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
    /// Tables of which it gets so many bytes.
    needs: Vec<(CString, u32)>,
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
        HostTables { shared: Arc::new(Shared { find, cut: false, keys: Mutex::new(interner) }) }
    }
    /// Each plugin that does not come with the program gets copies of the tables that it needs, with as many bytes as
    /// it states. A read beyond them ends the process. For validators: call it before anything is loaded.
    pub fn cut_to_needs(&mut self) {
        if let Some(shared) = Arc::get_mut(&mut self.shared) {
            shared.cut = true;
        }
    }
    /// The host for a plugin; `needs`: ids of tables and the bytes of them that it states.
    pub(crate) fn own(&self, plugin: &str, of_program: bool, needs: Vec<(CString, u32)>) -> *const tatu_host {
        let raw = tatu_host {
            size: size_of::<tatu_host>() as u32,
            abi_minor: TATU_ABI_MINOR.into(),
            ctx: std::ptr::null_mut(),
            service: Some(service),
        };
        let holder = Holder { plugin: plugin.to_owned(), of_program };
        let needs = if self.shared.cut && !of_program { needs } else { Vec::new() };
        let new = Box::into_raw(Box::new(OwnHost { raw, shared: Arc::downgrade(&self.shared), holder, needs }));
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
    let Some(own) = (unsafe { own(host) }).filter(|_| !id.is_null()) else { return std::ptr::null() };
    let Some(shared) = own.shared.upgrade() else { return std::ptr::null() };
    // SAFETY: NUL-terminated, by the contract.
    let id = unsafe { CStr::from_ptr(id) };
    let found = (shared.find)(id);
    if found.is_null() {
        // A plugin that asks for ever must not fill the memory.
        if let Some(mut keys) = shared.keys.lock().ok().filter(|k| k.refused.len() < 64) {
            keys.refused.push(id.to_string_lossy().into_owned());
        }
    }
    match own.needs.iter().find(|(need, bytes)| need.as_c_str() == id && *bytes > 0) {
        // SAFETY: a table of the host, which begins with its size.
        Some((_, bytes)) if !found.is_null() => unsafe { cut(found, *bytes, id) },
        _ => found,
    }
}

/// A copy of the first bytes of a table, whose `size` says so; never given back.
///
/// # Safety
/// `table` is one of the host's, which begins with its size.
unsafe fn cut(table: *const c_void, bytes: u32, id: &CStr) -> *const c_void {
    // SAFETY: the caller promises it.
    let size = unsafe { *table.cast::<u32>() };
    // Fields do not end within a pointer.
    let bytes = bytes.min(size) & !7;
    // SAFETY: at most as many bytes as the table has.
    let mut copy = unsafe { std::slice::from_raw_parts(table.cast::<u8>(), bytes as usize) }.to_vec();
    copy.splice(..4.min(copy.len()), bytes.to_ne_bytes());
    guard_page::before_guard(&copy, &format!("the {bytes} bytes of `{}` that `needs` states", id.to_string_lossy()))
}
