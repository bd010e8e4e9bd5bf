//! The public interface of a session.

use std::{
    cell::RefCell,
    rc::Rc,
    sync::{Arc, atomic::AtomicBool},
};

use tatu_errors::{Error, Fault, FaultKind, Result};
use tatu_plugins::Registry;
use tatu_scene::document::ServiceSpec;

use super::World;
use crate::{
    cell::{RunningService, SessionCell, SessionSignals},
    session, state,
};

/// Services, and the worlds that they serve.
///
/// Services are started once, in the order of their ids, and stopped when the session is dropped. Worlds can join and
/// leave in the meantime.
pub struct Session {
    cell: Rc<SessionCell>,
}

impl Session {
    /// Starts services. Fails with E404 if one cannot be started, or with E104 if one lacks a parameter; those already
    /// started are stopped again.
    pub fn new(registry: Arc<Registry>, services: &[ServiceSpec]) -> Result<Self> {
        let cell = Rc::new(SessionCell {
            signals: SessionSignals::default(),
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
            let running = RunningService::start(&session.cell.registry, session.cell.raw(), spec, number)?;
            session.cell.services.borrow_mut().push(Rc::new(running));
        }
        Ok(session)
    }

    /// Adds a world. Services then have a turn before each of its steps. The world leaves the session when it is
    /// dropped.
    pub fn join(&self, world: &World) {
        let handle = &world.cell().run.connections.handle;
        let mut worlds = self.cell.worlds.borrow_mut();
        worlds.retain(|w| w.strong_count() > 0 && !std::ptr::eq(w.as_ptr(), Rc::as_ptr(handle)));
        worlds.push(Rc::downgrade(handle));
        world.cell().run.connections.join(&self.cell, world.cell().raw());
        // A world restored from a snapshot contains the states that services saved.
        if let Err(e) = state::restore::services(world.cell()) {
            world.cell().report(Fault::new(FaultKind::Plugin, e.text));
        }
    }

    /// Sets the flag that releases a world that services hold at its barrier; a signal handler, for example, can set
    /// it. While a world is held, the flag is checked ten times a second.
    pub fn set_interrupt_flag(&self, flag: Arc<AtomicBool>) {
        *self.cell.interrupt.borrow_mut() = flag;
    }

    /// Lets services take turns while the simulation is stopped. Returns `true` when a service requests a start, and
    /// `false` if a service requests a different scene or the end, the session is interrupted, or no service is left.
    pub fn wait_for_start(&self, world: &World) -> bool {
        session::wait_for_start(world.cell(), &self.cell)
    }

    /// Returns whether any service has not been switched off.
    pub fn has_services(&self) -> bool {
        self.cell.any_service()
    }
}

impl Session {
    /// Ends the services and returns the errors. Dropping the session does the same but discards them.
    pub fn end(self) -> Vec<Error> {
        self.cell.end()
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.cell.end();
    }
}
