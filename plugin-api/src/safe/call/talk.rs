//! Communication between scripts and plugins in a world: signals, functions of scripts, events.

use crate::abi::*;
use crate::safe::{
    Called, Result, Value, ValueRef, World,
    call::{outgoing, shared_world::service},
    value::owned::Owned,
};

impl<'a> World<'a> {
    /// Calls a callback in all scripts that define it, except in `except`, if it is not 0; results are discarded.
    pub fn broadcast(&self, callback: &str, args: &[ValueRef<'_>], except: tatu_object) -> Result {
        let (ptr, n) = (args.as_ptr().cast(), args.len() as u32);
        let broadcast = service!(self.scripts.broadcast);
        // SAFETY: the pointer and the count are those of the slice `args`; `ValueRef` is transparent over `tatu_value`.
        self.check(unsafe { broadcast(self.raw(), callback.into(), ptr, n, except) })
    }
    /// Calls, with these arguments, the child scripts of the objects below `above` that the running stage
    /// (`TATU_STAGE_ACTUATE` or `TATU_STAGE_REACT`) has not called yet; the stage then skips them. Returns the number
    /// of scripts called, which is 0 if the stage is not running.
    pub fn call_below(&self, above: tatu_object, stage: u32, args: &[ValueRef<'_>]) -> Result<u32> {
        let (ptr, len, mut n) = (args.as_ptr().cast(), args.len() as u32, 0);
        let call_below = service!(self.scripts.call_below);
        // SAFETY: the pointer and the count are those of the slice `args`; `ValueRef` is transparent over `tatu_value`.
        self.check(unsafe { call_below(self.raw(), above, stage, ptr, len, Some(&mut n)) })?;
        Ok(n)
    }

    /// Returns a signal, or nil if it is not set.
    pub fn signal(&self, kind: u32, name: &[u8]) -> Result<ValueRef<'a>> {
        let mut value = ValueRef::NIL;
        let status = service!(self.signals.get)(self.raw(), kind, name.into(), Some(&mut value));
        Ok(self.found(status, value)?.unwrap_or(ValueRef::NIL))
    }
    /// Sets a signal.
    pub fn set_signal(&self, kind: u32, name: &[u8], value: ValueRef<'_>) -> Result {
        self.check(service!(self.signals.set)(self.raw(), kind, name.into(), Some(&value)))
    }
    /// Removes a signal, or all signals of a kind if `name` is empty. Returns the number of signals removed.
    pub fn clear_signal(&self, kind: u32, name: &[u8]) -> Result<u32> {
        Ok(service!(self.signals.clear)(self.raw(), kind, name.into()))
    }
    /// Returns the name of the `index`-th signal of a kind, from 0 in the order of names, or `None` past the last one.
    pub fn signal_name(&self, kind: u32, index: u32) -> Result<Option<Vec<u8>>> {
        let mut name = Lent::EMPTY;
        let status = service!(self.signals.name)(self.raw(), kind, index, Some(&mut name));
        Ok(self.found(status, name)?.map(|name| name.bytes().to_vec()))
    }

    /// Returns the scripts of an object, or all scripts if `owner` is 0.
    pub fn scripts(&self, owner: tatu_object) -> Result<Vec<tatu_object>> {
        let list = service!(self.scripts.list);
        // SAFETY: `fill` passes a buffer with room for `cap` elements.
        self.fill(|out, cap, n| unsafe { list(self.raw(), owner, out, cap, n) })
    }
    /// Calls a function of a script; returns its results.
    pub fn call_function(&self, script: tatu_object, function: &str, args: &[Value]) -> Result<Vec<Value>> {
        let call = service!(self.scripts.call);
        // SAFETY: `outgoing::call` passes a complete frame that lives during the call.
        let call = |world: WorldRef<'_>, frame: &mut tatu_call| unsafe { call(world, script, function.into(), frame) };
        outgoing::call(self, tatu_call::empty(), args, call).map(Called::done)
    }
    /// Adds a script of kind "child", "threaded" or "customization" to an object; returns the script object. During a
    /// run it starts in the next stage, after all others. `dialect` may be empty.
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
        let [language, dialect, kind, name] = [language, dialect, kind, name].map(Lent::from);
        let mut out = 0;
        self.check(add(self.raw(), owner, language, dialect, kind, name, text.into(), Some(&mut out)))?;
        Ok(out)
    }

    /// Returns the options of a script that was started from outside the scene, such as an add-on, as a map of texts;
    /// the map is empty for other scripts.
    pub fn script_options(&self, script: tatu_object) -> Result<ValueRef<'a>> {
        let mut value = ValueRef::NIL;
        self.check(service!(self.scripts.options)(self.raw(), script, Some(&mut value)))?;
        Ok(value)
    }

    /// Publishes an event of this plugin; `payload` is a map, or nil.
    pub fn publish(&self, name: &str, payload: ValueRef<'_>) -> Result {
        self.check(service!(self.events.publish)(self.raw(), name.into(), Some(&payload)))
    }
    /// Publishes an event like [`publish`](Self::publish), but with an owned payload.
    pub fn publish_value(&self, name: &str, payload: &Value) -> Result {
        self.publish(name, Owned::default().value(payload))
    }
    /// Subscribes a function of a script to the event `name`, and returns the id of the subscription.
    pub fn subscribe(&self, name: &str, handler: tatu_func) -> Result<u64> {
        let (mut kept, mut id) = (0, 0);
        self.check(service!(self.commands.retain)(self.raw(), handler, Some(&mut kept)))?;
        let done = self.check(service!(self.events.subscribe)(self.raw(), name.into(), kept, Some(&mut id)));
        if done.is_err()
            && let Some(drop) = self.host().commands.and_then(|t| t.drop)
        {
            drop(self.raw(), kept);
        }
        done.map(|()| id)
    }
    /// Ends a subscription, by the id that [`World::subscribe`] returned.
    pub fn unsubscribe(&self, id: u64) -> Result {
        self.check(service!(self.events.unsubscribe)(self.raw(), id))
    }
    /// Returns whether an event has subscribers.
    pub fn is_wanted(&self, name: &str) -> bool {
        self.host().events.and_then(|t| t.wanted).is_some_and(|f| f(self.raw(), name.into()) != 0)
    }
}
