//! What a world keeps of its outside.

use std::{
    cell::{Cell, RefCell},
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
    rc::{Rc, Weak},
    sync::Arc,
};

use tatu_errors::{Error, Fault, FaultKind};
use tatu_plugin_api::{abi::tatu_world, safe::Value};
use tatu_scene::document::Document;

use super::{
    events::Bus,
    input_log::{InputLog, Replay},
    instance_image::InstanceImage,
    session::{SessionCell, WorldHandle},
};

/// The world's side of its session: events for services, the input log, what is replayed.
pub(crate) struct Outside {
    session: RefCell<Weak<SessionCell>>,
    /// By which the session knows the world.
    pub handle: Rc<WorldHandle>,
    /// Somebody stands by who can lift a pause.
    pub interactive: Cell<bool>,
    /// The client on whose behalf the current service acts, by the service's number.
    pub client: Cell<u64>,
    /// What scripts from outside were given, by slot.
    pub options: RefCell<BTreeMap<u32, Value>>,
    /// What happens, for scripts.
    pub bus: Bus,
    /// Events queued for services until the next barrier.
    events: RefCell<Vec<(Rc<str>, Value)>>,
    pub log: RefCell<InputLog>,
    pub replay: RefCell<Option<Replay>>,
    /// What services kept of the world, from a snapshot: until they take it up.
    pub saved_services: RefCell<Vec<(String, InstanceImage)>>,
    /// Functions of clients that run now, one within the other.
    pub functions: Cell<u32>,
    /// The caller of the call that is being replayed.
    pub replayed: RefCell<String>,
    /// What came in since the start, but for what services did: kind and text.
    pub inputs: RefCell<Vec<(String, String)>>,
    /// What clocks show, s since the start, where that is not simulation time.
    pub clock: Cell<Option<f64>>,
    /// The date of the start, s since 1970.
    pub epoch: Cell<i64>,
    /// Files that scripts or plugins asked to read since the start.
    pub opened: RefCell<BTreeSet<String>>,
    /// Reads another scene, with which the program goes on when it is asked to; none: it runs this one only.
    pub scene_reader: RefCell<Option<SceneReader>>,
    /// The scene that was asked for.
    pub next_scene: RefCell<Option<NextScene>>,
}

/// Reads the scene in a file; an empty path: the present one again.
pub(crate) type SceneReader = Rc<dyn Fn(&Path) -> Result<Arc<Document>, Error>>;

/// A scene with which the program is to go on.
pub struct NextScene {
    /// Its file; empty: that of the present one.
    pub file: PathBuf,
    /// What it is made of.
    pub document: Arc<Document>,
    /// It is to start at once: a start was requested since.
    pub starts: bool,
}

/// Where clocks show simulation time, runs start with the first second of 2015, in universal time.
const EPOCH: i64 = 1_420_070_400;

impl Default for Outside {
    fn default() -> Self {
        Outside {
            session: RefCell::default(),
            handle: Rc::new(Cell::new(std::ptr::null_mut())),
            interactive: Cell::default(),
            client: Cell::default(),
            options: RefCell::default(),
            bus: Bus::default(),
            events: RefCell::default(),
            log: RefCell::default(),
            replay: RefCell::default(),
            saved_services: RefCell::default(),
            functions: Cell::default(),
            replayed: RefCell::default(),
            inputs: RefCell::default(),
            clock: Cell::default(),
            epoch: Cell::new(EPOCH),
            opened: RefCell::default(),
            scene_reader: RefCell::default(),
            next_scene: RefCell::default(),
        }
    }
}

impl Outside {
    /// Something came in: kept for plugins, and if it is the time, for clocks.
    pub fn take_in(&self, kind: &str, text: &str) {
        match kind {
            "clock" => self.clock.set(text.parse().ok()),
            "epoch" => self.epoch.set(text.parse().unwrap_or(EPOCH)),
            _ => self.inputs.borrow_mut().push((kind.to_owned(), text.to_owned())),
        }
    }
    /// The world joins a session, which knows it by `world`.
    pub fn join(&self, session: &Rc<SessionCell>, world: *mut tatu_world) {
        self.handle.set(world);
        *self.session.borrow_mut() = Rc::downgrade(session);
    }
    /// The world leaves its session.
    pub fn leave(&self) {
        *self.session.borrow_mut() = Weak::new();
    }
    /// The session, if the world is in one that still lives.
    pub fn session(&self) -> Option<Rc<SessionCell>> {
        self.session.borrow().upgrade()
    }
    /// The world starts.
    pub fn begin(&self) {
        self.log.borrow_mut().clear();
        self.opened.borrow_mut().clear();
        self.inputs.borrow_mut().clear();
        self.clock.set(None);
        self.epoch.set(EPOCH);
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
    /// Publishes an event: for scripts at the next delivery, for services at the next barrier. What it holds is only
    /// made if somebody listens.
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
    /// Whether an event has subscribers.
    pub fn wants(&self, name: &str) -> bool {
        self.bus.wants(name) || self.services_want(name)
    }
    fn services_want(&self, name: &str) -> bool {
        self.session().is_some_and(|s| s.wants(name))
    }
    /// Takes the events that have not been delivered yet.
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
}
