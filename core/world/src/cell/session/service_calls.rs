//! Calls the functions of a service.

use std::ffi::c_void;

use tatu_errors::{Fault, FaultKind};
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::{
    border::{ErrorSlot, raw},
    state_block::PAST_STATE,
    watchdog::PluginCall,
};

use crate::cell::{
    WorldCell,
    calls::errors,
    calls::stack::Caller,
    session::service::{RunningService, to_raw_values},
};

impl RunningService {
    /// Runs `f` with this service recorded as the subject of the plugin call.
    pub fn call_with_subject<T>(&self, world: &WorldCell, f: impl FnOnce() -> T) -> T {
        world.monitor.watch.replace_subject(&self.subject);
        let done = f();
        world.monitor.watch.replace_subject("");
        done
    }

    /// Calls a function of one of the service's clients. The caller releases the arena memory of the results.
    pub fn call_func(&self, world: &WorldCell, local: u32, f: &mut tatu_call) -> tatu_status {
        let kind = self.info(&world.model.registry);
        let Some(call) = kind.raw.call_func else { return TATU_ERR_UNSUPPORTED };
        world.run.calls.caller.set(Caller::remote(self.number));
        (f.world, f.caller_kind) = (world.raw(), TATU_CALLER_HOST);
        (f.caller, f.caller_object, f.caller_script) = (0, 0, 0);
        let error = f.error;
        // SAFETY: `call` is from a plugin that is never unloaded, and `self.data` points to the instance that it
        // created. The frame lives until the call has returned, and no borrow of the world is active.
        let status = world
            .call_plugin(kind.plugin, PluginCall::ServiceFunc, 0, || unsafe { call(self.data, world.raw(), local, f) });
        f.error = error;
        let status = errors::check_status(error, status, false);
        if status < 0 {
            errors::name_plugin(error, status, &world.model.registry.plugins[kind.plugin].id, PluginCall::ServiceFunc);
        }
        status
    }

    /// Runs a call into the service, and restores the call depth, the caller and the arena afterwards.
    fn enter<T>(
        &self,
        world: &WorldCell,
        call: PluginCall,
        f: impl FnOnce(&tatu_service, *mut c_void) -> T,
    ) -> Option<T> {
        if self.off.get() {
            return None;
        }
        let level = world.run.calls.enter()?;
        let mark = world.run.calls.arena.borrow().mark();
        world.run.calls.caller.set(Caller::remote(self.number));
        world.run.connections.client.set(0);
        let kind = self.info(&world.model.registry);
        world.monitor.watch.replace_subject(&self.subject);
        let (out, heard) = world.call_plugin_capturing(kind.plugin, call, 0, || f(&kind.raw, self.data));
        world.run.calls.arena.borrow_mut().release(mark);
        world.monitor.watch.replace_subject("");
        drop(level);
        if let Some(said) = heard.first() {
            self.switch_off(world, call, said);
            return None;
        }
        Some(out)
    }

    /// Runs a call with an error object. A failed call is reported and switches the service off. Returns `None` if the
    /// call failed, the service was switched off already, or the limit of nested calls was reached.
    fn call_or_switch_off(
        &self,
        world: &WorldCell,
        call: PluginCall,
        f: impl FnOnce(&tatu_service, *mut c_void, *mut tatu_error) -> tatu_status,
    ) -> Option<tatu_status> {
        let mut error = ErrorSlot::new();
        let told = error.raw();
        let status = self.enter(world, call, |raw, data| f(raw, data, told))?;
        let why = match status {
            TATU_OK | TATU_HOLD if !self.state.borrow().guards_intact() => format!(": {PAST_STATE}"),
            TATU_OK => return Some(TATU_OK),
            TATU_HOLD if call == PluginCall::Barrier => return Some(TATU_HOLD),
            ..0 if !error.has_error() => failure(status),
            ..0 => format!(": {}", error.text()),
            n => format!(": broke the contract: it returned {n}"),
        };
        self.switch_off(world, call, &why);
        None
    }

    /// Calls the service at the barrier, and returns whether it holds the world.
    pub fn barrier(&self, world: &WorldCell) -> bool {
        let step = world.state.clock.step.get();
        let begin = std::time::Instant::now();
        let answer = self.call_or_switch_off(world, PluginCall::Barrier, |raw, data, error| {
            // SAFETY: `f` is from a plugin that is never unloaded, and `data` points to the instance that it created.
            // `error` lives until the call has returned, and no borrow of the world is active.
            raw.barrier.map_or(TATU_GO, |f| unsafe { f(data, world.raw(), step, error) })
        });
        let holds = answer == Some(TATU_HOLD);
        let registry = &world.model.registry;
        match &registry.inspector {
            None => holds,
            Some(inspector) => inspector.after_barrier(self.info(registry).plugin, holds, begin.elapsed()),
        }
    }

    /// Notifies the service that the world is about to end. It is the last call in which the service can access the
    /// world.
    pub fn notify_world_end(&self, world: &WorldCell) {
        self.call_or_switch_off(world, PluginCall::Last, |raw, data, error| {
            // SAFETY: `f` is from a plugin that is never unloaded, and `data` points to the instance that it created.
            // `error` lives until the call has returned, and no borrow of the world is active.
            raw.last.map_or(TATU_OK, |f| unsafe { f(data, world.raw(), error) })
        });
    }

    /// Delivers an event if the service subscribes to it.
    pub fn deliver_event(&self, world: &WorldCell, name: &str, payload: &Value) {
        if !self.subscribes_to(&world.model.registry, name) {
            return;
        }
        let payload = to_raw_values([payload]);
        self.call_or_switch_off(world, PluginCall::Event, |service, data, error| {
            let name = raw(name.as_bytes());
            // SAFETY: `f` is from a plugin that is never unloaded, and `data` points to the instance that it created.
            // `name`, `payload` and `error` live until the call has returned, and no borrow of the world is active.
            service.event.map_or(TATU_OK, |f| unsafe { f(data, world.raw(), name, payload.0.as_ptr(), error) })
        });
    }

    /// Passes the result of a command that waited to the service.
    pub fn resume(&self, world: &WorldCell, token: u64, status: tatu_status, frame: &tatu_call) {
        self.call_or_switch_off(world, PluginCall::ServiceResume, |service, data, error| {
            // SAFETY: `f` is from a plugin that is never unloaded, and `data` points to the instance that it created.
            // The frame and `error` live until the call has returned, and no borrow of the world is active.
            service.resume.map_or(TATU_OK, |f| unsafe { f(data, world.raw(), token, status, frame, error) })
        });
    }

    /// Reports a failure and switches the service off. `how` begins with a verb or a colon.
    fn switch_off(&self, world: &WorldCell, call: PluginCall, how: &str) {
        self.off.set(true);
        let info = self.info(&world.model.registry);
        let plugin = &world.model.registry.plugins[info.plugin].id;
        let gap = if how.starts_with(':') { "" } else { " " };
        let text = format!("plugin `{plugin}`: {}{gap}{how} [{}]; it is switched off", self.subject, call.text());
        let mut fault = Fault::new(FaultKind::Plugin, text);
        fault.plugin = Some(plugin.clone());
        world.report(fault);
    }
}

/// Describes a failure for which the service gave no message.
fn failure(status: tatu_status) -> String {
    match status {
        TATU_ERR_PANIC => "panicked".to_owned(),
        _ => format!("failed with status {status}"),
    }
}
