//! A world, together with the inputs from which it was built.

use tatu_core::{
    Session, World,
    errors::{Error, Result},
    state::Snapshot,
};

use crate::{WorldSetup, WorldTemplate};

/// A world that has been started, on the thread that owns it.
pub struct WorldSlot {
    setup: WorldSetup,
    template: WorldTemplate,
    /// The services that the setup starts; `None` if there are none, or if they have been ended.
    session: Option<Session>,
    /// `None` only if the last reset or restore failed to rebuild the world.
    world: Option<World>,
}

/// The result of [`WorldSlot::step`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepOutcome {
    /// Number of steps run.
    pub steps: u64,
    /// Whether the world is still running; false if the scene has requested a stop or the world has ended.
    pub running: bool,
}

impl WorldSlot {
    /// Creates a world and starts it: its time is 0, and no sensor has been measured yet.
    ///
    /// # Errors
    /// An instance of a plugin or a service cannot be created.
    pub fn new(setup: WorldSetup, engine: WorldTemplate) -> Result<Self> {
        let mut seat = WorldSlot { setup, template: engine, session: None, world: None };
        let (world, session) = seat.build_world()?;
        world.start();
        (seat.world, seat.session) = (Some(world), session);
        Ok(seat)
    }

    fn build_world(&self) -> Result<(World, Option<Session>)> {
        let WorldTemplate { registry, document, .. } = &self.template;
        let world = World::with_threads(document.clone(), registry.clone(), self.setup.threads)?;
        if let Some(folder) = &self.setup.files {
            world.set_file_folder(folder)?;
        }
        let services = &document.requests.services;
        let session = match self.setup.services.is_empty() {
            true => None,
            false => Some(Session::new(registry.clone(), services)?),
        };
        if let Some(session) = &session {
            session.join(&world);
        }
        Ok((world, session))
    }

    /// Returns the world.
    ///
    /// # Errors
    /// The last reset or restore failed to rebuild the world.
    pub fn world(&self) -> Result<&World> {
        self.world.as_ref().ok_or_else(|| {
            Error::new("E405", "there is no world, because the last reset or restore failed")
                .help("reset the world again")
        })
    }
    /// Returns the plugins and the document from which the world was built.
    pub fn template(&self) -> &WorldTemplate {
        &self.template
    }
    /// Returns the setup, with the changes of the last reset.
    pub fn setup(&self) -> &WorldSetup {
        &self.setup
    }

    /// Runs up to `n` steps, fewer if the world stops.
    ///
    /// # Errors
    /// The last reset or restore failed to rebuild the world.
    pub fn step(&self, n: u64) -> Result<StepOutcome> {
        let world = self.world()?;
        for done in 0..n {
            if !world.step() || world.stop_requested() {
                return Ok(StepOutcome { steps: done + u64::from(world.stop_requested()), running: false });
            }
        }
        Ok(StepOutcome { steps: n, running: true })
    }

    /// Rebuilds the world in its initial state. `seed` and `set`, if given, replace those of the setup, for later
    /// resets as well.
    ///
    /// # Errors
    /// A change is invalid, in which case the old world remains unchanged, or the new world cannot be created.
    pub fn reset(&mut self, seed: Option<u64>, set: Option<Vec<String>>) -> Result {
        if seed.is_some() || set.is_some() {
            let mut setup = self.setup.clone();
            setup.seed = seed.or(setup.seed);
            setup.set = set.unwrap_or(setup.set);
            self.template = self.template.reload(&setup)?;
            self.setup = setup;
        }
        self.rebuild_world(|world| {
            world.start();
            Ok(())
        })
    }

    /// Captures all state that determines the future of the world.
    ///
    /// # Errors
    /// The world has stopped, or a part of its state cannot be captured.
    pub fn snapshot(&self) -> Result<Snapshot> {
        let snapshot = self.world()?.snapshot()?;
        match snapshot.head.missed.first() {
            None => Ok(snapshot),
            Some(why) => {
                let e = Error::new("E503", format!("the state cannot be captured completely: {why}"));
                Err(e.help("a world whose scripts hold such state can only be run again from the start"))
            }
        }
    }

    /// Rebuilds the world in the state of a snapshot of the same scene.
    ///
    /// # Errors
    /// The snapshot belongs to another scene or other plugins, or is incomplete.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result {
        let (document, registry) = (self.template.document.clone(), self.template.registry.clone());
        snapshot.check(&document, &registry)?;
        self.rebuild_world(|world| world.restore(snapshot, false))
    }

    fn rebuild_world(&mut self, begin: impl FnOnce(&World) -> Result) -> Result {
        self.end_world();
        let (world, session) = self.build_world()?;
        begin(&world)?;
        (self.world, self.session) = (Some(world), session);
        Ok(())
    }

    /// Ends the services, which then write their files, such as a film; the world continues without them.
    ///
    /// # Errors
    /// A service failed to end; the error is that of the first such service.
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

    /// Ends the world, and the plugins if nothing else uses them.
    pub fn end(mut self) {
        self.end_world();
        let WorldSlot { template: engine, .. } = self;
        engine.end();
    }
}
