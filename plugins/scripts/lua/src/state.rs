//! What belongs to one script: its Lua state, and what the plugin knows about it.

use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
    ops::Deref,
};

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use crate::{
    alloc::{Slot, lua_alloc},
    budget, collect,
    errors::{self, Errors},
    files::Files,
    load::Text,
    lua_internals::NumberFormat,
    slices::Slices,
    stdlib::{self, Originals},
};

/// Places in Lua's registry. 1 and 2 are Lua's own.
pub(crate) mod reg {
    /// The compiled text of the script.
    pub const CHUNK: i64 = 10;
    /// Functions lent during a call: id -> function.
    pub const BORROWED: i64 = 11;
    /// Functions kept by the host: id -> function.
    pub const KEPT: i64 = 12;
    /// Coroutines that wait: token -> coroutine.
    pub const WAITS: i64 = 13;
    /// Results of waits that are over: token -> packed results.
    pub const DONE: i64 = 14;
    /// Numbers of what has been shown as text: object -> number.
    pub const NUMBERS: i64 = 15;
    /// Tables of command names: prefix -> table ("" is the one of the globals).
    pub const SCOPES: i64 = 16;
    /// Metatable of files.
    pub const FILE: i64 = 17;
    /// Coroutines of the plugin: coroutine -> true.
    pub const THREADS: i64 = 18;
    /// What `require` has loaded.
    pub const LOADED: i64 = 19;
    /// What was there before the text ran: number -> object.
    pub const FRESH: i64 = 20;
    /// Objects of a snapshot, while it is taken back.
    pub const BUILT: i64 = 21;
    /// Constants that preludes tell: name -> value.
    pub const CONSTANTS: i64 = 22;
    /// Names of the globals that tell a text which callback it runs for, and its script.
    pub const TOLD: i64 = 23;
}

/// The functions of the commands service that the bindings call.
#[derive(Clone, Copy)]
pub(crate) struct Commands {
    pub find: unsafe extern "C" fn(WorldPtr, tatu_str) -> u32,
    pub call: unsafe extern "C" fn(WorldPtr, *mut tatu_call) -> tatu_status,
    pub generation: unsafe extern "C" fn(WorldPtr) -> u64,
    pub constant: unsafe extern "C" fn(WorldPtr, tatu_str, *mut tatu_value) -> tatu_status,
    pub mark: unsafe extern "C" fn(WorldPtr) -> u64,
    pub alloc: unsafe extern "C" fn(WorldPtr, u64) -> *mut std::ffi::c_void,
    pub release: unsafe extern "C" fn(WorldPtr, u64),
    pub call_func: unsafe extern "C" fn(WorldPtr, tatu_func, *mut tatu_call) -> tatu_status,
}

/// A script's state. Its address stays: Lua keeps it in the extra space of every thread.
pub(crate) struct State {
    /// The main thread.
    pub main: *mut lua_State,
    /// The thread that runs now: where a call that comes in runs on.
    pub running: Cell<*mut lua_State>,
    pub world: *mut tatu_world,
    pub host: Host,
    pub instance: Instance,
    pub commands: Commands,
    pub time: Prop,
    /// The date of the start.
    pub epoch: Prop,
    /// Whether the state was restored, and no doubtful order of keys has been told since.
    pub restored: Cell<bool>,
    /// How many calls of the host have come in.
    pub entries: Cell<u64>,
    /// How many calls into the state are running.
    pub depth: Cell<u32>,
    /// The place in the world's arena at which the running call began.
    pub mark: Cell<u64>,
    /// Of the commands, when names were last bound.
    pub generation: Cell<u64>,
    pub budget: budget::State,
    /// The last token given to a call that may wait, and the thread of the last one that did.
    pub token: Cell<u64>,
    pub waiting: Cell<(u64, *mut lua_State)>,
    /// The last ids of lent and kept functions.
    pub borrowed: Cell<u32>,
    pub returned: Cell<u32>,
    pub kept: Cell<u32>,
    /// The last number given to something shown as text.
    pub numbers: Cell<i64>,
    /// Whether the text is of a dialect that ran on Lua 5.1.
    pub old: Cell<bool>,
    /// Whether numbers lose what a 32-bit float does not hold when they pass to commands and back.
    pub single: Cell<bool>,
    /// The running call is one of several that run side by side.
    pub beside: Cell<bool>,
    /// What the text speaks of, while it is loaded.
    pub words: RefCell<Vec<Vec<u8>>>,
    pub slices: Slices,
    pub errors: RefCell<Errors>,
    pub text: RefCell<Text>,
    /// Texts that the script loaded, chunk name and text, so that a snapshot can name their functions.
    pub texts: RefCell<Vec<(Vec<u8>, Vec<u8>)>>,
    pub files: RefCell<Files>,
    /// A line begun with `io.write`.
    pub line: RefCell<Vec<u8>>,
    /// Room for texts on their way into Lua.
    pub scratch: RefCell<Vec<u8>>,
    /// Library functions that ours call.
    pub originals: Originals,
    /// Failures of waits that coroutines have not seen yet.
    pub failed: RefCell<BTreeMap<u64, Fail>>,
    /// Where the script was when its memory was last used up: files and lines, innermost first.
    pub full_at: RefCell<Vec<(String, u64)>>,
    /// Whether a panic went through the state.
    pub broken: Cell<bool>,
    pub slot: Box<Slot>,
}

