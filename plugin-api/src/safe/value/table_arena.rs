//! Owns the memory to which a plugin's tables point.

use std::{
    any::Any,
    ffi::{CString, c_char},
    ptr::null,
};

use crate::abi::*;
use crate::safe::{Value, value::owned::Owned};

/// Owns everything that the plugin's tables point to, until shutdown.
#[derive(Default)]
pub(crate) struct TableArena(Vec<ArenaItem>);

/// A stored value, as a raw pointer, because moving a box would invalidate pointers into it.
struct ArenaItem(*mut dyn Any);

impl Drop for ArenaItem {
    fn drop(&mut self) {
        // SAFETY: the pointer was created by `Box::into_raw` in `TableArena::store`, and is freed only here.
        drop(unsafe { Box::from_raw(self.0) });
    }
}

impl TableArena {
    /// Stores a value until shutdown; returns a reference to it.
    pub(crate) fn store<T: 'static>(&mut self, thing: T) -> &mut T {
        let ptr = Box::into_raw(Box::new(thing));
        self.0.push(ArenaItem(ptr));
        // SAFETY: `ptr` was just allocated; `ArenaItem` does not dereference it before it is dropped, which the borrow
        // of `self` prevents.
        unsafe { &mut *ptr }
    }
    pub(crate) fn table<T: 'static>(&mut self, table: T) -> *const T {
        self.store(table)
    }
    pub(crate) fn text(&mut self, text: &str) -> *const c_char {
        // A NUL inside a declared text would truncate it, so it is removed.
        self.store(CString::new(text.replace('\0', "")).unwrap_or_default()).as_ptr()
    }
    pub(crate) fn list<T: 'static>(&mut self, mut items: Vec<*const T>) -> *const *const T {
        items.push(null());
        self.store(items).as_ptr()
    }
    pub(crate) fn texts<S: AsRef<str>>(&mut self, items: &[S]) -> *const *const c_char {
        let items = items.iter().map(|s| self.text(s.as_ref())).collect();
        self.list(items)
    }
    pub(crate) fn value(&mut self, value: &Value) -> tatu_value {
        self.store(Owned::default()).raw(value)
    }
    pub(crate) fn values(&mut self, values: &[Value]) -> *const tatu_value {
        let raw: Vec<_> = values.iter().map(|v| self.value(v)).collect();
        self.store(raw).as_ptr()
    }
}
