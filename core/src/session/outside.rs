//! What a world keeps of its outside.

use std::{
    cell::{Cell, RefCell},
    collections::BTreeSet,
    rc::{Rc, Weak},
};

use tatu_plugin_api::safe::Value;

use super::{
    SessionCell,
    log::{InputLog, Replay},
};
use crate::error::Fault;

/// The world's side of its session: events for services, the input log, what is replayed.
#[derive(Default)]
pub(crate) struct Outside {
    session: RefCell<Weak<SessionCell>>,
    /// Somebody stands by who can lift a pause.
    pub interactive: Cell<bool>,
    /// For whom the service whose turn it is acts, by the service's number.
    pub client: Cell<u64>,
    /// Told to services at the next barrier.
    events: RefCell<Vec<(&'static str, Value)>>,
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
        self.log.borrow_mut().clear();
        self.opened.borrow_mut().clear();
        if let Some(replay) = &mut *self.replay.borrow_mut() {
            replay.rewind();
        }
        self.tell("started", Value::Nil);
    }
    /// Keeps an event for services; without a session nobody would take it.
    pub fn tell(&self, name: &'static str, payload: Value) {
        if self.session.borrow().strong_count() > 0
            && let Ok(mut events) = self.events.try_borrow_mut()
        {
            events.push((name, payload));
        }
    }
    /// Takes the events that have not been told yet.
    pub fn take_events(&self) -> Vec<(&'static str, Value)> {
        std::mem::take(&mut *self.events.borrow_mut())
    }
    pub fn has_events(&self) -> bool {
        !self.events.borrow().is_empty()
    }
    /// Something went wrong for the first time.
    pub fn fault(&self, fault: &Fault) {
        if self.session.borrow().strong_count() == 0 {
            return;
        }
        let text = |key: &str, value: &str| (Value::text(key), Value::text(value));
        let mut payload = vec![text("code", fault.code), text("message", &fault.message)];
        for (key, value) in [("plugin", &fault.plugin), ("object", &fault.object), ("file", &fault.file)] {
            payload.extend(value.as_ref().map(|v| text(key, v)));
        }
        payload.extend(fault.line.map(|l| (Value::text("line"), Value::Int(l as i64))));
        self.tell("fault", Value::Map(payload));
    }
}
