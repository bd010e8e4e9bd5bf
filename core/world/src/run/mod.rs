//! The public interface of a world, to create, start, step, stop and inspect it.
//!
//! - [`World`]: a running scene; `life`: start, step, stop; `addons`: scripts that are not part of a document;
//!   `call`: commands that the program calls;
//! - [`Reading`]: the last reading of a sensor; `snapshot`: saves and restores the state of a world;
//! - [`Session`]: services, and the worlds that they serve; `replay`: repeats the inputs of a log.

mod addons;
mod call;
mod life;
mod reading;
mod replay;
mod session;
mod snapshot;

use std::{
    path::Path,
    rc::Rc,
    sync::{Arc, atomic::AtomicBool},
};

use nalgebra::Vector3;
use tatu_devices::figures::Figures;
use tatu_errors::{Error, Fault, Result};
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::Registry;
use tatu_scene::{Scene, document::Document, pose_to_array};

pub use self::session::Session;
pub use reading::{Reading, ReadingField};
pub use replay::replay_to;

use crate::{
    cell::{
        self, CommandInstance, InputLog, InputRecord, LogBuffer, LogLine, OptionalObject, Phase, Scripts, StandIn,
        WorldCell, pool_of,
    },
    instances::{create_devices, end_devices},
    parts, session as barrier,
    state::{self, StateHash},
};
/// A running scene. A world is used by one thread; different worlds may run on different threads.
pub struct World {
    cell: Rc<WorldCell>,
}

impl World {
    /// Creates a world from a document, with its objects, devices and instances of command plugins.
    pub fn new(document: Arc<Document>, registry: Arc<Registry>) -> Result<Self> {
        Self::with_threads(document, registry, 1)
    }

    /// Like `new`, but with a number of threads, which does not affect the results.
    pub fn with_threads(document: Arc<Document>, registry: Arc<Registry>, threads: usize) -> Result<Self> {
        let pool = pool_of(threads)?;
        let settings = document.settings.clone();
        let (scene, slots) = document.instantiate();
        let origins = slots.iter().map(|s| scene.id(*s)).collect();
        let cell = Rc::new(WorldCell::new(document, registry, settings, scene, origins, pool));
        cell::register_world(&cell);
        let world = World { cell };
        world.cell.run.folders.allow_modules_of(&world.cell.model.document);
        create_devices(&world.cell, &slots)?;
        world.create_instances()?;
        world.cell.restore_process_state("the creation of the world");
        world.cell.restore_process("the creation of the world");
        Scripts::add_from_document(&world.cell, &slots);
        let cell = &world.cell;
        cell.state.dynamics.borrow_mut().update_bodies(&mut cell.state.scene.borrow_mut());
        for (joint, master) in cell.state.scene.borrow().dangling_followers() {
            let text = format!("the joint {joint} should follow `{master}`, but there is no such joint");
            cell.log(TATU_LOG_WARNING, &text);
        }
        for (dummy, link) in cell.state.scene.borrow().dangling_links() {
            let text = format!("the dummy {dummy} should be linked to `{link}`, but there is no such dummy");
            cell.log(TATU_LOG_WARNING, &text);
        }
        for text in cell.state.scene.borrow().open_loops() {
            cell.log(TATU_LOG_WARNING, &text);
        }
        for text in cell.state.dynamics.borrow_mut().take_notices() {
            cell.log(TATU_LOG_WARNING, &text);
        }
        Ok(world)
    }

    /// Returns the mechanical problems of the scene, such as parts that are impossible or hard to simulate. Each
    /// problem is described by one sentence.
    pub fn mechanics(&self) -> Vec<String> {
        tatu_scene::check_mechanics(&self.cell.state.scene.borrow(), &self.cell.model.settings.borrow())
    }

    /// Returns, for each mechanism, the path of its first shape, and its solver with the reason for this choice, in the
    /// order of objects.
    pub fn mechanisms(&self) -> Vec<(String, String)> {
        tatu_scene::describe_solvers(&self.cell.state.scene.borrow())
    }

