//! What commands and constants there are: for services that list them for their clients.

use std::ffi::{CStr, c_char};

use crate::abi::*;
use crate::safe::{Result, Value, ValueRef, World, call::shared_world::service};

/// What a command is, in short.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct About {
    /// Its names; the first one is the canonical one.
    pub names: Vec<String>,
    /// The names of its parameters.
    pub params: Vec<String>,
    /// One sentence.
    pub text: String,
}

impl World<'_> {
    /// All commands, in the order in which they were declared. Cost: a copy of their names.
    pub fn commands(&self) -> Vec<About> {
        let Some(table) = self.host().commands else { return Vec::new() };
        let (Some(count), Some(describe)) = (table.count, table.describe) else { return Vec::new() };
        // SAFETY: declarations of the host and their texts live as long as the host, and their lists end with null.
        let all = (1..=count(self.raw())).filter_map(|id| unsafe {
            let command = describe(self.raw(), id).as_ref()?;
            let names = list(command.names).iter().map(|n| text((**n).name)).collect();
            let params = list(command.params).iter().map(|p| text((**p).key)).collect();
            Some(About { names, params, text: text(command.text) })
        });
        all.collect()
    }

    /// All constants by name, in the order of their names.
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

/// # Safety
/// Null, or a NUL-terminated text.
unsafe fn text(p: *const c_char) -> String {
    // SAFETY: the caller promises it.
    if p.is_null() { String::new() } else { unsafe { CStr::from_ptr(p) }.to_string_lossy().into_owned() }
}

/// # Safety
/// Null, or a null-terminated list that lives for `'a`.
unsafe fn list<'a, T>(first: *const *const T) -> &'a [*const T] {
    if first.is_null() {
        return &[];
    }
    // SAFETY: the caller promises it.
    unsafe {
        let n = (0..).take_while(|i| !(*first.add(*i)).is_null()).count();
        std::slice::from_raw_parts(first, n)
    }
}
