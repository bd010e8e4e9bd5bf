//! Lists of commands and constants, for services that present them to clients.

use std::ffi::{CStr, c_char};

use crate::abi::*;
use crate::safe::{Result, Value, ValueRef, World, call::shared_world::service};

/// A short description of a command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct About {
    /// All names of the command; the first one is canonical.
    pub names: Vec<String>,
    /// The names of its parameters, in order.
    pub params: Vec<String>,
    /// What the command does, one sentence.
    pub text: String,
}

impl World<'_> {
    /// Returns descriptions of all commands, in the order of declaration; empty if the host lacks the service.
    pub fn commands(&self) -> Vec<About> {
        let Some(table) = self.host().commands else { return Vec::new() };
        let (Some(count), Some(describe)) = (table.count, table.describe) else { return Vec::new() };
        // SAFETY: declarations and their texts live as long as the host, and their lists end with a null pointer.
        let all = (1..=count(self.raw())).filter_map(|id| unsafe {
            let command = describe(self.raw(), id).as_ref()?;
            let names = list(command.names).iter().map(|n| text((**n).name)).collect();
            let params = list(command.params).iter().map(|p| text((**p).key)).collect();
            Some(About { names, params, text: text(command.text) })
        });
        all.collect()
    }

    /// Returns all constants, ordered by name.
    pub fn constants(&self) -> Result<Vec<(String, Value)>> {
        let (name_of, value_of) = (service!(self.commands.constant_name), service!(self.commands.constant));
        let mut all = Vec::new();
        loop {
            let (mut name, mut value) = (Lent::EMPTY, ValueRef::NIL);
            let status = name_of(self.raw(), all.len() as u32, Some(&mut name));
            if self.found(status, ())?.is_none() {
                return Ok(all);
            }
            self.check(value_of(self.raw(), name, Some(&mut value)))?;
            all.push((name.text().into_owned(), value.to_value()?));
        }
    }
}

/// Returns a text of a declaration, or an empty string for null.
///
/// # Safety
/// `p` must be null, or a NUL-terminated text that is valid during the call.
unsafe fn text(p: *const c_char) -> String {
    // SAFETY: `p` is not null here, and the caller guarantees that it is NUL-terminated and valid during the call.
    if p.is_null() { String::new() } else { unsafe { CStr::from_ptr(p) }.to_string_lossy().into_owned() }
}

/// Returns a null-terminated list of pointers as a slice, which is empty for null.
///
/// # Safety
/// `first` must be null, or a list that ends with a null pointer and lives for `'a`.
unsafe fn list<'a, T>(first: *const *const T) -> &'a [*const T] {
    if first.is_null() {
        return &[];
    }
    // SAFETY: the caller guarantees that the list ends with null, so counting stops within it, and that it lives for
    // `'a`.
    unsafe {
        let n = (0..).take_while(|i| !(*first.add(*i)).is_null()).count();
        std::slice::from_raw_parts(first, n)
    }
}
