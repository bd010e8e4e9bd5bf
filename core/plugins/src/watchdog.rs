//! Which plugin call is running, noted so that another thread can tell when one never returns.
//!
//! The running thread notes each call by two stores of one word, a relaxed one on the way in and one on the way out. A
//! [watchdog](Watches::guard) looks at the words now and then; one that stays the same for longer than the limit
//! names the call. A wall clock only ever ends a run; it never decides what happens in one.

use std::{
    collections::BTreeMap,
    sync::{
        Arc, Mutex, Weak,
        atomic::{AtomicU64, Ordering::Relaxed},
    },
    thread,
    time::Duration,
};

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
            const ALL: [Option<Call>; 64] = {
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
}

impl Call {
    /// As the header calls it: "tatu_sensor.measure".
    pub fn text(self) -> &'static str {
        Self::TEXTS[self as usize]
    }
}

/// Bits of a note: object (20), plugin (14), call (6), and above them a count that makes every note another word.
const OBJECT: u32 = 20;
const PLUGIN: u32 = 14;
const COUNT: u32 = 40;

/// What one thread of calls (a world, or the loading of plugins) is in. Written by that thread alone.
#[derive(Default)]
pub struct Watch {
    now: AtomicU64,
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
    #[inline]
    pub fn call(&self) -> Option<Call> {
        Call::ALL[(self.now.load(Relaxed) >> (OBJECT + PLUGIN)) as usize & ((1 << (COUNT - OBJECT - PLUGIN)) - 1)]
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
    pub fn enter(&self, call: Call, plugin: usize, slot: u32) -> u64 {
        let before = self.now.load(Relaxed);
        let plugin = (plugin as u64) & ((1 << PLUGIN) - 1);
        let object = u64::from(slot) & ((1 << OBJECT) - 1);
        self.note(before, (call as u64) << (OBJECT + PLUGIN) | plugin << OBJECT | object);
        before
    }
    /// Notes that it has returned.
    #[inline]
    pub fn leave(&self, before: u64) {
        self.note(self.now.load(Relaxed), before);
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
    /// How an object is called in messages.
    pub fn name(&self, slot: u32, name: String) {
        if let Ok(mut names) = self.names.lock() {
            names.insert(slot, name);
        }
    }
    /// The name of an object, if it was told; 0: of what runs for none.
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

/// A call that did not return.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stuck {
    /// Id of the plugin; its file while it is being loaded.
    pub plugin: String,
    /// Path of the object whose instance it is, or that called.
    pub object: Option<String>,
    /// The function.
    pub call: &'static str,
}

/// The notes of all worlds that share a set of plugins.
#[derive(Clone, Default)]
pub struct Watches(Arc<Inner>);

#[derive(Default)]
struct Inner {
    all: Mutex<Vec<Weak<Watch>>>,
    /// Ids, by index.
    plugins: Mutex<Vec<String>>,
}

impl Watches {
    /// One more place for notes.
    pub fn watch(&self) -> Arc<Watch> {
        self.add(Watch::default())
    }
    fn add(&self, watch: Watch) -> Arc<Watch> {
        let new = Arc::new(watch);
        if let Ok(mut all) = self.0.all.lock() {
            all.retain(|w| w.strong_count() > 0);
            all.push(Arc::downgrade(&new));
        }
        new
    }
    /// The ids of plugins, by index.
    pub fn plugins(&self, ids: Vec<String>) {
        if let Ok(mut plugins) = self.0.plugins.lock() {
            *plugins = ids;
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
                let all: Vec<Arc<Watch>> =
                    watches.0.all.lock().map(|all| all.iter().filter_map(Weak::upgrade).collect()).unwrap_or_default();
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

    fn describe(&self, watch: &Watch, word: u64) -> Stuck {
        let part = |from: u32, bits: u32| (word >> from & ((1 << bits) - 1)) as usize;
        let (slot, plugin) = (part(0, OBJECT) as u32, part(OBJECT, PLUGIN));
        let call = Call::TEXTS.get(part(OBJECT + PLUGIN, COUNT - OBJECT - PLUGIN)).copied().unwrap_or("a function");
        let subject = watch.subject.lock().map(|s| s.clone()).unwrap_or_default();
        let id = self.0.plugins.lock().ok().and_then(|p| p.get(plugin).cloned());
        let name = || watch.names.lock().ok().and_then(|n| n.get(&slot).cloned());
        let object = match slot {
            0 => (!subject.is_empty() && id.is_some()).then(|| subject.clone()),
            _ => Some(name().unwrap_or_else(|| format!("object {slot}"))),
        };
        Stuck { plugin: id.unwrap_or(subject), object, call }
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
        let wanted = Stuck { plugin: "org.b".into(), object: Some("/robot".into()), call: "tatu_command.call" };
        assert_eq!(stuck, wanted);
        assert_eq!(outer & ((1 << COUNT) - 1), 0, "nothing was noted before");
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
