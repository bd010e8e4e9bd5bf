//! Runs many worlds on several threads; each thread owns a fixed share of the worlds.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    process,
    sync::{Arc, mpsc},
    thread::JoinHandle,
};

use tatu_core::errors::{Error, Result};

use crate::{
    WorldSetup, WorldSlot, WorldTemplate,
    host::{catch_panic, forked_process_error, spawn_world_thread, with_slot},
    job_queue::JobQueue,
};

type WorkerWorlds = Vec<Option<WorldSlot>>;

/// A set of worlds. The results of each world do not depend on the number of threads.
pub struct WorldBatch {
    workers: Vec<BatchWorker>,
    count: usize,
    process: u32,
}

struct BatchWorker {
    queue: Arc<JobQueue<WorkerWorlds>>,
    thread: Option<JoinHandle<()>>,
    /// Index of the first world of this thread.
    first: usize,
}

impl WorldBatch {
    /// Creates a world from each setup, on up to `threads` threads. Consecutive equal setups share a document if their
    /// worlds are on the same thread; all worlds share the plugins of the first setup.
    ///
    /// # Errors
    /// `setups` is empty, a thread cannot be started, or a world cannot be created. If several worlds cannot be
    /// created, the error is that of the world with the lowest index.
    pub fn open(setups: Vec<WorldSetup>, threads: usize) -> Result<Self> {
        let count = setups.len();
        let Some(first) = setups.first() else {
            return Err(Error::new("E102", "a batch needs at least one world"));
        };
        let engine = WorldTemplate::load(first)?;
        let threads = threads.clamp(1, count);
        let (tell, told) = mpsc::channel();
        let mut setups = setups.into_iter();
        let mut workers: Vec<BatchWorker> = Vec::new();
        let mut failed = Ok(());
        for n in 0..threads {
            let (from, to) = (n * count / threads, (n + 1) * count / threads);
            let part: Vec<WorldSetup> = setups.by_ref().take(to - from).collect();
            let line = Arc::new(JobQueue::new());
            let (served, engine, tell) = (line.clone(), engine.clone(), tell.clone());
            let spawned =
                spawn_world_thread(&format!("worlds {n}"), move || run_worker(part, &engine, from, &tell, &served));
            match spawned {
                Ok(thread) => workers.push(BatchWorker { queue: line, thread: Some(thread), first: from }),
                Err(e) => {
                    failed = Err(e);
                    break;
                }
            }
        }
        drop(tell);
        let mut wrong: Vec<(usize, Error)> = Vec::new();
        for _ in 0..workers.len() {
            wrong.extend(told.recv().ok().flatten());
        }
        // Created before any early return, because dropping the batch ends the worlds.
        let batch = WorldBatch { workers, count, process: process::id() };
        engine.end();
        failed?;
        match wrong.into_iter().min_by_key(|(n, _)| *n) {
            Some((_, e)) => Err(e),
            None => Ok(batch),
        }
    }

    /// Returns the number of worlds.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Calls `f` with the index of each world, the world and its own element of `out`, on the threads of the worlds,
    /// and waits until all calls have returned.
    ///
    /// # Errors
    /// The process is a forked copy of the one that created the batch, or `f` failed or panicked for a world. The error
    /// is that of the world with the lowest index; `f` is still called for all other worlds.
    pub fn for_each<O: Send>(
        &self,
        out: &mut [O],
        f: impl Fn(usize, &mut WorldSlot, &mut O) -> Result + Sync,
    ) -> Result {
        if self.process != process::id() {
            return Err(forked_process_error(self.process));
        }
        assert_eq!(out.len(), self.count, "one element for each world");
        let mut rest = out;
        let mut jobs = Vec::with_capacity(self.workers.len());
        for (n, worker) in self.workers.iter().enumerate() {
            let end = self.workers.get(n + 1).map_or(self.count, |next| next.first);
            let part;
            (part, rest) = rest.split_at_mut(end - worker.first);
            let (f, first) = (&f, worker.first);
            jobs.push((worker, BatchPart { out: part, first, wrong: None, f }));
        }
        let mut calls: Vec<_> =
            jobs.iter_mut().map(|(w, part)| (*w, move |owned: &mut WorkerWorlds| part.run(owned))).collect();
        let posted: Vec<_> = calls
            .iter_mut()
            .filter_map(|(w, call)| Some(w.queue.post(w.thread.as_ref()?.thread(), Some(call))))
            .collect();
        drop(posted);
        drop(calls);
        // Each part records the first failure among its worlds, and the parts are in the order of the worlds.
        jobs.into_iter().find_map(|(_, part)| part.wrong).map_or(Ok(()), Err)
    }

