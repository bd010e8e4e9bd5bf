//! A world: a scene, its engine, sensors and scripts, made, started, stepped, stopped and looked at.
//!
//! `cell` holds its parts, which plugins reach through `tatu_world *`; `devices` makes the instances of sensors and
//! actuators; `pool` is its threads; `swap` what a reload exchanges.

mod cell;
mod devices;
mod pool;
mod swap;

use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
    rc::Rc,
    sync::Arc,
};

use nalgebra::Vector3;
use tatu_plugin_api::{abi::*, safe::Value};

pub(crate) use cell::Instance;
pub use cell::LogLine;
pub(crate) use cell::{Clock, WorldCell, instance_fault};
use swap::Swap;

use crate::{
    act::Acting,
    calls::{Calls, ErrorSlot, answer},
    document::Document,
    error::{Error, Fault, FaultKind, Result},
    host::{Registry, guard::Home, watchdog::Call},
    scene::{Data, Dynamics, pose_to_array},
    scripts::Scripts,
    sense::{Sensing, Targets},
    session::{
        self, Outside,
        log::{InputLog, Record},
    },
    state::{self, Hash},
    step,
};

/// A scene that runs. One thread at a time uses it; different worlds run on different threads.
pub struct World {
    cell: Rc<WorldCell>,
}

impl World {
    /// Makes a world of a document: its objects, devices and command instances.
    pub fn new(document: Arc<Document>, registry: Arc<Registry>) -> Result<Self> {
        Self::with_threads(document, registry, 1)
    }

    /// The same, with so many threads; the results do not depend on their number.
    pub fn with_threads(document: Arc<Document>, registry: Arc<Registry>, threads: usize) -> Result<Self> {
        let pool = pool::of(threads)?;
        let settings = document.settings.clone();
        let (scene, slots) = document.instantiate();
        let cell = Rc::new(WorldCell {
            dynamics: RefCell::new(Dynamics::new(WorldCell::engine_settings(&settings))),
            clock: Clock::new(settings.dt),
            settings: RefCell::new(settings),
            sensing: RefCell::new(Sensing::default()),
            acting: RefCell::new(Acting::default()),
            scripts: RefCell::new(Scripts::default()),
            signals: RefCell::new(BTreeMap::new()),
            calls: Calls::new(),
            running: Cell::new(false),
            requests: Cell::new(0),
            stages: RefCell::new(Vec::new()),
            outside: Outside::default(),
            next_instance: Cell::new(1),
            next_replacement: Cell::new(1 << 31),
            instances: RefCell::new(Vec::new()),
            faults: RefCell::new(Vec::new()),
            lines: RefCell::new(Vec::new()),
            before: RefCell::new(Vec::new()),
            initial: RefCell::new(None),
            initial_devices: RefCell::new(Vec::new()),
            pool,
            watch: registry.watches.watch(),
            home: Home::now(),
            called: Cell::new(0),
            suspicious: Cell::new(false),
            origins: RefCell::new(slots.iter().map(|s| scene.id(*s)).collect()),
            scene: RefCell::new(scene),
            registry: Swap::new(registry),
            document: Swap::new(document),
        });
        let world = World { cell };
        world.make_devices(&slots)?;
        world.make_instances()?;
        world.cell.look_after("the making of the world");
        Scripts::declare(&world.cell, &slots);
        let cell = &world.cell;
        cell.dynamics.borrow_mut().settle(&mut cell.scene.borrow_mut());
        Ok(world)
    }

    fn make_instances(&self) -> Result {
        let cell = &self.cell;
        cell.instances.borrow_mut().resize_with(cell.registry.plugins.len(), || None);
        for (plugin, life) in &cell.registry.world_lives {
            let made = Instance::create(cell, *plugin, life, cell.new_instance())?;
            cell.instances.borrow_mut()[*plugin] = Some(made);
        }
        Ok(())
    }

    /// Starts: time is 0, script states are made. Their first callbacks run in the first step.
    pub fn start(&self) {
        let cell = &self.cell;
        if cell.running.get() {
            return;
        }
        *cell.initial.borrow_mut() = Some(cell.scene.borrow().clone());
        self.note_devices();
        cell.clock.time.set(0.0);
        cell.clock.step.set(0);
        cell.requests.set(0);
        cell.running.set(true);
        cell.outside.begin();
        Scripts::begin(cell);
        cell.look_after("the start of scripts");
    }

