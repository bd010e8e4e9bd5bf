//! A world that a test has opened, and what its sensors measured.

use std::{ffi::CString, marker::PhantomData};

use tatu_plugin_api::{
    abi::*,
    safe::{Owned, Value, ValueRef},
};

use crate::{Error, Result};

/// A scene that runs, step by step. It belongs to the thread that opened it, and ends when it is dropped.
pub struct World {
    table: &'static tatu_test_host,
    /// Null once it is closed.
    raw: *mut tatu_test_world,
    /// Of one thread.
    thread: PhantomData<*mut ()>,
}

/// A function of the host, or an error if it lacks that.
macro_rules! host {
    ($world:ident . $function:ident) => {
        $world.table.$function.ok_or_else(|| Error::new(concat!("this host has no ", stringify!($function))))?
    };
}

impl World {
    /// # Safety
    /// A world that is open on this thread, of this table, and nobody else's.
    pub(crate) unsafe fn new(table: &'static tatu_test_host, raw: *mut tatu_test_world) -> Self {
        World { table, raw, thread: PhantomData }
    }

    /// Why the last call on this thread failed.
    ///
    /// # Safety
    /// The host's own table.
    pub(crate) unsafe fn last_error(table: &tatu_test_host) -> Error {
        let Some(last) = table.last_error else { return Error::new("the host failed without a reason") };
        // SAFETY: the host's text, which lives until the next call and is copied at once.
        Error::new(unsafe { Lent::new(last()) }.text())
    }

    fn check(&self, status: tatu_status) -> Result {
        // SAFETY: the host's own table.
        if status >= 0 { Ok(()) } else { Err(unsafe { Self::last_error(self.table) }) }
    }

    /// A value that the host wrote.
    fn value(&self, status: tatu_status, raw: tatu_value) -> Result<Value> {
        self.check(status)?;
        // SAFETY: it lives until the next call with this world, and is copied at once.
        Ok(unsafe { ValueRef::new(raw) }.to_value()?)
    }

    /// Does `n` steps. Faults of scripts and plugins do not stop it: see [`World::faults`].
    ///
    /// # Errors
    /// Something asked for a stop.
    pub fn step(&self, n: u64) -> Result {
        let step = host!(self.step);
        // SAFETY: a world that is open.
        self.check(unsafe { step(self.raw, n) })
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        // SAFETY: a world that is open.
        self.table.time.map_or(0.0, |time| unsafe { time(self.raw) })
    }

    /// What a sensor measured last, by its path or unique name.
    ///
    /// # Errors
    /// There is no such sensor.
    pub fn reading(&self, path: &str) -> Result<Reading> {
        let (reading, name) = (host!(self.reading), text(path)?);
        let mut out = ValueRef::NIL.raw();
        // SAFETY: a world that is open, a text, and a place for the value.
        let status = unsafe { reading(self.raw, name.as_ptr(), &raw mut out) };
        Reading::of(path, &self.value(status, out)?)
    }

    /// A property of an object: "position", "joint.position", a parameter such as "lamp.range", a command of an actuator.
    /// An empty path is the world: "scene.gravity".
    ///
    /// # Errors
    /// There is no such object or property.
    pub fn get(&self, path: &str, key: &str) -> Result<Value> {
        let (get, path, key) = (host!(self.get), text(path)?, text(key)?);
        let mut out = ValueRef::NIL.raw();
        // SAFETY: a world that is open, two texts, and a place for the value.
        let status = unsafe { get(self.raw, path.as_ptr(), key.as_ptr(), &raw mut out) };
        self.value(status, out)
    }

    /// Sets a property, as a script would.
    ///
    /// # Errors
    /// There is no such object or property, or it does not take the value.
    pub fn set(&self, path: &str, key: &str, value: impl Into<Value>) -> Result {
        let (set, path, key) = (host!(self.set), text(path)?, text(key)?);
        let mut room = Owned::default();
        let value = room.raw(&value.into());
        // SAFETY: a world that is open, two texts, and a value, which live through the call.
        self.check(unsafe { set(self.raw, path.as_ptr(), key.as_ptr(), &raw const value) })
    }

