//! A world: a scene, its engine, sensors and scripts, and the calls between them.
//!
//! Plugins call back while they are called, so nothing here is borrowed across the border: every mutable part has a
//! `RefCell` of its own, a service borrows it, acts, and lets it go.

use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
    ffi::c_void,
    rc::Rc,
    sync::Arc,
};

use nalgebra::Vector3;
use serde::Serialize;
use tatu_plugin_api::{abi::*, safe::Value};

use crate::{
    calls::{Calls, ErrorSlot},
    document::{Document, Settings},
    error::{Error, Fault, FaultKind, Result},
    host::Registry,
    physics::EngineSettings,
    scene::{Data, Dynamics, Scene, pose_to_array},
    scripts::Scripts,
    sense::{self, Device, Sensing, Targets},
    state::{self, Hash},
    step,
};

/// A line that something told.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LogLine {
    /// `TATU_LOG_*`
    pub level: u32,
    /// The text.
    pub text: String,
}

/// Time and steps.
pub(crate) struct Clock {
    /// Simulation time, s: step * dt as long as dt does not change.
    pub time: Cell<f64>,
    pub step: Cell<u64>,
    pub dt: Cell<f64>,
}

/// What a command plugin keeps for this world.
struct Instance {
    data: *mut c_void,
    state: Vec<u64>,
    destroy: Option<unsafe extern "C" fn(*mut c_void)>,
}

/// The inside of a world, at an address that stays: plugins hold it as `tatu_world *`.
pub(crate) struct WorldCell {
    pub registry: Arc<Registry>,
    pub document: Arc<Document>,
    pub settings: RefCell<Settings>,
    pub scene: RefCell<Scene>,
    pub dynamics: RefCell<Dynamics>,
    pub sensing: RefCell<Sensing>,
    pub scripts: RefCell<Scripts>,
    pub signals: RefCell<BTreeMap<(u32, Vec<u8>), Value>>,
    pub calls: Calls,
    pub clock: Clock,
    pub running: Cell<bool>,
    /// Bits of `1 << TATU_REQUEST_*`, carried out at the barrier.
    pub requests: Cell<u32>,
    pub stage: Cell<u32>,
    next_instance: Cell<u64>,
    instances: RefCell<Vec<Option<Instance>>>,
    faults: RefCell<Vec<Fault>>,
    lines: RefCell<Vec<LogLine>>,
    /// World poses of the step before, for velocities of objects that the engine does not move.
    pub before: RefCell<BTreeMap<u32, nalgebra::Isometry3<f64>>>,
    initial: RefCell<Option<Scene>>,
    pool: rayon::ThreadPool,
}

/// A scene that runs. One thread at a time uses it; different worlds run on different threads.
pub struct World {
    cell: Rc<WorldCell>,
}

impl WorldCell {
    /// The world behind a pointer of the border.
    ///
    /// # Safety
    /// `ptr` is null or a living world that this host gave out.
    pub unsafe fn of<'a>(ptr: *mut tatu_world) -> Option<&'a WorldCell> {
        // SAFETY: as promised.
        unsafe { ptr.cast::<WorldCell>().cast_const().as_ref() }
    }
    /// The pointer that plugins get.
    pub fn raw(&self) -> *mut tatu_world {
        (&raw const *self).cast_mut().cast()
    }
    /// A number for a new instance.
    pub fn new_instance(&self) -> u64 {
        let id = self.next_instance.get();
        self.next_instance.set(id + 1);
        id
    }
    /// The seed of something, from the scene's seed and a number that is the same in every run.
    pub fn seed_of(&self, uid: u64) -> u64 {
        let mut bytes = [0u8; 16];
        bytes[..8].copy_from_slice(&self.settings.borrow().seed.to_le_bytes());
        bytes[8..].copy_from_slice(&uid.to_le_bytes());
        xxhash_rust::xxh3::xxh3_64(&bytes)
    }
    /// The instance data of a plugin in this world.
    pub fn instance(&self, plugin: usize) -> *mut c_void {
        match self.instances.try_borrow() {
            Ok(all) => all.get(plugin).and_then(Option::as_ref).map_or(std::ptr::null_mut(), |i| i.data),
            Err(_) => std::ptr::null_mut(),
        }
    }
    /// The state block of a plugin's instance in this world.
    pub fn instance_state(&self, plugin: usize) -> *mut c_void {
        match self.instances.try_borrow() {
            Ok(all) => all
                .get(plugin)
                .and_then(Option::as_ref)
                .map_or(std::ptr::null_mut(), |i| i.state.as_ptr().cast_mut().cast()),
            Err(_) => std::ptr::null_mut(),
        }
    }
    /// Who calls now, for messages.
    pub fn caller_name(&self) -> String {
        let caller = self.calls.caller.get();
        match self.scene.try_borrow() {
            Ok(scene) if caller.object != 0 => scene.path((caller.object & 0xF_FFFF) as u32),
            _ => "the host".into(),
        }
    }
    /// Adds to a fault whose script it was.
    pub fn blame_caller(&self, fault: &mut Fault) {
        let caller = self.calls.caller.get();
        if let (Ok(scene), true) = (self.scene.try_borrow(), caller.object != 0) {
            fault.object = Some(scene.path((caller.object & 0xF_FFFF) as u32));
        }
        if let Ok(scripts) = self.scripts.try_borrow() {
            fault.script = scripts.by_id(caller.instance).map(|s| s.name.clone());
        }
    }
    /// Records a fault: told once, then counted.
    pub fn report(&self, fault: Fault) {
        let Ok(mut faults) = self.faults.try_borrow_mut() else { return };
        if let Some(known) = faults.iter_mut().find(|f| f.same_as(&fault)) {
            known.count += 1;
            return;
        }
        let mut text = fault.message.clone();
        if let (Some(file), Some(line)) = (&fault.file, fault.line) {
            text = format!("{file}:{line}: {text}");
        }
        if let Some(object) = &fault.object {
            text += &format!(" [{object}]");
        }
        if let Some(help) = &fault.help {
            text += &format!(" ({help})");
        }
        faults.push(fault);
        drop(faults);
        self.log(TATU_LOG_ERROR, &text);
    }
    /// Keeps a line for whoever runs the world.
    pub fn log(&self, level: u32, text: &str) {
        if let Ok(mut lines) = self.lines.try_borrow_mut() {
            lines.push(LogLine { level, text: text.to_owned() });
        }
    }
    /// Runs `f` with the world's pool of threads.
    pub fn install<T: Send>(&self, f: impl FnOnce() -> T + Send) -> T {
        self.pool.install(f)
    }
    /// The world's threads.
    pub fn pool(&self) -> &rayon::ThreadPool {
        &self.pool
    }
    /// Velocity of an object: from the engine if it moves it, else from its motion in the last step.
    pub fn twist(&self, scene: &Scene, dynamics: &Dynamics, slot: u32) -> [f64; 6] {
        let Some(o) = scene.get(slot) else { return [0.0; 6] };
        if let Some(t) = o.shape().filter(|s| s.dynamic).and_then(|s| dynamics.twist(s)) {
            return [t.linear.x, t.linear.y, t.linear.z, t.angular.x, t.angular.y, t.angular.z];
        }
        let Ok(before) = self.before.try_borrow() else { return [0.0; 6] };
        let (Some(old), dt) = (before.get(&slot), self.clock.dt.get()) else { return [0.0; 6] };
        let v = (o.world.translation.vector - old.translation.vector) / dt;
        let w = (o.world.rotation * old.rotation.inverse()).scaled_axis() / dt;
        [v.x, v.y, v.z, w.x, w.y, w.z]
    }

