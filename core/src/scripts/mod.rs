//! Scripts: their states, callbacks, waits and functions.
//!
//! - [`Scripts`]: the world's scripts;
//! - `kinds`: kinds of scripts, the callbacks that there are; `order`: which script comes first;
//! - `life`: what is called when, from the first pass of a stopped world to its end;
//! - `script`: one script's callbacks and waits; `answers`: what its callbacks may ask for;
//! - `beside`: scripts that run side by side;
//! - `enter`: one way into a script's language, with budget, caller and errors;
//! - `reload`: another text in place of one that runs;
//! - `state`: scripts in snapshots.

mod answers;
mod beside;
mod enter;
mod kinds;
mod life;
mod order;
mod reload;
mod script;
mod state;
mod told;

use std::{cell::Cell, ffi::c_void, rc::Rc};

use tatu_plugin_api::{abi::*, safe::Value};

use answers::Ask;
pub(crate) use answers::entry;
pub(crate) use enter::{Room, call_func, call_function, drop_func, keep_func, owner_of_func};
pub use kinds::OUTSIDE_KINDS;
use kinds::{CALLBACKS, Numbers};
pub(crate) use kinds::{Callback, Heard, Kind};
use order::Order;
pub(crate) use reload::{Handed, Written};
pub use told::ScriptTold;
use told::Told;

use crate::{calls::raw, document::ScriptSpec, scene::Data, world::WorldCell};

/// The priority of scripts that are given none.
pub(crate) const NORMAL: u8 = 1;

/// One script. The state of a child script exists while the world runs, that of others as long as the world.
pub(crate) struct Script {
    pub slot: u32,
    pub language: usize,
    pub kind: Kind,
    /// The same as text.
    pub kind_name: String,
    /// Among scripts of one object, or of siblings: 0 first, 1, 2 last.
    priority: u8,
    /// The scene lets it run beside others.
    pub side_by_side: bool,
    /// For messages: its file, if it has one.
    pub name: String,
    text: Rc<[u8]>,
    wanted_dialect: String,
    /// Instance number; 0: not made.
    pub id: Cell<u64>,
    data: Cell<*mut c_void>,
    /// The dialect chosen; owned by the instance.
    pub dialect: Cell<tatu_str>,
    /// `TATU_SCRIPT_*`, told by its language.
    traits: Cell<u32>,
    /// Runs as a thread by itself.
    threaded: Cell<bool>,
    initialised: Cell<bool>,
    /// It was added while the world ran: until it has begun it comes after all others.
    late: Cell<bool>,
    /// It had its clean-up.
    cleaned: Cell<bool>,
    /// It ended itself.
    ended: Cell<bool>,
    /// Its text could not be loaded, it used up its budget, or it failed and is silent from then on.
    dead: Cell<bool>,
    /// Of actuation and of sensing: the turn in which it was called last.
    called_in: [Cell<u64>; 2],
    /// Calls into it that are running.
    depth: Cell<u32>,
    /// What it asked for, to be done when no call of it runs any more.
    asked: Cell<Ask>,
    callbacks: Cell<Numbers>,
    pub calls: Cell<u64>,
    pub instructions: Cell<u64>,
    told: Told,
}

/// All scripts of a world.
#[derive(Default)]
pub(crate) struct Scripts {
    /// In the order in which they were added.
    list: Vec<Rc<Script>>,
    /// In the order in which they are called, as of this version of the tree; 0: to be made anew.
    sorted: Rc<[Rc<Script>]>,
    sorted_at: u64,
    /// How often the stages of actuation and of sensing have begun.
    turns: [Cell<u64>; 2],
    order: Order,
}

impl Scripts {
    /// Takes the scripts of the document: each becomes an object that belongs to its owner.
    pub fn declare(world: &WorldCell, slots: &[u32]) {
        for (spec, owner) in world.document.objects.iter().zip(slots) {
            for s in &spec.scripts {
                Self::add(world, *owner, s);
            }
        }
    }

    /// Adds a script that belongs to an object (0: to none); the slot of its own object. `None`: no slot is free, or its
    /// kind is unknown.
    pub fn add(world: &WorldCell, owner: u32, spec: &ScriptSpec) -> Option<u32> {
        let kind = Kind::parse(&spec.kind)?;
        let local = nalgebra::Isometry3::identity();
        let slot = world.scene.try_borrow_mut().ok()?.add(owner, "script", local, Data::Script)?;
        let default = world.settings.borrow().dialect.clone();
        let script = Rc::new(Script::new(slot, kind, spec, default));
        script.late.set(world.running());
        world.heard.note_kind(kind, script.late.get());
        let mut scripts = world.scripts.try_borrow_mut().ok()?;
        scripts.list.push(script);
        scripts.sorted_at = 0;
        Some(slot)
    }

