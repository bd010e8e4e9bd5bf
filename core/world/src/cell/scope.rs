//! What a plugin may ask of the host depends on the call that it is in. The host checks this in every function that
//! takes a world.
//!
//! A world belongs to the thread that made it. A pointer that belongs to no living world of this thread is refused
//! before it is read: it is used on a thread of the plugin's own, or was kept after its world ended.

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

/// A function of the host, for messages: "scene.pose", and whether it changes something.
#[derive(Clone, Copy)]
pub(crate) struct Function {
    /// As the header calls it.
    pub name: &'static str,
    /// Whether it changes the world, or lets others do so.
    pub acts: bool,
}

impl Function {
    /// One that changes nothing.
    pub const fn looks(name: &'static str) -> Self {
        Function { name, acts: false }
    }
    /// One that changes the world, or lets others do so.
    pub const fn acts(name: &'static str) -> Self {
        Function { name, acts: true }
    }
}

/// What a call may use. Each level includes the previous ones.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Scope {
    /// Nothing that needs a world.
    Nothing,
    /// What changes nothing.
    Look,
    /// Everything.
    Act,
}

/// Scopes, indexed by the number of a call in the watchdog's notes.
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
        // These run in parallel, on any thread, in the middle of a stage.
        Some(Call::Aim | Call::Measure | Call::Finish | Call::Apply) | None => Scope::Nothing,
        // A snapshot, a restore or a change of parameters must not change anything else, or the run could not continue
        // from it.
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

/// A world has got the address at which it stays.
pub(crate) fn enlist(world: &WorldCell) {
    if let Ok(mut all) = STRANGERS.lock() {
        all.known.clear();
    }
    living::add((&raw const *world).cast());
}

impl WorldCell {
    /// The world behind an ABI pointer, whatever call is running: for the log. None where no world of this thread
    /// has that address. On a thread that runs scripts beside others it is the thread's own cell.
    #[inline]
    pub fn at<'a>(ptr: *mut tatu_world) -> Option<&'a WorldCell> {
        let world = ptr.cast::<WorldCell>().cast_const();
        if living::is_last(ptr) {
            // SAFETY: it is alive on this thread, and the thread is not in a worker: ending the world or entering a
            // worker clears the entry that `is_last` compares with.
            return unsafe { world.as_ref() };
        }
        match script_worker::of_this_thread() {
            None if living::has(ptr) => {
                // SAFETY: the list holds only worlds that are alive on this thread.
                unsafe { world.as_ref() }
            }
            None => None,
            // Nothing else is to be touched from here.
            Some(cell) => (cell.raw() == ptr).then_some(cell),
        }
    }

    /// The same for a function of the host: the call that runs must allow it. `Err`: the status, whose message has been
    /// recorded.
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
        // Statuses are easily passed over: who broke the rule is named.
        let mut fault = Fault::new(FaultKind::Plugin, format!("plugin `{}` broke the contract: {text}", plugin.id));
        fault.plugin = Some(plugin.id.clone());
        fault.object = world.border.watch.name_of(world.border.watch.slot());
        world.report(fault);
    }
    world.run.calls.refuse(TATU_ERR_BUSY, &text)
}

/// Refusals that belong to no world, with the library that called: each is reported once, and the first world to look
/// takes them for faults of its run.
static STRANGERS: Mutex<Strangers> = Mutex::new(Strangers { known: BTreeSet::new(), pending: Vec::new() });
static ANY_STRANGER: AtomicBool = AtomicBool::new(false);
/// How many of them are kept.
const MOST_STRANGERS: usize = 16;

struct Strangers {
    /// Reported since the last world was made.
    known: BTreeSet<String>,
    /// Not reported yet.
    pending: Vec<String>,
}

/// A plugin broke the contract outside of any call that a world knows of: a fault of the run that looks next, reported
/// once.
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
        true => format!("{who} broke the contract: `{name}` was called with null for its world, and is refused"),
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
    /// Takes refusals that belong to no world for faults of this run.
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

/// The caller of a host function, where no call is noted.
mod caller {
    /// The library of a plugin in the chain of calls, nearest first.
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    pub fn library() -> Option<String> {
        use std::ffi::{CStr, c_int, c_void};
        unsafe extern "C" {
            fn backtrace(frames: *mut *mut c_void, n: c_int) -> c_int;
        }
        let mut frames = [std::ptr::null_mut(); 32];
        // SAFETY: room for as many; any address may be asked for, and the names live as long as their libraries.
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
