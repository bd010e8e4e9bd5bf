//! The inside of a world: every mutable part behind a `RefCell` of its own.
//!
//! Plugins call back while they are called, so nothing here is borrowed across the border: a service borrows one part,
//! acts, and lets it go.

use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
    ffi::c_void,
    sync::Arc,
};

use serde::Serialize;
use tatu_plugin_api::{abi::*, safe::Value};

use crate::{
    calls::Calls,
    document::{Document, Settings},
    error::{Fault, FaultKind},
    host::Registry,
    physics::EngineSettings,
    scene::{Dynamics, Scene},
    scripts::Scripts,
    sense::Sensing,
};

/// A line that something told.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LogLine {
    /// `TATU_LOG_*`
    pub level: u32,
    /// Of a fault: its stable code.
    pub code: Option<&'static str>,
    /// The text.
    pub text: String,
}

/// Lines that are kept between two looks at them: a script that prints in an endless loop must not fill the memory.
const MAX_LINES: usize = 10_000;

/// Time and steps.
pub(crate) struct Clock {
    /// Simulation time, s: step * dt as long as dt does not change.
    pub time: Cell<f64>,
    pub step: Cell<u64>,
    pub dt: Cell<f64>,
}

/// What a command plugin keeps for this world.
pub(crate) struct Instance {
    pub data: *mut c_void,
    pub state: Vec<u64>,
    pub destroy: Option<unsafe extern "C" fn(*mut c_void)>,
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
    pub(crate) next_instance: Cell<u64>,
    pub(crate) instances: RefCell<Vec<Option<Instance>>>,
    pub(crate) faults: RefCell<Vec<Fault>>,
    pub(crate) lines: RefCell<Vec<LogLine>>,
    /// World poses of the step before, for velocities of objects that the engine does not move.
    pub before: RefCell<BTreeMap<u32, nalgebra::Isometry3<f64>>>,
    pub(super) initial: RefCell<Option<Scene>>,
    pub(super) pool: rayon::ThreadPool,
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
    /// What a new instance of an object is told.
    ///
    /// `key` names the owner by what does not change when other things are added: its seed follows from it.
    pub fn instance_info(&self, owner: tatu_object, key: &str) -> tatu_instance {
        tatu_instance {
            size: size_of::<tatu_instance>() as u32,
            n_params: 0,
            world: self.raw(),
            owner,
            id: self.new_instance(),
            seed: self.seed_of(key),
            params: std::ptr::null(),
            state: std::ptr::null_mut(),
        }
    }
    /// The seed of something, from the scene's seed and its key.
    pub fn seed_of(&self, key: &str) -> u64 {
        xxhash_rust::xxh3::xxh3_64_with_seed(key.as_bytes(), self.settings.borrow().seed)
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
        let code = Some(fault.code);
        faults.push(fault);
        drop(faults);
        if let Ok(mut lines) = self.lines.try_borrow_mut() {
            lines.push(LogLine { level: TATU_LOG_ERROR, code, text });
        }
    }
    /// Keeps a line for whoever runs the world.
    pub fn log(&self, level: u32, text: &str) {
        let Ok(mut lines) = self.lines.try_borrow_mut() else { return };
        match lines.len() {
            0..MAX_LINES => lines.push(LogLine { level, code: None, text: text.to_owned() }),
            MAX_LINES => lines.push(LogLine {
                level: TATU_LOG_WARNING,
                code: None,
                text: format!("more than {MAX_LINES} lines in one step: the rest is left out"),
            }),
            _ => {}
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

    /// What the engine is told of them.
    pub fn engine_settings(settings: &Settings) -> EngineSettings {
        EngineSettings { gravity: settings.gravity, step: settings.physics_dt.min(settings.dt) }
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
