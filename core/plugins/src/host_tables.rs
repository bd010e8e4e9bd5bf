//! The tables of host functions for plugins, and interned property keys.

use std::{
    collections::BTreeMap,
    ffi::{CStr, CString, c_char, c_void},
    sync::{Arc, Mutex, Weak},
};

use tatu_plugin_api::abi::*;

use crate::{
    drafts::{self, OtherDraft},
    guarded_copy,
    tables::Table,
    tickets::{Mailbox, TicketTable},
};

/// Returns the table of host functions with an id, or `None` if there is no such table.
pub type FindTable = fn(&CStr) -> Option<HostTable>;

/// A table of host functions, which begins with its size and is never freed.
#[derive(Clone, Copy)]
pub struct HostTable {
    ptr: *const c_void,
    size: u32,
}

impl HostTable {
    /// Wraps one of the host's tables.
    pub fn new<T: Table>(table: &'static T) -> Self {
        HostTable { ptr: std::ptr::from_ref(table).cast(), size: size_of::<T>() as u32 }
    }
    /// Returns the pointer for plugins.
    pub fn ptr(self) -> *const c_void {
        self.ptr
    }
    /// Returns the size of the table, bytes.
    pub fn size(self) -> u32 {
        self.size
    }
    /// Copies the first bytes of the table and stores their number as its `size`. The copy is never freed.
    fn truncate(self, bytes: u32, id: &CStr) -> *const c_void {
        // Rounding down prevents the table from ending within a pointer.
        let bytes = bytes.min(self.size) & !7;
        // SAFETY: `bytes` is at most the size of the table, which is never freed or changed.
        let mut copy = unsafe { std::slice::from_raw_parts(self.ptr.cast::<u8>(), bytes as usize) }.to_vec();
        copy.splice(..4.min(copy.len()), bytes.to_ne_bytes());
        let label = format!("the {bytes} bytes of `{}` that `needs` states", id.to_string_lossy());
        guarded_copy::leak_before_guard(&copy, &label)
    }
}

/// The host tables for plugins, and the interned keys.
pub struct HostTables {
    shared: Arc<SharedTables>,
}

/// The data used by the host's entry function.
struct SharedTables {
    find: FindTable,
    /// Whether third-party plugins receive truncated tables: see [`HostTables::truncate_to_needs`].
    truncate: bool,
    keys: Mutex<Interner>,
    tickets: TicketTable,
}

/// The plugin that a host pointer was given to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HostHolder {
    /// Id of the plugin.
    pub plugin: String,
    /// Whether the plugin comes with the program; such plugins prefix their log lines themselves.
    pub of_program: bool,
}

/// The host object of one plugin. Its address identifies the plugin on any thread. It is never freed, because a thread
/// of the plugin may hold the pointer until the process ends.
pub struct PluginHost {
    raw: tatu_host,
    shared: Weak<SharedTables>,
    holder: HostHolder,
    /// Tables of which the plugin gets truncated copies, with the sizes of the copies in bytes.
    needs: Vec<(CString, u32)>,
    /// The folder of the plugin's assets, if it exists.
    assets: Option<CString>,
}

impl PluginHost {
    /// Returns the host object of a pointer that a plugin passes back, or `None` for null.
    ///
    /// # Safety
    /// `host` must be null or a pointer made by [`HostTables`].
    pub unsafe fn at(host: *const tatu_host) -> Option<&'static PluginHost> {
        // SAFETY: `host` is null or was made by `HostTables`, so its `ctx` points to the `PluginHost` that contains it,
        // which is never freed.
        unsafe { host.as_ref()?.ctx.cast::<PluginHost>().as_ref() }
    }
    /// Returns the plugin that the pointer was given to.
    pub fn holder(&self) -> &HostHolder {
        &self.holder
    }
    /// Like [`HostTables::number`]. Returns `None` if the `HostTables` has been dropped.
    pub fn number(&self, key: &str) -> Option<u32> {
        Some(self.shared.upgrade()?.number(key))
    }
    /// Delivers the result for a ticket. Returns whether the ticket was valid.
    pub fn deliver(&self, ticket: u64, result: &[u8]) -> bool {
        self.shared.upgrade().is_some_and(|shared| shared.tickets.deliver(ticket, result))
    }
}