impl State {
    /// The world, as the safe door shows it.
    pub(crate) fn world(&self) -> World<'_> {
        // SAFETY: the world outlives its scripts, and every call here comes from a call of the host.
        unsafe { World::from_raw(self.world, &self.host) }
    }
    /// A log line.
    pub(crate) fn log(&self, level: u32, text: &[u8]) {
        self.world().log(level, text);
    }
    /// What clocks show since the start, s.
    pub(crate) fn now(&self) -> f64 {
        self.world().f64(0, self.time).unwrap_or(0.0)
    }

    /// Runs `f` on the running thread; a Lua error in it becomes a `Fail`. `f` keeps nothing with a destructor of its
    /// own across Lua functions that raise.
    pub(crate) fn protect(&self, f: &mut dyn FnMut(*mut lua_State)) -> Result {
        let l = self.running.get();
        let mut f = f;
        let _format = NumberFormat::begin(self.old.get());
        // SAFETY: the thread is the one that runs; its stack is left as it was found.
        unsafe {
            let top = lua_gettop(l);
            if lua_checkstack(l, 8) == 0 {
                return Err(Fail::with_code(TATU_ERR_SCRIPT, "stack overflow"));
            }
            lua_pushcclosure(l, errors::handler, 0);
            lua_pushcclosure(l, run, 0);
            lua_pushlightuserdata(l, (&raw mut f).cast());
            let status = lua_pcall(l, 1, 0, top + 1);
            let result = if status == LUA_OK { Ok(()) } else { Err(errors::take(self, l, status)) };
            lua_settop(l, top);
            result
        }
    }
}

/// The body of `protect`.
unsafe extern "C-unwind" fn run(l: *mut lua_State) -> i32 {
    let f = &mut *lua_touserdata(l, 1).cast::<&mut dyn FnMut(*mut lua_State)>();
    lua_settop(l, 0);
    f(l);
    0
}

/// The state that a thread belongs to.
///
/// # Safety
/// `l` is a thread of a state made here; the result is not used beyond the running call.
#[inline(always)]
pub(crate) unsafe fn of<'a>(l: *mut lua_State) -> &'a State {
    &**lua_getextraspace(l).cast::<*const State>()
}

/// One script: the instance of the language.
pub(crate) struct Script {
    state: Box<State>,
}

impl Deref for Script {
    type Target = State;
    fn deref(&self) -> &State {
        &self.state
    }
}

