//! A world that a test has opened, and readings of its sensors.

use std::{ffi::CString, marker::PhantomData};

use tatu_plugin_api::{
    abi::*,
    safe::{Owned, Value, ValueRef},
};

use crate::{Error, Result};

/// A running scene. Only the thread that opened it can use it, and it is closed when it is dropped.
pub struct World {
    table: &'static tatu_test_host,
    /// Null once the world is closed.
    raw: *mut tatu_test_world,
    /// Prevents the type from being `Send` or `Sync`.
    thread: PhantomData<*mut ()>,
}

/// Evaluates to a function of the host's table or, if the host lacks it, returns an error from the enclosing function.
macro_rules! host {
    ($world:ident . $function:ident) => {
        $world
            .table
            .$function
            .ok_or_else(|| Error::new(concat!("this host has no function `", stringify!($function), "`")))?
    };
}

impl World {
    /// Wraps a world that the host has opened.
    ///
    /// # Safety
    /// `raw` must be a world that `table` has opened on this thread, and that nothing else uses.
    pub(crate) unsafe fn new(table: &'static tatu_test_host, raw: *mut tatu_test_world) -> Self {
        World { table, raw, thread: PhantomData }
    }

    /// Returns the error of the last call on this thread that failed.
    ///
    /// # Safety
    /// `table` must belong to the host.
    pub(crate) unsafe fn last_error(table: &tatu_test_host) -> Error {
        let Some(last) = table.last_error else { return Error::new("the host failed without an error message") };
        // SAFETY: the host's text lives until the next call, and is copied at once.
        Error::new(unsafe { Lent::new(last()) }.text())
    }

    fn check(&self, status: tatu_status) -> Result {
        // SAFETY: `self.table` belongs to the host.
        if status >= 0 { Ok(()) } else { Err(unsafe { Self::last_error(self.table) }) }
    }

    /// Copies a value that the host wrote, if `status` is a success.
    fn value(&self, status: tatu_status, raw: tatu_value) -> Result<Value> {
        self.check(status)?;
        // SAFETY: the value's memory is valid until the next call with this world, and is copied at once.
        Ok(unsafe { ValueRef::new(raw) }.to_value()?)
    }

    /// Runs `n` steps. Faults of scripts and plugins do not stop the world; see [`World::faults`].
    ///
    /// # Errors
    /// Fails if a script or plugin has requested a stop.
    pub fn step(&self, n: u64) -> Result {
        let step = host!(self.step);
        // SAFETY: the world is open.
        self.check(unsafe { step(self.raw, n) })
    }

    /// Returns the simulation time, s.
    pub fn time(&self) -> f64 {
        // SAFETY: the world is open.
        self.table.time.map_or(0.0, |time| unsafe { time(self.raw) })
    }

    /// Returns the last reading of a sensor, by its path or unique name.
    ///
    /// # Errors
    /// Fails if there is no such sensor.
    pub fn reading(&self, path: &str) -> Result<Reading> {
        let (reading, name) = (host!(self.reading), text(path)?);
        let mut out = ValueRef::NIL.raw();
        // SAFETY: the world is open, the text lives during the call, and the value can be written.
        let status = unsafe { reading(self.raw, name.as_ptr(), &raw mut out) };
        Reading::of(path, &self.value(status, out)?)
    }

    /// Returns a property of an object: "position", "joint.position", a parameter such as "lamp.range", or a command of
    /// an actuator. An empty path stands for the world ("scene.gravity").
    ///
    /// # Errors
    /// Fails if there is no such object or property.
    pub fn get(&self, path: &str, key: &str) -> Result<Value> {
        let (get, path, key) = (host!(self.get), text(path)?, text(key)?);
        let mut out = ValueRef::NIL.raw();
        // SAFETY: the world is open, the texts live during the call, and the value can be written.
        let status = unsafe { get(self.raw, path.as_ptr(), key.as_ptr(), &raw mut out) };
        self.value(status, out)
    }

    /// Sets a property, as a script would.
    ///
    /// # Errors
    /// Fails if there is no such object or property, or the property does not accept the value.
    pub fn set(&self, path: &str, key: &str, value: impl Into<Value>) -> Result {
        let (set, path, key) = (host!(self.set), text(path)?, text(key)?);
        let mut room = Owned::default();
        let value = room.raw(&value.into());
        // SAFETY: the world is open; the texts and the value live during the call.
        self.check(unsafe { set(self.raw, path.as_ptr(), key.as_ptr(), &raw const value) })
    }

    /// Calls a command of any plugin; returns its results.
    ///
    /// # Errors
    /// Fails if there is no such command, or with the command's own error.
    pub fn call(&self, name: &str, args: &[Value]) -> Result<Vec<Value>> {
        let (call, name) = (host!(self.call), text(name)?);
        let mut room = Owned::default();
        let args: Vec<tatu_value> = args.iter().map(|v| room.raw(v)).collect();
        let (mut results, mut n) = ([ValueRef::NIL.raw(); 64], 0);
        let (count, cap) = (args.len() as u32, results.len() as u32);
        let (args, out) = (args.as_ptr(), results.as_mut_ptr());
        // SAFETY: the world is open; the text and the arrays, of the stated lengths, live during the call.
        self.check(unsafe { call(self.raw, name.as_ptr(), args, count, out, cap, &raw mut n) })?;
        // SAFETY: the host has written this number of values, which are valid until the next call with this world; they
        // are copied at once.
        let results = unsafe { ValueRef::slice(results.as_ptr(), n.min(cap) as usize) };
        Ok(results.iter().map(|v| v.to_value()).collect::<Result<_, _>>()?)
    }

