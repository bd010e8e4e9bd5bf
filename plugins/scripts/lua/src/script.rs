//! Creation and destruction of a script.

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

// SAFETY: the Lua state, its memory and its files belong to this script alone, and only the owner of the `Script` uses
// them, from one thread at a time. Scripts share only immutable data and data behind locks. The world's pointer is only
// passed to functions of the host, which check the calling thread.
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
        let commands = Commands::of(host).ok_or_else(|| {
            Fail::unsupported("this host does not provide the command service, so scripts cannot run")
        })?;
        let slot = Slot::new(instance.seed);
        static TOLD: std::sync::atomic::AtomicBool = std::sync::atomic::AtomicBool::new(false);
        if !slot.is_mapped() && cfg!(unix) && !TOLD.swap(true, std::sync::atomic::Ordering::Relaxed) {
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
        // SAFETY: the extra space has the size of a pointer. The boxed `State` does not move and outlives the Lua
        // state; threads created later copy the extra space of the main thread.
        unsafe { *lua_getextraspace(main).cast::<*const State>() = &raw const *state };
        state.slot.full.set(Some((errors::note_memory, (&raw const *state).cast())));
        let script = Script { state };
        // SAFETY: `main` is the main thread of a state that was just created.
        unsafe { gc::open(main) };
        // SAFETY: `protect` calls the closure with the new state's main thread in protected mode.
        errors::protect(&script, &mut |l| unsafe {
            stdlib::open(l);
            stdlib::permissions::open(l, &script);
        })?;
        // SAFETY: `main` is live and runs nothing.
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
        // Dropping a mapped slot releases all Lua objects at once. Open files are owned by `State`, not by Lua.
        if !self.slot.is_mapped() {
            // SAFETY: the host destroys an instance only while none of its calls runs, and no other code closes the
            // state.
            unsafe { lua_close(self.main) };
        }
    }
}
