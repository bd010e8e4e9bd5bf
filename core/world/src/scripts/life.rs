//! The life cycle of scripts: when each callback is called.
//!
//! | moment | child scripts | customization scripts, add-ons, sandbox |
//! |---|---|---|
//! | a pass while stopped | | begin if they have not; threads, `nonSimulation` |
//! | start | states are created | `beforeSimulation` |
//! | each pass | `beforeStep`; begin if they have not; threads, `actuation`; `sensing` | the same |
//! | a pause | `suspend`, `suspended` in each pass, `resume` | the same |
//! | end of the last pass | `cleanup`, states end | |
//! | scene restored | | `afterSimulation` |
//! | end of the world | | `cleanup` |
//!
//! Referees are called like child scripts, but begin as soon as their states exist, before the first pass.
//!
//! A driver, which is a script of kind `main`, is called before the other scripts, and requests the stages in which
//! they are called.

use std::rc::Rc;

use tatu_plugin_api::{abi::*, safe::Value};

use super::answers::map_entry;
use crate::cell::{Callback, Phase, Script, ScriptKind, Scripts, WorldCell};

impl Scripts {
    /// Creates the states of scripts that have no state yet, and loads their sources. If `ends_with_run` is set, this
    /// applies to child scripts and the driver, otherwise to all other scripts.
    pub fn begin(world: &WorldCell, of_run: bool) {
        let (mut i, mut any) = (0, of_run);
        while let Some(script) = Self::nth(world, i) {
            i += 1;
            if script.kind.ends_with_run() == of_run
                && script.instance.id.get() == 0
                && (of_run || !script.progress.ended.get())
            {
                script.begin(world);
                any = true;
            }
        }
        if any {
            Self::choose_order(world);
        }
        if of_run {
            // Referees see the scene before any other script of the run has changed it.
            for script in Self::in_order(world).iter().filter(|s| s.kind == ScriptKind::Referee) {
                script.ensure_initialised(world);
            }
        }
    }

    /// While the simulation is stopped, begins the scripts that live as long as the world, resumes their commands, and
    /// runs their `nonSimulation` callbacks.
    pub fn idle(world: &WorldCell) {
        Self::begin(world, false);
        Self::each_called(world, |script| {
            if !script.kind.ends_with_run() {
                script.ensure_initialised(world);
                script.resume_waits(world);
                script.run_if_begun(world, Callback::NonSimulation, &[]);
            }
        });
    }

    /// Calls the `run` callback of add-ons, at the end of a pass of any kind.
    pub fn run_addons(world: &WorldCell) {
        if Self::any_has(world, Callback::Run) {
            Self::each_called(world, |script| {
                if script.kind >= ScriptKind::Addon {
                    script.run_if_begun(world, Callback::Run, &[]);
                }
            });
        }
    }

    /// Creates the states of the scripts that live as long as the world, and calls a callback of one of them before any
    /// other.
    pub fn call_first(world: &WorldCell, slot: u32, callback: &str) -> Option<Value> {
        Self::begin(world, false);
        let script = world.run.scripts.borrow().by_slot(slot).filter(|s| s.is_live(world))?;
        let number = script.find(world, TATU_FIND_CALLBACK, callback.as_bytes());
        script.query_callback(world, number, &[])
    }

    /// Runs a script that is not part of the document once, up to its `init`, and removes it without calling it again.
    pub fn run_once(world: &WorldCell, slot: u32) {
        Self::call_first(world, slot, "init");
        let script = world.run.scripts.borrow().by_slot(slot);
        if let Some(script) = script {
            script.end(world);
        }
        {
            let mut scripts = world.run.scripts.borrow_mut();
            scripts.list.retain(|s| s.slot != slot);
            scripts.sorted_at = 0;
        }
        world.state.scene.borrow_mut().remove(slot);
    }

    /// Calls `beforeSimulation` after a start was requested, before anything is prepared.
    pub fn before_run(world: &WorldCell) {
        Self::each_has(world, Callback::BeforeSimulation);
    }

