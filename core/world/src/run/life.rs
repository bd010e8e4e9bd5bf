//! A run from its start to its end.
//!
//! ```text
//! start             customization scripts have their pass, `beforeSimulation`; the scene is remembered; phase first
//! step, step, ...   one pass each
//! request_stop      the pass that follows is an ordinary one
//! step              running
//! step              stopping
//! step              last, with the clean-up of scripts at its end
//! step              no pass: the scene goes back to how it was at the start; stopped, `false`
//! ```

use std::{collections::BTreeMap, path::Path, rc::Rc, sync::Arc};

use tatu_errors::{Error, Fault, FaultKind, Result};
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_scene::{
    Data, Dynamics, Scene,
    document::{Document, ScriptSpec},
    rows,
};

use super::World;
use crate::{
    cell::{Model, NextScene, OUTSIDE_KINDS, Phase, Scripts, WorldCell},
    events,
    instances::{note_devices, remake_devices},
    recording, session, step,
};

impl World {
    /// What the world is doing.
    pub fn phase(&self) -> Phase {
        self.cell.state.phase.get()
    }

    /// A pass while it is stopped: scripts that live as long as the world have their turn. Nothing, while it runs.
    pub fn idle(&self) {
        if !self.cell.running() {
            self.cell.state.rested.set(true);
            step::idle(&self.cell);
        }
    }

    /// Starts: time is 0, the states of child scripts are made. Their first callbacks run in the first step. A world
    /// that never had a pass while stopped has one first.
    pub fn start(&self) {
        let cell = &self.cell;
        if cell.running() {
            return;
        }
        if !cell.state.rested.get() {
            self.idle();
        }
        Scripts::before_run(cell);
        self.prepare();
    }

    /// The same without a callback: for a state that is about to be restored.
    pub(crate) fn start_silently(&self) {
        Scripts::begin(&self.cell, false);
        self.cell.state.rested.set(true);
        self.prepare();
    }

    fn prepare(&self) {
        let cell = &self.cell;
        *cell.model.initial.borrow_mut() = Some(cell.state.scene.borrow().clone());
        note_devices(cell);
        cell.state.clock.time.set(0.0);
        cell.state.clock.step.set(0);
        cell.state.requests.set(0);
        cell.devices.figures.borrow_mut().begin(&cell.state.scene.borrow());
        recording::check(cell);
        report_lacks(cell);
        cell.state.phase.set(Phase::First);
        cell.run.outside.begin();
        Scripts::begin(cell, true);
        cell.restore_process_state("the start of scripts");
    }

    /// One pass, and whether the world still runs.
    ///
    /// In a session services have their turn first, and may hold the world: then this sleeps until they let go. If a
    /// stop is asked for meanwhile, or the session is interrupted, no pass is done: see
    /// [`stop_requested`](Self::stop_requested). The passes after a stop was asked for follow with the next calls.
    pub fn step(&self) -> bool {
        if self.barrier() { self.step_on() } else { self.cell.running() }
    }

    /// What comes before the next pass, without the pass; `false`: no pass is to be done. For a replay of a run that
    /// was ended within a barrier.
    pub fn barrier(&self) -> bool {
        if self.cell.state.over.replace(false) {
            self.finish();
        }
        session::before_step(&self.cell)
    }

    /// The pass that comes after [`barrier`](Self::barrier); whether the world still runs.
    pub fn step_on(&self) -> bool {
        if self.cell.running() && !self.cell.state.over.get() {
            step::step(&self.cell);
        }
        self.cell.running()
    }

    /// Asks for a stop: the next three passes are the last ones.
    pub fn request_stop(&self) {
        self.request(TATU_REQUEST_STOP);
    }

    /// Asks for a pause: the next two passes are the last ones before it. It stands in the input log.
    pub fn request_pause(&self) {
        session::outside_request(&self.cell, TATU_REQUEST_PAUSE);
    }

    /// Ends a pause, or cancels a requested one. Recorded in the input log.
    pub fn request_start(&self) {
        session::outside_request(&self.cell, TATU_REQUEST_START);
    }

    fn request(&self, what: u32) {
        self.cell.state.requests.set(self.cell.state.requests.get() | 1 << what);
    }

    /// Somebody stands by who can lift a pause: a terminal, for instance. Otherwise a pause that no service and no
    /// add-on can lift ends the run.
    pub fn set_interactive(&self, on: bool) {
        self.cell.run.outside.interactive.set(on);
    }

    /// The program goes on with another scene when a service asks for one: see [`next_scene`](Self::next_scene). `read`
    /// reads it (an empty path means the current scene); its error is returned to the service that asked, and this
    /// world continues.
    pub fn take_scenes(&self, read: impl Fn(&Path) -> Result<Arc<Document>> + 'static) {
        *self.cell.run.outside.scene_reader.borrow_mut() = Some(Rc::new(read));
    }

    /// The scene that was asked for since the last call.
    pub fn next_scene(&self) -> Option<NextScene> {
        self.cell.run.outside.next_scene.borrow_mut().take()
    }

