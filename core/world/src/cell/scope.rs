//! Checks whether a plugin may use a host function during the current call. Every host function that has a world as an
//! argument performs this check, except the log.
//!
//! A world belongs to the thread that created it. A pointer that is not the address of a living world of this thread is
//! refused before it is dereferenced: a plugin either used it on a different thread, or retained it after the world had
//! ended.

use std::{
    collections::BTreeSet,
    sync::{
        Mutex,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
};

use tatu_errors::{Fault, FaultKind};
use tatu_plugin_api::abi::*;
use tatu_plugins::watchdog::Call;

use super::{WorldCell, living, script_worker};

/// A function of the host.
#[derive(Clone, Copy)]
pub(crate) struct Function {
    /// Its name in the header, such as "scene.pose", for messages.
    pub name: &'static str,
    /// Whether it changes the world, or calls code that can change it.
    pub acts: bool,
}

impl Function {
    /// Describes a function that changes nothing.
    pub const fn looks(name: &'static str) -> Self {
        Function { name, acts: false }
    }
    /// Describes a function that changes the world, or calls code that can change it.
    pub const fn acts(name: &'static str) -> Self {
        Function { name, acts: true }
    }
}

/// The host functions that a call may use. Each level includes the previous ones.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Scope {
    /// Only functions that do not access a world.
    Nothing,
    /// Functions that change nothing.
    Look,
    /// All functions.
    Act,
}

/// Scopes, indexed by the number of the call in the watchdog's records.
static SCOPES: [Scope; Call::ALL.len()] = {
    let mut all = [Scope::Nothing; Call::ALL.len()];
    let mut i = 0;
    while i < all.len() {
        all[i] = scope(Call::ALL[i]);
        i += 1;
    }
    all
};

const fn scope(call: Option<Call>) -> Scope {
    match call {
        // These calls run in parallel on any thread, in the middle of a stage.
        Some(Call::Aim | Call::Measure | Call::Finish | Call::Apply) | None => Scope::Nothing,
        // Creating, saving, restoring or configuring an instance must not change the rest of the world.
        Some(
            Call::Create
            | Call::Destroy
            | Call::Configure
            | Call::Save
            | Call::Restore
            | Call::Beams
            | Call::ScriptFind
            | Call::ScriptTraits
            | Call::ScriptOrder
            | Call::ScriptPlace
            | Call::KeepFunc
            | Call::DropFunc
            | Call::Last,
        ) => Scope::Look,
        Some(_) => Scope::Act,
    }
}

/// Registers a world. Its address must not change afterwards.
pub(crate) fn enlist(world: &WorldCell) {
    if let Ok(mut all) = STRANGERS.lock() {
        all.known.clear();
    }
    living::add((&raw const *world).cast());
}

impl WorldCell {
    /// Returns the world behind an ABI pointer, regardless of the running call, or `None` if no world of this thread
    /// has that address. Only the log uses this function directly. On a thread that runs scripts in parallel, the
    /// result is the thread's own worker.
    #[inline]
    pub fn at<'a>(ptr: *mut tatu_world) -> Option<&'a WorldCell> {
        let world = ptr.cast::<WorldCell>().cast_const();
        if living::is_last(ptr) {
            // SAFETY: `is_last` holds only while the world is alive on this thread and the thread is not in a worker:
            // ending the world and entering a worker both clear the entry.
            return unsafe { world.as_ref() };
        }
        match script_worker::of_this_thread() {
            None if living::has(ptr) => {
                // SAFETY: `world` is in the list, which contains only worlds that are alive on this thread.
                unsafe { world.as_ref() }
            }
            None => None,
            // In a worker, only the worker's own cell may be used.
            Some(cell) => (cell.raw() == ptr).then_some(cell),
        }
    }

    /// Like `at`, but for a host function, which the running call must allow. Otherwise, records a message and returns
    /// the status as an error.
    #[inline]
    pub fn admit<'a>(world: WorldRef<'a>, function: Function) -> Result<&'a WorldCell, tatu_status> {
        let Some(cell) = Self::at(world.ptr()) else { return Err(refuse_stranger(world.ptr(), function.name)) };
        let world: &'a WorldCell = cell;
        let has = SCOPES[world.border.watch.call_number()];
        let needs = if function.acts { Scope::Act } else { Scope::Look };
        if has >= needs { Ok(world) } else { Err(refuse(world, has, function.name)) }
    }
}

