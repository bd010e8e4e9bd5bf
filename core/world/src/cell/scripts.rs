//! The scripts of a world: what is kept of each.

use std::{cell::Cell, ffi::c_void, rc::Rc};

use tatu_plugin_api::abi::*;
use tatu_plugins::border::raw;
use tatu_scene::document::ScriptSpec;

use super::{
    script_counts::CallCounts,
    script_kinds::{CALLBACKS, Callback, CallbackIds, Kind, Order},
};

/// One script. The state of a child script exists while the world runs, that of others as long as the world.
pub(crate) struct Script {
    pub slot: u32,
    pub language: usize,
    pub kind: Kind,
    /// The same as text.
    pub kind_name: String,
    /// Among scripts of one object, or of siblings: 0 first, 1, 2 last.
    pub priority: u8,
    /// The scene lets it run beside others.
    pub side_by_side: bool,
    /// For messages: its file, if it has one.
    pub name: String,
    pub text: Rc<[u8]>,
    pub wanted_dialect: String,
    /// Instance number; 0: not made.
    pub id: Cell<u64>,
    pub data: Cell<*mut c_void>,
    /// The dialect chosen; owned by the instance.
    pub dialect: Cell<tatu_str>,
    /// `TATU_SCRIPT_*`, from its language.
    pub traits: Cell<u32>,
    /// Runs as a thread by itself.
    pub threaded: Cell<bool>,
    pub initialised: Cell<bool>,
    /// It was added while the world ran: until it has begun it comes after all others.
    pub late: Cell<bool>,
    /// It had its clean-up.
    pub cleaned: Cell<bool>,
    /// It ended itself.
    pub ended: Cell<bool>,
    /// Its text could not be loaded, it used up its budget, or it failed and is silent from then on.
    pub dead: Cell<bool>,
    /// Of actuation and of sensing: the turn in which it was called last.
    pub called_in: [Cell<u64>; 2],
    /// Calls into it that are running.
    pub depth: Cell<u32>,
    /// What it asked for, to be done when no call of it runs any more.
    pub asked: Cell<ExitRequest>,
    pub callbacks: Cell<CallbackIds>,
    pub calls: Cell<u64>,
    pub instructions: Cell<u64>,
    pub told: CallCounts,
}

/// All scripts of a world.
#[derive(Default)]
pub(crate) struct Scripts {
    /// In the order in which they were added.
    pub list: Vec<Rc<Script>>,
    /// In the order in which they are called, as of this version of the tree; 0: to be rebuilt.
    pub sorted: Rc<[Rc<Script>]>,
    pub sorted_at: u64,
    /// How often the stages of actuation and of sensing have begun.
    pub turns: [Cell<u64>; 2],
    pub order: Order,
}

/// What a script has asked for, the weightiest last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum ExitRequest {
    Nothing,
    /// It failed: its clean-up, and nothing more.
    Silence,
    Restart,
    End,
}

impl Scripts {
    /// A script by its instance.
    pub fn by_id(&self, id: u64) -> Option<Rc<Script>> {
        self.list.iter().find(|s| id != 0 && s.id.get() == id).cloned()
    }
    /// A script by its object.
    pub fn by_slot(&self, slot: u32) -> Option<Rc<Script>> {
        self.list.iter().find(|s| s.slot == slot).cloned()
    }
}

impl Script {
    /// A script that has not begun; `dialect` is the one of scripts that name none.
    pub fn new(slot: u32, kind: Kind, spec: &ScriptSpec, dialect: String) -> Self {
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
            asked: Cell::new(ExitRequest::Nothing),
            callbacks: Cell::new([0; CALLBACKS.len()]),
            calls: Cell::new(0),
            instructions: Cell::new(0),
            told: CallCounts::default(),
        }
    }

    pub fn has_loaded(&self) -> bool {
        !self.data.get().is_null() && !self.dead.get()
    }

    /// The language's number for a callback; 0: it has none.
    pub fn number(&self, callback: Callback) -> u32 {
        self.callbacks.get()[callback as usize]
    }
}
