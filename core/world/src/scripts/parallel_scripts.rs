//! Scripts that run in parallel, on all threads of the world.
//!
//! A scene can permit this for a script (`side_by_side = true`). Consecutive scripts of this type then read the world
//! in its state when the first of them was called, and their changes are applied in script order after all of them have
//! run. They can therefore run in any order and on several threads. The same rules apply with a single thread, so the
//! number of threads does not affect the results.
//!
//! A script that cannot run in parallel at present (it has not begun, it waits, or its language does not support it)
//! runs alone after the others.

use std::{
    rc::Rc,
    sync::atomic::{AtomicUsize, Ordering::Relaxed},
};

use tatu_plugin_api::abi::*;
use tatu_plugins::thread_grant::ThreadGrant;

use super::life::turn_index;
use crate::{
    calls::clone_error,
    cell::{Callback, DeferredEffect, ExitRequest, Script, ScriptKind, ScriptWorker, WaitOwner, WorkerView, WorldCell},
};

/// Number of consecutive scripts that a thread runs at a time, because neighbouring scripts share cache lines.
const SCRIPTS_PER_CHUNK: usize = 32;

/// Returns how many of the next scripts are permitted to run in parallel.
pub(super) fn parallel_count(world: &WorldCell, order: &[Rc<Script>]) -> usize {
    // Stand-ins are created when scripts look up objects, which requires access to the world itself.
    if world.run.stand_ins.is_on() {
        return 0;
    }
    order.iter().take_while(|s| s.side_by_side).count()
}

/// Data that the threads of a stage share.
struct ParallelStage<'a> {
    world: &'a WorldCell,
    order: &'a [Rc<Script>],
    callback: Callback,
    /// Index of the stage, and number of its current turn, which show whether a script has been called in this turn.
    turn: (usize, u64),
    /// Whether any command is waiting. If not, the scripts need not be checked for waiting commands.
    waits: bool,
    /// For each worker, the first of its chunks that no worker has taken, and the end of its chunks.
    chunks: Vec<(AtomicUsize, usize)>,
}

/// Runs scripts in parallel. `alone` runs a script that cannot run in parallel at present.
pub(super) fn run(world: &WorldCell, order: &[Rc<Script>], callback: Callback, alone: &impl Fn(&Rc<Script>)) {
    let chunks = order.len().div_ceil(SCRIPTS_PER_CHUNK);
    let workers = world.run.pool().current_num_threads().min(chunks);
    let taken = {
        let Ok(mut all) = world.workers.try_borrow_mut() else { return };
        while all.len() < workers {
            all.push(ScriptWorker::of(world));
        }
        std::mem::take(&mut *all)
    };
    taken[..workers].iter().for_each(|worker| worker.begin(world));
    {
        // These borrows keep the world unchanged while several threads read it.
        let (_scene, _sensing, _scripts) =
            (world.state.scene.borrow(), world.devices.sensing.borrow(), world.run.scripts.borrow());
        let (_dynamics, _settings, _instances) =
            (world.state.dynamics.borrow(), world.model.settings.borrow(), world.devices.instances.borrow());
        let place = turn_index(stage_of(callback));
        let stage = ParallelStage {
            world,
            order,
            callback,
            turn: (place, world.run.scripts.borrow().turns[place].get()),
            waits: world.run.calls.waits.borrow().any(),
            chunks: (0..workers)
                .map(|i| (AtomicUsize::new(chunks * i / workers), chunks * (i + 1) / workers))
                .collect(),
        };
        let stage = &stage;
        if workers == 1 {
            stage.run_chunks(0, &taken[0]);
        } else {
            world.run.pool().in_place_scope(|scope| {
                for (i, worker) in taken[..workers].iter().enumerate().skip(1) {
                    // SAFETY: only scripts whose language declares `TATU_LANGUAGE_SIDE_BY_SIDE` are called
                    // (`is_ready`), and a worker calls only commands that declare `TATU_COMMAND_SIDE_BY_SIDE`. A script
                    // is used only by the thread that has taken its chunk, and a worker only by the thread that it is
                    // passed to. The borrows above keep the world unchanged until all threads are done.
                    let mut granted = unsafe { ThreadGrant::new((stage, worker)) };
                    scope.spawn(move |_| {
                        let (stage, worker) = granted.get();
                        stage.run_chunks(i, worker);
                    });
                }
                stage.run_chunks(0, &taken[0]);
            });
        }
    }
    apply_effects(world, order, &taken[..workers], alone);
    world.workers.replace(taken);
}

/// Applies the effects of the scripts of a stage, in script order.
fn apply_effects(world: &WorldCell, order: &[Rc<Script>], workers: &[ScriptWorker], alone: &impl Fn(&Rc<Script>)) {
    let (mut chunks, mut effects) = (Vec::new(), Vec::with_capacity(workers.len()));
    for (i, worker) in workers.iter().enumerate() {
        let (done, begun) = worker.end(world);
        let ends = begun.iter().skip(1).map(|c| c.1).chain([done.len()]);
        chunks.extend(begun.iter().zip(ends).map(|((chunk, from), to)| (*chunk, i, *from, to)));
        effects.push(done);
    }
    chunks.sort_unstable();
    for (_, worker, from, to) in chunks {
        let mut rest = &mut effects[worker][from..to];
        while !rest.is_empty() {
            let drives = set_drives(world, rest);
            if let Some(effect) = rest.get_mut(drives) {
                apply_effect(world, order, std::mem::replace(effect, DeferredEffect::Done), alone);
            }
            let done = rest.len().min(drives + 1);
            rest = &mut rest[done..];
        }
    }
    workers.iter().zip(effects).for_each(|(worker, effects)| worker.reuse(effects));
}

