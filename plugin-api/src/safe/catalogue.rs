//! What commands and constants there are: for services that tell their clients.

use std::ffi::CStr;

use super::{
    Result, Value, ValueRef, World,
    fail::{bytes_of, bytes_raw},
    world::service,
};
use crate::abi::*;

/// What a command is, in short.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct About {
    /// Its names; the first one is its own.
    pub names: Vec<String>,
    /// The names of its parameters.
    pub params: Vec<String>,
    /// One sentence.
    pub text: String,
}

impl World<'_> {
    /// All commands, in the order in which they were declared. Cost: a copy of their names.
    pub fn commands(&self) -> Vec<About> {
        let Some(table) = self.host.commands else { return Vec::new() };
        let (Some(count), Some(describe)) = (table.count, table.describe) else { return Vec::new() };
        let text = |p: *const std::ffi::c_char| -> String {
            // SAFETY: declarations of the host are texts that end with 0 and live as long as the host.
            if p.is_null() { String::new() } else { unsafe { CStr::from_ptr(p) }.to_string_lossy().into_owned() }
        };
        // SAFETY: the world of the running call.
        let n = unsafe { count(self.raw()) };
        let all = (1..=n).filter_map(|id| {
            // SAFETY: the declaration is the host's own copy; its lists end with null.
            unsafe {
                let command = describe(self.raw(), id).as_ref()?;
                let mut params = Vec::new();
                let mut at = command.params;
                while !at.is_null() && !(*at).is_null() {
                    params.push(text((**at).key));
                    at = at.add(1);
                }
                let mut names = Vec::new();
                let mut at = command.names;
                while !at.is_null() && !(*at).is_null() {
                    names.push(text((**at).name));
                    at = at.add(1);
                }
                Some(About { names, params, text: text(command.text) })
            }
        });
        all.collect()
    }

    /// All constants by name, in the order of their names.
    pub fn constants(&self) -> Result<Vec<(String, Value)>> {
        let (name_of, value_of) = (service!(self.commands.constant_name), service!(self.commands.constant));
        let mut all = Vec::new();
        loop {
            let mut name = bytes_raw(&[]);
            let mut value = ValueRef::NIL.raw();
            // SAFETY: the world is that of the running call, and what is passed lives until it returns; names and values are
            // copied at once.
            unsafe {
                match name_of(self.raw(), all.len() as u32, &mut name) {
                    TATU_ERR_MISSING => return Ok(all),
                    status => self.check(status)?,
                }
                self.check(value_of(self.raw(), name, &mut value))?;
                all.push((String::from_utf8_lossy(bytes_of(name)).into_owned(), ValueRef::new(value).to_value()?));
            }
        }
    }
}