    /// Returns the messages logged since the previous call.
    pub fn lines(&self) -> Vec<String> {
        // SAFETY: the world is open, and the text lives until the next call with it.
        self.table.lines.map_or(Vec::new(), |lines| lines_of(unsafe { Lent::new(lines(self.raw)) }))
    }

    /// Returns the faults since the previous call. If faults have not been read, [`World::close`] fails.
    pub fn faults(&self) -> Vec<String> {
        // SAFETY: the world is open, and the text lives until the next call with it.
        self.table.faults.map_or(Vec::new(), |faults| lines_of(unsafe { Lent::new(faults(self.raw)) }))
    }

    /// Stops and closes the world. A test should call this at its end, because dropping the world ignores errors.
    ///
    /// # Errors
    /// Fails if a fault occurs while scripts and plugins end, or has occurred before and has not been read.
    pub fn close(mut self) -> Result {
        let raw = std::mem::replace(&mut self.raw, std::ptr::null_mut());
        let close = host!(self.close);
        // SAFETY: the world is open, and is closed only once, because `self.raw` is null now.
        self.check(unsafe { close(raw) })
    }
}

impl Drop for World {
    fn drop(&mut self) {
        if let Some(close) = self.table.close {
            // SAFETY: `self.raw` is null or an open world, and is not used afterwards.
            unsafe { close(self.raw) };
        }
    }
}

fn text(text: &str) -> Result<CString> {
    CString::new(text).map_err(|_| Error::new(format!("`{}` must not contain a NUL character", text.escape_debug())))
}

fn lines_of(text: Lent<'_>) -> Vec<String> {
    text.text().lines().map(str::to_owned).collect()
}

/// The last reading of a sensor, copied.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    path: String,
    kind: String,
    time: f64,
    sequence: i64,
    fields: Vec<(String, Value)>,
}

impl Reading {
    fn of(path: &str, map: &Value) -> Result<Self> {
        let wrong = || Error::new(format!("the host returned no reading of {path}"));
        let Value::Map(entries) = map else { return Err(wrong()) };
        let mut out = Reading { path: path.into(), kind: String::new(), time: 0.0, sequence: 0, fields: Vec::new() };
        for (key, value) in entries {
            match (name(key).as_str(), value) {
                ("kind", kind) => out.kind = name(kind),
                ("time", Value::Float(time)) => out.time = *time,
                ("sequence", Value::Int(n)) => out.sequence = *n,
                ("fields", Value::Map(fields)) => {
                    out.fields = fields.iter().map(|(k, v)| (name(k), v.clone())).collect();
                }
                _ => {}
            }
        }
        Ok(out)
    }

    /// Returns the simulation time of the measurement, s.
    pub fn time(&self) -> f64 {
        self.time
    }
    /// Returns the number of measurements of the sensor so far; 0 if it has not been measured.
    pub fn sequence(&self) -> u64 {
        self.sequence.unsigned_abs()
    }
    /// Returns the names of the fields.
    pub fn names(&self) -> Vec<&str> {
        self.fields.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// Returns all numbers of a field of any element type.
    ///
    /// # Errors
    /// Fails if there is no such field, or the sensor has not been measured yet.
    pub fn f64s(&self, field: &str) -> Result<Vec<f64>> {
        let Some((_, value)) = self.fields.iter().find(|(name, _)| name == field) else {
            let (path, kind, known) = (&self.path, &self.kind, self.names().join(", "));
            let text = format!("the sensor {path} of kind `{kind}` has no field `{field}`\n  expected: one of {known}");
            return Err(Error::new(text));
        };
        if self.sequence == 0 {
            return Err(Error::new(format!("the sensor {} has not measured yet\n  help: run a step first", self.path)));
        }
        match value {
            Value::Floats(all) => Ok(all.clone()),
            Value::Ints(all) => Ok(all.iter().map(|i| *i as f64).collect()),
            _ => Err(Error::new(format!("the field `{field}` is not numeric"))),
        }
    }

    /// Returns the value of a field with a single element.
    ///
    /// # Errors
    /// Fails like [`Reading::f64s`], or if the number of elements is not 1.
    pub fn f64(&self, field: &str) -> Result<f64> {
        match self.f64s(field)?.as_slice() {
            [one] => Ok(*one),
            all => {
                let text = format!("{}: `{field}` has {} elements, but `f64` needs 1", self.path, all.len());
                Err(Error::new(text + "\n  help: use `f64s`"))
            }
        }
    }
}

fn name(value: &Value) -> String {
    match value {
        Value::Text(text) => String::from_utf8_lossy(text).into_owned(),
        _ => String::new(),
    }
}
