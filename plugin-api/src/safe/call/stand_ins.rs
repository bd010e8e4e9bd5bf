//! Stand-ins for objects that scripts ask for and that do not exist: see `tatu.host.stand_ins` in `tatu.h`. Parallel
//! scripts get none.

use std::ffi::CString;

use crate::abi::*;
use crate::safe::SharedWorld;

impl SharedWorld<'_> {
    /// Requests a stand-in for an object, by path or unique name, that was not found; `kind` may
    /// be empty (any). `None` in runs without stand-ins.
    pub fn stand_in(&self, from: tatu_object, name: &str, kind: &str) -> Option<tatu_object> {
        let kind = CString::new(kind).ok()?;
        let kind = if kind.is_empty() { LentCStr::NULL } else { kind.as_c_str().into() };
        let mut id = 0;
        let object = self.host().stand_ins?.object?;
        (object(self.raw(), from, name.into(), kind, Some(&mut id)) >= 0).then_some(id)
    }
    /// Reports that an object was used as one of a kind, or as a sensor that fills a schema ("proximity/1");
    /// returns whether it is one now. Only stand-ins change.
    pub fn used_as(&self, object: tatu_object, kind: &str) -> bool {
        let Ok(kind) = CString::new(kind) else { return false };
        let used = self.host().stand_ins.and_then(|t| t.used);
        used.is_some_and(|f| f(self.raw(), object, kind.as_c_str().into()) >= 0)
    }
    /// Whether objects that a script asks for by name are created if missing: in runs of scripts without their scene.
    pub fn makes_stand_ins(&self) -> bool {
        self.host().stand_ins.and_then(|t| t.made).is_some_and(|f| f(self.raw()) >= 0)
    }
    /// Whether a value that an object lacks is to be given a neutral default: only in runs with stand-ins,
    /// and only if it was missing before.
    pub fn stands_in(&self, object: tatu_object, value: &str) -> bool {
        let f = self.host().stand_ins.and_then(|t| t.value);
        f.is_some_and(|f| f(self.raw(), object, value.into()) >= 0)
    }
    /// A script asked for the parent of an object that has none.
    pub fn missed_parent(&self, object: tatu_object) {
        if let Some(f) = self.host().stand_ins.and_then(|t| t.parent) {
            f(self.raw(), object);
        }
    }
    /// A script asked for a child of an object, of a kind (empty: any), and it has none.
    pub fn missed_child(&self, object: tatu_object, kind: &str) {
        let Ok(kind) = CString::new(kind) else { return };
        let kind = if kind.is_empty() { LentCStr::NULL } else { kind.as_c_str().into() };
        if let Some(f) = self.host().stand_ins.and_then(|t| t.child) {
            f(self.raw(), object, kind);
        }
    }
    /// A script asked for the script of an object that has none.
    pub fn missed_script(&self, object: tatu_object) {
        if let Some(f) = self.host().stand_ins.and_then(|t| t.script) {
            f(self.raw(), object);
        }
    }
}
