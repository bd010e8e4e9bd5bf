//! One running service, and the calls into it.

use std::{
    cell::{Cell, RefCell},
    ffi::c_void,
};

use tatu_errors::{Error, Fault, FaultKind, Result};
use tatu_plugin_api::{
    abi::*,
    safe::{Owned, Value},
};
use tatu_plugins::{
    Registry, ServiceKind,
    border::{ErrorSlot, answer, raw},
    events::covers,
    state_block::{PAST_STATE, StateBlock},
    watchdog::Call,
};
use tatu_scene::document::ServiceSpec;

use super::{SessionCell, call_errors};
use crate::cell::{Caller, WorldCell};

/// A service that has been started.
pub(crate) struct Running {
    /// Index of its kind.
    pub kind: usize,
    /// Its number in the session, from 1.
    pub number: u32,
    pub data: *mut c_void,
    /// Its state block.
    pub state: RefCell<StateBlock>,
    /// How messages call it.
    subject: String,
    /// It failed: it has no more turns, and holds nothing.
    pub off: Cell<bool>,
    /// That it holds the session for long has been told.
    pub hold_told: Cell<bool>,
}

/// Values in the border form, and the memory that their spans lie in.
struct Laid(Vec<tatu_value>, #[allow(dead_code, reason = "keeps the spans alive")] Owned);

fn lay<'v>(values: impl IntoIterator<Item = &'v Value>) -> Laid {
    let mut owned = Owned::default();
    let raw = values.into_iter().map(|v| owned.raw(v)).collect();
    Laid(raw, owned)
}

impl Running {
    /// Starts a service.
    pub fn start(session: &SessionCell, spec: &ServiceSpec, number: u32) -> Result<Self> {
        let registry = &session.registry;
        let kind = &registry.services[spec.kind];
        let lacking = |p: &&tatu_plugins::Declared| !p.optional() && !spec.params.iter().any(|(k, _)| *k == p.key);
        if let Some(p) = kind.params.iter().find(lacking) {
            return Err(Error::new("E104", format!("the service `{}` lacks its parameter `{}`", kind.id, p.key))
                .expected(p.expectation())
                .at(spec.place.clone()));
        }
        let given = kind
            .params
            .iter()
            .map(|p| spec.params.iter().rev().find(|(k, _)| *k == p.key).map_or(&p.fallback, |(_, v)| v));
        let params = lay(given);
        let plugin = &registry.plugins[kind.plugin];
        let (mut data, mut error) = (std::ptr::null_mut(), ErrorSlot::new());
        let state = StateBlock::new(kind.life.state_bytes);
        let info = tatu_instance {
            size: size_of::<tatu_instance>() as u32,
            n_params: params.0.len() as u32,
            world: std::ptr::null_mut(),
            owner: 0,
            id: number.into(),
            seed: 0,
            params: params.0.as_ptr(),
            state: state.place(),
            session: session.raw(),
        };
        // SAFETY: by the contract; the description and what it points to live through the call.
        let run = || unsafe {
            let status = kind.life.create.map_or(TATU_OK, |f| f(plugin.me, &info, &mut data, error.raw()));
            answer(status, false, error.raw())
        };
        let subject = format!("the service `{}`", kind.id);
        if registry.watched(kind.plugin, Call::Start, &subject, run).map_err(|e| e.at(spec.place.clone()))? < 0 {
            let why = format!("plugin `{}`: {} [{}]", plugin.id, error.text(), Call::Start.text());
            let text = format!("{subject} cannot be started: {why}");
            return Err(Error::new("E404", text).at(spec.place.clone()));
        }
        if !state.is_whole() {
            let text = format!("{subject} cannot be started: plugin `{}`: {PAST_STATE}", plugin.id);
            return Err(Error::new("E404", text).at(spec.place.clone()));
        }
        let (off, hold_told) = (Cell::new(false), Cell::new(false));
        Ok(Running { kind: spec.kind, number, data, state: state.into(), subject, off, hold_told })
    }

    /// Ends it; its threads are joined when this returns.
    pub fn stop(&self, registry: &Registry) -> Result {
        let kind = self.info(registry);
        let Some(stop) = kind.life.destroy else { return Ok(()) };
        // SAFETY: made by `create`, given back once.
        let run = || unsafe { stop(self.data) };
        let done = registry.watched(kind.plugin, Call::Stop, &self.subject, run);
        done.map_err(|e| if e.code == "E111" { Error { code: "E323", ..e } } else { e })
    }