    /// One step: see [`step`]. `false`: a stop has been asked for; the caller carries it out.
    ///
    /// In a session services have their turn first, and may hold the world: then this sleeps until they let go. If a
    /// stop is asked for meanwhile, or the session is interrupted, no step is done.
    pub fn step(&self) -> bool {
        if !session::before_step(&self.cell) {
            return false;
        }
        self.step_on()
    }

    /// Whether something asked for a stop.
    pub fn stop_requested(&self) -> bool {
        self.cell.requests.get() & (1 << TATU_REQUEST_STOP | 1 << TATU_REQUEST_QUIT) != 0
    }

    /// Stops: scripts clean up and end, the scene goes back to how it was at the start.
    pub fn stop(&self) {
        let cell = &self.cell;
        if !cell.running.get() {
            return;
        }
        Scripts::end(cell);
        cell.running.set(false);
        session::stopped(cell);
        self.end_instances();
        if let Err(e) = self.make_instances() {
            cell.report(Fault::new(FaultKind::Plugin, e.text));
        }
        cell.look_after("the end of the run");
        cell.signals.borrow_mut().clear();
        cell.before.borrow_mut().clear();
        if let Some(mut initial) = cell.initial.borrow_mut().take() {
            let mut scene = cell.scene.borrow_mut();
            // What the engine and the beams made of the running scene is not what they make of this one.
            initial.shape_version = scene.shape_version + 1;
            *scene = initial;
            *cell.dynamics.borrow_mut() = Dynamics::new(WorldCell::engine_settings(&cell.settings.borrow()));
            cell.sensing.borrow_mut().targets = Targets::default();
            for (slot, _) in scene.clone().slots() {
                match scene.get_mut(slot).map(|o| &mut o.data) {
                    Some(Data::Shape(s)) => s.body.0 = None,
                    Some(Data::Joint(j)) => j.id = None,
                    _ => {}
                }
            }
            cell.dynamics.borrow_mut().settle(&mut scene);
        }
        self.remake_devices();
    }

    /// Ends what command plugins keep for this world.
    fn end_instances(&self) {
        let instances = std::mem::take(&mut *self.cell.instances.borrow_mut());
        for (plugin, i) in instances.into_iter().enumerate() {
            if let Some(i) = i {
                i.end(&self.cell, plugin);
            }
        }
    }

    /// What plugins offer, as it is now.
    pub fn registry(&self) -> Arc<Registry> {
        self.cell.registry.shared()
    }
    /// What the world was made of, as it is now.
    pub fn document(&self) -> Arc<Document> {
        self.cell.document.shared()
    }

    /// What came from outside since the start.
    pub fn input_log(&self) -> std::cell::Ref<'_, InputLog> {
        self.cell.outside.log.borrow()
    }
    /// The same, to tell whether records are kept and where else they go.
    pub fn input_log_mut(&self) -> std::cell::RefMut<'_, InputLog> {
        self.cell.outside.log.borrow_mut()
    }
    /// Feeds an input log: what it holds is done again, each at its barrier. Before the start.
    pub fn feed(&self, records: Arc<[Record]>) {
        session::log::attach(&self.cell, records);
    }
    /// Files that scripts or plugins asked to read since the start, by the names that they gave: what they read is not
    /// part of the input log.
    pub fn files_opened(&self) -> Vec<String> {
        self.cell.outside.opened.borrow().iter().cloned().collect()
    }
    /// What comes before the next step, without the step; `false`: no step is to be done. For a replay of a run that was
    /// ended within a barrier.
    pub fn barrier(&self) -> bool {
        session::before_step(&self.cell)
    }
    /// The step that comes after [`barrier`](Self::barrier).
    pub fn step_on(&self) -> bool {
        step::step(&self.cell);
        !self.stop_requested()
    }
    pub(crate) fn cell(&self) -> &Rc<WorldCell> {
        &self.cell
    }

    /// Simulation time, s.
    pub fn time(&self) -> f64 {
        self.cell.clock.time.get()
    }
    /// Steps done.
    pub fn steps(&self) -> u64 {
        self.cell.clock.step.get()
    }
    /// Length of a step, s.
    pub fn dt(&self) -> f64 {
        self.cell.clock.dt.get()
    }
    /// Hash over the dynamic state, with its table of contents.
    pub fn hash(&self) -> Hash {
        state::hash(&self.cell.scene.borrow(), &self.cell.dynamics.borrow(), &self.cell.clock)
    }
    /// What its scripts did, in the order in which they were added.
    pub fn scripts(&self) -> Vec<crate::scripts::ScriptTold> {
        crate::scripts::Scripts::told(&self.cell)
    }
    /// Everything that went wrong so far.
    pub fn faults(&self) -> Vec<Fault> {
        self.cell.faults.borrow().clone()
    }
    /// Lines told since the last call.
    pub fn take_lines(&self) -> Vec<LogLine> {
        std::mem::take(&mut *self.cell.lines.borrow_mut())
    }
    /// The path of every model base, in order of slots.
    pub fn model_bases(&self) -> Vec<String> {
        let scene = self.cell.scene.borrow();
        scene.slots().filter(|(_, o)| o.model_base).map(|(s, _)| scene.path(s)).collect()
    }
    /// What can be seen of an object by path or unique name; `None`: there is none.
    pub fn observe(&self, path: &str) -> Option<Observed> {
        let cell = &self.cell;
        let scene = cell.scene.borrow();
        let slot = scene.find(0, path)?;
        let o = scene.get(slot)?;
        let pose = pose_to_array(&o.world);
        let twist = cell.twist(&scene, &cell.dynamics.borrow(), slot);
        let sensing = cell.sensing.borrow();
        let reading = sensing.device(slot).map(|d| {
            let kind = &cell.registry.sensors[d.kind];
            kind.fields.iter().enumerate().map(|(i, f)| (f.name.clone(), d.value(kind, i))).collect()
        });
        let joint = o.joint().map(|j| [j.position, j.velocity, j.effort]);
        Some(Observed { path: scene.path(slot), pose, twist, joint, reading })
    }
    /// The nearest name to one that is not there.
    pub fn nearest(&self, path: &str) -> Option<String> {
        self.cell.scene.borrow().nearest(path)
    }
    /// Contacts between shapes after the last step, by path, with the normal force in N.
    pub fn contacts(&self) -> Vec<(String, String, f64)> {
        let scene = self.cell.scene.borrow();
        let dynamics = self.cell.dynamics.borrow();
        dynamics.contacts().map(|(a, b, c)| (scene.path(a), scene.path(b), c.force)).collect()
    }
    /// Gravity, m/s^2.
    pub fn gravity(&self) -> Vector3<f64> {
        self.cell.settings.borrow().gravity
    }
}

