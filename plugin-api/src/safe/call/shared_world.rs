//! Read-only access to a world from several threads, for parallel commands and for instances during creation.

use std::ffi::CStr;

use crate::abi::*;
use crate::safe::{Fail, Host, Prop, Reading, Result, Value, ValueRef, value::owned::Owned};

/// An existing object and its kind (`TATU_KIND_*`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Object {
    /// Full id, with generation and slot.
    pub id: tatu_object,
    /// `TATU_KIND_*`.
    pub kind: i32,
}

impl Object {
    /// Returns the handle that scripts use.
    pub fn handle(self) -> i64 {
        i64::from(tatu_slot(self.id))
    }
}

/// A world that other threads may read at the same time. It is read-only, except for the drives of joints, whose
/// changes take effect once all threads have finished. [`World`](crate::safe::World) adds the functions that need
/// exclusive access.
#[derive(Clone, Copy)]
pub struct SharedWorld<'a> {
    raw: WorldRef<'a>,
    host: &'a Host,
}

/// Evaluates to a function of a host table or, if this host lacks it, returns an error from the enclosing function.
macro_rules! service {
    ($world:ident . $table:ident . $function:ident) => {
        $world.host().$table.and_then(|t| t.$function).ok_or_else(|| {
            $crate::safe::Fail::unsupported(concat!(
                "this host lacks the service function ",
                stringify!($table),
                ".",
                stringify!($function)
            ))
        })?
    };
}

pub(crate) use service;

impl<'a> SharedWorld<'a> {
    pub(crate) fn new(raw: WorldRef<'a>, host: &'a Host) -> Self {
        SharedWorld { raw, host }
    }
    /// Returns the world in the form that host functions accept.
    pub fn raw(&self) -> WorldRef<'a> {
        self.raw
    }
    /// Returns the host.
    pub fn host(&self) -> &'a Host {
        self.host
    }
    pub(crate) fn check(&self, status: tatu_status) -> Result {
        if status >= 0 { Ok(()) } else { Err(self.refusal(status)) }
    }
    #[cold]
    fn refusal(&self, status: tatu_status) -> Fail {
        match self.host.log.and_then(|l| l.last_error) {
            // SAFETY: `last` returns null or a pointer to an error of the host that lives until the next one; it is
            // copied at once.
            Some(last) => unsafe { Fail::read(status, last(self.raw)) },
            None => Fail::with_code(status, "the host rejected the call without an error message"),
        }
    }
    /// Checks a status like [`check`](Self::check), but returns `None` for `TATU_ERR_MISSING`.
    pub(crate) fn found<T>(&self, status: tatu_status, value: T) -> Result<Option<T>> {
        match status {
            TATU_ERR_MISSING => Ok(None),
            status => self.check(status).map(|()| Some(value)),
        }
    }

    /// Validates a handle from a script, or an id; returns the object and its kind.
    pub fn look(&self, object: tatu_object) -> Result<Object> {
        let (mut id, mut kind) = (0, 0);
        self.check(service!(self.scene.look)(self.raw, object, Some(&mut id), Some(&mut kind)))?;
        Ok(Object { id, kind })
    }
    /// Finds an object by path or unique name; relative paths start at `from`.
    pub fn find(&self, from: tatu_object, path: &str) -> Result<tatu_object> {
        let mut id = 0;
        self.check(service!(self.scene.find)(self.raw, from, path.into(), Some(&mut id)))?;
        Ok(id)
    }
    /// Reads a property; text and arrays are valid until the current call returns.
    pub fn get(&self, object: tatu_object, prop: Prop) -> Result<ValueRef<'a>> {
        let mut value = ValueRef::NIL;
        self.check(service!(self.scene.get)(self.raw, object, prop.0, Some(&mut value)))?;
        Ok(value)
    }
    /// Reads a property that consists of exactly `N` numbers.
    #[inline]
    pub fn f64s<const N: usize>(&self, object: tatu_object, prop: Prop) -> Result<[f64; N]> {
        let mut out = [0.0; N];
        let get = service!(self.scene.get_f64);
        // SAFETY: `out` points to `N` numbers, which live during the call.
        self.check(unsafe { get(self.raw, object, prop.0, out.as_mut_ptr(), N as u32) })?;
        Ok(out)
    }
    /// Reads a property that consists of one number.
    #[inline]
    pub fn f64(&self, object: tatu_object, prop: Prop) -> Result<f64> {
        Ok(self.f64s::<1>(object, prop)?[0])
    }
    /// Sets a property. In a parallel command, only the drives of joints can be set.
    pub fn set(&self, object: tatu_object, prop: Prop, value: &Value) -> Result {
        let mut owned = Owned::default();
        let value = owned.value(value);
        self.check(service!(self.scene.set)(self.raw, object, prop.0, Some(&value)))
    }
    /// Sets a property to exactly these numbers.
    #[inline]
    pub fn set_f64s(&self, object: tatu_object, prop: Prop, values: &[f64]) -> Result {
        let set = service!(self.scene.set_f64);
        // SAFETY: the pointer and the count are those of the slice `values`.
        self.check(unsafe { set(self.raw, object, prop.0, values.as_ptr(), values.len() as u32) })
    }
    /// Returns the pose of an object in the frame of another, or in the world frame if `frame` is 0: x y z, then the
    /// unit quaternion x y z w.
    pub fn pose(&self, object: tatu_object, frame: tatu_object) -> Result<[f64; 7]> {
        let mut out = [0.0; 7];
        self.check(service!(self.scene.pose)(self.raw, object, frame, Some(&mut out)))?;
        Ok(out)
    }
    /// Returns the velocity of an object in the world frame: linear (m/s), then angular (rad/s).
    pub fn twist(&self, object: tatu_object) -> Result<[f64; 6]> {
        let mut out = [0.0; 6];
        self.check(service!(self.bodies.twist)(self.raw, object, Some(&mut out)))?;
        Ok(out)
    }

    /// Copies one field of a sensor's last reading, so that later measurements do not change it.
    #[inline]
    pub fn reading(&self, sensor: tatu_object, field: Prop) -> Result<Reading> {
        let mut view = tatu_field_view { ptr: std::ptr::null(), len: 0, elem: 0, dims: [0; 3], time: 0.0, sequence: 0 };
        self.check(service!(self.readings.field)(self.raw, sensor, field.0, Some(&mut view)))?;
        // SAFETY: the host has just filled `view`, whose pointers are valid until the next measurement; the data is
        // copied at once.
        Ok(unsafe { Reading::of(&view) })
    }
    /// Returns the name and the shape of the `index`-th field of a sensor, from 0, or `None` past the last one.
    pub fn field_of(&self, sensor: tatu_object, index: u32) -> Option<(&'a str, [u32; 3])> {
        let describe = self.host.readings.and_then(|t| t.describe)?;
        let mut field = tatu_field { size: size_of::<tatu_field>() as u32, ..tatu_field::empty() };
        // SAFETY: `field` lives during the call and is as large as its `size` states.
        if unsafe { describe(self.raw, sensor, index, &mut field) } < 0 || field.name.is_null() {
            return None;
        }
        // SAFETY: texts of a declaration are NUL-terminated and live as long as the world; null was excluded above.
        unsafe { CStr::from_ptr(field.name) }.to_str().ok().map(|name| (name, field.dims))
    }

    /// Writes a line to the log; `level` is one of `TATU_LOG_*`.
    pub fn log(&self, level: u32, text: &[u8]) {
        self.host.write(self.raw.ptr(), level, text);
    }
}