impl Script {
    pub(crate) fn new(host: &Host, world: &World<'_>, instance: Instance) -> Result<Self> {
        let commands =
            table(host).ok_or_else(|| Fail::unsupported("this host offers no commands, so scripts cannot run"))?;
        let slot = Slot::new(instance.seed);
        // SAFETY: the slot is boxed and outlives the state.
        let main = unsafe { lua_newstate(lua_alloc, (&raw const *slot).cast_mut().cast()) };
        if main.is_null() {
            return Err(Fail::new("no memory for a Lua state"));
        }
        let state = Box::new(State {
            main,
            running: Cell::new(main),
            world: world.raw(),
            host: *host,
            instance,
            commands,
            time: host.prop("scene.clock"),
            epoch: host.prop("scene.epoch"),
            restored: Cell::new(false),
            entries: Cell::new(0),
            depth: Cell::new(0),
            mark: Cell::new(0),
            generation: Cell::new(0),
            budget: budget::State::default(),
            token: Cell::new(0),
            waiting: Cell::new((0, std::ptr::null_mut())),
            borrowed: Cell::new(0),
            returned: Cell::new(0),
            kept: Cell::new(0),
            numbers: Cell::new(0),
            old: Cell::new(false),
            single: Cell::new(false),
            beside: Cell::new(false),
            words: RefCell::default(),
            slices: Slices::default(),
            errors: RefCell::default(),
            text: RefCell::default(),
            texts: RefCell::default(),
            files: RefCell::default(),
            line: RefCell::default(),
            scratch: RefCell::default(),
            originals: Originals::default(),
            failed: RefCell::default(),
            full_at: RefCell::default(),
            broken: Cell::new(false),
            slot,
        });
        // SAFETY: the box's content stays where it is; threads made later copy the main thread's extra space.
        unsafe { *lua_getextraspace(main).cast::<*const State>() = &raw const *state };
        state.slot.full.set(Some((errors::note_memory, (&raw const *state).cast())));
        let script = Script { state };
        // SAFETY: as below.
        unsafe { collect::open(main) };
        // SAFETY: runs in protected mode, on the new state's own stack.
        script.protect(&mut |l| unsafe {
            stdlib::open(l);
            crate::allow::open(l, &script);
        })?;
        // SAFETY: the main thread is idle.
        unsafe {
            budget::arm(main);
            script.budget.find_count(main);
        }
        Ok(script)
    }
}

impl Drop for Script {
    fn drop(&mut self) {
        let line = self.line.take();
        if !line.is_empty() {
            self.log(TATU_LOG_INFO, &line);
        }
        // In a slot all that Lua made vanishes with it; files are kept, and closed, outside of Lua.
        if !self.slot.is_mapped() {
            // SAFETY: the host ends an instance only when none of its calls runs.
            unsafe { lua_close(self.main) };
        }
    }
}

fn table(host: &Host) -> Option<Commands> {
    let t = host.commands_table()?;
    Some(Commands {
        find: t.find?,
        call: t.call?,
        generation: t.generation?,
        constant: t.constant?,
        mark: t.mark?,
        alloc: t.alloc?,
        release: t.release?,
        call_func: t.call_func?,
    })
}

/// A text at the border.
pub(crate) fn border(bytes: &[u8]) -> tatu_str {
    tatu_str { ptr: bytes.as_ptr().cast(), len: bytes.len() as u64 }
}

/// The bytes of the text or number at `idx`; numbers are turned into text there. Empty if it is neither.
///
/// # Safety
/// The slice lives as long as the value stays on the stack.
pub(crate) unsafe fn bytes<'a>(l: *mut lua_State, idx: i32) -> &'a [u8] {
    let mut len = 0;
    let ptr = lua_tolstring(l, idx, &mut len);
    if ptr.is_null() {
        return &[];
    }
    std::slice::from_raw_parts(ptr.cast(), len)
}

/// Pushes a text.
///
/// # Safety
/// One free place on the stack; may raise.
pub(crate) unsafe fn push(l: *mut lua_State, text: &[u8]) {
    lua_pushlstring(l, text.as_ptr().cast(), text.len());
}

/// Pushes the value of a registry place; its type.
///
/// # Safety
/// One free place on the stack.
pub(crate) unsafe fn registry(l: *mut lua_State, place: i64) -> i32 {
    lua_rawgeti(l, LUA_REGISTRYINDEX, place)
}

/// Pushes what stands in the state's scratch room.
///
/// # Safety
/// One free place on the stack; may raise.
pub(crate) unsafe fn push_scratch(l: *mut lua_State, s: &State) {
    let (ptr, len) = {
        let scratch = s.scratch.borrow();
        (scratch.as_ptr(), scratch.len())
    };
    lua_pushlstring(l, ptr.cast(), len);
}