    /// Calls `f` with the current objects, graphs and drawings.
    pub fn with_scene<T>(&self, f: impl FnOnce(&Scene, &Figures) -> T) -> T {
        f(&self.cell.state.scene.borrow(), &self.cell.devices.figures.borrow())
    }

    /// Runs `f` in the world's thread pool.
    pub fn install<T: Send>(&self, f: impl FnOnce() -> T + Send) -> T {
        self.cell.run.install(f)
    }

    fn create_instances(&self) -> Result {
        let cell = &self.cell;
        cell.devices.instances.borrow_mut().resize_with(cell.model.registry.plugins.len(), || None);
        for (plugin, life) in &cell.model.registry.command_offers.world_lives {
            let made = CommandInstance::create(cell, *plugin, life, cell.devices.next_instance_id())?;
            cell.devices.instances.borrow_mut()[*plugin] = Some(made);
        }
        Ok(())
    }

    /// Notifies the instances of command plugins that the run has ended, so that they discard the state that belongs to
    /// scripts of the run. Instances that cannot do so are recreated.
    fn renew_instances(&self) -> Result {
        let cell = &self.cell;
        for (plugin, life) in &cell.model.registry.command_offers.world_lives {
            let kept = cell.devices.instances.borrow_mut()[*plugin].take();
            let Some(kept) = kept else { continue };
            let renewed = match kept.end_run(cell, *plugin, life) {
                true => kept,
                false => {
                    kept.end(cell, *plugin);
                    CommandInstance::create(cell, *plugin, life, cell.devices.next_instance_id())?
                }
            };
            cell.devices.instances.borrow_mut()[*plugin] = Some(renewed);
        }
        Ok(())
    }

    /// Ends the instances of command plugins for this world.
    fn end_instances(&self) {
        let instances = std::mem::take(&mut *self.cell.devices.instances.borrow_mut());
        for (plugin, i) in instances.into_iter().enumerate() {
            if let Some(i) = i {
                i.end(&self.cell, plugin);
            }
        }
    }

    /// Sets the folder in which scripts can read and write files, in place of the working folder. Fails with E105 if it
    /// is not a folder.
    pub fn set_file_folder(&self, folder: &Path) -> Result {
        let folder = match folder.canonicalize() {
            Ok(folder) if folder.is_dir() => folder,
            Ok(_) => return Err(Error::new("E105", format!("{} is not a folder", folder.display()))),
            Err(e) => return Err(Error::new("E105", format!("cannot use the folder {}: {e}", folder.display()))),
        };
        self.cell.run.folders.set_working_folder(folder);
        Ok(())
    }
    /// Sets the flag with which any thread can request the end of the run. A running script that does not return within
    /// a second of the request is ended.
    pub fn set_interrupt_flag(&self, flag: Arc<AtomicBool>) {
        *self.cell.run.connections.interrupt.borrow_mut() = Some(flag);
    }
    /// Creates a stand-in for each object that scripts look up and that does not exist, and changes the kind of dummies
    /// to the one that their use implies. The values listed in `values`, such as parameters of scripts, exist with
    /// neutral contents. This is meant for runs without a scene, and must be called before the start.
    pub fn enable_stand_ins(&self, values: &[String]) {
        let cell = &self.cell;
        cell::begin_stand_ins(cell, values);
    }
    /// Returns the names of the values, such as signals, that scripts requested but that do not exist, in alphabetical
    /// order.
    pub fn missing_values(&self) -> Vec<String> {
        self.cell.run.stand_ins.missing_values()
    }
    /// Returns the objects of the document, then those created since, each with the kind that its use implied. The
    /// result is empty unless [`enable_stand_ins`](Self::enable_stand_ins) was called.
    pub fn stand_ins(&self) -> Vec<StandIn> {
        self.cell.run.stand_ins.list()
    }

