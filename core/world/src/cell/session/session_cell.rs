//! The interior of a session: its services, and the worlds that they serve.

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

use crate::cell::{session::service::RunningService, session::wake_flag::WakeFlag};

/// The pointer under which plugins receive a world. It is dropped with the world.
pub(crate) type WorldHandle = Cell<*mut tatu_world>;

/// The interior of a session, at a stable address. Plugins receive a pointer to it, as `tatu_session *`.
pub(crate) struct SessionCell {
    pub signals: SessionSignals,
    pub registry: Arc<Registry>,
    pub services: RefCell<Vec<Rc<RunningService>>>,
    /// Handles of the living worlds, in the order in which they joined.
    pub worlds: RefCell<Vec<Weak<WorldHandle>>>,
    pub interrupt: RefCell<Arc<AtomicBool>>,
}

/// Requests of services to a session, from their own threads.
#[derive(Default)]
pub(crate) struct SessionSignals {
    pub wake: WakeFlag,
    /// Whether a service has requested that the running script return.
    pub stop: AtomicBool,
}

impl SessionSignals {
    /// Requests that the running script return, so that the services can take their turns.
    pub fn request_stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
        self.wake.wake();
    }
}

impl SessionCell {
    /// Returns the pointer that is passed to plugins.
    pub fn raw(&self) -> *mut tatu_session {
        (&raw const *self).cast_mut().cast()
    }
    /// Returns the signals of the session behind an ABI pointer. Can be called from any thread.
    ///
    /// # Safety
    /// `session` must be null or point to a session of this host that is alive for `'a`.
    pub unsafe fn signals<'a>(session: *mut tatu_session) -> Option<&'a SessionSignals> {
        let cell = session.cast::<SessionCell>().cast_const();
        // SAFETY: the caller guarantees that the pointer is to a session that is alive. Only `signals`, which are
        // `Sync`, are borrowed.
        (!cell.is_null()).then(|| unsafe { &(*cell).signals })
    }
    /// Returns the session behind an ABI pointer.
    ///
    /// # Safety
    /// `session` must be null or point to a session of this host that is alive for `'a`, and the call must be on the
    /// session's thread.
    pub unsafe fn of<'a>(session: *mut tatu_session) -> Option<&'a SessionCell> {
        // SAFETY: the caller guarantees that the pointer is null, or is to a session of this thread that is alive for
        // `'a`.
        unsafe { session.cast::<SessionCell>().cast_const().as_ref() }
    }
    /// Returns the living worlds, in the order in which they joined.
    pub fn worlds(&self) -> Vec<*mut tatu_world> {
        self.worlds.borrow().iter().filter_map(Weak::upgrade).map(|w| w.get()).collect()
    }
    pub fn interrupted(&self) -> bool {
        self.interrupt.borrow().load(Ordering::Relaxed)
    }
    /// Returns whether a stop has been requested from outside that the services have not carried out yet.
    pub fn has_external_stop(&self) -> bool {
        self.signals.stop.load(Ordering::Relaxed) || self.interrupted()
    }
    /// Ends all services, the last one first, and returns the errors.
    pub fn end(&self) -> Vec<Error> {
        let services = std::mem::take(&mut *self.services.borrow_mut());
        services.iter().rev().filter_map(|s| s.stop(&self.registry).err()).collect()
    }
    /// Returns whether any service has not been switched off.
    pub fn any_service(&self) -> bool {
        self.services.borrow().iter().any(|s| !s.off.get())
    }
    /// Returns whether a service that has not been switched off subscribes to an event.
    pub fn has_subscriber(&self, name: &str) -> bool {
        let Ok(services) = self.services.try_borrow() else { return false };
        services.iter().any(|s| !s.off.get() && s.subscribes_to(&self.registry, name))
    }
    /// Returns the id of a plugin's running service.
    pub fn service_id_of(&self, plugin: usize) -> Option<String> {
        let kind = |s: &Rc<RunningService>| &self.registry.services[s.kind];
        self.services.borrow().iter().map(kind).find(|k| k.plugin == plugin).map(|k| k.id.clone())
    }
    /// Returns the `i`-th service, cloned so that the list is not borrowed while the service runs.
    pub fn nth(&self, i: usize) -> Option<Rc<RunningService>> {
        self.services.borrow().get(i).cloned()
    }
}
