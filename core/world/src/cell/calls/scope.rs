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
use tatu_plugins::watchdog::PluginCall;

use crate::cell::{WorldCell, live_worlds, scripts::worker};

/// A function of the host.
#[derive(Clone, Copy)]
pub(crate) struct HostFunction {
    /// Its name in the header, such as "scene.pose", for messages.
    pub name: &'static str,
    /// Whether it changes the world, or calls code that can change it.
    pub mutates: bool,
}

impl HostFunction {
    /// Describes a function that changes nothing.
    pub const fn read_only(name: &'static str) -> Self {
        HostFunction { name, mutates: false }
    }
    /// Describes a function that changes the world, or calls code that can change it.
    pub const fn mutating(name: &'static str) -> Self {
        HostFunction { name, mutates: true }
    }
}

/// The access of a call to the host functions. Each level includes the previous ones.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum AccessLevel {
    /// Only functions that do not access a world.
    NoWorld,
    /// Functions that change nothing.
    ReadOnly,
    /// All functions.
    Full,
}

/// Scopes, indexed by the number of the call in the watchdog's records.
static ACCESS_LEVELS: [AccessLevel; PluginCall::ALL.len()] = {
    let mut all = [AccessLevel::NoWorld; PluginCall::ALL.len()];
    let mut i = 0;
    while i < all.len() {
        all[i] = access_during(PluginCall::ALL[i]);
        i += 1;
    }
    all
};

const fn access_during(call: Option<PluginCall>) -> AccessLevel {
    match call {
        // These calls run in parallel on any thread, in the middle of a stage.
        Some(PluginCall::Aim | PluginCall::Measure | PluginCall::Finish | PluginCall::Apply) | None => {
            AccessLevel::NoWorld
        }
        // Creating, saving, restoring or configuring an instance must not change the rest of the world.
        Some(
            PluginCall::Create
            | PluginCall::Destroy
            | PluginCall::Configure
            | PluginCall::Save
            | PluginCall::Restore
            | PluginCall::Beams
            | PluginCall::ScriptFind
            | PluginCall::ScriptTraits
            | PluginCall::ScriptOrder
            | PluginCall::ScriptPlace
            | PluginCall::KeepFunc
            | PluginCall::DropFunc
            | PluginCall::Last,
        ) => AccessLevel::ReadOnly,
        Some(_) => AccessLevel::Full,
    }
}

/// Registers a world. Its address must not change afterwards.
pub(crate) fn register_world(world: &WorldCell) {
    if let Ok(mut all) = UNASSIGNED_BREACHES.lock() {
        all.known.clear();
    }
    live_worlds::add((&raw const *world).cast());
}

impl WorldCell {
    /// Returns the world behind an ABI pointer, regardless of the running call, or `None` if no world of this thread
    /// has that address. Only the log uses this function directly. On a thread that runs scripts in parallel, the
    /// result is the thread's own worker.
    #[inline]
    pub fn from_pointer<'a>(ptr: *mut tatu_world) -> Option<&'a WorldCell> {
        let world = ptr.cast::<WorldCell>().cast_const();
        if live_worlds::is_last(ptr) {
            // SAFETY: `is_last` holds only while the world is alive on this thread and the thread is not in a worker:
            // ending the world and entering a worker both clear the entry.
            return unsafe { world.as_ref() };
        }
        match worker::current_worker() {
            None if live_worlds::is_live(ptr) => {
                // SAFETY: `world` is in the list, which contains only worlds that are alive on this thread.
                unsafe { world.as_ref() }
            }
            None => None,
            // In a worker, only the worker's own cell may be used.
            Some(cell) => (cell.raw() == ptr).then_some(cell),
        }
    }

    /// Like `from_pointer`, but for a host function, which the running call must allow. Otherwise, records a message
    /// and returns the status as an error.
    #[inline]
    pub fn admit<'a>(world: WorldRef<'a>, function: HostFunction) -> Result<&'a WorldCell, tatu_status> {
        let Some(cell) = Self::from_pointer(world.ptr()) else {
            return Err(refuse_invalid_world(world.ptr(), function.name));
        };
        let world: &'a WorldCell = cell;
        let has = ACCESS_LEVELS[world.monitor.watch.call_number()];
        let needs = if function.mutates { AccessLevel::Full } else { AccessLevel::ReadOnly };
        if has >= needs { Ok(world) } else { Err(refuse(world, has, function.name)) }
    }
}

#[cold]
fn refuse(world: &WorldCell, scope: AccessLevel, name: &str) -> tatu_status {
    let Some(call) = world.monitor.watch.call() else {
        let text = format!("`{name}` was called outside of any call of this world, and is refused");
        return world.run.calls.refuse(TATU_ERR_BUSY, &text);
    };
    let why = match scope {
        AccessLevel::NoWorld => "may call only the log, and `random` of its batch",
        _ => "may read the world, and change only its own instance",
    };
    let text = format!("`{name}` was called in `{}`, and is refused: it {why}", call.text());
    if let Some(plugin) = world.model.registry.plugins.get(world.monitor.watch.plugin()) {
        // Plugins often ignore a status, so the breach is reported as a fault as well.
        let mut fault = Fault::new(FaultKind::Plugin, format!("plugin `{}` broke the contract: {text}", plugin.id));
        fault.plugin = Some(plugin.id.clone());
        fault.object = world.monitor.watch.name_of(world.monitor.watch.slot());
        world.report(fault);
    }
    world.run.calls.refuse(TATU_ERR_BUSY, &text)
}

/// Breaches of the contract that cannot be assigned to a world. Each is stored once, and the first world that checks
/// reports them as faults of its run.
static UNASSIGNED_BREACHES: Mutex<UnassignedBreaches> =
    Mutex::new(UnassignedBreaches { known: BTreeSet::new(), pending: Vec::new() });
static HAS_PENDING_BREACH: AtomicBool = AtomicBool::new(false);
/// Maximum number of breaches that are stored.
const MAX_BREACHES: usize = 16;

struct UnassignedBreaches {
    /// Breaches found since the last world was created.
    known: BTreeSet<String>,
    /// Breaches that have not been reported yet.
    pending: Vec<String>,
}

/// Records a breach of the contract that happened outside any recorded call. The next run that checks reports it once.
pub fn record_breach(text: String) {
    if let Ok(mut all) = UNASSIGNED_BREACHES.lock()
        && all.known.len() < MAX_BREACHES
        && all.known.insert(text.clone())
    {
        all.pending.push(text);
        HAS_PENDING_BREACH.store(true, Relaxed);
    }
}

#[cold]
fn refuse_invalid_world(ptr: *mut tatu_world, name: &str) -> tatu_status {
    let who = caller::library().map_or("a plugin".to_owned(), |file| format!("the plugin {file}"));
    let text = match ptr.is_null() {
        true => {
            format!("{who} broke the contract: `{name}` was called with a null pointer as the world, and is refused")
        }
        false => format!(
            "{who} broke the contract: `{name}` was called for a world that does not exist, or from a thread that is \
             not the world's, and is refused: threads of a plugin may call only log.write, commands.wake, \
             session.wake and session.stop, and must leave everything else to a barrier"
        ),
    };
    record_breach(text);
    TATU_ERR_BUSY
}

impl WorldCell {
    /// Reports breaches that cannot be assigned to a world as faults of this run.
    pub fn report_unassigned_breaches(&self) {
        if HAS_PENDING_BREACH.swap(false, Relaxed)
            && let Ok(mut all) = UNASSIGNED_BREACHES.lock()
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
