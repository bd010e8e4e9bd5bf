//! The inside of a world: every mutable part behind a `RefCell` of its own.
//!
//! Plugins call back while they are called, so nothing here is borrowed across the border: a service borrows one part,
//! acts, and lets it go.

use std::{
    borrow::Cow,
    cell::{Cell, RefCell},
    ffi::c_void,
    sync::Arc,
};

use tatu_devices::{actuators::Actuators, figures::Figures, sense::Sensing};
use tatu_errors::{Fault, FaultKind};
use tatu_physics::EngineSettings;
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::{
    Registry,
    guard::{self, ProcessState},
    state_block::StateBlock,
    watchdog::{Call, Watch},
};
use tatu_scene::{
    Dynamics, Scene,
    document::{DeviceSpec, Document, Settings},
};

use super::{clock::Clock, phase::Phase, stand_ins::StandIns, swap::Swap};
use crate::cell::{
    CallbackMask, Calls, Due, Folders, Noted, Outside, Scripts, Signals,
    report::Lines,
    script_worker::{ScriptWorker, WorkerView},
};
/// Of so many looks at the process, one is at what takes calls of the system.
const LOOKS: u32 = 64;

/// The value of a signal.
pub(crate) struct Signal {
    pub value: Value,
    /// Set by a script of the run: it ends with it.
    pub of_run: bool,
}

/// What a command plugin keeps for this world.
pub(crate) struct Instance {
    pub data: *mut c_void,
    pub state: StateBlock,
    pub destroy: Option<unsafe extern "C" fn(*mut c_void)>,
}