fn apply_effect(world: &WorldCell, order: &[Rc<Script>], effect: DeferredEffect, alone: &impl Fn(&Rc<Script>)) {
    match effect {
        DeferredEffect::Done | DeferredEffect::Set(..) => {}
        DeferredEffect::Line(level, text) => world.log(level, &text),
        DeferredEffect::Fault(fault) => world.report(*fault),
        DeferredEffect::Failed(i, status, said) => {
            let (mut error, blame) = *said;
            *world.run.calls.blame.borrow_mut() = blame;
            order[i].fail(world, status, error.raw());
            order[i].find_callbacks(world);
            order[i].carry_out_request(world);
        }
        DeferredEffect::Settle(i) => order[i].carry_out_request(world),
        DeferredEffect::Alone(i) => order[i].call_unless_driver(world, alone),
    }
}

/// Applies the drive properties that parallel scripts have set, up to the first effect of another kind. Returns the
/// number of effects applied.
fn set_drives(world: &WorldCell, effects: &[DeferredEffect]) -> usize {
    for (i, effect) in effects.iter().enumerate() {
        let DeferredEffect::Set(object, row, x) = effect else { return i };
        // A script that ran alone in between may have removed the joint.
        let slot = world.state.scene.try_borrow().ok().and_then(|scene| scene.resolve(*object).ok());
        // The value was checked when the script set it.
        let _ = slot.and_then(|slot| world.set_numbers(slot, *row, &[*x]));
    }
    effects.len()
}

impl ParallelStage<'_> {
    /// Runs chunks of scripts in a worker: first the worker's own chunks, then chunks that other workers have not
    /// taken.
    fn run_chunks(&self, own: usize, worker: &ScriptWorker) {
        // SAFETY: the world that `worker` refers to is alive and unchanged during the call: `run` holds shared borrows
        // of all parts that workers read, until all threads are done.
        let run = || unsafe {
            worker.enter(|cell, worker| {
                for i in (own..self.chunks.len()).chain(0..own) {
                    let (next, end) = &self.chunks[i];
                    while let Some(chunk) = Some(next.fetch_add(1, Relaxed)).filter(|c| c < end) {
                        worker.begin_chunk(chunk);
                        let end = self.order.len().min((chunk + 1) * SCRIPTS_PER_CHUNK);
                        for at in chunk * SCRIPTS_PER_CHUNK..end {
                            self.run_script(cell, worker, at);
                        }
                    }
                }
            })
        };
        run();
    }

    fn run_script(&self, cell: &WorldCell, worker: &WorkerView, at: usize) {
        let script = &self.order[at];
        let (place, turn) = self.turn;
        if script.counters.called_in[place].get() == turn {
            return;
        }
        worker.begin_script();
        // Errors of earlier scripts in this worker must not be visible to this one.
        cell.run.calls.blame.take();
        cell.run.calls.last_refusal.borrow_mut().reset();
        if !self.is_ready(cell, script) {
            return worker.note(DeferredEffect::Alone(at));
        }
        script.counters.called_in[place].set(turn);
        let number = script.number(self.callback);
        if number == 0 || !script.is_live(cell) {
            return;
        }
        script.query_callback_or(cell, number, &[], |status, error| {
            let kept = clone_error(error);
            let blame = cell.run.calls.blame.borrow_mut().take();
            // The drives that the script has set are recorded before its failure, which may cause its clean-up: the
            // clean-up must override them.
            worker.end_script();
            worker.note(DeferredEffect::Failed(at, status, Box::new((kept, blame))));
        });
        worker.end_script();
        if script.progress.exit_request.get() != ExitRequest::Nothing {
            worker.note(DeferredEffect::Settle(at));
        }
    }

    /// Returns whether a script can run in parallel now.
    fn is_ready(&self, cell: &WorldCell, script: &Script) -> bool {
        // SAFETY: `as_ptr` points to the list of waits, which lives as long as the world and is not modified, since no
        // wait begins or ends while scripts run in parallel. The `RefCell`'s borrow count is bypassed because several
        // threads read at once, and the count is not atomic.
        let waits =
            || unsafe { (*self.world.run.calls.waits.as_ptr()).any_of(WaitOwner::Script(script.instance.id.get())) };
        script.kind != ScriptKind::Main
            && script.progress.initialised.get()
            && !script.progress.cleaned.get()
            && script.raw(&cell.model.registry).flags & TATU_LANGUAGE_SIDE_BY_SIDE != 0
            && script.depth.get() == 0
            && script.progress.exit_request.get() == ExitRequest::Nothing
            && !(self.waits && waits())
    }
}

/// Returns the stage that calls a callback.
fn stage_of(callback: Callback) -> u32 {
    if callback == Callback::Actuation { TATU_STAGE_ACTUATE } else { TATU_STAGE_REACT }
}
