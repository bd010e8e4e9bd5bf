//! The inside of a session: its services and the worlds that they serve.

use std::{
    cell::{Cell, RefCell},
    rc::{Rc, Weak},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

use tatu_errors::Error;
use tatu_plugin_api::abi::*;
use tatu_plugins::Registry;

use super::{service::Running, wake::Wake};

/// The pointer by which plugins know a world; it goes with the world.
pub(crate) type WorldHandle = Cell<*mut tatu_world>;

/// The inside, at an address that stays: plugins hold it as `tatu_session *`.
pub(crate) struct SessionCell {
    pub wake: Wake,
    pub registry: Arc<Registry>,
    pub services: RefCell<Vec<Rc<Running>>>,
    /// The handles of those that live, in the order in which they joined.
    pub worlds: RefCell<Vec<Weak<WorldHandle>>>,
    pub interrupt: RefCell<Arc<AtomicBool>>,
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
            // SAFETY: the caller promises it; of all its parts only this one, which threads may share, is looked at.
            let wake: &Wake = unsafe { &(*cell).wake };
            wake.wake();
        }
    }
    /// The session behind an ABI pointer.
    ///
    /// # Safety
    /// `session` is null or a living session of this host, and this is its thread.
    pub unsafe fn of<'a>(session: *mut tatu_session) -> Option<&'a SessionCell> {
        // SAFETY: the caller promises it.
        unsafe { session.cast::<SessionCell>().cast_const().as_ref() }
    }
    /// The worlds that are there, in the order in which they joined.
    pub fn worlds(&self) -> Vec<*mut tatu_world> {
        self.worlds.borrow().iter().filter_map(Weak::upgrade).map(|w| w.get()).collect()
    }
    pub fn interrupted(&self) -> bool {
        self.interrupt.borrow().load(Ordering::Relaxed)
    }
    /// Ends the services that there are, the last one first.
    pub fn end(&self) -> Vec<Error> {
        let services = std::mem::take(&mut *self.services.borrow_mut());
        services.iter().rev().filter_map(|s| s.stop(&self.registry).err()).collect()
    }
    /// Whether a service is left that works.
    pub fn any_service(&self) -> bool {
        self.services.borrow().iter().any(|s| !s.off.get())
    }
    /// Whether a running service subscribes to an event.
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
    pub fn nth(&self, i: usize) -> Option<Rc<Running>> {
        self.services.borrow().get(i).cloned()
    }
}