/// Keys and their numbers. The first numbers are those of the core's properties, in order.
#[derive(Default)]
struct Interner {
    numbers: BTreeMap<String, u32>,
    keys: Vec<String>,
    /// Ids of tables that were requested since the last call to `clear_refused` but do not exist.
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
        HostTables {
            shared: Arc::new(SharedTables {
                find,
                truncate: false,
                keys: Mutex::new(interner),
                tickets: TicketTable::default(),
            }),
        }
    }
    /// Passes truncated copies of tables to all plugins that are loaded from now on and do not come with the program.
    /// Each copy has the size that the plugin's `needs` state, and a read past its end crashes the process. Meant for
    /// validators.
    pub fn truncate_to_needs(&mut self) {
        if let Some(shared) = Arc::get_mut(&mut self.shared) {
            shared.truncate = true;
        }
    }
    /// Creates the host object for a plugin. `needs` contains the ids of tables and the number of bytes that the plugin
    /// requires of each; `assets` is the folder of the plugin's assets.
    pub(crate) fn create_plugin_host(
        &self,
        plugin: &str,
        of_program: bool,
        needs: Vec<(CString, u32)>,
        assets: Option<CString>,
    ) -> *const tatu_host {
        let raw = tatu_host {
            size: size_of::<tatu_host>() as u32,
            abi_minor: TATU_ABI_MINOR.into(),
            ctx: std::ptr::null_mut(),
            service: Some(service),
            assets: std::ptr::null(),
        };
        let holder = HostHolder { plugin: plugin.to_owned(), of_program };
        let needs = if self.shared.truncate && !of_program { needs } else { Vec::new() };
        let new =
            Box::into_raw(Box::new(PluginHost { raw, shared: Arc::downgrade(&self.shared), holder, needs, assets }));
        // SAFETY: `new` was just allocated and is never freed.
        unsafe {
            (*new).raw.ctx = new.cast();
            (*new).raw.assets = (*new).assets.as_ref().map_or(std::ptr::null(), |a| a.as_ptr());
            &raw const (*new).raw
        }
    }
    /// Returns the table with an id, or `None` if there is no such table.
    pub(crate) fn find(&self, id: &str) -> Option<HostTable> {
        (self.shared.find)(&CString::new(id).ok()?)
    }
    /// Clears the list of requests for unknown tables.
    pub(crate) fn clear_refused(&self) {
        if let Ok(mut k) = self.shared.keys.lock() {
            k.refused.clear();
        }
    }
    /// Describes the tables in other drafts that were requested since the last call to `clear_refused`.
    pub(crate) fn refused_drafts(&self) -> Vec<OtherDraft> {
        let Ok(keys) = self.shared.keys.lock() else { return Vec::new() };
        keys.refused.iter().filter_map(|id| drafts::other_draft(id)).collect()
    }
    /// Returns the number of a key, interning it if it is new.
    pub fn number(&self, key: &str) -> u32 {
        self.shared.number(key)
    }
    /// Returns the key with a number, or `None` if the number is unused.
    pub fn key(&self, number: u32) -> Option<String> {
        self.shared.keys.lock().ok()?.keys.get(number as usize).cloned()
    }
    /// Issues a ticket for a result that a world waits for under the number `wait`. With the ticket, any thread can
    /// deliver this result, once.
    pub fn ticket(&self, mailbox: &Arc<Mailbox>, wait: u64) -> u64 {
        self.shared.tickets.issue(mailbox, wait)
    }
}

impl SharedTables {
    fn number(&self, key: &str) -> u32 {
        self.keys.lock().map_or(0, |mut k| k.number(key))
    }
}

unsafe extern "C" fn service(host: *const tatu_host, id: *const c_char) -> *const c_void {
    // SAFETY: the header requires `host` to be the pointer that the plugin was given, which is never freed.
    let Some(own) = (unsafe { PluginHost::at(host) }).filter(|_| !id.is_null()) else { return std::ptr::null() };
    let Some(shared) = own.shared.upgrade() else { return std::ptr::null() };
    // SAFETY: `id` is not null, and the header requires it to be a NUL-terminated string that is valid during the call.
    let id = unsafe { CStr::from_ptr(id) };
    let Some(found) = (shared.find)(id) else {
        // The limit prevents a plugin that requests tables endlessly from exhausting memory.
        if let Some(mut keys) = shared.keys.lock().ok().filter(|k| k.refused.len() < 64) {
            keys.refused.push(id.to_string_lossy().into_owned());
        }
        return std::ptr::null();
    };
    match own.needs.iter().find(|(need, bytes)| need.as_c_str() == id && *bytes > 0) {
        Some((_, bytes)) => found.truncate(*bytes, id),
        None => found.ptr(),
    }
}
