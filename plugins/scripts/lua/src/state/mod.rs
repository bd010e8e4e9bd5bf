//! The state of a script: its Lua state, and the plugin's data about the script.

pub(crate) mod account;
pub(crate) mod commands;
pub(crate) mod errors;
pub(crate) mod field_names;
pub(crate) mod files;
pub(crate) mod originals;
pub(crate) mod rerun;
pub(crate) mod slices;
pub(crate) mod text;

use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
};

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use crate::alloc::MemorySlot;
use account::CallBudget;
use commands::CommandService;
use errors::RecentErrors;
use files::OpenFiles;
use originals::WrappedFunctions;
use slices::TimeSlices;
use text::LoadedSource;

/// State of a script. Its address is stable, because every Lua thread stores it in its extra space.
pub(crate) struct ScriptState {
    pub threads: LuaThreads,
    pub border: HostBorder,
    pub clock: ClockProps,
    /// Whether the state has been restored and the warning about the order of keys has not been logged since then.
    pub restored: Cell<bool>,
    pub call: CallState,
    pub budget: CallBudget,
    pub waits: ThreadWaits,
    pub functions: FunctionIds,
    pub mode: NumberMode,
    pub sources: ScriptSources,
    pub slices: TimeSlices,
    pub failures: ScriptFailures,
    pub streams: ScriptStreams,
    /// Library functions that this plugin wraps.
    pub originals: WrappedFunctions,
    /// The Lua function that calls a function of another script; upvalue 1 is the function's id.
    pub foreign: lua_CFunction,
    pub slot: Box<MemorySlot>,
}

/// Threads of the Lua state.
pub(crate) struct LuaThreads {
    /// The main thread of the Lua state.
    pub main: *mut lua_State,
    /// The running thread, which also runs nested calls.
    pub running: Cell<*mut lua_State>,
}

/// The interface to the host: the world, the plugin's instance, and the host's functions.
pub(crate) struct HostBorder {
    pub world: *mut tatu_world,
    pub host: Host,
    pub instance: Instance,
    pub commands: CommandService,
    /// The generation of the host's commands for which the name caches are valid.
    pub generation: Cell<u64>,
}

/// The properties from which scripts read the time.
pub(crate) struct ClockProps {
    pub time: Prop,
    /// The start date of the run.
    pub epoch: Prop,
}

/// The running call of the host.
pub(crate) struct CallState {
    /// Number of calls from the host.
    pub entries: Cell<u64>,
    /// Nesting depth of calls into the state.
    pub depth: Cell<u32>,
    /// Position in the world's arena at which the running call began.
    pub arena_mark: Cell<u64>,
    /// Whether the running call is one of several parallel ones.
    pub parallel: Cell<bool>,
}

/// State of the threads that wait in commands.
pub(crate) struct ThreadWaits {
    /// The last token issued, and the token and thread of the last wait.
    pub token: Cell<u64>,
    pub waiting: Cell<(u64, *mut lua_State)>,
    /// Errors with which waits have ended, by token, until the waiting coroutines receive them.
    pub wait_errors: RefCell<BTreeMap<u64, Fail>>,
}

/// The last numbers that were assigned to functions and objects.
pub(crate) struct FunctionIds {
    /// The last id of a borrowed function; the last such id that has been released; and the last id of a kept function.
    pub last_borrowed: Cell<u32>,
    pub released: Cell<u32>,
    pub last_kept: Cell<u32>,
    /// The last number that was assigned to an object in place of its address.
    pub numbers: Cell<i64>,
}

/// How numbers are treated, which depends on the dialect.
pub(crate) struct NumberMode {
    /// Whether the dialect is based on Lua 5.1.
    pub old: Cell<bool>,
    /// Whether numbers are rounded to 32-bit floats when passed to commands.
    pub single: Cell<bool>,
}

