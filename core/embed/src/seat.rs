//! A world, together with what it was made of.

use tatu_core::{
    Session, World,
    errors::{Error, Result},
    state::Snapshot,
};

use crate::{Engine, Setup};

/// A world that has been started, on the thread that owns it.
pub struct Seat {
    setup: Setup,
    engine: Engine,
    /// Services of the world. Ends before the world does.
    session: Option<Session>,
    /// `None` only if it could not be made anew.
    world: Option<World>,
}

/// How far a world came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stepped {
    /// Number of steps done.
    pub steps: u64,
    /// Whether it still runs: nothing has stopped it.
    pub running: bool,
}

impl Seat {
    /// Makes a world and starts it: time is 0, and nothing has been measured yet.
    ///
    /// # Errors
    /// An instance of a plugin or a service could not be made.
    pub fn new(setup: Setup, engine: Engine) -> Result<Self> {
        let mut seat = Seat { setup, engine, session: None, world: None };
        let (world, session) = seat.make()?;
        world.start();
        (seat.world, seat.session) = (Some(world), session);
        Ok(seat)
    }

    fn make(&self) -> Result<(World, Option<Session>)> {
        let Engine { registry, document, .. } = &self.engine;
        let world = World::with_threads(document.clone(), registry.clone(), self.setup.threads)?;
        if let Some(folder) = &self.setup.files {
            world.open_files_in(folder)?;
        }
        let services = &document.services;
        let session = match self.setup.services.is_empty() {
            true => None,
            false => Some(Session::new(registry.clone(), services)?),
        };
        if let Some(session) = &session {
            session.join(&world);
        }
        Ok((world, session))
    }

    /// The world.
    ///
    /// # Errors
    /// It could not be made anew by the last reset.
    pub fn world(&self) -> Result<&World> {
        self.world
            .as_ref()
            .ok_or_else(|| Error::new("E405", "there is no world: the last reset failed").help("reset it again"))
    }
    /// What it was made of.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }
    /// The setup, with the changes of the last reset.
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// Does up to `n` steps, fewer if the world stops.
    ///
    /// # Errors
    /// There is no world.
    pub fn step(&self, n: u64) -> Result<Stepped> {
        let world = self.world()?;
        for done in 0..n {
            if !world.step() || world.stop_requested() {
                return Ok(Stepped { steps: done + u64::from(world.stop_requested()), running: false });
            }
        }
        Ok(Stepped { steps: n, running: true })
    }

    /// Makes the world anew, as at the beginning, with another seed and other changes if they are given.
    ///
    /// # Errors
    /// A change is invalid; the old world is kept. Or it could not be made.
    pub fn reset(&mut self, seed: Option<u64>, set: Option<Vec<String>>) -> Result {
        if seed.is_some() || set.is_some() {
            let mut setup = self.setup.clone();
            setup.seed = seed.or(setup.seed);
            setup.set = set.unwrap_or(setup.set);
            self.engine = self.engine.reload(&setup)?;
            self.setup = setup;
        }
        self.renew(|world| {
            world.start();
            Ok(())
        })
    }

    /// Captures everything that determines the future of the world.
    ///
    /// # Errors
    /// The world has stopped, or a part of its state cannot be captured.
    pub fn snapshot(&self) -> Result<Snapshot> {
        let snapshot = self.world()?.snapshot()?;
        match snapshot.head.missed.first() {
            None => Ok(snapshot),
            Some(why) => {
                let e = Error::new("E503", format!("the state cannot be captured completely: {why}"));
                Err(e.help("a world whose scripts hold such a state can only be run again from its beginning"))
            }
        }
    }

    /// Makes the world anew in the state of a snapshot of the same scene.
    ///
    /// # Errors
    /// The snapshot is of another scene or of other plugins, or incomplete.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result {
        let (document, registry) = (self.engine.document.clone(), self.engine.registry.clone());
        snapshot.check(&document, &registry)?;
        self.renew(|world| world.restore(snapshot, false))
    }

    fn renew(&mut self, begin: impl FnOnce(&World) -> Result) -> Result {
        self.end_world();
        let (world, session) = self.make()?;
        begin(&world)?;
        (self.world, self.session) = (Some(world), session);
        Ok(())
    }

    /// Ends the services, which then write their files, such as a film; the world goes on without them.
    ///
    /// # Errors
    /// Of the first service that could not be ended in order.
    pub fn end_services(&mut self) -> Result {
        let errors = self.session.take().map(Session::end).unwrap_or_default();
        errors.into_iter().next().map_or(Ok(()), Err)
    }

    fn end_world(&mut self) {
        if let Some(world) = &self.world {
            world.end();
        }
        self.session = None;
        self.world = None;
    }

    /// Ends the world, and the plugins if nobody else uses them.
    pub fn end(mut self) {
        self.end_world();
        let Seat { engine, .. } = self;
        engine.end();
    }
}