    /// Returns objects that scripts requested but may not need, such as the parent of an object or a child by index.
    /// Each is returned with the index of the object in [`stand_ins`](Self::stand_ins). Scripts usually request these
    /// objects to find the ends of the tree.
    pub fn optional_objects(&self) -> Vec<(usize, OptionalObject)> {
        self.cell.run.stand_ins.optional_objects()
    }

    /// Returns the current registry of plugins.
    pub fn registry(&self) -> Arc<Registry> {
        self.cell.model.registry.shared()
    }
    /// Returns the current document.
    pub fn document(&self) -> Arc<Document> {
        self.cell.model.document.shared()
    }

    /// Returns the log of external inputs since the start.
    pub fn input_log(&self) -> std::cell::Ref<'_, InputLog> {
        self.cell.run.connections.record.log.borrow()
    }
    /// Returns the input log mutably, to set whether and where records are stored.
    pub fn input_log_mut(&self) -> std::cell::RefMut<'_, InputLog> {
        self.cell.run.connections.record.log.borrow_mut()
    }
    /// Adds an external input at the current barrier, before the next step, and records it in the input log. If `kind`
    /// is "key", it is a key press, and `text` is its character or name. "clock" (time since the start, s) and "epoch"
    /// (Unix time, s) set the clocks that scripts and plugins read. Other kinds are passed to plugins.
    pub fn put_in(&self, kind: &str, text: &str) {
        cell::put_in(&self.cell, kind, text);
    }
    /// Attaches an input log, whose inputs are repeated at their barriers. Must be called before the start.
    pub fn attach_log(&self, records: Arc<[InputRecord]>) {
        barrier::log::attach(&self.cell, records);
    }
    /// Attaches an input log that begins when the scene was opened, and repeats the inputs from before the start of the
    /// simulation.
    pub fn attach_session_log(&self, records: Arc<[InputRecord]>) {
        barrier::log::attach_and_repeat_session(&self.cell, records);
    }
    /// Returns the names of the files that scripts or plugins have requested to read since the start. The contents of
    /// these files are not part of the input log.
    pub fn files_opened(&self) -> Vec<String> {
        self.cell.run.connections.opened_files.borrow().iter().cloned().collect()
    }
    pub(crate) fn cell(&self) -> &Rc<WorldCell> {
        &self.cell
    }

    /// Returns the simulation time, s.
    pub fn time(&self) -> f64 {
        self.cell.state.clock.time.get()
    }
    /// Returns the number of steps since the start.
    pub fn steps(&self) -> u64 {
        self.cell.state.clock.step.get()
    }
    /// Returns the duration of a step, s.
    pub fn dt(&self) -> f64 {
        self.cell.state.clock.dt.get()
    }
    /// Returns the hash of the dynamic state, with a hash per object.
    pub fn hash(&self) -> StateHash {
        let (scene, dynamics) = (self.cell.state.scene.borrow(), self.cell.state.dynamics.borrow());
        state::hash(&scene, &dynamics, &self.cell.devices.actuators.borrow(), &self.cell.state.clock)
    }
    /// Returns a summary of each script, in the order in which the scripts were added.
    pub fn scripts(&self) -> Vec<crate::cell::ScriptSummary> {
        crate::cell::Scripts::summaries(&self.cell)
    }
    /// Returns a summary of each part, in the order in which they are called.
    pub fn parts(&self) -> Vec<crate::cell::PartSummary> {
        parts::summaries(&self.cell)
    }
    /// Returns all faults so far.
    pub fn faults(&self) -> Vec<Fault> {
        self.cell.run.faults.borrow().clone()
    }
    /// Takes the lines logged since the last call.
    pub fn take_lines(&self) -> Vec<LogLine> {
        self.cell.run.lines.take()
    }
    /// Returns whether there are log lines that have not been taken.
    pub fn has_lines(&self) -> bool {
        self.cell.run.lines.has_lines()
    }
    /// Returns the store of log lines, for a program that exits while a step is running.
    pub fn lines(&self) -> LogBuffer {
        self.cell.run.lines.clone()
    }
    /// Returns the path and the pose (position in m, quaternion x y z w) of every model base, in the order of slots.
    pub fn model_bases(&self) -> Vec<(String, [f64; 7])> {
        let scene = self.cell.state.scene.borrow();
        let mut paths = scene.paths();
        let bases = scene.slots().map(|(s, _)| s).filter(|s| scene.is_model_base(*s));
        bases.filter_map(|s| Some((paths.remove(&s)?, pose_to_array(&scene.world(s))))).collect()
    }
    /// Returns a document that describes the current state as a scene. It does not contain velocities or the internal
    /// state of scripts and devices.
    pub fn to_document(&self) -> Document {
        crate::state::save::document_of(&self.cell, 0)
    }
    /// Returns the observable state of an object, given by path or unique name, or `None` if it does not exist.
    pub fn observe(&self, path: &str) -> Option<ObjectState> {
        let cell = &self.cell;
        let scene = cell.state.scene.borrow();
        let slot = scene.find(0, path)?;
        let o = scene.get(slot)?;
        let pose = pose_to_array(&scene.world(slot));
        let twist = cell.state.twist(&scene, &cell.state.dynamics.borrow(), slot);
        let sensing = cell.devices.sensing.borrow();
        let reading = sensing.device(slot).map(|d| {
            let kind = &cell.model.registry.sensors[d.kind];
            kind.fields.iter().enumerate().map(|(i, f)| (f.name.clone(), d.value(kind, i))).collect()
        });
        let joint = o.joint().map(|j| [j.position, j.velocity, j.effort]);
        Some(ObjectState { path: scene.path(slot), pose, twist, joint, reading })
    }
    /// Returns the path that is most similar to `path`, which does not exist, or `None` if no path is similar enough.
    pub fn nearest(&self, path: &str) -> Option<String> {
        self.cell.state.scene.borrow().nearest(path)
    }
    /// Returns the contacts between shapes after the last step: the paths of the two shapes, and the normal force, N.
    pub fn contacts(&self) -> Vec<(String, String, f64)> {
        let scene = self.cell.state.scene.borrow();
        let dynamics = self.cell.state.dynamics.borrow();
        dynamics.contacts(&scene).map(|(a, b, c)| (scene.path(a), scene.path(b), c.force)).collect()
    }
    /// Returns the graphs and drawings. Graphs retain their samples when the world stops.
    pub fn figures(&self) -> std::cell::Ref<'_, Figures> {
        self.cell.devices.figures.borrow()
    }
    /// Returns the gravitational acceleration, m/s^2.
    pub fn gravity(&self) -> Vector3<f64> {
        self.cell.model.settings.borrow().gravity
    }
}

/// The observable state of an object.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectState {
    /// Path of the object.
    pub path: String,
    /// World pose: position x y z, m, and quaternion x y z w.
    pub pose: [f64; 7],
    /// Linear and angular velocity in the world frame, m/s and rad/s.
    pub twist: [f64; 6],
    /// Position (m or rad), velocity (m/s or rad/s) and effort (N or N m) of a joint; `None` for other objects.
    pub joint: Option<[f64; 3]>,
    /// Names and values of the fields of the last reading; `None` for objects without readings.
    pub reading: Option<Vec<(String, Value)>>,
}

impl World {
    /// Ends all plugin instances of this world; errors are reported in [`faults`](Self::faults). Afterwards the world
    /// is read-only. Dropping it has the same effect.
    pub fn end(&self) {
        let cell = &self.cell;
        Scripts::end(cell);
        if cell.running() {
            parts::end_all(cell);
            cell.state.phase.set(Phase::Stopped);
            barrier::cancel_service_waits(cell);
        }
        barrier::notify_world_end(cell);
        end_devices(cell);
        self.end_instances();
        cell.restore_process_state("the end of the world");
        cell.restore_process("the run");
    }
}

impl Drop for World {
    fn drop(&mut self) {
        self.end();
    }
}
