//! What scripts ask for and what is not there: see `tatu.host.stand_ins` in the header.

use std::ffi::CString;

use super::{World, fail::text_raw};
use crate::abi::*;

impl World<'_> {
    /// Asks for an object by path or unique name that was not found: a run that makes stand-ins makes one, of `kind`
    /// if one is told (empty: any). `None` in all other runs.
    pub fn stand_in(&self, from: tatu_object, name: &str, kind: &str) -> Option<tatu_object> {
        let kind = CString::new(kind).ok()?;
        let kind = if kind.is_empty() { std::ptr::null() } else { kind.as_ptr() };
        let mut id = 0;
        let object = self.host().stand_ins?.object?;
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        (unsafe { object(self.raw(), from, text_raw(name), kind, &mut id) } >= 0).then_some(id)
    }
    /// Tells that an object was used as one of a kind of object or as a sensor that fills a schema ("proximity/1");
    /// whether it is one now, which only stand-ins become.
    pub fn used_as(&self, object: tatu_object, kind: &str) -> bool {
        let Ok(kind) = CString::new(kind) else { return false };
        let used = self.host().stand_ins.and_then(|t| t.used);
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        used.is_some_and(|f| unsafe { f(self.raw(), object, kind.as_ptr()) } >= 0)
    }
    /// Whether what a script asks for by name and is not there is to be made: in runs of scripts without their scene.
    pub fn makes_stand_ins(&self) -> bool {
        // SAFETY: the world is that of the running call.
        self.host().stand_ins.and_then(|t| t.made).is_some_and(|f| unsafe { f(self.raw()) } >= 0)
    }
    /// Whether a value that an object does not have is to be there in a neutral form: only in runs that make stand-ins,
    /// and there only if it was missed before.
    pub fn stands_in(&self, object: tatu_object, value: &str) -> bool {
        let f = self.host().stand_ins.and_then(|t| t.value);
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        f.is_some_and(|f| unsafe { f(self.raw(), object, text_raw(value)) } >= 0)
    }
    /// A script looked at what an object hangs on, and it hangs on nothing.
    pub fn missed_parent(&self, object: tatu_object) {
        if let Some(f) = self.host().stand_ins.and_then(|t| t.parent) {
            // SAFETY: the world is that of the running call.
            unsafe { f(self.raw(), object) };
        }
    }
    /// A script looked at what hangs on an object, of a kind (empty: any), and nothing does.
    pub fn missed_child(&self, object: tatu_object, kind: &str) {
        let Ok(kind) = CString::new(kind) else { return };
        let kind = if kind.is_empty() { std::ptr::null() } else { kind.as_ptr() };
        if let Some(f) = self.host().stand_ins.and_then(|t| t.child) {
            // SAFETY: the world is that of the running call, and what is passed lives until it returns.
            unsafe { f(self.raw(), object, kind) };
        }
    }
    /// A script looked at the script of an object, and it has none.
    pub fn missed_script(&self, object: tatu_object) {
        if let Some(f) = self.host().stand_ins.and_then(|t| t.script) {
            // SAFETY: the world is that of the running call.
            unsafe { f(self.raw(), object) };
        }
    }
}