    /// Calls `beforeStep` before the stages of a pass, and returns whether a script requests that the pass be skipped.
    pub fn before_step(world: &WorldCell) -> bool {
        let mut hold = false;
        if Self::any_has(world, Callback::BeforeStep) {
            for script in &*Self::in_order(world) {
                let number = script.number(Callback::BeforeStep);
                if number == 0
                    || !script.progress.initialised.get()
                    || !script.is_live(world)
                    || script.kind == ScriptKind::Main
                {
                    continue;
                }
                let answer = script.query_callback(world, number, &[]);
                script.carry_out_request(world);
                hold |= answer.is_some_and(|a| map_entry(&a, "skip") == Some(&Value::Bool(true)));
            }
        }
        hold
    }

    /// Runs the actuation of all scripts. For each script, calls `init` if it has not begun, and resumes commands that
    /// have finished waiting, before the callback.
    pub fn actuate(world: &WorldCell) {
        Self::begin_turn(world, TATU_STAGE_ACTUATE);
        Self::each_in_turn(world, Callback::Actuation, |script| script.actuate(world, &[]));
    }

    /// Runs the sensing of all scripts.
    pub fn react(world: &WorldCell) {
        Self::begin_turn(world, TATU_STAGE_REACT);
        Self::each_in_turn(world, Callback::Sensing, |script| script.react(world, &[]));
    }

    /// Starts a new turn of a stage, in which no script has been called yet.
    fn begin_turn(world: &WorldCell, stage: u32) {
        let turn = &world.run.scripts.borrow().turns[turn_index(stage)];
        turn.set(turn.get() + 1);
    }

    /// Calls, in order, the child scripts below an object that the running stage has not called yet. Returns the number
    /// of scripts called.
    pub fn call_below(world: &WorldCell, above: u32, stage: u32, args: &[tatu_value]) -> u32 {
        let runs = world.run.stages.try_borrow().is_ok_and(|s| s.iter().any(|(running, _)| *running == stage));
        if !runs || ![TATU_STAGE_ACTUATE, TATU_STAGE_REACT].contains(&stage) {
            return 0;
        }
        let mut n = 0;
        for script in &*Self::in_order(world) {
            let is_below = world.state.scene.try_borrow().is_ok_and(|scene| {
                let mut at = scene.get(script.slot).map_or(0, |o| o.parent);
                while at != 0 && at != above {
                    at = scene.get(at).map_or(0, |o| o.parent);
                    if at == above {
                        return true;
                    }
                }
                false
            });
            if !is_below || script.kind != ScriptKind::Child || script.had_turn(world, stage) {
                continue;
            }
            script.begin_if_late(world);
            if script.is_live(world) {
                n += 1;
                if stage == TATU_STAGE_ACTUATE { script.actuate(world, args) } else { script.react(world, args) }
            }
        }
        n
    }

    /// Calls a callback for the beginning, each pass or the end of a pause: first the driver's, then those of all other
    /// scripts.
    pub fn pause(world: &WorldCell, callback: Callback) {
        if let Some(driver) = Self::driver(world) {
            driver.run_if_begun(world, callback, &[]);
        }
        Self::each_has(world, callback);
    }

    /// Calls the `cleanup` callbacks of the run's scripts at the end of the last pass, each of them once.
    pub fn clean_up(world: &WorldCell) {
        for script in &*Self::in_order(world) {
            if script.kind.ends_with_run() {
                script.clean_up(world);
            }
        }
    }

    /// Ends the states of the run's scripts.
    pub fn end_run(world: &WorldCell) {
        Self::clean_up(world);
        let mut i = 0;
        while let Some(script) = Self::nth(world, i) {
            i += 1;
            if script.kind.ends_with_run() {
                script.end(world);
            }
        }
    }

    /// Calls `afterSimulation`, after the scene has been restored to its initial state.
    pub fn after_run(world: &WorldCell) {
        Self::each_has(world, Callback::AfterSimulation);
    }