impl Instance {
    /// What a command plugin keeps for a world. Must be called without any borrow of the world.
    pub fn create(cell: &WorldCell, plugin: usize, life: &tatu_life, id: u64) -> Result<Self> {
        let mut state = vec![0u64; (life.state_bytes as usize).div_ceil(8)];
        let info = tatu_instance { state: state.as_mut_ptr().cast(), ..cell.instance_again(0, "", id) };
        let (mut data, mut error) = (std::ptr::null_mut(), ErrorSlot::new());
        let p = &cell.registry.plugins[plugin];
        if let Some(create) = life.create {
            // SAFETY: by the contract; `info` lives through the call, the state as long as the instance.
            let made = || unsafe { answer(create(p.me, &info, &mut data, error.raw()), false, error.raw()) };
            if cell.cross(plugin, Call::Create, 0, made) < 0 {
                let (why, call) = (error.text(), Call::Create.text());
                let text = format!("plugin `{}` cannot serve this world: {why} [{call}]", p.id);
                return Err(Error::new("E403", text));
            }
        }
        Ok(Instance { data, state, destroy: life.destroy })
    }

    /// Ends it.
    pub fn end(self, cell: &WorldCell, plugin: usize) {
        if let Some(destroy) = self.destroy {
            // SAFETY: made by `create`, given back once.
            cell.cross_quietly(plugin, Call::Destroy, 0, || unsafe { destroy(self.data) });
        }
    }
}

/// What can be seen of an object.
#[derive(Debug, Clone, PartialEq)]
pub struct Observed {
    /// Its path.
    pub path: String,
    /// x y z, quaternion x y z w, world.
    pub pose: [f64; 7],
    /// m/s, rad/s, world.
    pub twist: [f64; 6],
    /// Of a joint: position, velocity, effort.
    pub joint: Option<[f64; 3]>,
    /// Of a sensor: its fields.
    pub reading: Option<Vec<(String, Value)>>,
}

impl World {
    /// Ends all that plugins keep for this world; what goes wrong is still told in [`faults`](Self::faults). Afterwards
    /// the world can only be looked at. Dropping it does the same.
    pub fn end(&self) {
        let cell = &self.cell;
        Scripts::end(cell);
        if cell.running.get() {
            session::stopped(cell);
        }
        self.end_devices();
        self.end_instances();
        cell.look_after("the end of the world");
    }
}

impl Drop for World {
    fn drop(&mut self) {
        self.end();
    }
}
