//! A script from its creation to its end.

use std::{
    cell::{Cell, RefCell},
    ops::Deref,
};

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use crate::{
    alloc::{Slot, lua_alloc},
    errors,
    run::{budget, commands::foreign, gc, hidden},
    state::{State, account::Account, commands::Commands, originals::Originals, slices::Slices},
    stdlib,
};

/// A script: an instance of the language.
pub(crate) struct Script {
    state: Box<State>,
}

// SAFETY: what its pointers lead to (the Lua state, its memory, its files) belongs to this script alone, and is used by
// the owner of the script, one thread at a time. Scripts share nothing in Lua or in this plugin except what is
// immutable or behind a lock. The world's pointer is only passed to functions of the host, which check the thread that
// they run on.
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
        let commands = Commands::of(host)
            .ok_or_else(|| Fail::unsupported("this host offers no commands, so scripts cannot run"))?;
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
            return Err(Fail::new("not enough memory for a Lua state"));
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
            budget: Account::default(),
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
            foreign,
            slot,
        });
        // SAFETY: the box's content does not move; threads created later copy the main thread's extra space.
        unsafe { *lua_getextraspace(main).cast::<*const State>() = &raw const *state };
        state.slot.full.set(Some((errors::note_memory, (&raw const *state).cast())));
        let script = Script { state };
        // SAFETY: the state is new and runs nothing.
        unsafe { gc::open(main) };
        // SAFETY: runs in protected mode, on the new state's own stack.
        errors::protect(&script, &mut |l| unsafe {
            stdlib::open(l);
            stdlib::permissions::open(l, &script);
        })?;
        // SAFETY: the main thread runs nothing.
        unsafe {
            budget::arm(main);
            script.budget.locate(main);
        }
        hidden::tell(&script, world);
        Ok(script)
    }
}

impl Drop for Script {
    fn drop(&mut self) {
        self.end_line();
        // In a mapped slot all Lua objects vanish with it; files are owned and closed outside of Lua.
        if !self.slot.is_mapped() {
            // SAFETY: the host ends an instance only while none of its calls runs.
            unsafe { lua_close(self.main) };
        }
    }
}