    /// The program has changed something of its process since the world was made (what signals do): plugins are to
    /// leave it so.
    pub fn take_process_anew(&self) {
        self.cell.border.home.borrow_mut().take_process_anew();
    }

    /// Writes a line, as the host does.
    pub fn say(&self, level: u32, text: &str) {
        self.cell.log(level, text);
    }

    /// Whether something asked for a stop.
    pub fn stop_requested(&self) -> bool {
        self.cell.stop_requested()
    }

    /// Asks for a stop and carries it out: scripts see the end coming, clean up and end, the scene goes back to how it
    /// was at the start.
    pub fn stop(&self) {
        if self.cell.running() {
            self.request_stop();
        }
        while self.cell.running() {
            self.step();
        }
    }

    /// Adds a script that is part of no document: of kind "addon" or "sandbox". It lives as long as the world, and is
    /// called after all others. Its slot; an error when its kind is another, or no slot is free.
    pub fn attach(&self, spec: &ScriptSpec) -> Result<u32> {
        let kinds = OUTSIDE_KINDS;
        if !kinds.contains(&spec.kind.as_str()) {
            let error = Error::new("E102", format!("a script of kind `{}` is not attached to a world", spec.kind));
            return Err(error.expected(kinds.join(", ")));
        }
        Scripts::add(&self.cell, 0, spec).ok_or_else(|| Error::new("E401", "the world has no room for another script"))
    }

    /// At the end of a run: ends states, and resets the scene to its state at the start.
    fn finish(&self) {
        let cell = &self.cell;
        Scripts::end_run(cell);
        cell.state.phase.set(Phase::Stopped);
        cell.state.requests.set(cell.state.requests.get() & 1 << TATU_REQUEST_QUIT);
        session::stopped(cell);
        if let Err(e) = self.renew_instances() {
            cell.report(Fault::new(FaultKind::Plugin, e.text));
        }
        cell.restore_process_state("the end of the run");
        cell.state.signals.borrow_mut().retain(|_, s| !s.of_run);
        cell.devices.figures.borrow_mut().end();
        if let Some(initial) = cell.model.initial.borrow_mut().take() {
            go_back(cell, initial);
        }
        remake_devices(cell);
        Scripts::end_removed(cell);
        Scripts::after_run(cell);
        events::deliver(cell);
        cell.restore_process_state("the end of the run");
        cell.restore_process("the run");
    }
}

/// Free data stays, but for what plugins keep there of an object: tags that begin with a control character.
fn leave(then: &mut BTreeMap<Vec<u8>, Vec<u8>>, now: &BTreeMap<Vec<u8>, Vec<u8>>) {
    let free = |tag: &[u8]| tag.first().is_none_or(|c| !c.is_ascii_control());
    then.retain(|tag, _| !free(tag));
    then.extend(now.iter().filter(|(tag, _)| free(tag)).map(|(tag, data)| (tag.clone(), data.clone())));
}

/// The scene as it was at the start, but for what a stop leaves.
fn go_back(cell: &WorldCell, mut initial: Scene) {
    let mut scene = cell.state.scene.borrow_mut();
    for (slot, now) in scene.slots() {
        if initial.get(slot).is_some_and(|o| o.uid == now.uid) {
            initial.set_name(slot, now.alias(), now.suffix());
        }
        if let Some(then) = initial.get_mut(slot).filter(|o| o.uid == now.uid) {
            then.layer = now.layer;
            leave(&mut then.notes, &now.notes);
            if let (Data::Shape(then), Data::Shape(now)) = (&mut then.data, &now.data) {
                (then.color, then.mass, then.inertia) = (now.color, now.mass, now.inertia);
            }
        }
    }
    leave(&mut initial.notes, &scene.notes);
    // What the engine and the beams made of the running scene is not what they make of this one.
    initial.shape_version = scene.shape_version + 1;
    initial.forget_before();
    *scene = initial;
    *cell.state.dynamics.borrow_mut() = Dynamics::new(Model::engine_settings(&cell.model.settings.borrow()));
    cell.devices.sensing.borrow_mut().forget_scene();
    for (slot, _) in scene.clone().slots() {
        match scene.get_mut(slot).map(|o| &mut o.data) {
            Some(Data::Shape(s)) => s.body.0 = None,
            Some(Data::Joint(j)) => j.id = None,
            _ => {}
        }
    }
    cell.state.dynamics.borrow_mut().settle(&mut scene);
}

impl World {
    /// A property of an object, by path or unique name, and key; `None`: there is none.
    pub fn property(&self, path: &str, key: &str) -> Option<Value> {
        let scene = self.cell.state.scene.borrow();
        let row = rows::ROWS.iter().position(|r| r.key == key)?;
        tatu_scene::get(&scene, scene.find(0, path)?, rows::Row::of(row as u32)).ok()
    }
}

/// What of its sources cannot run here is a fault of each run, so that none of them passes for a whole one.
fn report_lacks(world: &WorldCell) {
    let settings = &world.model.document.settings;
    settings.lacks.iter().for_each(|text| world.report(Fault::new(FaultKind::Unsupported, text.as_str())));
}
