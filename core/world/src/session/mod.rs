//! What outlives worlds: services, and the barrier at which they act.
//!
//! - [`Session`]: starts services, has worlds, stops services at its end;
//! - `barrier`: what happens between two steps: waits that are over, replayed calls, services until all say go;
//! - `service`: one running service and the calls into it;
//! - `outside`: what a world keeps of its outside;
//! - `wake`: the one word on which a held session sleeps;
//! - [`mod@log`]: what came from outside, and feeding it again; [`mod@file`]: the same as a file.
//!
//! A session and its worlds live on one thread; different sessions live on different threads. Only `wake` is called
//! from other threads.

mod barrier;
pub mod file;
mod json;
pub mod log;
mod outside;
mod service;
mod wake;

use std::{
    cell::RefCell,
    rc::{Rc, Weak},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

use tatu_plugin_api::abi::*;

pub(crate) use barrier::{before_step, stopped};
pub(crate) use log::{outside_request, remote_call, remote_request};
pub(crate) use outside::Outside;
use service::Running;
use wake::Wake;

use crate::{World, world::WorldCell};
use tatu_errors::{Error, Result};
use tatu_plugins::Registry;
use tatu_scene::document::ServiceSpec;

/// Services and the worlds that they serve.
///
/// Services are started once, in order of their ids, and stopped when the session is dropped; worlds come and go.
pub struct Session {
    cell: Rc<SessionCell>,
}

/// The inside, at an address that stays: plugins hold it as `tatu_session *`.
pub(crate) struct SessionCell {
    wake: Wake,
    registry: Arc<Registry>,
    services: RefCell<Vec<Rc<Running>>>,
    worlds: RefCell<Vec<Weak<WorldCell>>>,
    interrupt: RefCell<Arc<AtomicBool>>,
}

impl Session {
    /// Starts services. Fails with E404 when one cannot be started; those before it are stopped again.
    pub fn new(registry: Arc<Registry>, services: &[ServiceSpec]) -> Result<Self> {
        let cell = Rc::new(SessionCell {
            wake: Wake::default(),
            registry,
            services: RefCell::default(),
            worlds: RefCell::default(),
            interrupt: RefCell::default(),
        });
        let session = Session { cell };
        let mut specs: Vec<&ServiceSpec> = services.iter().collect();
        specs.sort_by_key(|s| s.kind);
        for spec in specs {
            let number = session.cell.services.borrow().len() as u32 + 1;
            let running = Running::start(&session.cell, spec, number)?;
            session.cell.services.borrow_mut().push(Rc::new(running));
        }
        Ok(session)
    }

    /// A world joins: from now on services have their turn before each of its steps. It leaves when it is dropped.
    pub fn join(&self, world: &World) {
        let mut worlds = self.cell.worlds.borrow_mut();
        worlds.retain(|w| w.strong_count() > 0 && !std::ptr::eq(w.as_ptr(), Rc::as_ptr(world.cell())));
        worlds.push(Rc::downgrade(world.cell()));
        world.cell().outside.join(&self.cell);
    }

    /// A flag that ends every wait at the barrier when it is set, by a signal for instance. It is looked at ten times
    /// a second while a world is held.
    pub fn interrupt_by(&self, flag: Arc<AtomicBool>) {
        *self.cell.interrupt.borrow_mut() = flag;
    }

    /// Lets services have their turn in a world that is stopped, until one asks for a start: `true`. `false`: one asked
    /// to quit, the session was interrupted, or no service is left that could ask.
    pub fn wait_for_start(&self, world: &World) -> bool {
        barrier::rest(world.cell(), &self.cell)
    }

    /// Whether any service runs.
    pub fn has_services(&self) -> bool {
        self.cell.any_service()
    }
}

impl Session {
    /// Ends the services; what went wrong. Dropping the session does the same silently.
    pub fn end(self) -> Vec<Error> {
        self.cell.end()
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.cell.end();
    }
}

impl SessionCell {
    /// The pointer that plugins get.
    pub fn raw(&self) -> *mut tatu_session {
        (&raw const *self).cast_mut().cast()
    }
    /// Wakes a session that sleeps at its barrier; from any thread.
    ///
    /// # Safety
    /// `session` is null or a living session of this host.
    pub unsafe fn wake(session: *mut tatu_session) {
        let cell = session.cast::<SessionCell>().cast_const();
        if !cell.is_null() {
            // SAFETY: as promised; of all its parts only this one, which threads may share, is looked at.
            let wake: &Wake = unsafe { &(*cell).wake };
            wake.wake();
        }
    }
    /// The session behind a pointer of the border.
    ///
    /// # Safety
    /// `session` is null or a living session of this host, and this is its thread.
    pub unsafe fn of<'a>(session: *mut tatu_session) -> Option<&'a SessionCell> {
        // SAFETY: as promised.
        unsafe { session.cast::<SessionCell>().cast_const().as_ref() }
    }
    /// The worlds that are there, in the order in which they joined.
    pub fn worlds(&self) -> Vec<*mut tatu_world> {
        self.worlds.borrow().iter().filter_map(Weak::upgrade).map(|w| w.raw()).collect()
    }
    fn interrupted(&self) -> bool {
        self.interrupt.borrow().load(Ordering::Relaxed)
    }
    /// Ends the services that there are, the last one first.
    fn end(&self) -> Vec<Error> {
        let services = std::mem::take(&mut *self.services.borrow_mut());
        services.iter().rev().filter_map(|s| s.stop(&self.registry).err()).collect()
    }
    /// Whether a service is left that works.
    pub fn any_service(&self) -> bool {
        self.services.borrow().iter().any(|s| !s.off.get())
    }
    /// Whether a service that works is told of an event.
    pub fn wants(&self, name: &str) -> bool {
        let Ok(services) = self.services.try_borrow() else { return false };
        services.iter().any(|s| !s.off.get() && s.wants(&self.registry, name))
    }
    /// A service of a plugin that runs, by id.
    pub fn service_of(&self, plugin: usize) -> Option<String> {
        let kind = |s: &Rc<Running>| &self.registry.services[s.kind];
        self.services.borrow().iter().map(kind).find(|k| k.plugin == plugin).map(|k| k.id.clone())
    }
    /// The `i`-th service, copied out so that the list is free while it runs.
    fn nth(&self, i: usize) -> Option<Rc<Running>> {
        self.services.borrow().get(i).cloned()
    }
}
