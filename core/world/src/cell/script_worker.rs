//! What a thread sees of a world while it runs scripts beside those of other threads (see `scripts::beside`).
//!
//! Such scripts do not touch the world. Their thread is in a *lane*: a cell of its own, with its own stack of calls,
//! errors and lines, which takes the world's place in every service. It looks at the world as it stood when the stage
//! began, through shared references. What scripts set, say and do wrong is noted as a [`Deed`], and done to the world in
//! the order of the scripts when all of them have run: what comes out does not depend on the number of lanes. Whatever
//! else would change the world is refused.

use std::{
    cell::{Cell, Ref, RefCell},
    ffi::c_void,
    ops::Deref,
    ptr::null,
};

use tatu_plugin_api::abi::*;

use crate::cell::{WorldCell, report::MAX_LINES};
use tatu_errors::Fault;
use tatu_plugins::border::ErrorSlot;
use tatu_scene::{is_drive, rows::Row};

thread_local! {
    /// The lane that this thread is in.
    static LANE: Cell<*const WorldCell> = const { Cell::new(null()) };
}

/// The cell of the lane that this thread is in.
#[inline]
pub(crate) fn of_this_thread<'a>() -> Option<&'a WorldCell> {
    // SAFETY: set by `Lane::enter` only, for as long as the lane is borrowed.
    unsafe { LANE.get().as_ref() }
}

/// What a script did, to be done to the world.
pub(crate) enum Deed {
    /// It has been done.
    Done,
    /// It told a line of a level.
    Line(u32, String),
    /// A command that it called failed, and gave a value all the same.
    Fault(Box<Fault>),
    /// It set a number of a joint's drive.
    Set(tatu_object, Row, f64),
    /// An error left it: its place in the order, the status, and what was said.
    Failed(usize, tatu_status, Box<(ErrorSlot, Option<(String, String)>)>),
    /// It asked for its end.
    Settle(usize),
    /// It is none that can run beside others now.
    Alone(usize),
}

/// A lane of a world; its cell stays where it is.
pub(crate) struct Lane(Box<WorldCell>);

/// The part of a cell that makes it a lane.
pub(crate) struct Beside {
    world: Cell<*const WorldCell>,
    /// Instances of plugins, and their state blocks.
    instances: RefCell<Vec<(*mut c_void, *mut c_void)>>,
    deeds: RefCell<Vec<Deed>>,
    /// What the running script has set: each number once.
    own: RefCell<Vec<(tatu_object, Row, f64)>>,
    /// Lines that the scripts of the chunk have told.
    lines: Cell<usize>,
    /// Where the deeds of the running script begin.
    begun: Cell<usize>,
    /// Chunks of scripts that have run here, and where their deeds begin.
    pub chunks: RefCell<Vec<(usize, usize)>>,
}

impl Lane {
    /// A lane of a world.
    pub fn of(world: &WorldCell) -> Self {
        let settings = world.settings.borrow().clone();
        let (registry, document) = (world.registry.shared(), world.document.shared());
        let mut cell = WorldCell::new(document, registry, settings, Default::default(), Vec::new(), world.pool.clone());
        cell.watch = world.watch.beside(&world.registry.watches);
        cell.lane = Some(Box::new(Beside {
            world: Cell::new(null()),
            instances: RefCell::default(),
            deeds: RefCell::default(),
            own: RefCell::default(),
            lines: Cell::new(0),
            begun: Cell::new(0),
            chunks: RefCell::default(),
        }));
        let cell = Box::new(cell);
        // What is not looked at through the world counts as in use: services that try refuse.
        std::mem::forget((cell.scene.borrow_mut(), cell.dynamics.borrow_mut(), cell.sensing.borrow_mut()));
        std::mem::forget((cell.acting.borrow_mut(), cell.scripts.borrow_mut(), cell.signals.borrow_mut()));
        std::mem::forget((cell.figures.borrow_mut(), cell.settings.borrow_mut()));
        Lane(cell)
    }

    /// A stage begins: the lane takes up what the world is now.
    pub fn begin(&self, world: &WorldCell) {
        let cell = &*self.0;
        if !std::ptr::eq(&raw const *cell.registry, &raw const *world.registry) {
            cell.registry.set(world.registry.shared());
        }
        if !std::ptr::eq(&raw const *cell.document, &raw const *world.document) {
            cell.document.set(world.document.shared());
        }
        cell.clock.like(&world.clock);
        cell.phase.set(world.phase.get());
        cell.outside.clock.set(world.outside.clock.get());
        cell.outside.epoch.set(world.outside.epoch.get());
        cell.suspicious.set(world.suspicious.get());
        let Some(lane) = &cell.lane else { return };
        lane.world.set(world);
        let instances = world.instances.borrow();
        let places = instances.iter().map(|i| {
            i.as_ref().map_or((std::ptr::null_mut(), std::ptr::null_mut()), |i| {
                (i.data, i.state.as_ptr().cast_mut().cast::<c_void>())
            })
        });
        let mut own = lane.instances.borrow_mut();
        own.clear();
        own.extend(places);
        lane.deeds.borrow_mut().clear();
        lane.chunks.borrow_mut().clear();
    }

