//! What a world keeps of its outside.

use std::{
    cell::{Cell, RefCell},
    collections::{BTreeMap, BTreeSet},
    rc::{Rc, Weak},
};

use tatu_plugin_api::safe::Value;

use super::{
    SessionCell,
    log::{InputLog, Replay},
};
use crate::{
    error::{Fault, FaultKind},
    events::Bus,
};

/// The world's side of its session: events for services, the input log, what is replayed.
#[derive(Default)]
pub(crate) struct Outside {
    session: RefCell<Weak<SessionCell>>,
    /// A pause has been asked for and not been lifted: time stands.
    pub paused: Cell<bool>,
    /// For whom the service whose turn it is acts, by the service's number.
    pub client: Cell<u64>,
    /// What scripts from outside were given, by slot.
    pub options: RefCell<BTreeMap<u32, Value>>,
    /// What happens, for scripts.
    pub bus: Bus,
    /// Told to services at the next barrier.
    events: RefCell<Vec<(Rc<str>, Value)>>,
    pub log: RefCell<InputLog>,
    pub replay: RefCell<Option<Replay>>,
    /// Who made the call that is being replayed.
    pub replayed: RefCell<String>,
    /// Files that scripts or plugins asked to read since the start.
    pub opened: RefCell<BTreeSet<String>>,
}

impl Outside {
    pub fn join(&self, session: &Rc<SessionCell>) {
        *self.session.borrow_mut() = Rc::downgrade(session);
    }
    /// The session, if the world is in one that still lives.
    pub fn session(&self) -> Option<Rc<SessionCell>> {
        self.session.borrow().upgrade()
    }
    /// The world starts.
    pub fn begin(&self) {
        self.paused.set(false);
        self.log.borrow_mut().clear();
        self.opened.borrow_mut().clear();
        if let Some(replay) = &mut *self.replay.borrow_mut() {
            replay.rewind();
        }
        self.bus.begin();
        self.tell("started", Value::Nil);
    }
    /// Publishes an event that costs nothing to make.
    pub fn tell(&self, name: &str, payload: Value) {
        self.publish(name, || payload);
    }
    /// Publishes an event: for scripts at the next delivery, for services at the next barrier. What it holds is only made
    /// if somebody listens.
    pub fn publish(&self, name: &str, payload: impl FnOnce() -> Value) {
        let (scripts, services) = (self.bus.wants(name), self.services_want(name));
        if !scripts && !services {
            return;
        }
        let payload = payload();
        if services && let Ok(mut events) = self.events.try_borrow_mut() {
            events.push((name.into(), payload.clone()));
        }
        if scripts {
            self.bus.push(name, payload);
        }
    }
    /// Whether anybody listens to an event.
    pub fn wants(&self, name: &str) -> bool {
        self.bus.wants(name) || self.services_want(name)
    }
    fn services_want(&self, name: &str) -> bool {
        self.session().is_some_and(|s| s.wants(name))
    }
    /// Takes the events that have not been told yet.
    pub fn take_events(&self) -> Vec<(Rc<str>, Value)> {
        std::mem::take(&mut *self.events.borrow_mut())
    }
    pub fn has_events(&self) -> bool {
        !self.events.borrow().is_empty()
    }
    /// Something went wrong for the first time.
    pub fn fault(&self, fault: &Fault) {
        let of = match fault.kind {
            FaultKind::Plugin => "plugin_failed",
            _ if fault.script.is_some() => "script_error",
            _ => "fault",
        };
        if !self.wants("fault") && !self.wants(of) {
            return;
        }
        let text = |key: &str, value: &str| (Value::text(key), Value::text(value));
        let mut payload = vec![text("code", fault.code), text("message", &fault.message)];
        for (key, value) in
            [("plugin", &fault.plugin), ("script", &fault.script), ("object", &fault.object), ("file", &fault.file)]
        {
            payload.extend(value.as_ref().map(|v| text(key, v)));
        }
        payload.extend(fault.line.map(|l| (Value::text("line"), Value::Int(l as i64))));
        if of != "fault" {
            self.tell(of, Value::Map(payload.clone()));
        }
        self.tell("fault", Value::Map(payload));
    }
    /// Whether a pause can be lifted again: by a service, or because a replay takes no notice of it.
    pub fn can_pause(&self) -> bool {
        self.replay.borrow().is_some() || self.session().is_some_and(|s| s.any_service())
    }
}