    fn info<'r>(&self, registry: &'r Registry) -> &'r ServiceKind {
        &registry.services[self.kind]
    }

    /// Runs something that is noted as this service's.
    pub fn noted<T>(&self, world: &WorldCell, f: impl FnOnce() -> T) -> T {
        world.watch.subject(&self.subject);
        let done = f();
        world.watch.subject("");
        done
    }

    /// How messages call it, with its plugin.
    pub fn name(&self, registry: &Registry) -> String {
        format!("{} (plugin `{}`)", self.subject, registry.plugins[self.info(registry).plugin].id)
    }

    /// Whether commands that it calls may wait.
    pub fn can_wait(&self, registry: &Registry) -> bool {
        !self.off.get() && self.info(registry).raw.resume.is_some()
    }

    /// Whether it gives functions of its clients to commands.
    pub fn gives_functions(&self, registry: &Registry) -> bool {
        !self.off.get() && self.info(registry).raw.call_func.is_some()
    }

    /// Calls a function of one of its clients. The results' memory is the caller's to release.
    pub fn call_func(&self, world: &WorldCell, local: u32, f: &mut tatu_call) -> tatu_status {
        let kind = self.info(&world.registry);
        let Some(call) = kind.raw.call_func else { return TATU_ERR_UNSUPPORTED };
        world.calls.caller.set(Caller::remote(self.number));
        (f.world, f.caller_kind) = (world.raw(), TATU_CALLER_HOST);
        (f.caller, f.caller_object, f.caller_script) = (0, 0, 0);
        let error = f.error;
        // SAFETY: by the contract; no borrow of the world is alive here, and the frame lives through the call.
        let status =
            world.cross(kind.plugin, Call::ServiceFunc, 0, || unsafe { call(self.data, world.raw(), local, f) });
        f.error = error;
        let status = call_errors::answer(error, status, false);
        if status < 0 {
            call_errors::name_plugin(error, status, &world.registry.plugins[kind.plugin].id, Call::ServiceFunc);
        }
        status
    }

    /// Runs a call into it: depth, caller and arena are afterwards as before.
    fn enter<T>(&self, world: &WorldCell, call: Call, f: impl FnOnce(&tatu_service, *mut c_void) -> T) -> Option<T> {
        if self.off.get() {
            return None;
        }
        let level = world.calls.enter()?;
        let mark = world.calls.arena.borrow().mark();
        world.calls.caller.set(Caller::remote(self.number));
        world.outside.client.set(0);
        let kind = self.info(&world.registry);
        world.watch.subject(&self.subject);
        let (out, heard) = world.cross_capturing(kind.plugin, call, 0, || f(&kind.raw, self.data));
        world.calls.arena.borrow_mut().release(mark);
        world.watch.subject("");
        drop(level);
        if let Some(said) = heard.first() {
            self.switch_off(world, call, said);
            return None;
        }
        Some(out)
    }

    /// Runs a call with an error object; `None`: it does not work any more. After a failure it is switched off, and named.
    fn ask(
        &self,
        world: &WorldCell,
        call: Call,
        f: impl FnOnce(&tatu_service, *mut c_void, *mut tatu_error) -> tatu_status,
    ) -> Option<tatu_status> {
        let mut error = ErrorSlot::new();
        let told = error.raw();
        let status = self.enter(world, call, |raw, data| f(raw, data, told))?;
        let why = match status {
            TATU_OK | TATU_HOLD if !self.state.borrow().is_whole() => format!(": {PAST_STATE}"),
            TATU_OK => return Some(TATU_OK),
            TATU_HOLD if call == Call::Barrier => return Some(TATU_HOLD),
            ..0 if !error.has_said() => failure(status),
            ..0 => format!(": {}", error.text()),
            n => format!(": broke the contract: it answered {n}"),
        };
        self.switch_off(world, call, &why);
        None
    }

    /// Its turn at the barrier; whether it holds the world.
    pub fn barrier(&self, world: &WorldCell) -> bool {
        let step = world.clock.step.get();
        let answer = self.ask(world, Call::Barrier, |raw, data, error| {
            // SAFETY: by the contract; no borrow of the world is alive here.
            raw.barrier.map_or(TATU_GO, |f| unsafe { f(data, world.raw(), step, error) })
        });
        answer == Some(TATU_HOLD)
    }

    /// The world ends: the last time that it is seen.
    pub fn last(&self, world: &WorldCell) {
        self.ask(world, Call::Last, |raw, data, error| {
            // SAFETY: by the contract; no borrow of the world is alive here.
            raw.last.map_or(TATU_OK, |f| unsafe { f(data, world.raw(), error) })
        });
    }

    /// Whether it subscribes to an event.
    pub fn wants(&self, registry: &Registry, name: &str) -> bool {
        self.info(registry).events.iter().any(|wanted| covers(wanted, name))
    }

    /// Tells it that something happened, if it wants to know.
    pub fn event(&self, world: &WorldCell, name: &str, payload: &Value) {
        if !self.wants(&world.registry, name) {
            return;
        }
        let payload = lay([payload]);
        self.ask(world, Call::Event, |service, data, error| {
            let name = raw(name.as_bytes());
            // SAFETY: by the contract; name and payload live through the call.
            service.event.map_or(TATU_OK, |f| unsafe { f(data, world.raw(), name, payload.0.as_ptr(), error) })
        });
    }

    /// Hands it the end of a command that waited.
    pub fn resume(&self, world: &WorldCell, token: u64, status: tatu_status, frame: &tatu_call) {
        self.ask(world, Call::ServiceResume, |service, data, error| {
            // SAFETY: by the contract; the frame lives through the call.
            service.resume.map_or(TATU_OK, |f| unsafe { f(data, world.raw(), token, status, frame, error) })
        });
    }

    /// It failed, and has no more turns; `how` begins with a verb, or with a colon.
    fn switch_off(&self, world: &WorldCell, call: Call, how: &str) {
        self.off.set(true);
        let info = self.info(&world.registry);
        let plugin = &world.registry.plugins[info.plugin].id;
        let gap = if how.starts_with(':') { "" } else { " " };
        let text = format!("plugin `{plugin}`: {}{gap}{how} [{}]; it is switched off", self.subject, call.text());
        let mut fault = Fault::new(FaultKind::Plugin, text);
        fault.plugin = Some(plugin.clone());
        world.report(fault);
    }
}

/// A failure without a sentence.
fn failure(status: tatu_status) -> String {
    match status {
        TATU_ERR_PANIC => "panicked".to_owned(),
        _ => format!("failed with status {status}"),
    }
}
