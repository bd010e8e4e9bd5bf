//! Which plugin call is running, noted so that another thread notices when one never returns.
//!
//! The running thread notes each call by two stores of one word, a relaxed one on the way in and one on the way out. A
//! [watchdog](Watches::guard) looks at the words now and then; one that stays the same for longer than the limit
//! names the call. A wall clock only ever ends a run; it never decides what happens in one.
//!
//! Each thread knows the watch whose call it runs ([`here`]), so that a crash on it can be attributed to that call.

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
        /// A function of a plugin.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u8)]
        #[allow(missing_docs, reason = "the names are those of the header")]
        pub enum Call { None, $($(#[$doc])* $name),* }

        impl Call {
            const TEXTS: &[&str] = &["nothing", $($text),*];
            /// By number, as a note has it.
            pub const ALL: [Option<Call>; 64] = {
                let mut all = [None; 64];
                $(all[Call::$name as usize] = Some(Call::$name);)*
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
}

impl Call {
    /// Its name in the header: "tatu_sensor.measure".
    pub fn text(self) -> &'static str {
        Self::TEXTS[self as usize]
    }
}

/// Bits of a note: object (20), plugin (14), call (6), and above them a count that makes every note another word.
const OBJECT: u32 = 20;
const PLUGIN: u32 = 14;
const COUNT: u32 = 40;

thread_local! {
    /// The watch of the innermost call on this thread. Constant at first and without a destructor: a signal handler may
    /// read it at any time.
    static HERE: Cell<*const Watch> = const { Cell::new(ptr::null()) };
}

/// The watch whose plugin call runs on this thread; null: none does. Signal handlers may ask; what it is, and whether
/// it still exists is known by [`Watches::running`].
pub fn here() -> *const Watch {
    HERE.get()
}

/// How the position of a script is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScriptPlace(usize, usize);

impl ScriptPlace {
    /// By the function of its language and its data there.
    pub fn new(place: Option<unsafe extern "C" fn(*mut c_void, *mut tatu_error)>, data: *mut c_void) -> Self {
        ScriptPlace(place.map_or(0, |f| f as usize), data as usize)
    }
    /// Queries it: file and line.
    ///
    /// # Safety
    /// The script exists, and the thread that runs it is stopped.
    pub unsafe fn ask(self) -> Option<(String, u64)> {
        if self.0 == 0 || self.1 == 0 {
            return None;
        }
        let mut error = ErrorSlot::new();
        // SAFETY: made of such a function in `new`; the rest the caller promises.
        unsafe {
            let place: unsafe extern "C" fn(*mut c_void, *mut tatu_error) = std::mem::transmute(self.0);
            place(self.1 as *mut c_void, error.fresh());
        }
        let said = error.said();
        said.file.filter(|_| said.line > 0).map(|file| (file, said.line))
    }
}

/// What ran before a call: for [`Watch::leave`].
#[derive(Debug, Clone, Copy)]
pub struct Before {
    word: u64,
    outer: *const Watch,
}

/// What one thread of calls (a world, or the loading of plugins) is in. Written by that thread alone.
#[derive(Default)]
pub struct Watch {
    now: AtomicU64,
    /// Instances of the call, where it is one for a batch; the note has the first one.
    batch: AtomicU32,
    /// The command that runs, by its number from 1; 0: none.
    command: AtomicU32,
    /// How the position of the innermost script is found: `tatu_language.place` and its data; 0: there is none.
    script: [AtomicUsize; 2],
    /// Names of objects, by slot.
    names: Arc<Mutex<BTreeMap<u32, String>>>,
    /// While nothing has an index yet: what is loaded or built. Within a service's turn: the service.
    subject: Mutex<String>,
}

impl Watch {
    /// Another place for notes, of a thread that works beside this one: objects have the same names.
    pub fn beside(&self, watches: &Watches) -> Arc<Watch> {
        watches.add(Watch { names: self.names.clone(), ..Watch::default() })
    }
    /// Whether no call is running.
    #[inline]
    pub fn is_idle(&self) -> bool {
        self.now.load(Relaxed) & ((1 << COUNT) - 1) == 0
    }
    /// The call that runs, the innermost one; none: none does.
    pub fn call(&self) -> Option<Call> {
        Call::ALL[self.call_number()]
    }
    /// Its number: a place in [`Call::ALL`].
    #[inline]
    pub fn call_number(&self) -> usize {
        (self.now.load(Relaxed) >> (OBJECT + PLUGIN)) as usize & (Call::ALL.len() - 1)
    }
    /// The index of its plugin.
    pub fn plugin(&self) -> usize {
        (self.now.load(Relaxed) >> OBJECT) as usize & ((1 << PLUGIN) - 1)
    }
    /// The slot of its object; 0: none.
    pub fn slot(&self) -> u32 {
        (self.now.load(Relaxed) & ((1 << OBJECT) - 1)) as u32
    }
    /// Notes a call; gives what was noted before, for [`leave`](Self::leave).
    #[inline]
    pub fn enter(&self, call: Call, plugin: usize, slot: u32) -> Before {
        let word = self.now.load(Relaxed);
        let plugin = (plugin as u64) & ((1 << PLUGIN) - 1);
        let object = u64::from(slot) & ((1 << OBJECT) - 1);
        self.note(word, (call as u64) << (OBJECT + PLUGIN) | plugin << OBJECT | object);
        Before { word, outer: HERE.replace(self) }
    }
    /// The same for one call that is for several instances, of which `slot` is the first.
    pub fn enter_batch(&self, call: Call, plugin: usize, slot: u32, instances: usize) -> Before {
        self.batch.store(u32::try_from(instances).unwrap_or(u32::MAX), Relaxed);
        self.enter(call, plugin, slot)
    }
    /// Notes that it has returned.
    #[inline]
    pub fn leave(&self, before: Before) {
        self.note(self.now.load(Relaxed), before.word);
        HERE.set(before.outer);
    }
    /// Notes which command is called; what was noted before, to be noted again when it has returned.
    #[inline]
    pub fn command(&self, number: u32) -> u32 {
        let before = self.command.load(Relaxed);
        self.command.store(number, Relaxed);
        before
    }
    /// Notes which script is entered, by what finds its position; returns what was noted before.
    #[inline]
    pub fn script(&self, place: ScriptPlace) -> ScriptPlace {
        let before = ScriptPlace(self.script[0].load(Relaxed), self.script[1].load(Relaxed));
        self.script[0].store(place.0, Relaxed);
        self.script[1].store(place.1, Relaxed);
        before
    }
    /// The call that runs waits for something outside, and asks whether the run is to end: it is not stuck.
    pub fn waits(&self) {
        let now = self.now.load(Relaxed);
        self.note(now, now);
    }
    #[inline]
    fn note(&self, last: u64, what: u64) {
        let count = (last >> COUNT).wrapping_add(1);
        self.now.store(count << COUNT | what & ((1 << COUNT) - 1), Relaxed);
    }
    /// The name of an object in messages.
    pub fn name(&self, slot: u32, name: String) {
        if let Ok(mut names) = self.names.lock() {
            names.insert(slot, name);
        }
    }
    /// The name of an object, if it is known; 0: of what runs for none.
    pub fn name_of(&self, slot: u32) -> Option<String> {
        if slot == 0 {
            return self.subject.lock().ok().map(|s| s.clone()).filter(|s| !s.is_empty());
        }
        self.names.lock().ok()?.get(&slot).cloned()
    }
    /// What is loaded or built, or whose turn it is.
    pub fn subject(&self, name: &str) {
        if let Ok(mut subject) = self.subject.lock() {
            name.clone_into(&mut subject);
        }
    }
}

/// A call that does not return: it is stuck, or the program crashed in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stuck {
    /// Id of the plugin; its file while it is being loaded.
    pub plugin: String,
    /// Path of the object whose instance it is, or that called.
    pub object: Option<String>,
    /// How many more instances the call is for.
    pub others: u32,
    /// The function.
    pub call: &'static str,
    /// The command, by its first name, if it is one's.
    pub command: Option<String>,
    /// The script that called it, or that runs.
    pub script: ScriptPlace,
}

/// How often, each a millisecond later, a lock is tried whose holder may never give it back.
const TRIES: usize = 100;

/// Locks something that a thread which is stuck, or has crashed, may hold: `None` then.
pub fn peek<T>(of: &Mutex<T>) -> Option<MutexGuard<'_, T>> {
    for _ in 0..TRIES {
        match of.try_lock() {
            Ok(guard) => return Some(guard),
            Err(TryLockError::Poisoned(guard)) => return Some(guard.into_inner()),
            Err(TryLockError::WouldBlock) => thread::sleep(Duration::from_millis(1)),
        }
    }
    None
}

/// Whether a watch is used outside the list.
fn is_used(watch: &Arc<Watch>) -> bool {
    Arc::strong_count(watch) > 1
}

/// The notes of all worlds that share a set of plugins.
#[derive(Clone, Default)]
pub struct Watches(Arc<Inner>);

#[derive(Default)]
struct Inner {
    /// Held by the list, too: an exception that leaves a plugin may take the world away before it ends the program, and
    /// whose call it was must still be known then.
    all: Mutex<Vec<Arc<Watch>>>,
    /// Ids, by index.
    plugins: Mutex<Vec<String>>,
    /// First names, by number.
    commands: Mutex<Vec<String>>,
}

impl Watches {
    /// One more place for notes.
    pub fn watch(&self) -> Arc<Watch> {
        self.add(Watch::default())
    }
    fn add(&self, watch: Watch) -> Arc<Watch> {
        let new = Arc::new(watch);
        if let Ok(mut all) = self.0.all.lock() {
            all.retain(|w| is_used(w) || !w.is_idle());
            all.push(new.clone());
        }
        new
    }
    /// Sets the ids of plugins, by index.
    pub fn plugins(&self, ids: Vec<String>) {
        if let Ok(mut plugins) = self.0.plugins.lock() {
            *plugins = ids;
        }
    }
    /// Sets the names of commands, by number.
    pub fn commands(&self, names: Vec<String>) {
        if let Ok(mut commands) = self.0.commands.lock() {
            *commands = names;
        }
    }
    /// Starts the watchdog: a thread that calls `stuck` once, when a call has not returned within `limit`.
    ///
    /// A pause of the whole process (a debugger, a laptop put to sleep) does not count.
    pub fn guard(&self, limit: Duration, stuck: impl FnOnce(Stuck) + Send + 'static) -> std::io::Result<()> {
        let watches = self.clone();
        let pause = (limit / 20).clamp(Duration::from_millis(1), Duration::from_millis(250));
        let run = move || {
            // What each watch was in, and for how long.
            let mut seen: BTreeMap<*const Watch, (u64, Duration)> = BTreeMap::new();
            loop {
                thread::sleep(pause);
                let all: Vec<Arc<Watch>> = watches
                    .0
                    .all
                    .lock()
                    .map(|all| all.iter().filter(|w| is_used(w)).cloned().collect())
                    .unwrap_or_default();
                let mut next = BTreeMap::new();
                for watch in &all {
                    let key = Arc::as_ptr(watch);
                    let word = watch.now.load(Relaxed);
                    let idle = word & ((1 << COUNT) - 1) == 0;
                    let since = match seen.get(&key) {
                        Some((last, since)) if *last == word && !idle => *since + pause,
                        _ => Duration::ZERO,
                    };
                    if since >= limit {
                        return stuck(watches.describe(watch, word));
                    }
                    next.insert(key, (word, since));
                }
                seen = next;
            }
        };
        thread::Builder::new().name("watchdog".into()).spawn(run).map(drop)
    }

    /// A call that runs on any thread.
    pub fn any_running(&self) -> Option<Stuck> {
        let watch = peek(&self.0.all)?.iter().find(|w| !w.is_idle())?.clone();
        let word = watch.now.load(Relaxed);
        (word & ((1 << COUNT) - 1) != 0).then(|| self.describe(&watch, word))
    }

    /// The call that runs on the thread whose [`here`] this is; `None`: none does.
    pub fn running(&self, here: *const Watch) -> Option<Stuck> {
        let watch = peek(&self.0.all)?.iter().find(|w| ptr::eq(Arc::as_ptr(w), here))?.clone();
        let word = watch.now.load(Relaxed);
        (word & ((1 << COUNT) - 1) != 0).then(|| self.describe(&watch, word))
    }

    fn describe(&self, watch: &Watch, word: u64) -> Stuck {
        let part = |from: u32, bits: u32| (word >> from & ((1 << bits) - 1)) as usize;
        let (slot, plugin) = (part(0, OBJECT) as u32, part(OBJECT, PLUGIN));
        let call = Call::TEXTS.get(part(OBJECT + PLUGIN, COUNT - OBJECT - PLUGIN)).copied().unwrap_or("a function");
        let subject = peek(&watch.subject).map(|s| s.clone()).unwrap_or_default();
        let id = peek(&self.0.plugins).and_then(|p| p.get(plugin).cloned());
        let name = || peek(&watch.names).and_then(|n| n.get(&slot).cloned());
        let object = match slot {
            0 => (!subject.is_empty() && id.is_some()).then(|| subject.clone()),
            _ => Some(name().unwrap_or_else(|| format!("object {slot}"))),
        };
        let batch = [Call::Aim, Call::Measure, Call::Finish, Call::Apply].map(Call::text).contains(&call);
        let others = if batch { watch.batch.load(Relaxed).saturating_sub(1) } else { 0 };
        let command = watch.command.load(Relaxed) as usize;
        let command = (call == Call::Command.text())
            .then(|| peek(&self.0.commands)?.get(command.wrapping_sub(1)).cloned())
            .flatten();
        let script = ScriptPlace(watch.script[0].load(Relaxed), watch.script[1].load(Relaxed));
        Stuck { plugin: id.unwrap_or(subject), object, others, call, command, script }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;

    #[test]
    fn a_call_that_stays_is_named_and_those_that_return_are_not() {
        let watches = Watches::default();
        watches.plugins(vec!["org.a".into(), "org.b".into()]);
        let (good, bad) = (watches.watch(), watches.watch());
        bad.name(7, "/robot".into());
        let (tell, told) = mpsc::channel();
        watches.guard(Duration::from_millis(40), move |s| tell.send(s).unwrap()).unwrap();
        let outer = bad.enter(Call::ScriptCall, 0, 7);
        bad.enter(Call::Command, 1, 7);
        // The other one calls and returns all the time, within a call that lasts.
        good.enter(Call::ScriptCall, 0, 3);
        let stuck = loop {
            let inner = good.enter(Call::Command, 1, 3);
            good.leave(inner);
            if let Ok(stuck) = told.try_recv() {
                break stuck;
            }
        };
        let object = Some("/robot".into());
        let (command, script) = (None, ScriptPlace(0, 0));
        let wanted = Stuck { plugin: "org.b".into(), object, others: 0, call: "tatu_command.call", command, script };
        assert_eq!(stuck, wanted);
        assert_eq!(outer.word & ((1 << COUNT) - 1), 0, "nothing was noted before");
    }

    #[test]
    fn a_thread_knows_the_innermost_call_that_it_runs() {
        let watches = Watches::default();
        watches.plugins(vec!["org.a".into(), "org.b".into()]);
        let (world, loading) = (watches.watch(), watches.watch());
        let of_here = || watches.running(here()).map(|s| (s.plugin, s.others));
        assert_eq!(of_here(), None);
        let outer = world.enter_batch(Call::Measure, 0, 7, 3);
        assert_eq!(of_here(), Some(("org.a".into(), 2)));
        let inner = loading.enter(Call::Import, 1, 0);
        assert_eq!(of_here(), Some(("org.b".into(), 0)));
        assert!(thread::spawn(|| here().is_null()).join().unwrap());
        loading.leave(inner);
        assert_eq!(of_here(), Some(("org.a".into(), 2)));
        world.leave(outer);
        assert!(here().is_null());
    }

    #[test]
    fn what_has_no_index_yet_is_named_by_its_file() {
        let watches = Watches::default();
        let watch = watches.watch();
        watch.subject("a/libtatu_x.so");
        watch.enter(Call::Init, 0, 0);
        let stuck = watches.describe(&watch, watch.now.load(Relaxed));
        assert_eq!((stuck.plugin.as_str(), stuck.object, stuck.call), ("a/libtatu_x.so", None, "tatu_plugin.init"));
    }
}
