//! What scripts ask for and what is not there: see `tatu.host.stand_ins` in the header. Where scripts run side by side nothing
//! is made.

use std::ffi::CString;

use crate::abi::*;
use crate::safe::SharedWorld;

impl SharedWorld<'_> {
    /// Asks for an object by path or unique name that was not found: a run that makes stand-ins makes one, of `kind`
    /// if one is given (empty: any). `None` in all other runs.
    pub fn stand_in(&self, from: tatu_object, name: &str, kind: &str) -> Option<tatu_object> {
        let kind = CString::new(kind).ok()?;
        let kind = if kind.is_empty() { LentCStr::NULL } else { kind.as_c_str().into() };
        let mut id = 0;
        let object = self.host().stand_ins?.object?;
        (object(self.raw(), from, name.into(), kind, Some(&mut id)) >= 0).then_some(id)
    }
    /// Tells that an object was used as one of a kind of object or as a sensor that fills a schema ("proximity/1");
    /// whether it is one now, which only stand-ins become.
    pub fn used_as(&self, object: tatu_object, kind: &str) -> bool {
        let Ok(kind) = CString::new(kind) else { return false };
        let used = self.host().stand_ins.and_then(|t| t.used);
        used.is_some_and(|f| f(self.raw(), object, kind.as_c_str().into()) >= 0)
    }
    /// Whether what a script asks for by name and is not there is to be made: in runs of scripts without their scene.
    pub fn makes_stand_ins(&self) -> bool {
        self.host().stand_ins.and_then(|t| t.made).is_some_and(|f| f(self.raw()) >= 0)
    }
    /// Whether a value that an object does not have is to be there in a neutral form: only in runs that make stand-ins,
    /// and there only if it was missed before.
    pub fn stands_in(&self, object: tatu_object, value: &str) -> bool {
        let f = self.host().stand_ins.and_then(|t| t.value);
        f.is_some_and(|f| f(self.raw(), object, value.into()) >= 0)
    }
    /// A script looked at what an object hangs on, and it hangs on nothing.
    pub fn missed_parent(&self, object: tatu_object) {
        if let Some(f) = self.host().stand_ins.and_then(|t| t.parent) {
            f(self.raw(), object);
        }
    }
    /// A script looked at what hangs on an object, of a kind (empty: any), and nothing does.
    pub fn missed_child(&self, object: tatu_object, kind: &str) {
        let Ok(kind) = CString::new(kind) else { return };
        let kind = if kind.is_empty() { LentCStr::NULL } else { kind.as_c_str().into() };
        if let Some(f) = self.host().stand_ins.and_then(|t| t.child) {
            f(self.raw(), object, kind);
        }
    }
    /// A script looked at the script of an object, and it has none.
    pub fn missed_script(&self, object: tatu_object) {
        if let Some(f) = self.host().stand_ins.and_then(|t| t.script) {
            f(self.raw(), object);
        }
    }
}