#[cold]
fn refuse(world: &WorldCell, scope: Scope, name: &str) -> tatu_status {
    let Some(call) = world.border.watch.call() else {
        let text = format!("`{name}` was called outside of any call of this world, and is refused");
        return world.run.calls.refuse(TATU_ERR_BUSY, &text);
    };
    let why = match scope {
        Scope::Nothing => "may call only the log, and `random` of its batch",
        _ => "may read the world, and change only its own instance",
    };
    let text = format!("`{name}` was called in `{}`, and is refused: it {why}", call.text());
    if let Some(plugin) = world.model.registry.plugins.get(world.border.watch.plugin()) {
        // Plugins often ignore a status, so the breach is reported as a fault as well.
        let mut fault = Fault::new(FaultKind::Plugin, format!("plugin `{}` broke the contract: {text}", plugin.id));
        fault.plugin = Some(plugin.id.clone());
        fault.object = world.border.watch.name_of(world.border.watch.slot());
        world.report(fault);
    }
    world.run.calls.refuse(TATU_ERR_BUSY, &text)
}

/// Breaches of the contract that cannot be assigned to a world. Each is stored once, and the first world that checks
/// reports them as faults of its run.
static STRANGERS: Mutex<Strangers> = Mutex::new(Strangers { known: BTreeSet::new(), pending: Vec::new() });
static ANY_STRANGER: AtomicBool = AtomicBool::new(false);
/// Maximum number of breaches that are stored.
const MOST_STRANGERS: usize = 16;

struct Strangers {
    /// Breaches found since the last world was created.
    known: BTreeSet<String>,
    /// Breaches that have not been reported yet.
    pending: Vec<String>,
}

/// Records a breach of the contract that happened outside any recorded call. The next run that checks reports it once.
pub fn breach(text: String) {
    if let Ok(mut all) = STRANGERS.lock()
        && all.known.len() < MOST_STRANGERS
        && all.known.insert(text.clone())
    {
        all.pending.push(text);
        ANY_STRANGER.store(true, Relaxed);
    }
}

#[cold]
fn refuse_stranger(ptr: *mut tatu_world, name: &str) -> tatu_status {
    let who = caller::library().map_or("a plugin".to_owned(), |file| format!("the plugin {file}"));
    let text = match ptr.is_null() {
        true => {
            format!("{who} broke the contract: `{name}` was called with a null pointer as the world, and is refused")
        }
        false => format!(
            "{who} broke the contract: `{name}` was called for a world that does not exist, or from a thread that is \
             not the world's, and is refused: threads of a plugin may call only log.write and \
             session.wake, and must leave everything else to a barrier"
        ),
    };
    breach(text);
    TATU_ERR_BUSY
}

impl WorldCell {
    /// Reports breaches that cannot be assigned to a world as faults of this run.
    pub fn take_strangers(&self) {
        if ANY_STRANGER.swap(false, Relaxed)
            && let Ok(mut all) = STRANGERS.lock()
        {
            let pending = std::mem::take(&mut all.pending);
            drop(all);
            pending.into_iter().for_each(|text| self.report(Fault::new(FaultKind::Plugin, text)));
        }
    }
}

/// Identifies the caller of a host function when no call is recorded.
mod caller {
    /// Returns the library of the nearest plugin on the call stack.
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    pub fn library() -> Option<String> {
        use std::ffi::{CStr, c_int, c_void};
        unsafe extern "C" {
            fn backtrace(frames: *mut *mut c_void, n: c_int) -> c_int;
        }
        let mut frames = [std::ptr::null_mut(); 32];
        // SAFETY: `frames` has room for 32 addresses and lives during the calls. `dladdr` accepts any address, and the
        // file name that it returns lives as long as its library is loaded.
        unsafe {
            let n = backtrace(frames.as_mut_ptr(), 32).clamp(0, 32) as usize;
            frames[..n].iter().find_map(|at| {
                let mut about: libc::Dl_info = std::mem::zeroed();
                if libc::dladdr(*at, &raw mut about) == 0 || about.dli_fname.is_null() {
                    return None;
                }
                let file = CStr::from_ptr(about.dli_fname).to_string_lossy().into_owned();
                let name = file.rsplit('/').next().unwrap_or_default();
                name.contains("tatu_").then_some(file)
            })
        }
    }
    #[cfg(not(all(target_os = "linux", target_env = "gnu")))]
    pub fn library() -> Option<String> {
        None
    }
}
