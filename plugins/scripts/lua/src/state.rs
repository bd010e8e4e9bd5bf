//! The state of one script: its Lua state, and what the plugin keeps about it.

use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
    ops::Deref,
};

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use crate::{
    alloc::{Slot, lua_alloc},
    budget,
    errors::{self, Errors},
    files::Files,
    gc,
    load::Text,
    lua_internals::{NumberFormat, Running},
    stdlib::{self, Originals},
    time_slices::Slices,
};

/// Keys in Lua's registry; 1 and 2 are reserved by Lua.
pub(crate) mod reg {
    /// The compiled text.
    pub const CHUNK: i64 = 10;
    /// Functions passed out during a call: id -> function.
    pub const BORROWED: i64 = 11;
    /// Functions kept by the host: id -> function.
    pub const KEPT: i64 = 12;
    /// Waiting coroutines: token -> coroutine.
    pub const WAITS: i64 = 13;
    /// Results of finished waits: token -> packed results.
    pub const DONE: i64 = 14;
    /// Numbers that stand for addresses in text: object -> number.
    pub const NUMBERS: i64 = 15;
    /// Name space tables: prefix -> table ("" for the globals).
    pub const SCOPES: i64 = 16;
    /// Metatable of files.
    pub const FILE: i64 = 17;
    /// Coroutines created by the plugin: coroutine -> true.
    pub const THREADS: i64 = 18;
    /// Modules loaded by `require`.
    pub const LOADED: i64 = 19;
    /// Objects that existed before the text ran: number -> object.
    pub const BASELINE: i64 = 20;
    /// Objects of a snapshot, while it is restored.
    pub const BUILT: i64 = 21;
    /// Constants of preludes: name -> value.
    pub const CONSTANTS: i64 = 22;
    /// Names of the globals that a rerun text reads: the callback, and the script's handle.
    pub const RERUN_GLOBALS: i64 = 23;
}

