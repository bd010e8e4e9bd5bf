//! Creation and destruction of a script.

use std::{
    cell::{Cell, RefCell},
    ops::Deref,
};

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use crate::{
    alloc::{MemorySlot, lua_alloc},
    errors,
    run::{budget, commands::call_foreign, gc, shadowed_commands},
    state::{
        CallState, ClockProps, FunctionIds, HostBorder, LuaThreads, NumberMode, ScriptFailures, ScriptSources,
        ScriptState, ScriptStreams, ThreadWaits, account::CallBudget, commands::CommandService,
        originals::WrappedFunctions, slices::TimeSlices,
    },
    stdlib,
};

/// A script: an instance of the language.
pub(crate) struct LuaScript {
    state: Box<ScriptState>,
}

// SAFETY: the Lua state, its memory and its files belong to this script alone, and only the owner of the `LuaScript`
// uses them, from one thread at a time. Scripts share only immutable data and data behind locks. The world's pointer is
// only passed to functions of the host, which check the calling thread.
unsafe impl Send for LuaScript {}

impl Deref for LuaScript {
    type Target = ScriptState;
    fn deref(&self) -> &ScriptState {
        &self.state
    }
}

impl LuaScript {
    pub(crate) fn new(world: &World<'_>, instance: Instance) -> Result<Self> {
        let host = world.host();
        let commands = CommandService::of(host).ok_or_else(|| {
            Fail::unsupported("this host does not provide the command service, so scripts cannot run")
        })?;
        let slot = MemorySlot::new(instance.seed);
        static ADDRESS_SPACE_WARNED: std::sync::atomic::AtomicBool = std::sync::atomic::AtomicBool::new(false);
        if !slot.is_mapped() && cfg!(unix) && !ADDRESS_SPACE_WARNED.swap(true, std::sync::atomic::Ordering::Relaxed) {
            let text = "Lua: the address space is too small for a script, so the order in which `pairs` visits keys \
                        that are tables or functions may differ between runs; raise the limit (`ulimit -v`)";
            world.log(TATU_LOG_WARNING, text.as_bytes());
        }
        // SAFETY: `lua_alloc` gets the slot as its argument; the slot is boxed, so its address is stable, and it is
        // dropped after the state is closed.
        let main = unsafe { lua_newstate(lua_alloc, (&raw const *slot).cast_mut().cast()) };
        if main.is_null() {
            return Err(Fail::new("there is not enough memory for a new Lua state"));
        }
        let state = Box::new(ScriptState {
            threads: LuaThreads { main, running: Cell::new(main) },
            border: HostBorder { world: world.raw().ptr(), host: *host, instance, commands, generation: Cell::new(0) },
            clock: ClockProps { time: host.prop("scene.clock"), epoch: host.prop("scene.epoch") },
            restored: Cell::new(false),
            call: CallState {
                entries: Cell::new(0),
                depth: Cell::new(0),
                arena_mark: Cell::new(0),
                parallel: Cell::new(false),
            },
            budget: CallBudget::default(),
            waits: ThreadWaits {
                token: Cell::new(0),
                waiting: Cell::new((0, std::ptr::null_mut())),
                wait_errors: RefCell::default(),
            },
            functions: FunctionIds {
                last_borrowed: Cell::new(0),
                released: Cell::new(0),
                last_kept: Cell::new(0),
                numbers: Cell::new(0),
            },
            mode: NumberMode { old: Cell::new(false), single: Cell::new(false) },
            sources: ScriptSources {
                source_words: RefCell::default(),
                text: RefCell::default(),
                loaded_sources: RefCell::default(),
            },
            slices: TimeSlices::default(),
            failures: ScriptFailures {
                errors: RefCell::default(),
                memory_positions: RefCell::default(),
                has_panicked: Cell::new(false),
            },
            streams: ScriptStreams { files: RefCell::default(), line: RefCell::default(), scratch: RefCell::default() },
            originals: WrappedFunctions::default(),
            foreign: call_foreign,
            slot,
        });
        // SAFETY: the extra space has the size of a pointer. The boxed `ScriptState` does not move and outlives the Lua
        // state; threads created later copy the extra space of the main thread.
        unsafe { *lua_getextraspace(main).cast::<*const ScriptState>() = &raw const *state };
        state.slot.full.set(Some((errors::note_memory, (&raw const *state).cast())));
        let script = LuaScript { state };
        // SAFETY: `main` is the main thread of a state that was just created.
        unsafe { gc::open(main) };
        // SAFETY: `protect` calls the closure with the new state's main thread in protected mode.
        errors::protect(&script, &mut |l| unsafe {
            stdlib::open(l);
            stdlib::permissions::open(l, &script);
        })?;
        // SAFETY: `main` is live and runs nothing.
        unsafe {
            budget::arm_hook(main);
            script.budget.locate_counters(main);
        }
        shadowed_commands::report_shadowed(&script, world);
        Ok(script)
    }
}

impl Drop for LuaScript {
    fn drop(&mut self) {
        self.end_line();
        // Dropping a mapped slot releases all Lua objects at once. Open files are owned by `ScriptState`, not by Lua.
        if !self.slot.is_mapped() {
            // SAFETY: the host destroys an instance only while none of its calls runs, and no other code closes the
            // state.
            unsafe { lua_close(self.threads.main) };
        }
    }
}
