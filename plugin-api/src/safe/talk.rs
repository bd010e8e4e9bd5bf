//! How scripts and plugins talk in a world: signals, scripts' functions, events.

use super::{
    Fail, Result, Value, ValueRef, World,
    fail::{bytes_of, bytes_raw, text_raw},
    value::Room,
    world::service,
};
use crate::abi::*;

impl<'a> World<'a> {
    /// Calls a callback in all scripts that have it, but not in `except` (0: in all); results are dropped.
    pub fn broadcast(&self, callback: &str, args: &[ValueRef<'_>], except: tatu_object) -> Result {
        let (ptr, n) = (args.as_ptr().cast(), args.len() as u32);
        // SAFETY: the world is that of the running call, and what is passed lives until it returns; `ValueRef` is transparent over `tatu_value`.
        self.check(unsafe { service!(self.scripts.broadcast)(self.raw(), text_raw(callback), ptr, n, except) })
    }
    /// Calls the child scripts below an object that the running stage (`TATU_STAGE_ACTUATE` or `TATU_STAGE_REACT`) has not
    /// called yet, with these arguments, in its place; how many.
    pub fn call_below(&self, above: tatu_object, stage: u32, args: &[ValueRef<'_>]) -> Result<u32> {
        let (ptr, len, mut n) = (args.as_ptr().cast(), args.len() as u32, 0);
        // SAFETY: the world is that of the running call, and what is passed lives until it returns; `ValueRef` is transparent over `tatu_value`.
        self.check(unsafe { service!(self.scripts.call_below)(self.raw(), above, stage, ptr, len, &mut n) })?;
        Ok(n)
    }

    /// A signal; nil if it is not set.
    pub fn signal(&self, kind: u32, name: &[u8]) -> Result<ValueRef<'a>> {
        let mut value = ValueRef::NIL.raw();
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        unsafe {
            match service!(self.signals.get)(self.raw(), kind, bytes_raw(name), &mut value) {
                TATU_ERR_MISSING => Ok(ValueRef::NIL),
                status => self.check(status).map(|()| ValueRef::new(value)),
            }
        }
    }
    /// Sets a signal.
    pub fn set_signal(&self, kind: u32, name: &[u8], value: ValueRef<'_>) -> Result {
        let raw = value.raw();
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.signals.set)(self.raw(), kind, bytes_raw(name), &raw) })
    }
    /// Removes a signal, or all of a kind (empty name); gives how many there were.
    pub fn clear_signal(&self, kind: u32, name: &[u8]) -> Result<u32> {
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        Ok(unsafe { service!(self.signals.clear)(self.raw(), kind, bytes_raw(name)) })
    }
    /// The `index`-th signal name of a kind.
    pub fn signal_name(&self, kind: u32, index: u32) -> Result<Option<Vec<u8>>> {
        let mut name = bytes_raw(&[]);
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        unsafe {
            match service!(self.signals.name)(self.raw(), kind, index, &mut name) {
                TATU_ERR_MISSING => Ok(None),
                status => self.check(status).map(|()| Some(bytes_of(name).to_vec())),
            }
        }
    }

    /// The scripts of an object; 0: all.
    pub fn scripts(&self, owner: tatu_object) -> Result<Vec<tatu_object>> {
        let list = service!(self.scripts.list);
        self.fill(|out, cap, n| {
            // SAFETY: the world is that of the running call, and what is passed lives until it returns.
            unsafe { list(self.raw(), owner, out, cap, n) }
        })
    }
    /// Calls a function of a script by name; `frame` as in the header.
    ///
    /// # Safety
    /// The frame's arrays are valid and as large as it tells.
    pub unsafe fn call_script(&self, script: tatu_object, function: &str, frame: &mut tatu_call) -> Result {
        // SAFETY: the caller promises it.
        self.check(unsafe { service!(self.scripts.call)(self.raw(), script, text_raw(function), frame) })
    }
    /// Calls a function of a script; what it returns.
    pub fn call_function(&self, script: tatu_object, function: &str, args: &[Value]) -> Result<Vec<Value>> {
        let mut room = Room::default();
        let args = room.all(args);
        let mut results = [ValueRef::NIL.raw(); 16];
        // SAFETY: an all-zero frame is a valid empty one.
        let mut frame: tatu_call = unsafe { std::mem::zeroed() };
        frame.size = size_of::<tatu_call>() as u32;
        (frame.args, frame.n_args) = (args.as_ptr(), args.len() as u32);
        (frame.results, frame.results_cap) = (results.as_mut_ptr(), results.len() as u32);
        // SAFETY: the arrays outlive the call, and are as long as told; results are copied at once.
        unsafe {
            self.call_script(script, function, &mut frame)?;
            ValueRef::slice(frame.results, frame.n_results as usize).iter().map(|v| v.to_value()).collect()
        }
    }
    /// Adds a script of kind "child", "threaded" or "customization" to an object; its handle. While the world runs it begins in the
    /// next stage, after all others. `dialect` may be empty.
    pub fn add_script(
        &self,
        owner: tatu_object,
        language: &str,
        dialect: &str,
        kind: &str,
        name: &str,
        text: &[u8],
    ) -> Result<tatu_object> {
        let add = service!(self.scripts.add);
        let [language, dialect, kind, name] = [language, dialect, kind, name].map(text_raw);
        let mut out = 0;
        // SAFETY: the world is that of the running call, and what is passed lives until it returns; the texts live through the call.
        self.check(unsafe { add(self.raw(), owner, language, dialect, kind, name, bytes_raw(text), &mut out) })?;
        Ok(out)
    }

    /// What a script was given when it was started from outside: a map of texts, empty for others.
    pub fn script_options(&self, script: tatu_object) -> Result<ValueRef<'a>> {
        let mut value = ValueRef::NIL.raw();
        // SAFETY: the world is that of the running call, and what is passed lives until it returns; the value lives until the plugin's call returns.
        unsafe {
            self.check(service!(self.scripts.options)(self.raw(), script, &mut value))?;
            Ok(ValueRef::new(value))
        }
    }

    /// Publishes an event of this plugin; `payload` is a map, or nil.
    pub fn publish(&self, name: &str, payload: ValueRef<'_>) -> Result {
        let raw = payload.raw();
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.events.publish)(self.raw(), text_raw(name), &raw) })
    }
    /// As [`publish`](Self::publish), of a value of one's own.
    pub fn publish_value(&self, name: &str, payload: &Value) -> Result {
        let mut room = Room::default();
        let raw = room.raw(payload);
        // SAFETY: the world is that of the running call; `room` lives until after the call.
        self.check(unsafe { service!(self.events.publish)(self.raw(), text_raw(name), &raw) })
    }
    /// Calls a function of a script for each event of a name from now on; the number of the subscription.
    pub fn subscribe(&self, name: &str, handler: tatu_func) -> Result<u64> {
        let commands = self.host.commands;
        let retain =
            commands.and_then(|t| t.retain).ok_or_else(|| Fail::unsupported("this host keeps no functions"))?;
        let (mut kept, mut id) = (0, 0);
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        unsafe {
            self.check(retain(self.raw(), handler, &mut kept))?;
            let done = self.check(service!(self.events.subscribe)(self.raw(), text_raw(name), kept, &mut id));
            if done.is_err()
                && let Some(drop) = commands.and_then(|t| t.drop)
            {
                drop(self.raw(), kept);
            }
            done.map(|()| id)
        }
    }
    /// Ends a subscription.
    pub fn unsubscribe(&self, id: u64) -> Result {
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.events.unsubscribe)(self.raw(), id) })
    }
    /// Whether anybody listens to an event.
    pub fn is_wanted(&self, name: &str) -> bool {
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.host.events.and_then(|t| t.wanted).is_some_and(|f| unsafe { f(self.raw(), text_raw(name)) } != 0)
    }
}