    /// The `i`-th script, copied out so that the list is free while the script runs.
    fn nth(world: &WorldCell, i: usize) -> Option<Rc<Script>> {
        world.scripts.try_borrow().ok()?.list.get(i).cloned()
    }
    /// A script by its instance.
    pub fn by_id(&self, id: u64) -> Option<Rc<Script>> {
        self.list.iter().find(|s| id != 0 && s.id.get() == id).cloned()
    }
    /// A script by its object.
    pub fn by_slot(&self, slot: u32) -> Option<Rc<Script>> {
        self.list.iter().find(|s| s.slot == slot).cloned()
    }
    /// Whether a script that comes from outside the document could lift a pause.
    pub fn any_addon_waits(&self) -> bool {
        let waits = |s: &Rc<Script>| s.kind >= Kind::Addon && !s.dead.get() && s.number(Callback::Suspended) != 0;
        self.list.iter().any(waits)
    }
    /// Whether a script calls whose state ends with the run.
    pub fn caller_is_of_run(world: &WorldCell) -> bool {
        let caller = world.calls.caller.get();
        let script = world.scripts.try_borrow().ok().and_then(|s| s.by_id(caller.instance));
        script.is_some_and(|s| s.kind.of_run())
    }
    /// Whether any script has a callback.
    pub fn any_has(world: &WorldCell, callback: Callback) -> bool {
        let has = |s: &Rc<Script>| s.initialised.get() && !s.dead.get() && s.number(callback) != 0;
        world.heard.has(callback) && world.scripts.try_borrow().is_ok_and(|s| s.list.iter().any(has))
    }

    /// The script that runs the stages itself, if the world has one.
    pub fn driver(world: &WorldCell) -> Option<Rc<Script>> {
        if !world.heard.any_driver() {
            return None;
        }
        world.scripts.try_borrow().ok()?.list.iter().find(|s| s.kind == Kind::Main).cloned()
    }

    /// All scripts in the order in which they are called, as it is now; who was added meanwhile comes last.
    fn in_order(world: &WorldCell) -> Rc<[Rc<Script>]> {
        let (Ok(mut scripts), Ok(scene)) = (world.scripts.try_borrow_mut(), world.scene.try_borrow()) else {
            return Rc::default();
        };
        if scripts.sorted_at != scene.shape_version {
            let mut sorted = scripts.list.clone();
            order::sort(&mut sorted, &scene, scripts.order);
            (scripts.sorted, scripts.sorted_at) = (sorted.into(), scene.shape_version);
        }
        let is_new = |s: &Rc<Script>| s.late.get() && !s.initialised.get();
        if !world.heard.any_late() || !scripts.sorted.iter().any(is_new) {
            return scripts.sorted.clone();
        }
        let mut all = scripts.sorted.to_vec();
        all.sort_by_key(is_new);
        all.into()
    }

    /// Which order the world has: told by the first of its languages that knows one.
    fn choose_order(world: &WorldCell) {
        let all = world.scripts.borrow().list.clone();
        let modern = all.iter().any(|s| s.traits.get() & TATU_SCRIPT_MODERN != 0);
        let dialect = world.settings.borrow().dialect.clone();
        let (mut told, mut asked) = (None, Vec::new());
        for script in all.iter().filter(|s| s.has_loaded()) {
            if !asked.contains(&script.language) {
                asked.push(script.language);
                let order = script.order_of(world, &dialect, modern);
                told = told.or(order);
            }
        }
        let mut scripts = world.scripts.borrow_mut();
        (scripts.order, scripts.sorted_at) = (told.unwrap_or_default(), 0);
    }

    /// All scripts that stages call, in order. The driver calls, and is not called.
    fn each_called(world: &WorldCell, f: impl Fn(&Rc<Script>)) {
        for script in &*Self::in_order(world) {
            script.called(world, &f);
        }
    }

    /// The same for a stage that calls a callback. Scripts one after the other that run side by side do so.
    fn each_in_turn(world: &WorldCell, callback: Callback, f: impl Fn(&Rc<Script>)) {
        let order = Self::in_order(world);
        let mut rest = 0..order.len();
        while let Some(i) = rest.next() {
            let beside = beside::how_many(world, &order[i..]);
            if beside > 0 {
                beside::run(world, &order[i..i + beside], callback, &f);
                rest.start = i + beside;
                continue;
            }
            order[i].called(world, &f);
        }
    }

    /// Calls a callback in all scripts that have begun and have it.
    fn each_has(world: &WorldCell, callback: Callback) {
        if Self::any_has(world, callback) {
            Self::each_called(world, |s| s.run_if_begun(world, callback, &[]));
        }
    }

    /// The same with one argument.
    pub fn tell(world: &WorldCell, callback: Callback, payload: &Value) {
        if Self::any_has(world, callback) {
            Self::with_payload(world, payload, |payload| {
                Self::each_called(world, |s| s.run_if_begun(world, callback, &[payload]));
            });
        }
    }