    fn engine_settings(settings: &Settings) -> EngineSettings {
        EngineSettings { gravity: settings.gravity, step: settings.physics_dt.min(settings.dt) }
    }
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

    fn make_devices(&self, slots: &[u32]) -> Result {
        let cell = &self.cell;
        for (spec, slot) in cell.document.objects.iter().zip(slots) {
            let Some(device) = &spec.device else { continue };
            let kind = &cell.registry.sensors[device.kind];
            let (owner, uid) = {
                let scene = cell.scene.borrow();
                (scene.id(*slot), scene.get(*slot).map_or(0, |o| o.uid))
            };
            let info = tatu_instance {
                size: size_of::<tatu_instance>() as u32,
                n_params: 0,
                world: cell.raw(),
                owner,
                id: cell.new_instance(),
                seed: cell.seed_of(uid),
                params: std::ptr::null(),
                state: std::ptr::null_mut(),
            };
            let params = sense::filled(kind, &device.params);
            let made = Device::create(&cell.registry, device.kind, *slot, info, params).map_err(|text| {
                let path = cell.scene.borrow().path(*slot);
                let plugin = &cell.registry.plugins[kind.plugin].id;
                Error::new("E402", format!("the sensor {path} cannot be made: plugin `{plugin}`: {text}"))
                    .at(spec.place.clone())
            })?;
            let mut sensing = cell.sensing.borrow_mut();
            if let Some(Data::Sensor(s)) = cell.scene.borrow_mut().get_mut(*slot).map(|o| &mut o.data) {
                s.device = sensing.devices.len();
            }
            sensing.devices.push(made);
        }
        Ok(())
    }

    fn make_instances(&self) -> Result {
        let cell = &self.cell;
        cell.instances.borrow_mut().resize_with(cell.registry.plugins.len(), || None);
        for (plugin, life) in &cell.registry.world_lives {
            let mut state = vec![0u64; (life.state_bytes as usize).div_ceil(8)];
            let info = tatu_instance {
                size: size_of::<tatu_instance>() as u32,
                n_params: 0,
                world: cell.raw(),
                owner: 0,
                id: cell.new_instance(),
                seed: cell.seed_of(0),
                params: std::ptr::null(),
                state: state.as_mut_ptr().cast(),
            };
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

/// A fault of a plugin's instance, which is switched off.
pub(crate) fn instance_fault(cell: &WorldCell, plugin: usize, slot: u32, status: tatu_status, text: &str) -> Fault {
    let id = &cell.registry.plugins[plugin].id;
    let path = cell.scene.try_borrow().map(|s| s.path(slot)).unwrap_or_default();
    let how = if status == TATU_ERR_PANIC { "" } else { "failed: " };
    let mut fault =
        Fault::new(FaultKind::Plugin, format!("plugin `{id}` {how}{text}; the sensor {path} is switched off"));
    fault.plugin = Some(id.clone());
    fault.object = Some(path);
    fault
}