    /// Cleans up all remaining scripts, then ends their states. Customization scripts are cleaned up in reverse order.
    pub fn end(world: &WorldCell) {
        Self::end_run(world);
        let all = Self::in_order(world);
        let (scene, outside): (Vec<_>, Vec<_>) = all.iter().partition(|s| s.kind < ScriptKind::Addon);
        for script in scene.into_iter().rev().chain(outside) {
            script.clean_up(world);
        }
        let mut i = 0;
        while let Some(script) = Self::nth(world, i) {
            i += 1;
            script.end(world);
        }
    }
}

impl Script {
    /// Creates the state of a script that was added while the world runs.
    pub(super) fn begin_if_late(&self, world: &WorldCell) {
        if self.progress.late.get() && self.instance.id.get() == 0 && !self.progress.ended.get() {
            self.begin(world);
        }
    }

    /// Calls `f` with the script, unless it is the driver. If it was added while the simulation was running, it begins
    /// first.
    pub(super) fn call_unless_driver(self: &Rc<Self>, world: &WorldCell, f: impl Fn(&Rc<Self>)) {
        self.begin_if_late(world);
        if self.kind != ScriptKind::Main && self.is_live(world) {
            f(self);
        }
    }

    /// Calls `init` and starts the thread of a script that has not begun.
    fn ensure_initialised(self: &Rc<Self>, world: &WorldCell) {
        if !self.progress.initialised.get() && self.is_live(world) {
            self.initialise(world);
        }
    }

    /// Runs the script's actuation, once per turn of the stage.
    fn actuate(self: &Rc<Self>, world: &WorldCell, args: &[tatu_value]) {
        if self.try_begin_turn(world, TATU_STAGE_ACTUATE) {
            self.ensure_initialised(world);
            self.resume_waits(world);
            self.run_if_begun(world, Callback::Actuation, args);
        }
    }

    /// Runs the script's sensing, once per turn of the stage.
    fn react(self: &Rc<Self>, world: &WorldCell, args: &[tatu_value]) {
        if self.try_begin_turn(world, TATU_STAGE_REACT) {
            self.ensure_initialised(world);
            self.run_if_begun(world, Callback::Sensing, args);
        }
    }

    /// Marks the script as called in this turn of a stage; returns `false` if it was called before.
    fn try_begin_turn(&self, world: &WorldCell, stage: u32) -> bool {
        let now = world.run.scripts.borrow().turns[turn_index(stage)].get();
        self.counters.called_in[turn_index(stage)].replace(now) != now
    }
    /// Returns whether the script was called in this turn of a stage.
    fn had_turn(&self, world: &WorldCell, stage: u32) -> bool {
        self.counters.called_in[turn_index(stage)].get() == world.run.scripts.borrow().turns[turn_index(stage)].get()
    }

    /// Runs one pass of the driver: first `init`, then its callbacks, which request the stages, and in the last pass
    /// `cleanup`. Returns whether the driver could run. If it could not be loaded or initialised, or has exceeded its
    /// budget, no stage is run; steps are counted, but simulation time does not advance.
    pub fn drive(self: &Rc<Self>, world: &WorldCell) -> bool {
        if !self.is_live(world) {
            return false;
        }
        self.ensure_initialised(world);
        self.resume_waits(world);
        self.run_if_begun(world, Callback::Actuation, &[]);
        self.run_if_begun(world, Callback::Sensing, &[]);
        let works = self.progress.initialised.get() && !self.progress.cleaned.get() && self.is_live(world);
        if world.state.phase.get() == Phase::Last {
            // The driver may request the clean-up of the other scripts itself.
            self.clean_up(world);
        }
        works
    }
}

/// Returns the index of a stage among those that call scripts.
pub(super) fn turn_index(stage: u32) -> usize {
    usize::from(stage != TATU_STAGE_ACTUATE)
}