/// The inside of a world, at an address that stays: plugins hold it as `tatu_world *`.
pub(crate) struct WorldCell {
    pub registry: Swap<Registry>,
    pub document: Swap<Document>,
    /// The object of each in the document, by generation and slot; 0: it was never made.
    pub origins: RefCell<Vec<tatu_object>>,
    pub settings: RefCell<Settings>,
    pub scene: RefCell<Scene>,
    pub dynamics: RefCell<Dynamics>,
    pub sensing: RefCell<Sensing>,
    pub actuators: RefCell<Actuators>,
    pub scripts: RefCell<Scripts>,
    /// What there has been among its scripts, so that nobody looks for the rest in all of them.
    pub callback_mask: CallbackMask,
    pub signals: RefCell<Signals>,
    pub noted: Noted,
    /// Bytes of the lines that are kept; all bits: they take too much, which was told.
    pub line_bytes: Cell<u64>,
    pub calls: Calls,
    pub clock: Clock,
    pub phase: Cell<Phase>,
    /// The last pass is done, and the run is to be ended.
    pub over: Cell<bool>,
    /// The stopped world had a pass.
    pub rested: Cell<bool>,
    /// Bits of `1 << TATU_REQUEST_*`, carried out at the barrier.
    pub requests: Cell<u32>,
    /// The stages that are running, outermost first, and who asked for each.
    pub stages: RefCell<Vec<(u32, Cow<'static, str>)>>,
    /// Where scripts open files.
    pub folders: Folders,
    /// What comes from outside: services, the log of what they did, what is replayed.
    pub outside: Outside,
    /// Stand-ins for what scripts ask for, in runs without a scene.
    pub stand_ins: StandIns,
    pub(crate) next_instance: Cell<u64>,
    pub(crate) next_replacement: Cell<u64>,
    pub(crate) instances: RefCell<Vec<Option<Instance>>>,
    pub(crate) faults: RefCell<Vec<Fault>>,
    pub(crate) lines: Lines,
    /// The version of the tree at which scripts and devices of objects that are gone were ended last.
    pub reaped: Cell<u64>,
    /// Graphs and drawings.
    pub figures: RefCell<Figures>,
    /// What a stop goes back to.
    pub initial: RefCell<Option<Scene>>,
    /// Slots, kinds and parameters of the devices at the start.
    pub initial_devices: RefCell<Vec<(u32, DeviceSpec)>>,
    pub(crate) pool: Arc<rayon::ThreadPool>,
    /// Which plugin call is running.
    pub watch: Arc<Watch>,
    /// Thread and process as they are to be.
    pub(crate) home: RefCell<ProcessState>,
    /// Plugins that were called since `home` was last looked at: one bit each, the last for all beyond.
    pub(crate) called: Cell<u64>,
    /// The same since all of `home` was looked at, and how many looks there have been.
    pub(crate) called_lately: Cell<u64>,
    pub(crate) looks: Cell<u32>,
    /// Somebody has changed the floating-point mode: from then on every call is looked at.
    pub(crate) suspicious: Cell<bool>,
    /// Cells of threads that run scripts side by side, made when they are needed first.
    pub workers: RefCell<Vec<ScriptWorker>>,
    /// This is such a cell: what its thread sees of the world.
    pub worker: Option<Box<WorkerView>>,
}

impl Drop for WorldCell {
    fn drop(&mut self) {
        super::scope::strike(self);
    }
}

impl WorldCell {
    /// Whether the world is started.
    pub fn running(&self) -> bool {
        self.phase.get() != Phase::Stopped
    }
    /// Whether something asked for a stop.
    pub fn stop_requested(&self) -> bool {
        self.requests.get() & (1 << TATU_REQUEST_STOP | 1 << TATU_REQUEST_QUIT) != 0
    }
    /// The pointer that plugins get.
    pub fn raw(&self) -> *mut tatu_world {
        self.worker.as_ref().map_or(&raw const *self, |worker| worker.world()).cast_mut().cast()
    }
    /// Calls a function of a plugin on behalf of an object (0: of none). Every call into a plugin goes through here: it is
    /// noted for the watchdog, and after the outermost one the floating-point mode is put back.
    ///
    /// Reading the mode takes some 10 ns, ten times as long as the note: commands that scripts call are looked at one by
    /// one only after something has been found.
    #[inline]
    pub fn cross<T>(&self, plugin: usize, call: Call, slot: u32, f: impl FnOnce() -> T) -> T {
        if self.watch.is_idle() || self.suspicious.get() {
            return self.cross_watched(plugin, call, slot, f);
        }
        let before = self.watch.enter(call, plugin, slot);
        let done = f();
        // The next copy would run backwards.
        let turned = guard::clear_direction();
        guard::end_if_child();
        self.watch.leave(before);
        self.called.set(self.called.get() | 1 << plugin.min(63));
        if turned {
            self.blame(1 << plugin.min(63), guard::DIRECTION, call.text(), self.watch.name_of(slot));
        }
        done
    }
    fn cross_watched<T>(&self, plugin: usize, call: Call, slot: u32, f: impl FnOnce() -> T) -> T {
        let earlier = self.called.replace(0);
        let before = self.watch.enter(call, plugin, slot);
        let (done, moved) = guard::watched(f);
        self.watch.leave(before);
        let own = 1 << plugin.min(63);
        let within = self.called.get() | own;
        self.called.set(earlier | within);
        if let Some(what) = moved {
            // What was called within has been looked at already, once there was a suspicion.
            let suspects = if self.suspicious.replace(true) { own } else { within };
            self.blame(suspects, what, call.text(), self.watch.name_of(slot));
        }
        done
    }
    /// The same for a function that has no error object; what it logged as an error comes with it.
    pub fn cross_capturing<T>(&self, plugin: usize, call: Call, slot: u32, f: impl FnOnce() -> T) -> (T, Vec<String>) {
        guard::capture_errors(|| self.cross_watched(plugin, call, slot, f))
    }
    /// The same: what it logs as an error, a panic for instance, is its fault.
    pub fn cross_quietly<T>(&self, plugin: usize, call: Call, slot: u32, f: impl FnOnce() -> T) -> T {
        let (done, heard) = self.cross_capturing(plugin, call, slot, f);
        for said in heard {
            let id = &self.registry.plugins[plugin].id;
            let mut fault = Fault::new(FaultKind::Plugin, format!("plugin `{id}` {said} in {}", call.text()));
            fault.plugin = Some(id.clone());
            fault.object = self.watch.name_of(slot);
            self.report(fault);
        }
        done
    }
    /// Plugins are called, and not by way of [`cross`](Self::cross).
    pub fn note_called(&self, plugins: impl Iterator<Item = usize>) {
        self.called.set(plugins.fold(self.called.get(), |called, plugin| called | 1 << plugin.min(63)));
    }
    /// Looks, after a stage, at what a look at each call would take too long: the locale, and the old floating-point
    /// unit. Who was called meanwhile is suspected.
    pub fn restore_process_state(&self, stage: &str) {
        let called = self.called.take();
        if let Some(what) = self.home.borrow().restore_quickly() {
            self.blame(called, what, stage, None);
        }
        self.take_strangers();
        self.called_lately.set(self.called_lately.get() | called);
        self.looks.set(self.looks.get().wrapping_add(1));
        if self.looks.get().is_multiple_of(LOOKS) {
            self.restore_process("the last steps");
        }
    }
    /// The same for what takes calls of the system: the working folder, what signals do, standard output.
    pub fn restore_process(&self, place: &str) {
        let called = self.called_lately.take();
        if let Some(what) = self.home.borrow().restore() {
            self.blame(called, &what, place, None);
        }
    }
    #[cold]
    fn blame(&self, suspects: u64, what: &str, place: &str, object: Option<String>) {
        let plugins = &self.registry.plugins;
        let mut all: Vec<usize> = (0..plugins.len()).filter(|i| suspects & 1 << (*i).min(63) != 0).collect();
        // Those of the program are tested for it.
        if all.iter().any(|i| !self.registry.is_of_program(*i)) {
            all.retain(|i| !self.registry.is_of_program(*i));
        }
        let ids: Vec<&str> = all.iter().map(|i| plugins[*i].id.as_str()).collect();
        let who = match ids.as_slice() {
            [one] => format!("plugin `{one}`"),
            [] => "a plugin, in a thread of its own,".to_owned(),
            many => format!("one of the plugins `{}`", many.join("`, `")),
        };
        let mut fault = Fault::new(FaultKind::Plugin, format!("{who} changed {what} in {place}"));
        fault.plugin = ids.first().filter(|_| ids.len() == 1).map(|id| (*id).to_owned());
        fault.object = object;
        fault.help = Some(guard::HELP.into());
        self.report(fault);
    }
    /// A number for a new instance.
    pub fn new_instance(&self) -> u64 {
        let id = self.next_instance.get();
        self.next_instance.set(id + 1);
        id
    }
    /// A number for an instance in the place of another: from the upper half, so that a reload changes no other numbers.
    pub fn new_replacement(&self) -> u64 {
        let id = self.next_replacement.get();
        self.next_replacement.set(id + 1);
        id
    }
    /// The description that a new instance of an object gets.
    ///
    /// `key` names the owner by what does not change when other things are added: its seed follows from it.
    pub fn instance_info(&self, owner: tatu_object, key: &str) -> tatu_instance {
        self.instance_again(owner, key, self.new_instance())
    }
    /// The same for one that takes the place of another, under a number that is given.
    pub fn instance_again(&self, owner: tatu_object, key: &str, id: u64) -> tatu_instance {
        tatu_instance {
            size: size_of::<tatu_instance>() as u32,
            n_params: 0,
            world: self.raw(),
            owner,
            id,
            seed: self.seed_of(key),
            params: std::ptr::null(),
            state: std::ptr::null_mut(),
            session: std::ptr::null_mut(),
        }
    }
    /// The seed of something, from the scene's seed and its key.
    pub fn seed_of(&self, key: &str) -> u64 {
        xxhash_rust::xxh3::xxh3_64_with_seed(key.as_bytes(), self.settings.borrow().seed)
    }
    /// The data and the state block of a plugin's instance in this world; null in a worker: they belong to the world's thread.
    #[inline]
    pub fn instance(&self, plugin: usize) -> (*mut c_void, *mut c_void) {
        let all = self.instances.try_borrow();
        let one = all.as_ref().ok().and_then(|all| all.get(plugin)?.as_ref());
        let none = (std::ptr::null_mut(), std::ptr::null_mut());
        one.map_or(none, |i| (i.data, i.state.place()))
    }
    /// Whether a plugin has kept within the state block of its instance in this world.
    pub fn state_is_whole(&self, plugin: usize) -> bool {
        let Ok(all) = self.instances.try_borrow() else { return true };
        all.get(plugin).and_then(Option::as_ref).is_none_or(|i| i.state.is_whole())
    }
    /// That one has not, has been told.
    #[cold]
    pub fn mend_state(&self, plugin: usize) {
        if let Ok(mut all) = self.instances.try_borrow_mut()
            && let Some(i) = all.get_mut(plugin).and_then(Option::as_mut)
        {
            i.state.mend();
        }
    }
    /// Whether a wait is over.
    pub fn is_over(&self, due: &Due) -> bool {
        match due {
            Due::Step(s) => self.clock.pass.get() >= *s,
            Due::Time(t) => self.clock.time.get() >= *t - 1e-9,
            Due::Signal(name) => self.signals.borrow().keys().any(|(_, n)| n == name),
            Due::Poll => true,
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
        self.twist_by_motion(scene, slot)
    }
    /// Velocity of an object by its motion in the last step.
    pub fn twist_by_motion(&self, scene: &Scene, slot: u32) -> [f64; 6] {
        let (Some(_), Some(old)) = (scene.get(slot), scene.before(slot)) else { return [0.0; 6] };
        let (now, dt) = (scene.world(slot), self.clock.dt.get());
        let v = (now.translation.vector - old.translation.vector) / dt;
        let w = (now.rotation * old.rotation.inverse()).scaled_axis() / dt;
        [v.x, v.y, v.z, w.x, w.y, w.z]
    }

    /// The part of them that concerns the engine.
    pub fn engine_settings(settings: &Settings) -> EngineSettings {
        EngineSettings {
            gravity: settings.gravity,
            step: settings.physics_dt.min(settings.dt),
            substeps: settings.physics_substeps,
            sleep: settings.sleep,
            friction_rule: settings.friction_rule,
            contact_spring: settings.contact_spring,
        }
    }
}
