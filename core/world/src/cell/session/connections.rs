//! The world's connections to services and to the program.

use std::{
    cell::{Cell, RefCell},
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
    rc::{Rc, Weak},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

use tatu_errors::{Error, Fault, FaultKind};
use tatu_plugin_api::{abi::tatu_world, safe::Value};
use tatu_scene::document::{Document, SourceFiles};

use crate::cell::{
    records::events::EventBus,
    records::instance_image::InstanceImage,
    session::input_log::{InputLog, Replay},
    session::session_cell::{SessionCell, WorldHandle},
};

/// The world's side of its session: events for services, the input log, and the log being replayed.
pub(crate) struct Connections {
    session: RefCell<Weak<SessionCell>>,
    /// The handle under which the session has registered the world.
    pub handle: Rc<WorldHandle>,
    /// Whether a user is present who can end a pause.
    pub interactive: Cell<bool>,
    /// The client on whose behalf the current service acts, as numbered by the service.
    pub client: Cell<u64>,
    /// Options of scripts that are not part of the document, by slot.
    pub options: RefCell<BTreeMap<u32, Value>>,
    /// The last payload of each event that a referee has published since the start, by name.
    pub verdicts: RefCell<BTreeMap<String, Value>>,
    /// Events for scripts.
    pub bus: EventBus,
    /// Events queued for services until the next barrier.
    events: RefCell<Vec<(Rc<str>, Value)>>,
    pub record: InputRecord,
    /// States of services from a snapshot, until the services take them.
    pub saved_services: RefCell<Vec<(String, InstanceImage)>>,
    /// Number of client functions that are currently running; they are nested in each other.
    pub running_functions: Cell<u32>,
    /// Inputs since the start that plugins can read, such as key presses, as pairs of kind and text.
    pub inputs: RefCell<Vec<(String, String)>>,
    pub clocks: RunClocks,
    /// Files that scripts or plugins have requested to read since the start.
    pub opened_files: RefCell<BTreeSet<String>>,
    pub scene_change: SceneChange,
    /// Set, from any thread, when the program must end the run.
    pub interrupt: RefCell<Option<Arc<AtomicBool>>>,
}

/// The clocks that scripts read.
pub(crate) struct RunClocks {
    /// Time that clocks show, s since the start; if `None`, clocks show simulation time.
    pub clock: Cell<Option<f64>>,
    /// The time of the start, Unix time in s.
    pub epoch: Cell<i64>,
}

/// The inputs that are recorded, or replayed.
#[derive(Default)]
pub(crate) struct InputRecord {
    pub log: RefCell<InputLog>,
    pub replay: RefCell<Option<Replay>>,
    /// Id of the service whose call is being replayed.
    pub replayed_service: RefCell<String>,
}

/// The change to another scene.
#[derive(Default)]
pub(crate) struct SceneChange {
    /// Reads scene files during a run: those that clients open, and the text of this scene when it is read again. If
    /// `None`, no other scene can be opened.
    pub scene_reader: RefCell<Option<SceneReader>>,
    /// The scene to load next, if one was requested.
    pub next_scene: RefCell<Option<NextScene>>,
}

/// Reads a scene file. An empty path stands for the current scene. Files that the given sources contain are not read
/// from disk.
pub(crate) type SceneReader = Rc<dyn Fn(&Path, Option<SourceFiles>) -> Result<Arc<Document>, Error>>;

/// The scene with which the program continues.
pub struct NextScene {
    /// Path of its file, or empty for the current scene.
    pub file: PathBuf,
    /// The document of the scene.
    pub document: Arc<Document>,
    /// Whether it starts immediately, because a start was requested after the scene.
    pub starts: bool,
}

/// Default start time of a run, 2015-01-01 00:00:00 UTC, as Unix time in s.
const DEFAULT_EPOCH_S: i64 = 1_420_070_400;

impl Default for Connections {
    fn default() -> Self {
        Connections {
            session: RefCell::default(),
            handle: Rc::new(Cell::new(std::ptr::null_mut())),
            interactive: Cell::default(),
            client: Cell::default(),
            options: RefCell::default(),
            verdicts: RefCell::default(),
            bus: EventBus::default(),
            events: RefCell::default(),
            record: InputRecord {
                log: RefCell::default(),
                replay: RefCell::default(),
                replayed_service: RefCell::default(),
            },
            saved_services: RefCell::default(),
            running_functions: Cell::default(),
            inputs: RefCell::default(),
            clocks: RunClocks { clock: Cell::default(), epoch: Cell::new(DEFAULT_EPOCH_S) },
            opened_files: RefCell::default(),
            scene_change: SceneChange { scene_reader: RefCell::default(), next_scene: RefCell::default() },
            interrupt: RefCell::default(),
        }
    }
}

impl Connections {
    /// Applies an input: "clock" and "epoch" set the clocks, and all other kinds are stored for plugins.
    pub fn apply_input(&self, kind: &str, text: &str) {
        match kind {
            "clock" => self.clocks.clock.set(text.parse().ok()),
            "epoch" => self.clocks.epoch.set(text.parse().unwrap_or(DEFAULT_EPOCH_S)),
            _ => self.inputs.borrow_mut().push((kind.to_owned(), text.to_owned())),
        }
    }
    /// Joins a session. `world` is the pointer under which services receive the world.
    pub fn join(&self, session: &Rc<SessionCell>, world: *mut tatu_world) {
        self.handle.set(world);
        *self.session.borrow_mut() = Rc::downgrade(session);
    }
    /// Leaves the session.
    pub fn leave(&self) {
        *self.session.borrow_mut() = Weak::new();
    }
    /// Returns the world's session, if it is still alive.
    pub fn session(&self) -> Option<Rc<SessionCell>> {
        self.session.borrow().upgrade()
    }
    /// Returns whether a stop has been requested from outside: by the user at the terminal, or by a client of a service
    /// that has not taken its turn since then.
    pub fn has_external_stop(&self) -> bool {
        self.interrupt.borrow().as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
            || self.session().is_some_and(|s| s.has_external_stop())
    }
    /// Resets the state of the run when the world starts.
    pub fn begin(&self) {
        self.verdicts.borrow_mut().clear();
        self.record.log.borrow_mut().clear();
        self.opened_files.borrow_mut().clear();
        self.inputs.borrow_mut().clear();
        self.clocks.clock.set(None);
        self.clocks.epoch.set(DEFAULT_EPOCH_S);
        if let Some(replay) = &mut *self.record.replay.borrow_mut() {
            replay.rewind();
        }
        self.bus.begin();
        self.publish_value("started", Value::Nil);
    }
    /// Publishes an event whose payload has already been created.
    pub fn publish_value(&self, name: &str, payload: Value) {
        self.publish(name, || payload);
    }
    /// Publishes an event, which scripts receive at the next delivery and services at the next barrier. `payload` is
    /// called only if the event has subscribers.
    pub fn publish(&self, name: &str, payload: impl FnOnce() -> Value) {
        let (scripts, services) = (self.bus.has_subscriber(name), self.services_subscribe(name));
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
    /// Publishes an event that depends on the real time, which scripts must not see: only services receive it.
    pub fn publish_to_services(&self, name: &str, payload: impl FnOnce() -> Value) {
        if self.services_subscribe(name)
            && let Ok(mut events) = self.events.try_borrow_mut()
        {
            events.push((name.into(), payload()));
        }
    }
    /// Returns whether an event has subscribers.
    pub fn has_subscriber(&self, name: &str) -> bool {
        self.bus.has_subscriber(name) || self.services_subscribe(name)
    }
    fn services_subscribe(&self, name: &str) -> bool {
        self.session().is_some_and(|s| s.has_subscriber(name))
    }
    /// Takes the events that have not been delivered to the services yet.
    pub fn take_events(&self) -> Vec<(Rc<str>, Value)> {
        std::mem::take(&mut *self.events.borrow_mut())
    }
    pub fn has_events(&self) -> bool {
        !self.events.borrow().is_empty()
    }
    /// Publishes the events that report the first occurrence of a fault.
    pub fn publish_fault(&self, fault: &Fault) {
        let of = match fault.kind {
            FaultKind::Plugin => "plugin_failed",
            _ if fault.script.is_some() => "script_error",
            _ => "fault",
        };
        if !self.has_subscriber("fault") && !self.has_subscriber(of) {
            return;
        }
        let text = |key: &str, value: &str| (Value::text(key), Value::text(value));
        let mut payload = vec![text("code", fault.code), text("message", &fault.message)];
        for (key, value) in [
            ("plugin", &fault.plugin),
            ("script", &fault.script),
            ("object", &fault.object),
            ("file", &fault.file),
            ("traceback", &fault.traceback),
        ] {
            payload.extend(value.as_ref().map(|v| text(key, v)));
        }
        payload.extend(fault.line.map(|l| (Value::text("line"), Value::Int(l as i64))));
        if of != "fault" {
            self.publish_value(of, Value::Map(payload.clone()));
        }
        self.publish_value("fault", Value::Map(payload));
    }
}
