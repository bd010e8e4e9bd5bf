//! Stand-ins: objects that the host creates in place of missing ones when a script is run without its scene; see
//! `tatu_host_stand_ins` in `tatu/vrep.h`. They are not created for scripts that run in parallel.

use std::ffi::CString;

use crate::abi::*;
use crate::safe::SharedWorld;

impl SharedWorld<'_> {
    /// Requests a stand-in for an object that was not found by path or unique name; an empty `kind` means any. Returns
    /// `None` in runs that do not create stand-ins.
    pub fn stand_in(&self, from: tatu_object, name: &str, kind: &str) -> Option<tatu_object> {
        let kind = CString::new(kind).ok()?;
        let kind = if kind.is_empty() { LentCStr::NULL } else { kind.as_c_str().into() };
        let mut id = 0;
        let object = self.host().stand_ins?.object?;
        (object(self.raw(), from, name.into(), kind, Some(&mut id)) >= 0).then_some(id)
    }
    /// Reports that a command used an object as one of the given kind ("joint"), or as a sensor with the given schema
    /// ("proximity/1"). Returns whether the object now is of that kind; only stand-ins change their kind.
    pub fn used_as(&self, object: tatu_object, kind: &str) -> bool {
        let Ok(kind) = CString::new(kind) else { return false };
        let used = self.host().stand_ins.and_then(|t| t.used);
        used.is_some_and(|f| f(self.raw(), object, kind.as_c_str().into()) >= 0)
    }
    /// Returns whether the run creates missing objects when a script looks them up by name, as runs of scripts without
    /// their scene do.
    pub fn makes_stand_ins(&self) -> bool {
        self.host().stand_ins.and_then(|t| t.made).is_some_and(|f| f(self.raw()) >= 0)
    }
    /// Returns whether a command should return a neutral default for a value that an object lacks: only in runs with
    /// stand-ins, and only if the value was missing before.
    pub fn stands_in(&self, object: tatu_object, value: &str) -> bool {
        let f = self.host().stand_ins.and_then(|t| t.value);
        f.is_some_and(|f| f(self.raw(), object, value.into()) >= 0)
    }
    /// Reports that a script requested the parent of an object that has none.
    pub fn missed_parent(&self, object: tatu_object) {
        if let Some(f) = self.host().stand_ins.and_then(|t| t.parent) {
            f(self.raw(), object);
        }
    }
    /// Reports that a script requested a child that an object does not have; an empty `kind` means any kind.
    pub fn missed_child(&self, object: tatu_object, kind: &str) {
        let Ok(kind) = CString::new(kind) else { return };
        let kind = if kind.is_empty() { LentCStr::NULL } else { kind.as_c_str().into() };
        if let Some(f) = self.host().stand_ins.and_then(|t| t.child) {
            f(self.raw(), object, kind);
        }
    }
    /// Reports that a script requested the script of an object that has none.
    pub fn missed_script(&self, object: tatu_object) {
        if let Some(f) = self.host().stand_ins.and_then(|t| t.script) {
            f(self.raw(), object);
        }
    }
}
