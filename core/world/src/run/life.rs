//! The run of a world, from its start to its end.
//!
//! ```text
//! start             a pass before the run, with `beforeSimulation`; the scene is saved; phase first
//! step, step, ...   one pass each
//! request_stop      the pass that follows is an ordinary one
//! step              running
//! step              stopping
//! step              last, with the clean-up of scripts at its end
//! step              no pass: the scene is restored to its state at the start; stopped, `false`
//! ```

use std::{path::Path, rc::Rc, sync::Arc};

use tatu_errors::{Error, Fault, FaultKind, Result};
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_scene::{
    document::{Document, REFEREE_KIND, ScriptSpec, SourceFiles},
    property_table::Property,
};

use super::World;
use crate::{
    cell::{NextScene, OUTSIDE_KINDS, Phase, Scripts, WorldCell},
    events, parts, recording, session,
    state::memento,
    step,
};

impl World {
    /// Returns the current phase.
    pub fn phase(&self) -> Phase {
        self.cell.state.phase.get()
    }

    /// Runs a pass while the simulation is stopped, in which scripts that live as long as the world are called. Does
    /// nothing if it is running.
    pub fn idle(&self) {
        if !self.cell.running() {
            self.cell.state.stopped_pass_done.set(true);
            step::run_stopped_pass(&self.cell);
        }
    }

    /// Starts the simulation: sets the time to 0, and creates the states of child scripts, whose first callbacks run in
    /// the first step. If no pass has run while the simulation was stopped, runs one first.
    pub fn start(&self) {
        let cell = &self.cell;
        if cell.running() {
            return;
        }
        // Errors of a former run are reported again, but those from before the first run are not.
        if cell.state.clock.step.get() > 0 {
            cell.run.reported.borrow_mut().clear();
        }
        if !cell.state.stopped_pass_done.get() {
            self.idle();
        }
        Scripts::before_run(cell);
        self.prepare();
    }

    /// Starts the world without calling scripts, for a state that is about to be restored.
    pub(crate) fn start_silently(&self) {
        Scripts::begin(&self.cell, false);
        self.cell.state.stopped_pass_done.set(true);
        self.prepare();
    }

    fn prepare(&self) {
        let cell = &self.cell;
        let start = memento::capture(cell);
        *cell.model.initial.borrow_mut() = Some(start);
        cell.state.clock.time.set(0.0);
        cell.state.clock.step.set(0);
        cell.state.requests.set(0);
        cell.devices.figures.borrow_mut().begin(&cell.state.scene.borrow());
        recording::warn_of_invalid_streams(cell);
        report_unsupported_parts(cell);
        cell.state.phase.set(Phase::First);
        cell.run.connections.begin();
        Scripts::begin(cell, true);
        cell.restore_process_state("the start of scripts");
    }

    /// Runs one pass, and returns whether the world is still running.
    ///
    /// In a session, services have their turns first and can hold the world. In that case, this method sleeps until
    /// they release it. If a stop is requested in the meantime or the session is interrupted, no pass is run: see
    /// [`stop_requested`](Self::stop_requested). The next calls run the passes that follow a requested stop.
    pub fn step(&self) -> bool {
        if self.barrier() { self.step_on() } else { self.cell.running() }
    }

    /// Runs the barrier before the next pass, but not the pass itself. Returns `false` if no pass may follow. This is
    /// required to replay a run that ended within a barrier.
    pub fn barrier(&self) -> bool {
        if self.cell.state.last_pass_done.replace(false) {
            self.finish();
        }
        session::before_step(&self.cell)
    }

    /// Runs the pass that follows [`barrier`](Self::barrier), and returns whether the world is still running.
    pub fn step_on(&self) -> bool {
        if self.cell.running() && !self.cell.state.last_pass_done.get() {
            step::step(&self.cell);
        }
        self.cell.running()
    }

    /// Requests a stop, before which three more passes are run, or four at the start of a run, during a pause or right
    /// after one.
    pub fn request_stop(&self) {
        self.request(TATU_REQUEST_STOP);
    }

    /// Requests a pause, before which two more passes are run, or three at the start of a run or right after a pause.
    /// The request is recorded in the input log.
    pub fn request_pause(&self) {
        session::request_from_program(&self.cell, TATU_REQUEST_PAUSE);
    }

    /// Ends a pause, or cancels a requested pause. The request is recorded in the input log.
    pub fn request_start(&self) {
        session::request_from_program(&self.cell, TATU_REQUEST_START);
    }

