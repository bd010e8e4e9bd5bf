//! Scripts: their states, callbacks, waits and functions.
//!
//! - [`Scripts`]: the world's scripts and the order in which they are called;
//! - `script`: one script's callbacks and waits;
//! - `enter`: one way into a script's language, with budget, caller and errors;
//! - `reload`: another text in place of one that runs;
//! - `state`: scripts in snapshots.

mod enter;
mod reload;
mod script;
mod state;
mod told;

use std::{cell::Cell, ffi::c_void, rc::Rc};

use tatu_plugin_api::abi::*;

pub(crate) use enter::{Room, call_func, call_function, drop_func, keep_func};
pub(crate) use reload::{Handed, Written};
pub use told::ScriptTold;
use told::Told;

use crate::{calls::raw, document::ScriptSpec, scene::Data, world::WorldCell};

/// One script. Its instance exists while the world runs.
pub(crate) struct Script {
    pub slot: u32,
    pub language: usize,
    pub kind: String,
    /// For messages: its file, if it has one.
    pub name: String,
    text: Rc<[u8]>,
    wanted_dialect: String,
    /// Instance number; 0: not made.
    pub id: Cell<u64>,
    data: Cell<*mut c_void>,
    /// The dialect chosen; owned by the instance.
    pub dialect: Cell<tatu_str>,
    initialised: Cell<bool>,
    /// Its text could not be loaded, or it used up its budget.
    dead: Cell<bool>,
    callbacks: Cell<Callbacks>,
    pub calls: Cell<u64>,
    pub instructions: Cell<u64>,
    told: Told,
}

/// The language's numbers for a script's callbacks; 0: it has none.
#[derive(Clone, Copy, Default)]
struct Callbacks {
    actuation: u32,
    sensing: u32,
    cleanup: u32,
    thread: u32,
}

/// All scripts of a world, in the order in which they are called.
#[derive(Default)]
pub(crate) struct Scripts {
    list: Vec<Rc<Script>>,
}

impl Scripts {
    /// Takes the scripts of the document: each becomes an object that belongs to its owner.
    pub fn declare(world: &WorldCell, slots: &[u32]) {
        for (spec, owner) in world.document.objects.iter().zip(slots) {
            for s in &spec.scripts {
                let local = nalgebra::Isometry3::identity();
                let Some(slot) = world.scene.borrow_mut().add(*owner, "script", local, Data::Script) else { continue };
                let default = world.settings.borrow().dialect.clone();
                world.scripts.borrow_mut().list.push(Rc::new(Script::new(slot, s, default)));
            }
        }
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

    /// Makes the states of all scripts and loads their texts.
    pub fn begin(world: &WorldCell) {
        let mut i = 0;
        while let Some(script) = Self::nth(world, i) {
            i += 1;
            script.begin(world);
        }
    }

    /// Actuation: a script that is new is initialised first; waits that are over go on before its own callback.
    pub fn actuate(world: &WorldCell) {
        Self::each_called(world, |script| {
            if !script.initialised.get() {
                script.initialise(world);
            }
            script.resume_waits(world);
            script.callback(world, script.callbacks.get().actuation);
        });
    }

    /// Sensing.
    pub fn react(world: &WorldCell) {
        Self::each_called(world, |script| {
            if !script.initialised.get() {
                script.initialise(world);
            }
            script.callback(world, script.callbacks.get().sensing);
        });
    }

    /// The script that runs the stages itself, if the world has one.
    pub fn driver(world: &WorldCell) -> Option<Rc<Script>> {
        world.scripts.try_borrow().ok()?.list.iter().find(|s| s.is_driver()).cloned()
    }

    /// All scripts that stages call, in order; the list may grow meanwhile. The driver calls, and is not called.
    fn each_called(world: &WorldCell, f: impl Fn(&Rc<Script>)) {
        Self::each(world, |script| {
            if !script.is_driver() {
                f(script);
            }
        });
    }

    /// All scripts that are there, in order; the list may grow meanwhile.
    fn each(world: &WorldCell, f: impl Fn(&Rc<Script>)) {
        let mut i = 0;
        while let Some(script) = Self::nth(world, i) {
            i += 1;
            if script.is_there(world) {
                f(&script);
            }
        }
    }

    /// Calls a callback by name in all scripts that have it, but one.
    pub fn broadcast(world: &WorldCell, name: &[u8], args: &[tatu_value], except: u32) {
        Self::each(world, |script| {
            if script.slot != except && script.initialised.get() {
                let id = script.find(world, TATU_FIND_CALLBACK, name);
                if id != 0 {
                    script.callback_with(world, id, args);
                }
            }
        });
    }

    /// Ends the instances of scripts whose objects are gone.
    pub fn reap(world: &WorldCell) {
        let gone: Vec<Rc<Script>> = {
            let (Ok(mut scripts), Ok(scene)) = (world.scripts.try_borrow_mut(), world.scene.try_borrow()) else {
                return;
            };
            if scripts.list.iter().all(|s| scene.get(s.slot).is_some()) {
                return;
            }
            let (keep, gone) = std::mem::take(&mut scripts.list).into_iter().partition(|s| scene.get(s.slot).is_some());
            scripts.list = keep;
            gone
        };
        for script in gone {
            // Its object is gone, its state is not yet: it may close its files.
            if script.initialised.get() && !script.dead.get() && !script.data.get().is_null() {
                script.run_callback(world, script.callbacks.get().cleanup, &[]);
            }
            script.end(world);
        }
    }

    /// Clean-up of all, then the end of their states.
    pub fn end(world: &WorldCell) {
        Self::each(world, |script| {
            if script.initialised.get() {
                script.callback(world, script.callbacks.get().cleanup);
            }
        });
        let mut i = 0;
        while let Some(script) = Self::nth(world, i) {
            i += 1;
            script.end(world);
        }
    }
}

impl Script {
    /// A script that has not begun; `dialect` is the one of scripts that name none.
    fn new(slot: u32, spec: &ScriptSpec, dialect: String) -> Self {
        Script {
            slot,
            language: spec.language,
            kind: spec.kind.clone(),
            name: spec.name.clone(),
            text: spec.text.clone().into(),
            wanted_dialect: if spec.dialect.is_empty() { dialect } else { spec.dialect.clone() },
            id: Cell::new(0),
            data: Cell::new(std::ptr::null_mut()),
            dialect: Cell::new(raw(&[])),
            initialised: Cell::new(false),
            dead: Cell::new(false),
            callbacks: Cell::default(),
            calls: Cell::new(0),
            instructions: Cell::new(0),
            told: Told::default(),
        }
    }
}