/// The source of the script, and the sources that the script itself has loaded.
pub(crate) struct ScriptSources {
    /// Names and operators in the script's source, while it is loaded.
    pub source_words: RefCell<Vec<Vec<u8>>>,
    pub text: RefCell<LoadedSource>,
    /// Sources that the script loaded (chunk name, source), so that a snapshot can refer to their functions.
    pub loaded_sources: RefCell<Vec<(Vec<u8>, Vec<u8>)>>,
}

/// Open files, and text that is being written.
pub(crate) struct ScriptStreams {
    pub files: RefCell<OpenFiles>,
    /// Incomplete line written with `io.write`.
    pub line: RefCell<Vec<u8>>,
    /// Buffer for text that is passed to Lua.
    pub scratch: RefCell<Vec<u8>>,
}

/// Errors of the script, and where memory ran out.
pub(crate) struct ScriptFailures {
    pub errors: RefCell<RecentErrors>,
    /// Files and lines at which memory last ran out, innermost first.
    pub memory_positions: RefCell<Vec<(String, u64)>>,
    /// Whether a panic has unwound through the state.
    pub has_panicked: Cell<bool>,
}

impl ScriptState {
    /// Returns the world to which the script belongs.
    pub(crate) fn world(&self) -> World<'_> {
        // SAFETY: the world outlives its scripts, and the host calls a script only on the thread that may use the
        // world; all callers run inside such a call.
        unsafe { World::new(self.border.world, &self.border.host) }
    }
    /// Returns the world in the form that functions of the host accept.
    #[inline]
    pub(crate) fn world_ref(&self) -> WorldRef<'_> {
        self.world().raw()
    }
    /// Writes a line to the world's log, at a `TATU_LOG_*` level.
    pub(crate) fn log(&self, level: u32, text: &[u8]) {
        self.world().log(level, text);
    }
    /// Logs a line of `print`, preceded by an incomplete line of `io.write`.
    pub(crate) fn log_line(&self, text: &[u8]) {
        let mut line = self.streams.line.take();
        if line.is_empty() {
            return self.log(TATU_LOG_INFO, text);
        }
        line.extend_from_slice(text);
        self.log(TATU_LOG_INFO, &line);
    }
    /// Logs the incomplete line of `io.write`, if there is one.
    pub(crate) fn end_line(&self) {
        let line = self.streams.line.take();
        if !line.is_empty() {
            self.log(TATU_LOG_INFO, &line);
        }
    }
    /// Returns the simulation time, s.
    pub(crate) fn now(&self) -> f64 {
        self.world().f64(0, self.clock.time).unwrap_or(0.0)
    }
}

/// Returns the state to which a thread belongs.
///
/// # Safety
/// `l` must be a thread of a state created by this plugin; the reference must not be used after the running call.
#[inline(always)]
pub(crate) unsafe fn of<'a>(l: *mut lua_State) -> &'a ScriptState {
    &**lua_getextraspace(l).cast::<*const ScriptState>()
}

/// Pushes the content of the scratch buffer.
///
/// # Safety
/// The stack must have one free slot. May raise a Lua error.
pub(crate) unsafe fn push_scratch(l: *mut lua_State, s: &ScriptState) {
    let (ptr, len) = {
        let scratch = s.streams.scratch.borrow();
        (scratch.as_ptr(), scratch.len())
    };
    lua_pushlstring(l, ptr.cast(), len);
}

/// Returns the module names and sources of all preludes.
pub(crate) fn preludes(s: &ScriptState) -> impl Iterator<Item = (&[u8], &[u8])> {
    let next = s.border.host.commands_table().and_then(|t| t.prelude);
    (0..).map_while(move |index| {
        let (mut module, mut text) = (Lent::EMPTY, Lent::EMPTY);
        let status = next?(s.world_ref(), c"lua".into(), index, Some(&mut module), Some(&mut text));
        (status == TATU_OK).then(|| (module.bytes(), text.bytes()))
    })
}
