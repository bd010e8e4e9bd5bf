//! Runs a world on a separate thread, and lets any thread use it.

use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind},
    process,
    sync::{Arc, OnceLock, mpsc},
    thread::{self, JoinHandle},
};

use tatu_core::{
    errors::{Error, Result},
    plugins::protected_state,
};

use crate::{WorldSetup, WorldSlot, WorldTemplate, job_queue::JobQueue};

/// Stack size of a world's thread, bytes: the usual size for the main thread on Linux, because scripts and importers
/// recurse.
pub(crate) const STACK_BYTES: usize = 8 << 20;

/// A world that any thread may use. Calls from several threads take turns.
pub struct WorldHost {
    queue: Arc<JobQueue<Option<WorldSlot>>>,
    thread: Option<JoinHandle<()>>,
    /// Id of the process that created the world. A copy of the process created by `fork` does not have the thread.
    process: u32,
}

impl WorldHost {
    /// Creates a world and starts it.
    ///
    /// # Errors
    /// The scene, a plugin or a change is invalid, or the system cannot start a thread.
    pub fn open(setup: WorldSetup) -> Result<Self> {
        Self::start(move || {
            let engine = WorldTemplate::load(&setup)?;
            WorldSlot::new(setup, engine)
        })
    }

    /// Creates an independent world in the same state as this one.
    ///
    /// # Errors
    /// The state cannot be captured completely, or the world cannot be created.
    pub fn fork(&self) -> Result<Self> {
        let (setup, engine, snapshot) =
            self.with(|seat| Ok((seat.setup().clone(), seat.template().clone(), seat.snapshot()?)))?;
        Self::start(move || {
            let mut seat = WorldSlot::new(setup, engine)?;
            seat.restore(&snapshot).map(|()| seat)
        })
    }

    fn start(make: impl FnOnce() -> Result<WorldSlot> + Send + 'static) -> Result<Self> {
        let line = Arc::new(JobQueue::new());
        let served = line.clone();
        let (tell, told) = mpsc::channel();
        let run = move || {
            let made = catch_panic(make);
            let mut seat = match made {
                Ok(seat) => Some(seat),
                Err(e) => {
                    let _ = tell.send(Err(e));
                    return;
                }
            };
            let _ = tell.send(Ok(()));
            served.serve(&mut seat);
            if let Some(seat) = seat {
                let _ = catch_unwind(AssertUnwindSafe(|| seat.end()));
            }
        };
        let thread = spawn_world_thread("world", run)?;
        told.recv().unwrap_or_else(|_| Err(lost_world_error()))?;
        Ok(WorldHost { queue: line, thread: Some(thread), process: process::id() })
    }

    /// Returns whether the calling thread is the world's own, which must not wait for itself.
    pub fn is_own_thread(&self) -> bool {
        self.thread.as_ref().is_some_and(|t| t.thread().id() == thread::current().id())
    }

    /// Calls `f` with the world, on the world's thread, and waits for the result.
    ///
    /// # Errors
    /// `f` failed; the process is a forked copy of the one that created the world; or `f` panicked in this call or an
    /// earlier one. A panic is a bug in the simulator, and makes the world unusable.
    pub fn with<T: Send>(&self, f: impl FnOnce(&mut WorldSlot) -> Result<T> + Send) -> Result<T> {
        if self.process != process::id() {
            return Err(forked_process_error(self.process));
        }
        let Some(thread) = &self.thread else { return Err(lost_world_error()) };
        let (mut f, mut result) = (Some(f), None);
        self.queue.call(thread.thread(), &mut |seat: &mut Option<WorldSlot>| {
            result = f.take().map(|f| with_slot(seat, f));
        });
        result.unwrap_or_else(|| Err(lost_world_error()))
    }
}

impl Drop for WorldHost {
    fn drop(&mut self) {
        let Some(thread) = self.thread.take() else { return };
        // In a forked copy of the process, the thread does not exist.
        if self.process == process::id() {
            self.queue.end(thread.thread());
            let _ = thread.join();
        }
    }
}

/// Calls `f` with a world. If `f` panics, the world is lost: its parts may be inconsistent, so it is neither used nor
/// dropped afterwards.
pub(crate) fn with_slot<T>(seat: &mut Option<WorldSlot>, f: impl FnOnce(&mut WorldSlot) -> Result<T>) -> Result<T> {
    let Some(own) = seat.as_mut() else { return Err(lost_world_error()) };
    catch_unwind(AssertUnwindSafe(|| f(own))).unwrap_or_else(|payload| {
        std::mem::forget(seat.take());
        Err(panic_error(&*payload))
    })
}

/// Starts a thread that owns worlds.
pub(crate) fn spawn_world_thread(name: &str, run: impl FnOnce() + Send + 'static) -> Result<JoinHandle<()>> {
    let run = move || {
        set_plain_locale();
        run();
    };
    let thread = thread::Builder::new().name(name.into()).stack_size(STACK_BYTES).spawn(run);
    thread.map_err(|e| Error::new("E401", format!("cannot start a thread for a world: {e}")).help("open fewer worlds"))
}

/// Sets the default rounding mode and the `C` locale for this thread, regardless of the settings of the process. In a
/// locale with a decimal comma, scripts would parse and format numbers differently.
#[cfg(unix)]
pub(crate) fn set_plain_locale() {
    // A thread inherits the rounding mode of the thread that starts it.
    protected_state::set_default_mode();
    /// Address of the locale, as an integer because raw pointers are not `Sync`. The locale is never freed.
    static PLAIN_LOCALE: OnceLock<usize> = OnceLock::new();
    // SAFETY: the name is a C string, and a null base requests a new locale.
    let make = || unsafe { libc::newlocale(libc::LC_ALL_MASK, c"C".as_ptr(), std::ptr::null_mut()) };
    let plain = *PLAIN_LOCALE.get_or_init(|| make().expose_provenance());
    if plain != 0 {
        // SAFETY: the locale was created by `newlocale` and is never freed.
        unsafe { libc::uselocale(std::ptr::with_exposed_provenance_mut(plain)) };
    }
}
#[cfg(not(unix))]
pub(crate) fn set_plain_locale() {}

/// Runs `f`, and converts a panic to an error.
pub(crate) fn catch_panic<T>(f: impl FnOnce() -> Result<T>) -> Result<T> {
    catch_unwind(AssertUnwindSafe(f)).unwrap_or_else(|payload| Err(panic_error(&*payload)))
}

/// Converts the payload of a panic to an error.
fn panic_error(payload: &(dyn Any + Send)) -> Error {
    let why = payload.downcast_ref::<String>().map(String::as_str).or(payload.downcast_ref::<&str>().copied());
    let text = format!("the simulator panicked: {}", why.unwrap_or("no message"));
    Error::new("E405", text).help("this is a bug in the simulator: please report it, with the scene")
}

fn lost_world_error() -> Error {
    Error::new("E405", "the world no longer exists: it was closed, or lost due to a bug").help("create a new world")
}

pub(crate) fn forked_process_error(process: u32) -> Error {
    let text =
        format!("the world belongs to process {process}; this process is a forked copy without the world's thread");
    Error::new("E406", text).help("create worlds after `fork`, or start processes with `spawn`")
}