    /// Tells the scripts of sensors that these have measured, in order.
    pub fn measured(world: &WorldCell, sensors: &[u32]) {
        if !Self::any_has(world, Callback::Measured) {
            return;
        }
        Self::each_called(world, |script| {
            let sensor = world.scene.try_borrow().ok().and_then(|scene| {
                let owner = scene.get(script.slot)?.parent;
                sensors.contains(&owner).then(|| scene.id(owner))
            });
            if let Some(sensor) = sensor {
                let payload = Value::Map(vec![(Value::text("sensor"), Value::Object(sensor))]);
                Self::with_payload(world, &payload, |p| script.run_if_begun(world, Callback::Measured, &[p]));
            }
        });
    }

    /// Asks the scripts that have a callback, in order or the other way round, until one answers with a map.
    pub fn ask(world: &WorldCell, callback: Callback, payload: &Value, last_first: bool) -> Option<Value> {
        let mut all = Self::in_order(world).to_vec();
        if last_first {
            all.reverse();
        }
        let mut answer = None;
        Self::with_payload(world, payload, |payload| {
            answer = all.iter().find_map(|script| {
                let number = script.number(callback);
                if number == 0 || !script.initialised.get() || !script.is_there(world) {
                    return None;
                }
                let answer = script.ask_callback(world, number, &[payload]);
                script.settle(world);
                answer.filter(|a| entry(a, "ignoreContact") != Some(&Value::Bool(true)))
            });
        });
        answer
    }

    /// Runs something with a value in the form that it has at the border.
    fn with_payload(world: &WorldCell, payload: &Value, f: impl FnOnce(tatu_value)) {
        let mark = world.calls.arena.borrow().mark();
        let raw = {
            let mut arena = world.calls.arena.borrow_mut();
            payload.to_raw(&mut |n| arena.alloc(n))
        };
        if let Some(raw) = raw {
            f(raw);
        }
        world.calls.arena.borrow_mut().release(mark);
    }

    /// Calls a callback by name in all scripts that have it, but one.
    pub fn broadcast(world: &WorldCell, name: &[u8], args: &[tatu_value], except: u32) {
        for script in &*Self::in_order(world) {
            if script.is_there(world) && script.slot != except && script.initialised.get() {
                let id = script.find(world, TATU_FIND_CALLBACK, name);
                if id != 0 {
                    script.callback_with(world, id, args);
                }
            }
        }
    }

    /// Ends the instances of scripts whose objects are gone.
    pub fn reap(world: &WorldCell) {
        let gone: Vec<Rc<Script>> = {
            let (Ok(mut scripts), Ok(scene)) = (world.scripts.try_borrow_mut(), world.scene.try_borrow()) else {
                return;
            };
            let is_there = |s: &Rc<Script>| matches!(scene.get(s.slot).map(|o| &o.data), Some(Data::Script));
            if scripts.list.iter().all(is_there) {
                return;
            }
            let (keep, gone) = std::mem::take(&mut scripts.list).into_iter().partition(is_there);
            (scripts.list, scripts.sorted_at) = (keep, 0);
            gone
        };
        for script in gone {
            // Its object is gone, its state is not yet: it may close its files.
            if script.initialised.get() && !script.dead.get() && !script.cleaned.get() && !script.data.get().is_null() {
                script.run_callback(world, script.number(Callback::Cleanup), &[]);
            }
            script.end(world);
        }
    }
}

impl Script {
    /// A script that has not begun; `dialect` is the one of scripts that name none.
    fn new(slot: u32, kind: Kind, spec: &ScriptSpec, dialect: String) -> Self {
        Script {
            slot,
            language: spec.language,
            kind,
            kind_name: spec.kind.clone(),
            priority: spec.priority,
            side_by_side: spec.side_by_side,
            name: spec.name.clone(),
            text: spec.text.clone().into(),
            // What comes from outside was not written for this scene.
            wanted_dialect: if spec.dialect.is_empty() && kind < Kind::Addon { dialect } else { spec.dialect.clone() },
            id: Cell::new(0),
            data: Cell::new(std::ptr::null_mut()),
            dialect: Cell::new(raw(&[])),
            traits: Cell::new(0),
            threaded: Cell::new(false),
            initialised: Cell::new(false),
            late: Cell::new(false),
            cleaned: Cell::new(false),
            ended: Cell::new(false),
            dead: Cell::new(false),
            called_in: Default::default(),
            depth: Cell::new(0),
            asked: Cell::new(Ask::Nothing),
            callbacks: Cell::new([0; CALLBACKS.len()]),
            calls: Cell::new(0),
            instructions: Cell::new(0),
            told: Told::default(),
        }
    }

    fn has_loaded(&self) -> bool {
        !self.data.get().is_null() && !self.dead.get()
    }

    /// The language's number for a callback; 0: it has none.
    fn number(&self, callback: Callback) -> u32 {
        self.callbacks.get()[callback as usize]
    }
}