    /// Runs something in the lane.
    ///
    /// # Safety
    /// The world that the lane began with is not changed meanwhile.
    pub unsafe fn enter<T>(&self, f: impl FnOnce(&WorldCell, &Beside) -> T) -> Option<T> {
        /// Leaves it, however it is left.
        struct Inside(*const WorldCell);
        impl Drop for Inside {
            fn drop(&mut self) {
                LANE.set(self.0);
            }
        }
        let lane = self.0.lane.as_deref()?;
        let _inside = Inside(LANE.replace(&raw const *self.0));
        Some(f(&self.0, lane))
    }

    /// The deeds of its chunks, and what it found about the floating-point mode.
    pub fn end(&self, world: &WorldCell) -> (Vec<Deed>, Vec<(usize, usize)>) {
        world.called.set(world.called.get() | self.0.called.take());
        if self.0.suspicious.get() {
            world.suspicious.set(true);
        }
        let Some(lane) = &self.0.lane else { return Default::default() };
        (lane.deeds.take(), lane.chunks.take())
    }

    /// Takes the memory of deeds back.
    pub fn reuse(&self, mut deeds: Vec<Deed>) {
        if let Some(lane) = &self.0.lane {
            deeds.clear();
            lane.deeds.replace(deeds);
        }
    }
}

impl Beside {
    /// The world itself, for plugins to know it by.
    pub fn world(&self) -> *const WorldCell {
        self.world.get()
    }
    /// The data and the state block of a plugin's instance.
    pub fn instance(&self, plugin: usize) -> (*mut c_void, *mut c_void) {
        let none = (std::ptr::null_mut(), std::ptr::null_mut());
        self.instances.borrow().get(plugin).copied().unwrap_or(none)
    }
    /// The next scripts are those of a chunk.
    pub fn begin_chunk(&self, chunk: usize) {
        self.chunks.borrow_mut().push((chunk, self.deeds.borrow().len()));
        self.lines.set(0);
    }
    /// Another script begins.
    pub fn begin_script(&self) {
        self.begun.set(self.deeds.borrow().len());
    }
    /// The script has run: what it has set becomes deeds.
    pub fn end_script(&self) {
        let mut own = self.own.borrow_mut();
        self.deeds.borrow_mut().extend(own.drain(..).map(|(object, row, x)| Deed::Set(object, row, x)));
    }
    /// Notes a deed of the running script. Of lines no more than the world would keep of the chunk's; of equal faults one.
    pub fn note(&self, deed: Deed) {
        let mut deeds = self.deeds.borrow_mut();
        match &deed {
            Deed::Line(..) if self.lines.replace(self.lines.get() + 1) > MAX_LINES => return,
            Deed::Fault(new) => {
                let begun = self.begun.get().min(deeds.len());
                let known = deeds[begun..].iter_mut().find_map(|deed| match deed {
                    Deed::Fault(known) if known.same_as(new) => Some(known),
                    _ => None,
                });
                if let Some(known) = known {
                    known.count += 1;
                    return;
                }
            }
            _ => {}
        }
        deeds.push(deed);
    }
    fn set(&self, object: tatu_object, row: Row, x: f64) {
        let mut own = self.own.borrow_mut();
        match own.iter_mut().find(|(o, r, _)| (*o, *r) == (object, row)) {
            Some(known) => known.2 = x,
            None => own.push((object, row, x)),
        }
    }
    /// What the running script has set a number of an object to.
    pub fn number(&self, slot: u32, row: Row) -> Option<f64> {
        let own = self.own.borrow();
        own.iter().find(|(o, r, _)| (o & 0xF_FFFF == u64::from(slot)) && *r == row).map(|(_, _, x)| *x)
    }
}

/// A part of the world that is looked at.
pub(crate) enum Look<'a, T> {
    /// By its only thread.
    Own(Ref<'a, T>),
    /// By one of several.
    Shared(&'a T),
}

impl<T> Deref for Look<'_, T> {
    type Target = T;
    #[inline]
    fn deref(&self) -> &T {
        match self {
            Look::Own(part) => part,
            Look::Shared(part) => part,
        }
    }
}

impl WorldCell {
    /// A look at a part of the world; `None`: it is in use by a caller further up.
    #[inline]
    pub fn see<T>(&self, part: impl Fn(&WorldCell) -> &RefCell<T>) -> Option<Look<'_, T>> {
        match &self.lane {
            None => part(self).try_borrow().ok().map(Look::Own),
            // SAFETY: nobody changes the world while its lanes are in use (`Lane::enter`).
            Some(lane) => unsafe { lane.world.get().as_ref().map(|w| Look::Shared(&*part(w).as_ptr())) },
        }
    }

    /// In a lane: sets a number of a joint's drive, when all scripts of the stage have run. `Err`: why not.
    pub fn set_later(&self, slot: u32, row: Row, x: f64) -> Result<(), String> {
        let joint = self.see(|w| &w.scene).filter(|s| s.is_joint(slot)).map(|s| s.id(slot));
        match (&self.lane, joint.filter(|_| is_drive(row))) {
            _ if !x.is_finite() => Err(format!("`{}`: expected finite numbers", row.info().key)),
            (Some(lane), Some(joint)) => {
                // As it would be kept.
                lane.set(joint, row, if row == Row::Slip { x.max(0.0) } else { x });
                Ok(())
            }
            _ => Err(format!("scripts that run side by side with others do not set `{}`", row.info().key)),
        }
    }
}
