//! A world: a scene, its engine, sensors and scripts, made, started, stepped, stopped and looked at.
//!
//! `cell` holds its parts, which plugins reach through `tatu_world *`.

mod cell;

use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
    rc::Rc,
    sync::Arc,
};

use nalgebra::Vector3;
use tatu_plugin_api::{abi::*, safe::Value};

use cell::Instance;
pub use cell::LogLine;
pub(crate) use cell::{Clock, WorldCell, instance_fault};

use crate::{
    calls::{Calls, ErrorSlot},
    document::{self, Document},
    error::{Error, Fault, FaultKind, Result},
    host::Registry,
    scene::{Data, Dynamics, pose_to_array},
    scripts::Scripts,
    sense::{self, Device, Sensing, Targets},
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

    /// The same, with a pool of `threads` threads of its own; the results do not depend on their number.
    ///
    /// A world never computes in somebody else's pool: the engine waits there for tasks that it gave to the pool, and
    /// two worlds that wait in one pool of two would wait for ever.
    pub fn with_threads(document: Arc<Document>, registry: Arc<Registry>, threads: usize) -> Result<Self> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads.max(1))
            .build()
            .map_err(|e| Error::new("E401", format!("cannot start {threads} threads: {e}")))?;
        let settings = document.settings.clone();
        let (scene, slots) = document.instantiate();
        let cell = Rc::new(WorldCell {
            dynamics: RefCell::new(Dynamics::new(WorldCell::engine_settings(&settings))),
            clock: Clock { time: Cell::new(0.0), step: Cell::new(0), dt: Cell::new(settings.dt) },
            settings: RefCell::new(settings),
            scene: RefCell::new(scene),
            sensing: RefCell::new(Sensing::default()),
            scripts: RefCell::new(Scripts::default()),
            signals: RefCell::new(BTreeMap::new()),
            calls: Calls::new(),
            running: Cell::new(false),
            requests: Cell::new(0),
            stage: Cell::new(0),
            next_instance: Cell::new(1),
            instances: RefCell::new(Vec::new()),
            faults: RefCell::new(Vec::new()),
            lines: RefCell::new(Vec::new()),
            before: RefCell::new(BTreeMap::new()),
            initial: RefCell::new(None),
            pool,
            registry,
            document,
        });
        let world = World { cell };
        world.make_devices(&slots)?;
        world.make_instances()?;
        Scripts::declare(&world.cell, &slots);
        let cell = &world.cell;
        cell.dynamics.borrow_mut().settle(&mut cell.scene.borrow_mut());
        Ok(world)
    }

    /// The inside, for snapshots.
    pub(crate) fn cell(&self) -> &WorldCell {
        &self.cell
    }

    fn make_devices(&self, slots: &[u32]) -> Result {
        let cell = &self.cell;
        for (spec, slot) in cell.document.objects.iter().zip(slots) {
            let Some(device) = &spec.device else { continue };
            let kind = &cell.registry.sensors[device.kind];
            let (owner, name) = {
                let scene = cell.scene.borrow();
                (scene.id(*slot), scene.get(*slot).map_or(String::new(), |o| o.name()))
            };
            let info = cell.instance_info(owner, &name);
            let params = sense::filled(kind, &device.params);
            let lacking = kind.params.iter().zip(&params).find(|(p, v)| **v == Value::Nil && !p.optional());
            if let Some((p, _)) = lacking {
                let key = document::units::written(&p.key, p.unit.as_deref());
                let text = format!("the sensor {} lacks its parameter `{key}`", cell.scene.borrow().path(*slot));
                return Err(Error::new("E104", text).expected(p.expectation()).at(spec.place.clone()));
            }
            let made = Device::create(&cell.registry, device.kind, *slot, info, params).map_err(|text| {
                let path = cell.scene.borrow().path(*slot);
                let plugin = &cell.registry.plugins[kind.plugin].id;
                Error::new("E402", format!("the sensor {path} cannot be made: plugin `{plugin}`: {text}"))
                    .at(spec.place.clone())
            })?;
            cell.sensing.borrow_mut().add(made);
        }
        Ok(())
    }

    fn make_instances(&self) -> Result {
        let cell = &self.cell;
        cell.instances.borrow_mut().resize_with(cell.registry.plugins.len(), || None);
        for (plugin, life) in &cell.registry.world_lives {
            let mut state = vec![0u64; (life.state_bytes as usize).div_ceil(8)];
            let info = tatu_instance { state: state.as_mut_ptr().cast(), ..cell.instance_info(0, "") };
            let (mut data, mut error) = (std::ptr::null_mut(), ErrorSlot::new());
            let p = &cell.registry.plugins[*plugin];
            if let Some(create) = life.create {
                // SAFETY: by the contract; `info` lives through the call, the state as long as the instance.
                if unsafe { create(p.me, &info, &mut data, error.raw()) } < 0 {
                    let text = format!("plugin `{}` cannot serve this world: {}", p.id, error.text());
                    return Err(Error::new("E403", text));
                }
            }
            cell.instances.borrow_mut()[*plugin] = Some(Instance { data, state, destroy: life.destroy });
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
        cell.clock.time.set(0.0);
        cell.clock.step.set(0);
        cell.requests.set(0);
        cell.running.set(true);
        Scripts::begin(cell);
    }

    /// One step: see [`step`]. `false`: a stop has been asked for, and carried out or not by the caller.
    pub fn step(&self) -> bool {
        step::step(&self.cell);
        !self.stop_requested()
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
        self.end_instances();
        if let Err(e) = self.make_instances() {
            cell.report(Fault::new(FaultKind::Plugin, e.text));
        }
        cell.signals.borrow_mut().clear();
        cell.sensing.borrow_mut().reset();
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
    }

    /// Ends what command plugins keep for this world.
    fn end_instances(&self) {
        let instances = std::mem::take(&mut *self.cell.instances.borrow_mut());
        for i in instances.into_iter().flatten() {
            if let Some(destroy) = i.destroy {
                // SAFETY: made by `create`, given back once.
                unsafe { destroy(i.data) };
            }
        }
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

impl Drop for World {
    fn drop(&mut self) {
        let cell = &self.cell;
        Scripts::end(cell);
        let devices = cell.sensing.borrow_mut().take_gone(|_, _| false);
        for d in devices {
            d.destroy(&cell.registry);
        }
        self.end_instances();
    }
}