    fn request(&self, what: u32) {
        self.cell.state.requests.set(self.cell.state.requests.get() | 1 << what);
    }

    /// Sets whether a user is present who can end a pause, for example at a terminal. If not, a pause that neither a
    /// service nor an add-on can end ends the run.
    pub fn set_interactive(&self, on: bool) {
        self.cell.run.connections.interactive.set(on);
    }

    /// Lets services request a different scene: see [`next_scene`](Self::next_scene). `read` loads the scene file with
    /// the given path, with the given sources if there are any; an empty path stands for the current scene. If `read`
    /// fails, the error is returned to the service, and this world continues.
    pub fn set_scene_reader(&self, read: impl Fn(&Path, Option<SourceFiles>) -> Result<Arc<Document>> + 'static) {
        *self.cell.run.connections.scene_change.scene_reader.borrow_mut() = Some(Rc::new(read));
    }

    /// Takes the scene that was requested since the last call, if any.
    pub fn next_scene(&self) -> Option<NextScene> {
        self.cell.run.connections.scene_change.next_scene.borrow_mut().take()
    }

    /// Records the current process state, such as signal handlers, as the state that plugins must leave unchanged. Must
    /// be called after the program has changed it.
    pub fn record_process_state(&self) {
        self.cell.monitor.process_state.borrow_mut().recapture_process();
    }

    /// Logs a line at a level, `TATU_LOG_*`.
    pub fn log(&self, level: u32, text: &str) {
        self.cell.log(level, text);
    }

    /// Returns whether a stop has been requested.
    pub fn stop_requested(&self) -> bool {
        self.cell.stop_requested()
    }

    /// Requests a stop, and runs the remaining passes: scripts are notified and clean up, and the scene is restored to
    /// its state at the start.
    pub fn stop(&self) {
        if self.cell.running() {
            self.request_stop();
        }
        while self.cell.running() {
            self.step();
        }
    }

    /// Adds a script that is not part of the document, of kind "addon", "sandbox" or "referee". It is called after all
    /// others, and lives as long as the world, but a referee from start to stop. Returns its slot, or an error if it has a
    /// different kind or no slot is free.
    pub fn attach(&self, spec: &ScriptSpec) -> Result<u32> {
        let kinds = OUTSIDE_KINDS;
        if !kinds.contains(&spec.kind.as_str()) && spec.kind != REFEREE_KIND {
            let error = Error::new("E102", format!("a script of kind `{}` cannot be attached to a world", spec.kind));
            return Err(error.expected(format!("{}, {REFEREE_KIND}", kinds.join(", "))));
        }
        Scripts::add(&self.cell, 0, spec)
            .ok_or_else(|| Error::new("E401", "the world has no free slot for another script"))
    }

    /// Ends the run: ends the states of its scripts, and restores the scene to its state at the start.
    fn finish(&self) {
        let cell = &self.cell;
        Scripts::end_run(cell);
        parts::end_all(cell);
        cell.state.phase.set(Phase::Stopped);
        cell.state.requests.set(cell.state.requests.get() & 1 << TATU_REQUEST_QUIT);
        session::cancel_service_waits(cell);
        if let Err(e) = self.renew_instances() {
            cell.report(Fault::new(FaultKind::Plugin, e.text));
        }
        cell.restore_process_state("the end of the run");
        cell.state.signals.borrow_mut().retain(|_, s| !s.ends_with_run);
        cell.devices.figures.borrow_mut().end();
        let start = cell.model.initial.borrow_mut().take();
        if let Some(start) = start {
            memento::end_run(cell, start);
        }
        Scripts::after_run(cell);
        events::deliver(cell);
        cell.restore_process_state("the end of the run");
        cell.restore_process("the run");
    }
}

impl World {
    /// Returns a property of an object, given by path or unique name, or `None` if it does not exist.
    pub fn property(&self, path: &str, key: &str) -> Option<Value> {
        let scene = self.cell.state.scene.borrow();
        tatu_scene::get(&scene, scene.find(0, path)?, Property::by_key(key)?).ok()
    }
}

/// Reports parts of the document's sources that are not supported. Each run reports them as faults, so that its results
/// are not mistaken for those of the complete scene.
fn report_unsupported_parts(world: &WorldCell) {
    let settings = &world.model.document.settings;
    settings.lacks.iter().for_each(|text| world.report(Fault::new(FaultKind::Unsupported, text.as_str())));
}