    /// Calls `f` with one world, on its thread, and waits for the result.
    ///
    /// # Errors
    /// The process is a forked copy of the one that created the batch, there is no such world, or `f` failed or
    /// panicked.
    pub fn with_world<T: Send>(&self, world: usize, f: impl FnOnce(&mut WorldSlot) -> Result<T> + Send) -> Result<T> {
        if self.process != process::id() {
            return Err(forked_process_error(self.process));
        }
        let worker = self.workers.iter().rev().find(|w| w.first <= world && world < self.count);
        let Some((worker, thread)) = worker.and_then(|w| Some((w, w.thread.as_ref()?))) else {
            return Err(no_such_world(world, self.count));
        };
        let (mut f, mut result) = (Some(f), None);
        worker.queue.call(thread.thread(), &mut |owned: &mut WorkerWorlds| {
            if let (Some(f), Some(seat)) = (f.take(), owned.get_mut(world - worker.first)) {
                result = Some(with_slot(seat, f));
            }
        });
        result.unwrap_or_else(|| Err(no_such_world(world, self.count)))
    }
}

fn no_such_world(world: usize, count: usize) -> Error {
    Error::new("E102", format!("there is no world {world}"))
        .expected(format!("a number from 0 to {}", count.saturating_sub(1)))
}

/// The share of one thread in a call to [`WorldBatch::for_each`].
struct BatchPart<'a, O, F> {
    out: &'a mut [O],
    first: usize,
    wrong: Option<Error>,
    f: &'a F,
}

impl<O, F: Fn(usize, &mut WorldSlot, &mut O) -> Result> BatchPart<'_, O, F> {
    fn run(&mut self, owned: &mut WorkerWorlds) {
        for ((n, seat), out) in owned.iter_mut().enumerate().zip(self.out.iter_mut()) {
            let done = with_slot(seat, |own| (self.f)(self.first + n, own, out));
            if let Err(e) = done
                && self.wrong.is_none()
            {
                self.wrong = Some(Error { text: format!("world {}: {}", self.first + n, e.text), ..e });
            }
        }
    }
}

/// Runs on each thread of a batch: creates the thread's worlds, executes the calls to the batch, then ends the worlds.
fn run_worker(
    setups: Vec<WorldSetup>,
    engine: &WorldTemplate,
    first: usize,
    tell: &mpsc::Sender<Option<(usize, Error)>>,
    line: &JobQueue<WorkerWorlds>,
) {
    let mut owned: WorkerWorlds = Vec::new();
    let mut wrong = None;
    // The template and the setup of the previous world.
    let mut last: Option<(WorldTemplate, WorldSetup)> = None;
    for (n, setup) in setups.into_iter().enumerate() {
        let own = match &last {
            Some((engine, of)) if *of == setup => Ok(engine.clone()),
            _ => catch_panic(|| engine.reload(&setup)),
        };
        let made = own.and_then(|own| {
            last = Some((own.clone(), setup.clone()));
            catch_panic(|| WorldSlot::new(setup, own))
        });
        match made {
            Ok(seat) => owned.push(Some(seat)),
            Err(e) => {
                wrong = Some((first + n, e));
                break;
            }
        }
    }
    drop(last);
    let _ = tell.send(wrong);
    line.serve(&mut owned);
    for seat in owned.into_iter().flatten() {
        let _ = catch_unwind(AssertUnwindSafe(|| seat.end()));
    }
}

impl Drop for WorldBatch {
    fn drop(&mut self) {
        for worker in &mut self.workers {
            let Some(thread) = worker.thread.take() else { continue };
            if self.process == process::id() {
                worker.queue.end(thread.thread());
                let _ = thread.join();
            }
        }
    }
}