/// Functions of the commands service.
#[derive(Clone, Copy)]
pub(crate) struct Commands {
    find: extern "C" fn(WorldRef<'_>, Lent<'_>, Option<&mut u32>) -> u32,
    pub is_name_space: extern "C" fn(WorldRef<'_>, Lent<'_>) -> u32,
    pub call: unsafe extern "C" fn(WorldRef<'_>, *mut tatu_call) -> tatu_status,
    pub generation: extern "C" fn(WorldRef<'_>) -> u64,
    pub constant: for<'a> extern "C" fn(WorldRef<'a>, Lent<'_>, Option<&mut ValueRef<'a>>) -> tatu_status,
    pub mark: extern "C" fn(WorldRef<'_>) -> u64,
    pub alloc: extern "C" fn(WorldRef<'_>, u64) -> *mut std::ffi::c_void,
    pub release: unsafe extern "C" fn(WorldRef<'_>, u64),
    pub call_func: unsafe extern "C" fn(WorldRef<'_>, tatu_func, *mut tatu_call) -> tatu_status,
}

impl Commands {
    /// Id and alias of a name, in the one number that a bound function keeps: id << 8 | alias; 0: no such command. A command
    /// has at most 255 names.
    pub fn number(&self, world: WorldRef<'_>, name: &[u8]) -> u32 {
        let mut alias = 0;
        match (self.find)(world, name.into(), Some(&mut alias)) {
            0 => 0,
            id => id << 8 | alias,
        }
    }
}

/// State of a script. Its address is stable: every Lua thread stores it in its extra space.
pub(crate) struct State {
    /// The main thread.
    pub main: *mut lua_State,
    /// The running thread, on which nested calls run.
    pub running: Cell<*mut lua_State>,
    world: *mut tatu_world,
    pub host: Host,
    pub instance: Instance,
    pub commands: Commands,
    pub time: Prop,
    /// The start date of the run.
    pub epoch: Prop,
    /// Whether the state was restored and no warning about key order has been logged since.
    pub restored: Cell<bool>,
    /// Number of calls from the host.
    pub entries: Cell<u64>,
    /// Nesting depth of calls into the state.
    pub depth: Cell<u32>,
    /// Position in the world's arena at which the running call began.
    pub mark: Cell<u64>,
    /// Generation of the commands for which the name caches are valid.
    pub generation: Cell<u64>,
    pub budget: budget::State,
    /// The last token issued, and the thread of the last wait.
    pub token: Cell<u64>,
    pub waiting: Cell<(u64, *mut lua_State)>,
    /// The last ids of borrowed and kept functions.
    pub borrowed: Cell<u32>,
    pub returned: Cell<u32>,
    pub kept: Cell<u32>,
    /// The last number issued in place of an address.
    pub numbers: Cell<i64>,
    /// Whether the dialect is based on Lua 5.1.
    pub old: Cell<bool>,
    /// Whether numbers are rounded to 32-bit floats at commands.
    pub single: Cell<bool>,
    /// Whether the running call is one of several parallel ones.
    pub parallel: Cell<bool>,
    /// Names and operators in the text, while it is loaded.
    pub words: RefCell<Vec<Vec<u8>>>,
    pub slices: Slices,
    pub errors: RefCell<Errors>,
    pub text: RefCell<Text>,
    /// Texts that the script loaded (chunk name, text), so that a snapshot can refer to their functions.
    pub texts: RefCell<Vec<(Vec<u8>, Vec<u8>)>>,
    pub files: RefCell<Files>,
    /// Line begun with `io.write`.
    pub line: RefCell<Vec<u8>>,
    /// Buffer for text on its way into Lua.
    pub scratch: RefCell<Vec<u8>>,
    /// Library functions that this plugin wraps.
    pub originals: Originals,
    /// Errors of waits that their coroutines have not received yet.
    pub failed: RefCell<BTreeMap<u64, Fail>>,
    /// Files and lines at which memory last ran out, innermost first.
    pub memory_positions: RefCell<Vec<(String, u64)>>,
    /// Whether a panic unwound through the state.
    pub broken: Cell<bool>,
    pub slot: Box<Slot>,
}

impl State {
    /// The world, as the safe API shows it.
    pub(crate) fn world(&self) -> World<'_> {
        // SAFETY: the world outlives its scripts, and every call here comes from a call of the host.
        unsafe { World::new(self.world, &self.host) }
    }
    /// The same as functions of the host get it.
    #[inline]
    pub(crate) fn world_ref(&self) -> WorldRef<'_> {
        self.world().raw()
    }
    /// Writes a log line.
    pub(crate) fn log(&self, level: u32, text: &[u8]) {
        self.world().log(level, text);
    }
    /// Simulation time, s.
    pub(crate) fn now(&self) -> f64 {
        self.world().f64(0, self.time).unwrap_or(0.0)
    }

    /// Runs `f` in protected mode on the running thread; a Lua error becomes a `Fail`. `f` must not keep anything with
    /// a destructor across Lua functions that raise.
    pub(crate) fn protect(&self, f: &mut dyn FnMut(*mut lua_State)) -> Result {
        let l = self.running.get();
        let mut f = f;
        let _format = NumberFormat::begin(self.old.get());
        // SAFETY: this is the running thread, and its stack is restored to `top`.
        unsafe {
            let _running = Running::begin(l);
            let top = lua_gettop(l);
            if lua_checkstack(l, 8) == 0 {
                return Err(Fail::with_code(TATU_ERR_SCRIPT, "stack overflow"));
            }
            lua_pushcclosure(l, errors::handler, 0);
            lua_pushcclosure(l, run, 0);
            lua_pushlightuserdata(l, (&raw mut f).cast());
            let status = lua_pcall(l, 1, 0, top + 1);
            let result = if status == LUA_OK { Ok(()) } else { Err(errors::from_lua(self, l, status)) };
            lua_settop(l, top);
            result
        }
    }
}

/// Body of `protect`.
unsafe extern "C-unwind" fn run(l: *mut lua_State) -> i32 {
    let f = &mut *lua_touserdata(l, 1).cast::<&mut dyn FnMut(*mut lua_State)>();
    lua_settop(l, 0);
    f(l);
    0
}

/// The state that a thread belongs to.
///
/// # Safety
/// `l` is a thread of a state created by this plugin; the reference is not used beyond the running call.
#[inline(always)]
pub(crate) unsafe fn of<'a>(l: *mut lua_State) -> &'a State {
    &**lua_getextraspace(l).cast::<*const State>()
}

/// A script: an instance of the language.
pub(crate) struct Script {
    state: Box<State>,
}

// SAFETY: what its pointers lead to (the Lua state, its memory, its files) belongs to this script alone, and is used by whoever
// has the script, one thread at a time. Nothing in Lua or in this plugin is shared between scripts but what never changes and
// what stands behind a lock. The world's pointer is handed to functions of the host only, which know on which thread they run.
unsafe impl Send for Script {}

impl Deref for Script {
    type Target = State;
    fn deref(&self) -> &State {
        &self.state
    }
}

impl Script {
    pub(crate) fn new(world: &World<'_>, instance: Instance) -> Result<Self> {
        let host = world.host();
        let commands =
            table(host).ok_or_else(|| Fail::unsupported("this host offers no commands, so scripts cannot run"))?;
        let slot = Slot::new(instance.seed);
        static TOLD: std::sync::atomic::AtomicBool = std::sync::atomic::AtomicBool::new(false);
        if !slot.is_mapped() && cfg!(unix) && !TOLD.swap(true, std::sync::atomic::Ordering::Relaxed) {
            let text = "Lua: the system has too little address space for a script: `pairs` may visit keys that are tables or \
                        functions in another order in each run; allow the program more (`ulimit -v`)";
            world.log(TATU_LOG_WARNING, text.as_bytes());
        }
        // SAFETY: the slot is boxed and outlives the state.
        let main = unsafe { lua_newstate(lua_alloc, (&raw const *slot).cast_mut().cast()) };
        if main.is_null() {
            return Err(Fail::new("no memory for a Lua state"));
        }
        let state = Box::new(State {
            main,
            running: Cell::new(main),
            world: world.raw().ptr(),
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
            parallel: Cell::new(false),
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
            memory_positions: RefCell::default(),
            broken: Cell::new(false),
            slot,
        });
        // SAFETY: the box's content does not move; threads created later copy the main thread's extra space.
        unsafe { *lua_getextraspace(main).cast::<*const State>() = &raw const *state };
        state.slot.full.set(Some((errors::note_memory, (&raw const *state).cast())));
        let script = Script { state };
        // SAFETY: the state is new and runs nothing.
        unsafe { gc::open(main) };
        // SAFETY: runs in protected mode, on the new state's own stack.
        script.protect(&mut |l| unsafe {
            stdlib::open(l);
            crate::permissions::open(l, &script);
        })?;
        // SAFETY: the main thread runs nothing.
        unsafe {
            budget::arm(main);
            script.budget.locate(main);
        }
        crate::hidden::tell(&script, world);
        Ok(script)
    }
}

impl Drop for Script {
    fn drop(&mut self) {
        crate::io::end_line(self);
        // In a mapped slot all Lua objects vanish with it; files are owned and closed outside of Lua.
        if !self.slot.is_mapped() {
            // SAFETY: the host ends an instance only while none of its calls runs.
            unsafe { lua_close(self.main) };
        }
    }
}

fn table(host: &Host) -> Option<Commands> {
    let t = host.commands_table()?;
    Some(Commands {
        find: t.find?,
        is_name_space: t.is_name_space?,
        call: t.call?,
        generation: t.generation?,
        constant: t.constant?,
        mark: t.mark?,
        alloc: t.alloc?,
        release: t.release?,
        call_func: t.call_func?,
    })
}

/// The bytes of the string or number at `idx`; converts a number in place. Empty for other types.
///
/// # Safety
/// The slice is used only while the value stays on the stack.
pub(crate) unsafe fn bytes<'a>(l: *mut lua_State, idx: i32) -> &'a [u8] {
    let mut len = 0;
    let ptr = lua_tolstring(l, idx, &mut len);
    if ptr.is_null() {
        return &[];
    }
    std::slice::from_raw_parts(ptr.cast(), len)
}

/// Pushes a string.
///
/// # Safety
/// One free stack slot; may raise.
pub(crate) unsafe fn push(l: *mut lua_State, text: &[u8]) {
    lua_pushlstring(l, text.as_ptr().cast(), text.len());
}

/// Pushes a registry value and returns its type.
///
/// # Safety
/// One free stack slot.
pub(crate) unsafe fn registry(l: *mut lua_State, place: i64) -> i32 {
    lua_rawgeti(l, LUA_REGISTRYINDEX, place)
}

/// Pushes the content of the scratch buffer.
///
/// # Safety
/// One free stack slot; may raise.
pub(crate) unsafe fn push_scratch(l: *mut lua_State, s: &State) {
    let (ptr, len) = {
        let scratch = s.scratch.borrow();
        (scratch.as_ptr(), scratch.len())
    };
    lua_pushlstring(l, ptr.cast(), len);
}
