//! Calls into plugins: noted for the watchdog, with the state of thread and process put back after them.

use tatu_errors::{Fault, FaultKind};
use tatu_plugins::{guard, watchdog::Call};

use super::WorldCell;

/// How many checks of the process there are to one that takes system calls.
const CHECKS: u32 = 64;

impl WorldCell {
    /// Calls a function of a plugin on behalf of an object (0: of none). Every call into a plugin goes through here: it is
    /// noted for the watchdog, and after the outermost one the floating-point mode is put back.
    ///
    /// Reading the mode takes some 10 ns, ten times as long as the note: commands that scripts call are looked at one by
    /// one only after something has been found.
    #[inline]
    pub fn cross<T>(&self, plugin: usize, call: Call, slot: u32, f: impl FnOnce() -> T) -> T {
        if self.border.watch.is_idle() || self.border.suspicious.get() {
            return self.cross_watched(plugin, call, slot, f);
        }
        let before = self.border.watch.enter(call, plugin, slot);
        let done = f();
        // The next copy would run backwards.
        let turned = guard::clear_direction();
        guard::end_if_child();
        self.border.watch.leave(before);
        self.border.called.set(self.border.called.get() | 1 << plugin.min(63));
        if turned {
            self.blame(1 << plugin.min(63), guard::DIRECTION, call.text(), self.border.watch.name_of(slot));
        }
        done
    }
    fn cross_watched<T>(&self, plugin: usize, call: Call, slot: u32, f: impl FnOnce() -> T) -> T {
        let earlier = self.border.called.replace(0);
        let before = self.border.watch.enter(call, plugin, slot);
        let (done, moved) = guard::watched(f);
        self.border.watch.leave(before);
        let own = 1 << plugin.min(63);
        let within = self.border.called.get() | own;
        self.border.called.set(earlier | within);
        if let Some(what) = moved {
            // What was called within has been looked at already, once there was a suspicion.
            let suspects = if self.border.suspicious.replace(true) { own } else { within };
            self.blame(suspects, what, call.text(), self.border.watch.name_of(slot));
        }
        done
    }
    /// The same for a function that has no error object; what it logged as an error comes with it.
    pub fn cross_capturing<T>(&self, plugin: usize, call: Call, slot: u32, f: impl FnOnce() -> T) -> (T, Vec<String>) {
        guard::capture_errors(|| self.cross_watched(plugin, call, slot, f))
    }
    /// The same: what it logs as an error, a panic for instance, is its fault.
    pub fn cross_quietly<T>(&self, plugin: usize, call: Call, slot: u32, f: impl FnOnce() -> T) -> T {
        let (done, heard) = self.cross_capturing(plugin, call, slot, f);
        for said in heard {
            let id = &self.model.registry.plugins[plugin].id;
            let mut fault = Fault::new(FaultKind::Plugin, format!("plugin `{id}` {said} in {}", call.text()));
            fault.plugin = Some(id.clone());
            fault.object = self.border.watch.name_of(slot);
            self.report(fault);
        }
        done
    }
    /// Looks, after a stage, at what a look at each call would take too long: the locale, and the old floating-point
    /// unit. Who was called meanwhile is suspected.
    pub fn restore_process_state(&self, stage: &str) {
        let called = self.border.called.take();
        if let Some(what) = self.border.home.borrow().restore_quickly() {
            self.blame(called, what, stage, None);
        }
        self.take_strangers();
        self.border.called_lately.set(self.border.called_lately.get() | called);
        self.border.checks.set(self.border.checks.get().wrapping_add(1));
        if self.border.checks.get().is_multiple_of(CHECKS) {
            self.restore_process("the last steps");
        }
    }
    /// The same for what takes calls of the system: the working folder, what signals do, standard output.
    pub fn restore_process(&self, place: &str) {
        let called = self.border.called_lately.take();
        if let Some(what) = self.border.home.borrow().restore() {
            self.blame(called, &what, place, None);
        }
    }
    #[cold]
    fn blame(&self, suspects: u64, what: &str, place: &str, object: Option<String>) {
        let plugins = &self.model.registry.plugins;
        let mut all: Vec<usize> = (0..plugins.len()).filter(|i| suspects & 1 << (*i).min(63) != 0).collect();
        // Those of the program are tested for it.
        if all.iter().any(|i| !self.model.registry.is_of_program(*i)) {
            all.retain(|i| !self.model.registry.is_of_program(*i));
        }
        let ids: Vec<&str> = all.iter().map(|i| plugins[*i].id.as_str()).collect();
        let who = match ids.as_slice() {
            [one] => format!("plugin `{one}`"),
            [] => "a plugin, in a thread of its own,".to_owned(),
            many => format!("one of the plugins `{}`", many.join("`, `")),
        };
        let mut fault = Fault::new(FaultKind::Plugin, format!("{who} changed {what} in {place}"));
        fault.plugin = ids.first().filter(|_| ids.len() == 1).map(|id| (*id).to_owned());
        fault.object = object;
        fault.help = Some(guard::HELP.into());
        self.report(fault);
    }
}
