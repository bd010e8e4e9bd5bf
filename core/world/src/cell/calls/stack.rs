//! The call stack of a world: the current caller, the depth, and the values in the arena.
//!
//! No Rust borrow of the world is held while a plugin runs, because a command may call a script that calls the same
//! command.

use std::{
    cell::{Cell, RefCell},
    collections::BTreeSet,
};

use tatu_plugin_api::abi::*;
use tatu_plugins::border::ErrorSlot;

use crate::cell::{Arena, GuardedResultBuffer, ThreadResults, WaitList, calls::cost::CommandCost};

/// Maximum depth of nested calls across the plugin ABI.
pub const MAX_DEPTH: u32 = 64;

/// The call stack of a world, with what its calls share.
pub(crate) struct CallStack {
    pub arena: RefCell<Arena>,
    /// Mark of the arena at which the running call into a script or service began; the blocks since then contain the
    /// arguments of the commands that it calls.
    pub args_mark: Cell<u64>,
    /// The current caller.
    pub caller: Cell<Caller>,
    pub depth: Cell<u32>,
    /// The work of the commands that the running script calls.
    pub cost: CommandCost,
    /// Number of calls into scripts that are running, each nested in the one before.
    pub scripts: Cell<u32>,
    /// Error objects, one per depth, created when first needed; their addresses are stable.
    slots: RefCell<Vec<ErrorSlot>>,
    /// Space for results, one per depth, created when first needed.
    results: RefCell<Vec<GuardedResultBuffer>>,
    /// Status and message with which a host function last refused a call.
    pub last_refusal: RefCell<ErrorSlot>,
    pub waits: RefCell<WaitList>,
    /// The results of plugins' own threads for which commands wait.
    pub thread_results: ThreadResults,
    /// Error message of the last failed command, and the id of its plugin. A script can pass the message on as its own
    /// error.
    pub blame: RefCell<Option<(String, String)>>,
    /// Ids of the stub commands that have been reported.
    pub stubs: RefCell<BTreeSet<u32>>,
    /// The slots of scripts that only they themselves and the host may see.
    pub sealed: RefCell<Vec<u32>>,
}

/// The caller of a command or host function. The host fills it in from its own stack and ignores values that plugins
/// write.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Caller {
    pub kind: u32,
    pub instance: u64,
    pub object: tatu_object,
    pub script: tatu_object,
    pub dialect: tatu_str,
    /// The service on whose behalf the call is made, counted from 1; 0 if there is none.
    pub service: u32,
}

impl Caller {
    pub const HOST: Caller = Caller {
        kind: TATU_CALLER_HOST,
        instance: 0,
        object: 0,
        script: 0,
        dialect: tatu_str { ptr: std::ptr::null(), len: 0 },
        service: 0,
    };

    /// Returns the caller that represents the service with this number in the session, counted from 1.
    pub fn remote(service: u32) -> Caller {
        Caller { kind: TATU_CALLER_REMOTE, service, ..Caller::HOST }
    }
}

impl CallStack {
    pub fn new() -> Self {
        CallStack {
            arena: RefCell::new(Arena::default()),
            args_mark: Cell::new(0),
            caller: Cell::new(Caller::HOST),
            depth: Cell::new(0),
            cost: CommandCost::default(),
            scripts: Cell::new(0),
            slots: RefCell::new(Vec::new()),
            results: RefCell::new(Vec::new()),
            last_refusal: RefCell::new(ErrorSlot::new()),
            waits: RefCell::new(WaitList::default()),
            thread_results: ThreadResults::default(),
            blame: RefCell::new(None),
            stubs: RefCell::new(BTreeSet::new()),
            sealed: RefCell::new(Vec::new()),
        }
    }

    /// Clears the error object of a call depth, and returns it.
    pub fn error_at(&self, depth: u32) -> *mut tatu_error {
        let mut slots = self.slots.borrow_mut();
        while slots.len() <= depth as usize {
            slots.push(ErrorSlot::new());
        }
        slots[depth as usize].reset()
    }

    /// Returns the space for the results of a command at a call depth.
    #[inline]
    pub fn results_at(&self, depth: u32) -> *mut tatu_value {
        let mut results = self.results.borrow_mut();
        while results.len() <= depth as usize {
            results.push(GuardedResultBuffer::new());
        }
        results[depth as usize].first()
    }

    /// Enters a call across the plugin ABI. Returns `None` if [`MAX_DEPTH`] is reached.
    pub fn enter(&self) -> Option<CallLevel<'_>> {
        let depth = self.depth.get();
        if depth >= MAX_DEPTH {
            return None;
        }
        self.depth.set(depth + 1);
        Some(CallLevel { calls: self, depth, caller: self.caller.get() })
    }

    /// Returns whether a slot is that of a script which the current caller must not see.
    pub fn hides(&self, slot: u32) -> bool {
        let caller = self.caller.get();
        caller.kind != TATU_CALLER_HOST
            && tatu_slot(caller.script) != slot
            && self.sealed.try_borrow().is_ok_and(|all| all.contains(&slot))
    }

    /// Returns whether the current caller is a referee.
    pub fn is_by_referee(&self) -> bool {
        let slot = tatu_slot(self.caller.get().script);
        self.sealed.try_borrow().is_ok_and(|all| all.contains(&slot))
    }

    /// Records why a host function was refused, and returns the status.
    #[cold]
    pub fn refuse(&self, status: tatu_status, text: &str) -> tatu_status {
        if let Ok(mut last) = self.last_refusal.try_borrow_mut() {
            last.set(status, text);
        }
        status
    }
}

/// A call across the ABI. Dropping it restores the depth and the caller.
pub(crate) struct CallLevel<'a> {
    calls: &'a CallStack,
    /// Depth of this call, counted from 0.
    pub depth: u32,
    /// The previous caller.
    pub caller: Caller,
}

impl Drop for CallLevel<'_> {
    fn drop(&mut self) {
        self.calls.depth.set(self.depth);
        self.calls.caller.set(self.caller);
    }
}