    /// Calls a command of any plugin; its results.
    ///
    /// # Errors
    /// There is no such command, or it failed: its own sentence.
    pub fn call(&self, name: &str, args: &[Value]) -> Result<Vec<Value>> {
        let (call, name) = (host!(self.call), text(name)?);
        let mut room = Owned::default();
        let args: Vec<tatu_value> = args.iter().map(|v| room.raw(v)).collect();
        let (mut results, mut n) = ([ValueRef::NIL.raw(); 64], 0);
        let (count, cap) = (args.len() as u32, results.len() as u32);
        let (args, out) = (args.as_ptr(), results.as_mut_ptr());
        // SAFETY: a world that is open, a text, and arrays of as many values as stated, which live through the call.
        self.check(unsafe { call(self.raw, name.as_ptr(), args, count, out, cap, &raw mut n) })?;
        // SAFETY: as many as were written; they live until the next call with this world, and are copied at once.
        let results = unsafe { ValueRef::slice(results.as_ptr(), n.min(cap) as usize) };
        Ok(results.iter().map(|v| v.to_value()).collect::<Result<_, _>>()?)
    }

    /// What has been logged since the last call, a line each.
    pub fn lines(&self) -> Vec<String> {
        // SAFETY: a world that is open; the text lives until the next call with it.
        self.table.lines.map_or(Vec::new(), |lines| lines_of(unsafe { Lent::new(lines(self.raw)) }))
    }

    /// What has gone wrong since the last call, a line each. What is not asked for makes [`World::close`] fail.
    pub fn faults(&self) -> Vec<String> {
        // SAFETY: a world that is open; the text lives until the next call with it.
        self.table.faults.map_or(Vec::new(), |faults| lines_of(unsafe { Lent::new(faults(self.raw)) }))
    }

    /// Stops it and ends it. A test ends with this: dropping it does the same, and keeps silent.
    ///
    /// # Errors
    /// Something went wrong, in the end of scripts and plugins or before.
    pub fn close(mut self) -> Result {
        let raw = std::mem::replace(&mut self.raw, std::ptr::null_mut());
        let close = host!(self.close);
        // SAFETY: a world that is open, and given back once.
        self.check(unsafe { close(raw) })
    }
}

impl Drop for World {
    fn drop(&mut self) {
        if let Some(close) = self.table.close {
            // SAFETY: null, or a world that is open, and given back once.
            unsafe { close(self.raw) };
        }
    }
}

fn text(text: &str) -> Result<CString> {
    CString::new(text).map_err(|_| Error::new(format!("`{}` has a 0 within", text.escape_debug())))
}

fn lines_of(text: Lent<'_>) -> Vec<String> {
    text.text().lines().map(str::to_owned).collect()
}

/// What a sensor measured last.
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
        let wrong = || Error::new(format!("the host gave no reading of {path}"));
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

    /// When it measured, s.
    pub fn time(&self) -> f64 {
        self.time
    }
    /// How often it has measured; 0: never.
    pub fn sequence(&self) -> u64 {
        self.sequence.unsigned_abs()
    }
    /// The names of its fields.
    pub fn names(&self) -> Vec<&str> {
        self.fields.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// All numbers of a field, of whatever type.
    ///
    /// # Errors
    /// There is no such field, or the sensor has not measured yet.
    pub fn f64s(&self, field: &str) -> Result<Vec<f64>> {
        let Some((_, value)) = self.fields.iter().find(|(name, _)| name == field) else {
            let (path, kind, known) = (&self.path, &self.kind, self.names().join(", "));
            let text = format!("the sensor {path} of kind `{kind}` has no field `{field}`\n  expected: one of {known}");
            return Err(Error::new(text));
        };
        if self.sequence == 0 {
            return Err(Error::new(format!("the sensor {} has not measured yet\n  help: do a step first", self.path)));
        }
        match value {
            Value::Floats(all) => Ok(all.clone()),
            Value::Ints(all) => Ok(all.iter().map(|i| *i as f64).collect()),
            _ => Err(Error::new(format!("the field `{field}` holds no numbers"))),
        }
    }

    /// The number of a field that has one.
    ///
    /// # Errors
    /// As [`Reading::f64s`]; or the field has another count of numbers.
    pub fn f64(&self, field: &str) -> Result<f64> {
        match self.f64s(field)?.as_slice() {
            [one] => Ok(*one),
            all => {
                let text = format!("{}: `{field}` has {} numbers, not one", self.path, all.len());
                Err(Error::new(text + "\n  help: `f64s` gives them all"))
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
