//! The scripts of a world, and the state that the host stores for each of them.

use std::{
    cell::{Cell, RefCell},
    ffi::c_void,
    rc::Rc,
};

use tatu_plugin_api::abi::*;
use tatu_plugins::{border::raw, state_block::StateBlock};
use tatu_scene::document::ScriptSpec;

use crate::cell::{
    scripts::counts::CallCounts,
    scripts::kinds::{CALLBACKS, Callback, CallbackIds, ScriptKind, ScriptOrder},
};

/// A script. The state of main and child scripts exists from start to stop, and that of other scripts as long as the
/// world.
pub(crate) struct Script {
    pub slot: u32,
    pub language: usize,
    pub kind: ScriptKind,
    /// Name of the kind, as in documents.
    pub kind_name: String,
    /// Rank among the scripts of an object or of siblings, from 0, which is called first, to 2.
    pub priority: u8,
    /// Whether the scene allows it to run in parallel with others.
    pub side_by_side: bool,
    /// Name for messages: its file, if it has one.
    pub name: String,
    pub text: Rc<[u8]>,
    pub wanted_dialect: String,
    pub instance: LanguageInstance,
    pub progress: ScriptProgress,
    pub counters: ScriptCounters,
    /// Number of running calls into the script.
    pub depth: Cell<u32>,
}

/// A script's instance in its language's plugin, and what the language reported.
pub(crate) struct LanguageInstance {
    /// Instance id, or 0 if there is no instance.
    pub id: Cell<u64>,
    pub data: Cell<*mut c_void>,
    /// The state block that the language writes to.
    pub state: RefCell<StateBlock>,
    /// The chosen dialect. The string is owned by the instance.
    pub dialect: Cell<tatu_str>,
    /// The `TATU_SCRIPT_*` flags that its language reported.
    pub traits: Cell<u32>,
    /// Whether it is a threaded script, as reported by its language.
    pub threaded: Cell<bool>,
    pub callbacks: Cell<CallbackIds>,
}

/// The stages of its life that a script has reached.
pub(crate) struct ScriptProgress {
    pub initialised: Cell<bool>,
    /// Whether it was added while the world was running. Such a script is called after all others until it has begun.
    pub late: Cell<bool>,
    /// Whether its `cleanup` callback has been called.
    pub cleaned: Cell<bool>,
    /// Whether it requested its own end.
    pub ended: Cell<bool>,
    /// Whether it is no longer called: its source could not be loaded, it exceeded its budget, or it failed and is
    /// silenced.
    pub dead: Cell<bool>,
    /// The request of the script, which is carried out when no call into the script is running.
    pub exit_request: Cell<ExitRequest>,
}

/// How often a script was called, and what it consumed.
pub(crate) struct ScriptCounters {
    /// The numbers of the actuation and sensing turns in which it was last called.
    pub called_in: [Cell<u64>; 2],
    pub calls: Cell<u64>,
    pub instructions: Cell<u64>,
    pub call_counts: CallCounts,
}

/// All scripts of a world.
#[derive(Default)]
pub(crate) struct Scripts {
    /// All scripts, in the order in which they were added.
    pub list: Vec<Rc<Script>>,
    /// All scripts in calling order, as of the version `sorted_at` of the tree.
    pub sorted: Rc<[Rc<Script>]>,
    /// Version of the tree for which `sorted` is valid, or 0 if `sorted` must be rebuilt.
    pub sorted_at: u64,
    /// Number of times that the actuation and sensing stages have begun.
    pub turns: [Cell<u64>; 2],
    pub order: ScriptOrder,
}

/// A request that ends a script, from the weakest to the strongest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum ExitRequest {
    Nothing,
    /// The script failed: it is cleaned up and no longer called.
    Silence,
    Restart,
    End,
}

impl Scripts {
    /// Returns the script with an instance id.
    pub fn by_id(&self, id: u64) -> Option<Rc<Script>> {
        self.list.iter().find(|s| id != 0 && s.instance.id.get() == id).cloned()
    }
    /// Returns the script of a slot.
    pub fn by_slot(&self, slot: u32) -> Option<Rc<Script>> {
        self.list.iter().find(|s| s.slot == slot).cloned()
    }
}

impl Script {
    /// Creates a script that has not begun. `dialect` is the default for scripts whose specification has no dialect.
    pub fn new(slot: u32, kind: ScriptKind, spec: &ScriptSpec, dialect: String) -> Self {
        Script {
            slot,
            language: spec.language,
            kind,
            kind_name: spec.kind.clone(),
            priority: spec.priority,
            side_by_side: spec.side_by_side,
            name: spec.name.clone(),
            text: spec.text.clone().into(),
            // Scripts that are not part of the document were not written for this scene, so its default does not apply
            // to them.
            wanted_dialect: if spec.dialect.is_empty() && kind < ScriptKind::Addon {
                dialect
            } else {
                spec.dialect.clone()
            },
            instance: LanguageInstance {
                id: Cell::new(0),
                data: Cell::new(std::ptr::null_mut()),
                state: RefCell::new(StateBlock::new(0)),
                dialect: Cell::new(raw(&[])),
                traits: Cell::new(0),
                threaded: Cell::new(false),
                callbacks: Cell::new([0; CALLBACKS.len()]),
            },
            progress: ScriptProgress {
                initialised: Cell::new(false),
                late: Cell::new(false),
                cleaned: Cell::new(false),
                ended: Cell::new(false),
                dead: Cell::new(false),
                exit_request: Cell::new(ExitRequest::Nothing),
            },
            counters: ScriptCounters {
                called_in: Default::default(),
                calls: Cell::new(0),
                instructions: Cell::new(0),
                call_counts: CallCounts::default(),
            },
            depth: Cell::new(0),
        }
    }

    pub fn has_loaded(&self) -> bool {
        !self.instance.data.get().is_null() && !self.progress.dead.get()
    }

    /// Returns the language's id of a callback, or 0 if the script does not define it.
    pub fn number(&self, callback: Callback) -> u32 {
        self.instance.callbacks.get()[callback as usize]
    }
}
