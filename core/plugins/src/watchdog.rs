//! The watchdog: records which plugin call is running, which allows another thread to detect a call that never returns.
//!
//! The running thread records each call with two relaxed stores of one word, one on entry and one on return. A
//! [watchdog](CallWatches::start_watchdog) reads the words from time to time; if one does not change for longer than
//! the limit, the watchdog reports the call. Real time can end a run, but never affects what happens in it. Each thread
//! stores the watch whose call it runs ([`current_watch`]), by which a crash on the thread is attributed to that call.

use std::{
    cell::Cell,
    collections::BTreeMap,
    ffi::c_void,
    ptr,
    sync::{
        Arc, Mutex, MutexGuard, TryLockError,
        atomic::{AtomicU32, AtomicU64, AtomicUsize, Ordering::Relaxed},
    },
    thread,
    time::Duration,
};

use tatu_plugin_api::abi::tatu_error;

use crate::border::ErrorSlot;

macro_rules! calls {
    ($($(#[$doc:meta])* $name:ident = $text:literal),* $(,)?) => {
        /// A function of a plugin that the host calls.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u8)]
        #[allow(missing_docs, reason = "the names are those of the header")]
        pub enum PluginCall { None, $($(#[$doc])* $name),* }

        impl PluginCall {
            const TEXTS: &[&str] = &["nothing", $($text),*];
            /// All calls, indexed by their number in a record.
            pub const ALL: [Option<PluginCall>; 64] = {
                let mut all = [None; 64];
                $(all[PluginCall::$name as usize] = Some(PluginCall::$name);)*
                all
            };
        }
    };
}

calls! {
    Load = "its loading (constructors of the library)",
    Init = "tatu_plugin.init",
    Extension = "tatu_plugin.extension",
    Shutdown = "tatu_plugin.shutdown",
    Create = "tatu_life.create",
    Destroy = "tatu_life.destroy",
    Configure = "tatu_life.configure",
    Save = "tatu_life.save",
    Restore = "tatu_life.load",
    Command = "tatu_command.call",
    Beams = "tatu_sensor.beams",
    Aim = "tatu_sensor.aim",
    Measure = "tatu_sensor.measure",
    Finish = "tatu_sensor.finish",
    Apply = "tatu_actuator.apply",
    Build = "tatu_model.build",
    Sniff = "tatu_importer.sniff",
    Import = "tatu_importer.load",
    ScriptLoad = "tatu_language.load",
    ScriptFind = "tatu_language.find",
    ScriptCall = "tatu_language.call",
    ScriptResume = "tatu_language.resume",
    KeepFunc = "tatu_language.keep_func",
    DropFunc = "tatu_language.drop_func",
    CallFunc = "tatu_language.call_func",
    KnowsDialect = "tatu_language.knows_dialect",
    ScriptTraits = "tatu_language.traits",
    ScriptOrder = "tatu_language.order",
    ScriptPlace = "tatu_language.place",
    Start = "tatu_life.create",
    Stop = "tatu_life.destroy",
    Barrier = "tatu_service.barrier",
    Event = "tatu_service.event",
    ServiceResume = "tatu_service.resume",
    ServiceFunc = "tatu_service.call_func",
    Last = "tatu_service.last",
    EndRun = "tatu_life.end_run",
    ReadModel = "tatu_ext_model.read",
    PartActuate = "tatu_part.actuate",
    PartPhysicsStep = "tatu_part.physics_step",
    PartSense = "tatu_part.sense",
    PartPaused = "tatu_part.paused",
    PartEnd = "tatu_part.end",
    PartEvent = "tatu_part.event",
    PartContact = "tatu_part.contact",
    Heard = "tatu_ext_event.heard",
}

impl PluginCall {
    /// Returns the function's name in the header, such as "tatu_sensor.measure".
    pub fn text(self) -> &'static str {
        Self::TEXTS[self as usize]
    }
}

/// Bits of a record: object (20), plugin (14), call (6), and above them a counter that makes each record different.
const OBJECT_BITS: u32 = 20;
const PLUGIN_BITS: u32 = 14;
const COUNTER_SHIFT: u32 = 40;

thread_local! {
    /// The watch of the innermost call on this thread. It has a constant initialiser and no destructor, so a signal
    /// handler can read it at any time.
    static CURRENT_WATCH: Cell<*const CallWatch> = const { Cell::new(ptr::null()) };
}

/// Returns the watch whose plugin call runs on this thread, or null if there is none. Signal handlers may call this.
/// Only [`CallWatches::running`] may use the pointer, because the watch may no longer exist.
pub fn current_watch() -> *const CallWatch {
    CURRENT_WATCH.get()
}

/// A function that reports the current position of a script, and its argument, as addresses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScriptPlace(usize, usize);

impl ScriptPlace {
    /// Stores the function of the script's language, and the data to pass to it.
    pub fn new(place: Option<unsafe extern "C" fn(*mut c_void, *mut tatu_error)>, data: *mut c_void) -> Self {
        ScriptPlace(place.map_or(0, |f| f as usize), data as usize)
    }
    /// Returns the current file and line.
    ///
    /// # Safety
    /// The script must exist, and the thread that runs it must be stopped.
    pub unsafe fn current_position(self) -> Option<(String, u64)> {
        if self.0 == 0 || self.1 == 0 {
            return None;
        }
        let mut error = ErrorSlot::new();
        // SAFETY: the number was made in `new` from a pointer to a function of this type, in a library that is never
        // unloaded; the caller guarantees that the script exists.
        unsafe {
            let place: unsafe extern "C" fn(*mut c_void, *mut tatu_error) = std::mem::transmute(self.0);
            place(self.1 as *mut c_void, error.reset());
        }
        let said = error.contents();
        said.file.filter(|_| said.line > 0).map(|file| (file, said.line))
    }
}

/// The record that a call replaced, for [`CallWatch::leave`].
#[derive(Debug, Clone, Copy)]
pub struct OuterCall {
    word: u64,
    outer: *const CallWatch,
}

/// The record of the calls of one thread, which works for a world or loads plugins. Only that thread writes it.
#[derive(Default)]
pub struct CallWatch {
    now: AtomicU64,
    /// Number of calls that were made while no other was running, and the record of the last of them. A script that
    /// calls commands without end changes `now` each time, but not these.
    outermost: AtomicU64,
    outer: AtomicU64,
    /// Number of instances if the call is for a batch; the record names the first one.
    batch: AtomicU32,
    /// Number of the running command, from 1; 0 if there is none.
    command: AtomicU32,
    /// Source of the innermost script's position: the function `tatu_language.place` and its data, as addresses; 0 if
    /// there is no script.
    script: [AtomicUsize; 2],
    /// Names of objects, by slot.
    names: Arc<Mutex<BTreeMap<u32, String>>>,
    /// Name of the file or model being loaded or built, which has no index yet, or of the service being called.
    subject: Mutex<String>,
}

impl CallWatch {
    /// Creates a watch for a thread that works in parallel with this one; object names are shared.
    pub fn for_parallel_thread(&self, watches: &CallWatches) -> Arc<CallWatch> {
        watches.add(CallWatch { names: self.names.clone(), ..CallWatch::default() })
    }
    /// Returns whether no call is running.
    #[inline]
    pub fn is_idle(&self) -> bool {
        self.now.load(Relaxed) & ((1 << COUNTER_SHIFT) - 1) == 0
    }
    /// Returns the innermost running call, or `None` if none is running.
    pub fn call(&self) -> Option<PluginCall> {
        PluginCall::ALL[self.call_number()]
    }
    /// Returns the number of the running call: an index into [`PluginCall::ALL`].
    #[inline]
    pub fn call_number(&self) -> usize {
        (self.now.load(Relaxed) >> (OBJECT_BITS + PLUGIN_BITS)) as usize & (PluginCall::ALL.len() - 1)
    }
    /// Returns the index, in the registry, of the plugin that is called.
    pub fn plugin(&self) -> usize {
        (self.now.load(Relaxed) >> OBJECT_BITS) as usize & ((1 << PLUGIN_BITS) - 1)
    }
    /// Returns the slot of the call's object, or 0 if it has none.
    pub fn slot(&self) -> u32 {
        (self.now.load(Relaxed) & ((1 << OBJECT_BITS) - 1)) as u32
    }
    /// Records a call; returns the previous record, for [`leave`](Self::leave).
    #[inline]
    pub fn enter(&self, call: PluginCall, plugin: usize, slot: u32) -> OuterCall {
        let word = self.now.load(Relaxed);
        let plugin = (plugin as u64) & ((1 << PLUGIN_BITS) - 1);
        let object = u64::from(slot) & ((1 << OBJECT_BITS) - 1);
        let new = (call as u64) << (OBJECT_BITS + PLUGIN_BITS) | plugin << OBJECT_BITS | object;
        if word & ((1 << COUNTER_SHIFT) - 1) == 0 {
            self.outer.store(new, Relaxed);
            self.outermost.store(self.outermost.load(Relaxed).wrapping_add(1), Relaxed);
        }
        self.store_record(word, new);
        OuterCall { word, outer: CURRENT_WATCH.replace(self) }
    }
    /// Like `enter`, for a call for several instances, of which `slot` is the first.
    pub fn enter_batch(&self, call: PluginCall, plugin: usize, slot: u32, instances: usize) -> OuterCall {
        self.batch.store(u32::try_from(instances).unwrap_or(u32::MAX), Relaxed);
        self.enter(call, plugin, slot)
    }
    /// Records that the call has returned.
    #[inline]
    pub fn leave(&self, before: OuterCall) {
        self.store_record(self.now.load(Relaxed), before.word);
        CURRENT_WATCH.set(before.outer);
    }
    /// Records the command that is called; returns the previous one, to be restored when it has returned.
    #[inline]
    pub fn enter_command(&self, number: u32) -> u32 {
        let before = self.command.load(Relaxed);
        self.command.store(number, Relaxed);
        before
    }
    /// Records the script that is entered; returns the previous one.
    #[inline]
    pub fn enter_script(&self, place: ScriptPlace) -> ScriptPlace {
        let before = ScriptPlace(self.script[0].load(Relaxed), self.script[1].load(Relaxed));
        self.script[0].store(place.0, Relaxed);
        self.script[1].store(place.1, Relaxed);
        before
    }
    /// Marks the running call as active, because it waits for an external event but checks whether the run must end.
    pub fn mark_active(&self) {
        let now = self.now.load(Relaxed);
        self.store_record(now, now);
        self.outermost.store(self.outermost.load(Relaxed).wrapping_add(1), Relaxed);
    }
    #[inline]
    fn store_record(&self, last: u64, what: u64) {
        let count = (last >> COUNTER_SHIFT).wrapping_add(1);
        self.now.store(count << COUNTER_SHIFT | what & ((1 << COUNTER_SHIFT) - 1), Relaxed);
    }
    /// Sets the name of an object, for messages.
    pub fn set_object_name(&self, slot: u32, name: String) {
        if let Ok(mut names) = self.names.lock() {
            names.insert(slot, name);
        }
    }
    /// Returns the name of an object, if it is known. For slot 0, returns the current subject.
    pub fn name_of(&self, slot: u32) -> Option<String> {
        if slot == 0 {
            return self.subject.lock().ok().map(|s| s.clone()).filter(|s| !s.is_empty());
        }
        self.names.lock().ok()?.get(&slot).cloned()
    }
    /// Sets the name of the file or model that is being loaded or built, or of the service that is being called.
    /// Returns the previous name.
    pub fn replace_subject(&self, name: &str) -> String {
        self.subject.lock().map(|mut subject| std::mem::replace(&mut *subject, name.to_owned())).unwrap_or_default()
    }
}

/// A plugin call that does not return, because it is stuck or because the program crashed in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StuckCall {
    /// Id of the plugin, or its file while it is being loaded.
    pub plugin: String,
    /// Path of the object whose instance was called, or that made the call.
    pub object: Option<String>,
    /// Number of further instances that the call is for.
    pub others: u32,
    /// Name of the function in the header.
    pub call: &'static str,
    /// First name of the command, if the function is a command.
    pub command: Option<String>,
    /// The script that is running, or that made the call.
    pub script: ScriptPlace,
}

/// Number of attempts, a millisecond apart, to acquire a lock whose holder may never release it.
const MAX_LOCK_ATTEMPTS: usize = 100;

/// Acquires a lock that a stuck or crashed thread may hold; returns `None` if it is not released in time.
pub fn lock_with_timeout<T>(of: &Mutex<T>) -> Option<MutexGuard<'_, T>> {
    for _ in 0..MAX_LOCK_ATTEMPTS {
        match of.try_lock() {
            Ok(guard) => return Some(guard),
            Err(TryLockError::Poisoned(guard)) => return Some(guard.into_inner()),
            Err(TryLockError::WouldBlock) => thread::sleep(Duration::from_millis(1)),
        }
    }
    None
}

/// Returns whether a watch is referenced outside the list.
fn is_used(watch: &Arc<CallWatch>) -> bool {
    Arc::strong_count(watch) > 1
}

/// The watches of all worlds that share a set of plugins.
#[derive(Clone, Default)]
pub struct CallWatches(Arc<WatchList>);

#[derive(Default)]
struct WatchList {
    /// Shared ownership, because an exception thrown by a plugin can destroy the world before the program ends, when
    /// the record of the call must still exist.
    all: Mutex<Vec<Arc<CallWatch>>>,
    /// Ids of plugins, by index.
    plugins: Mutex<Vec<String>>,
    /// First names of commands, by number.
    commands: Mutex<Vec<String>>,
}

impl CallWatches {
    /// Creates a watch for the calls of one thread, and adds it to the list.
    pub fn add_thread(&self) -> Arc<CallWatch> {
        self.add(CallWatch::default())
    }
    fn add(&self, watch: CallWatch) -> Arc<CallWatch> {
        let new = Arc::new(watch);
        if let Ok(mut all) = self.0.all.lock() {
            all.retain(|w| is_used(w) || !w.is_idle());
            all.push(new.clone());
        }
        new
    }
    /// Sets the ids of plugins, by index.
    pub fn set_plugin_ids(&self, ids: Vec<String>) {
        if let Ok(mut plugins) = self.0.plugins.lock() {
            *plugins = ids;
        }
    }
    /// Sets the names of commands, by number.
    pub fn set_command_names(&self, names: Vec<String>) {
        if let Ok(mut commands) = self.0.commands.lock() {
            *commands = names;
        }
    }
    /// Starts the watchdog: a thread that calls `stuck` once, if a call has not returned within `limit`. It looks at
    /// the innermost call and, while a script is running, also at the outermost one, since a script can call commands
    /// without end.
    ///
    /// Time for which the whole process is paused (by a debugger, or because the computer sleeps) does not count.
    pub fn start_watchdog(
        &self,
        limit: Duration,
        stuck: impl FnOnce(StuckCall) + Send + 'static,
    ) -> std::io::Result<()> {
        let watches = self.clone();
        let pause = (limit / 20).clamp(Duration::from_millis(1), Duration::from_millis(250));
        let run = move || {
            // For each watch: its last record, the number of its outermost call, and how long each has been unchanged.
            let mut seen: BTreeMap<*const CallWatch, ([u64; 2], [Duration; 2])> = BTreeMap::new();
            loop {
                thread::sleep(pause);
                let all: Vec<Arc<CallWatch>> = watches
                    .0
                    .all
                    .lock()
                    .map(|all| all.iter().filter(|w| is_used(w)).cloned().collect())
                    .unwrap_or_default();
                let mut next = BTreeMap::new();
                for watch in &all {
                    let key = Arc::as_ptr(watch);
                    let word = watch.now.load(Relaxed);
                    let idle = word & ((1 << COUNTER_SHIFT) - 1) == 0;
                    let runs_script = watch.script[0].load(Relaxed) != 0;
                    let (now, counts) = ([word, watch.outermost.load(Relaxed)], [!idle, !idle && runs_script]);
                    let mut since = [Duration::ZERO; 2];
                    if let Some((last, before)) = seen.get(&key) {
                        for i in 0..2 {
                            if counts[i] && last[i] == now[i] {
                                since[i] = before[i] + pause;
                            }
                        }
                    }
                    if since[0] >= limit {
                        return stuck(watches.describe(watch, word));
                    }
                    if since[1] >= limit {
                        return stuck(watches.describe(watch, watch.outer.load(Relaxed)));
                    }
                    next.insert(key, (now, since));
                }
                seen = next;
            }
        };
        thread::Builder::new().name("watchdog".into()).spawn(run).map(drop)
    }

    /// Returns a call that is running on any thread.
    pub fn any_running(&self) -> Option<StuckCall> {
        let watch = lock_with_timeout(&self.0.all)?.iter().find(|w| !w.is_idle())?.clone();
        let word = watch.now.load(Relaxed);
        (word & ((1 << COUNTER_SHIFT) - 1) != 0).then(|| self.describe(&watch, word))
    }

    /// Returns the call running on the thread whose [`current_watch`] this is, or `None` if there is none.
    pub fn running(&self, here: *const CallWatch) -> Option<StuckCall> {
        let watch = lock_with_timeout(&self.0.all)?.iter().find(|w| ptr::eq(Arc::as_ptr(w), here))?.clone();
        let word = watch.now.load(Relaxed);
        (word & ((1 << COUNTER_SHIFT) - 1) != 0).then(|| self.describe(&watch, word))
    }

    fn describe(&self, watch: &CallWatch, word: u64) -> StuckCall {
        let part = |from: u32, bits: u32| (word >> from & ((1 << bits) - 1)) as usize;
        let (slot, plugin) = (part(0, OBJECT_BITS) as u32, part(OBJECT_BITS, PLUGIN_BITS));
        let call = PluginCall::TEXTS
            .get(part(OBJECT_BITS + PLUGIN_BITS, COUNTER_SHIFT - OBJECT_BITS - PLUGIN_BITS))
            .copied()
            .unwrap_or("a function");
        let subject = lock_with_timeout(&watch.subject).map(|s| s.clone()).unwrap_or_default();
        let id = lock_with_timeout(&self.0.plugins).and_then(|p| p.get(plugin).cloned());
        let name = || lock_with_timeout(&watch.names).and_then(|n| n.get(&slot).cloned());
        let object = match slot {
            0 => (!subject.is_empty() && id.is_some()).then(|| subject.clone()),
            _ => Some(name().unwrap_or_else(|| format!("object {slot}"))),
        };
        let batch = [PluginCall::Aim, PluginCall::Measure, PluginCall::Finish, PluginCall::Apply]
            .map(PluginCall::text)
            .contains(&call);
        let others = if batch { watch.batch.load(Relaxed).saturating_sub(1) } else { 0 };
        let command = watch.command.load(Relaxed) as usize;
        let command = (call == PluginCall::Command.text())
            .then(|| lock_with_timeout(&self.0.commands)?.get(command.wrapping_sub(1)).cloned())
            .flatten();
        let script = ScriptPlace(watch.script[0].load(Relaxed), watch.script[1].load(Relaxed));
        StuckCall { plugin: id.unwrap_or(subject), object, others, call, command, script }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;

    #[test]
    fn hung_call_is_reported_while_returning_calls_are_not() {
        let watches = CallWatches::default();
        watches.set_plugin_ids(vec!["org.a".into(), "org.b".into()]);
        let (good, bad) = (watches.add_thread(), watches.add_thread());
        bad.set_object_name(7, "/robot".into());
        let (tell, told) = mpsc::channel();
        watches.start_watchdog(Duration::from_millis(40), move |s| tell.send(s).unwrap()).unwrap();
        let outer = bad.enter(PluginCall::ScriptCall, 0, 7);
        bad.enter(PluginCall::Command, 1, 7);
        // The other world keeps calling and returning, while this call lasts.
        good.enter(PluginCall::ScriptCall, 0, 3);
        let stuck = loop {
            let inner = good.enter(PluginCall::Command, 1, 3);
            good.leave(inner);
            if let Ok(stuck) = told.try_recv() {
                break stuck;
            }
        };
        let object = Some("/robot".into());
        let (command, script) = (None, ScriptPlace(0, 0));
        let wanted =
            StuckCall { plugin: "org.b".into(), object, others: 0, call: "tatu_command.call", command, script };
        assert_eq!(stuck, wanted);
        assert_eq!(outer.word & ((1 << COUNTER_SHIFT) - 1), 0, "nothing was noted before");
    }

    #[test]
    fn script_calling_commands_endlessly_is_reported() {
        let watches = CallWatches::default();
        watches.set_plugin_ids(vec!["org.language".into(), "org.commands".into()]);
        let watch = watches.add_thread();
        watch.set_object_name(7, "/robot".into());
        let (tell, told) = mpsc::channel();
        watches.start_watchdog(Duration::from_millis(40), move |s| tell.send(s).unwrap()).unwrap();
        watch.enter(PluginCall::ScriptCall, 0, 7);
        watch.enter_script(ScriptPlace(1, 1));
        let stuck = loop {
            let inner = watch.enter(PluginCall::Command, 1, 7);
            watch.leave(inner);
            if let Ok(stuck) = told.try_recv() {
                break stuck;
            }
        };
        assert_eq!((stuck.plugin.as_str(), stuck.call), ("org.language", "tatu_language.call"));
        assert_eq!(stuck.object.as_deref(), Some("/robot"));
    }

    #[test]
    fn innermost_call_of_a_thread_is_found() {
        let watches = CallWatches::default();
        watches.set_plugin_ids(vec!["org.a".into(), "org.b".into()]);
        let (world, loading) = (watches.add_thread(), watches.add_thread());
        let of_here = || watches.running(current_watch()).map(|s| (s.plugin, s.others));
        assert_eq!(of_here(), None);
        let outer = world.enter_batch(PluginCall::Measure, 0, 7, 3);
        assert_eq!(of_here(), Some(("org.a".into(), 2)));
        let inner = loading.enter(PluginCall::Import, 1, 0);
        assert_eq!(of_here(), Some(("org.b".into(), 0)));
        assert!(thread::spawn(|| current_watch().is_null()).join().unwrap());
        loading.leave(inner);
        assert_eq!(of_here(), Some(("org.a".into(), 2)));
        world.leave(outer);
        assert!(current_watch().is_null());
    }

    #[test]
    fn plugin_without_index_is_named_by_its_file() {
        let watches = CallWatches::default();
        let watch = watches.add_thread();
        watch.replace_subject("a/libtatu_x.so");
        watch.enter(PluginCall::Init, 0, 0);
        let stuck = watches.describe(&watch, watch.now.load(Relaxed));
        assert_eq!((stuck.plugin.as_str(), stuck.object, stuck.call), ("a/libtatu_x.so", None, "tatu_plugin.init"));
    }
}
