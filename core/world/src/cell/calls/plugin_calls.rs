//! Calls plugins. Each call is recorded for the watchdog, and the process and thread state is restored afterwards.

use tatu_errors::{Fault, FaultKind};
use tatu_plugin_api::abi::{tatu_error, tatu_status};
use tatu_plugins::{border::ErrorSlot, lock_setup, protected_state, watchdog::PluginCall};

use crate::cell::WorldCell;

/// Number of quick checks per full check, which requires system calls.
const QUICK_CHECKS_PER_FULL: u32 = 64;

/// Returns whether a call creates or destroys an instance. Worlds on different threads must not make such calls
/// concurrently.
#[inline]
fn is_setup(call: PluginCall) -> bool {
    matches!(call, PluginCall::Create | PluginCall::Destroy)
}

impl WorldCell {
    /// Calls a function of a plugin that returns a status, and describes a failure in `error`. If it fails without a reason,
    /// the reason is that of the host function that failed last, provided it had the same status.
    pub fn call_plugin_checked(
        &self,
        (plugin, call, slot): (usize, PluginCall, u32),
        error: &mut ErrorSlot,
        f: impl FnOnce(*mut tatu_error) -> tatu_status,
    ) -> tatu_status {
        let last = &self.run.calls.last_refusal;
        if let Ok(mut last) = last.try_borrow_mut() {
            last.reset();
        }
        let status = self.call_plugin(plugin, call, slot, || f(error.raw()));
        let status = error.check_status(status, false);
        if status < 0
            && !error.has_error()
            && let Ok(mut last) = last.try_borrow_mut()
            && last.code() == status
        {
            error.object().copy_from(&last.object());
        }
        status
    }

    /// Calls a function of a plugin on behalf of an object, or of no object if `slot` is 0. Records the call for the
    /// watchdog, and restores the floating-point mode after the outermost call.
    ///
    /// Reading the mode takes about 10 ns, ten times as long as the record. Commands called by scripts are therefore
    /// checked individually only after a change has been detected.
    #[inline]
    pub fn call_plugin<T>(&self, plugin: usize, call: PluginCall, slot: u32, f: impl FnOnce() -> T) -> T {
        let _turn = is_setup(call).then(lock_setup);
        if self.monitor.watch.is_idle() || self.monitor.suspicious.get() {
            return self.call_plugin_watched(plugin, call, slot, f);
        }
        let before = self.monitor.watch.enter(call, plugin, slot);
        let done = f();
        // If the direction flag remained set, the next memory copy would run backwards.
        let turned = protected_state::clear_direction();
        protected_state::end_if_child();
        self.monitor.watch.leave(before);
        self.monitor.called.set(self.monitor.called.get() | 1 << plugin.min(63));
        if turned {
            self.report_process_change(
                1 << plugin.min(63),
                protected_state::DIRECTION_TEXT,
                call.text(),
                self.monitor.watch.name_of(slot),
            );
        }
        done
    }
    fn call_plugin_watched<T>(&self, plugin: usize, call: PluginCall, slot: u32, f: impl FnOnce() -> T) -> T {
        let _turn = is_setup(call).then(lock_setup);
        let earlier = self.monitor.called.replace(0);
        let before = self.monitor.watch.enter(call, plugin, slot);
        let (done, moved) = protected_state::call_and_restore(f);
        self.monitor.watch.leave(before);
        let own = 1 << plugin.min(63);
        let within = self.monitor.called.get() | own;
        self.monitor.called.set(earlier | within);
        if let Some(what) = moved {
            // If the mode was already suspicious, the calls nested in this one have been checked individually.
            let suspects = if self.monitor.suspicious.replace(true) { own } else { within };
            self.report_process_change(suspects, what, call.text(), self.monitor.watch.name_of(slot));
        }
        done
    }
    /// Like `call_plugin`, but for a function without an error object. In addition, returns the errors that the
    /// function logged.
    pub fn call_plugin_capturing<T>(
        &self,
        plugin: usize,
        call: PluginCall,
        slot: u32,
        f: impl FnOnce() -> T,
    ) -> (T, Vec<String>) {
        protected_state::capture_errors(|| self.call_plugin_watched(plugin, call, slot, f))
    }
    /// Like `call_plugin`, but also reports the errors that the function logs (such as a panic) as faults of the
    /// plugin.
    pub fn call_plugin_reporting<T>(&self, plugin: usize, call: PluginCall, slot: u32, f: impl FnOnce() -> T) -> T {
        let (done, heard) = self.call_plugin_capturing(plugin, call, slot, f);
        for said in heard {
            let id = &self.model.registry.plugins[plugin].id;
            let mut fault = Fault::new(FaultKind::Plugin, format!("plugin `{id}` {said} in {}", call.text()));
            fault.plugin = Some(id.clone());
            fault.object = self.monitor.watch.name_of(slot);
            self.report(fault);
        }
        done
    }
    /// Restores the locale and the x87 control word after a stage, since checking them after each call would take too
    /// long. Reports a change as a fault of the plugins called since the last check.
    pub fn restore_process_state(&self, stage: &str) {
        let called = self.monitor.called.take();
        if let Some(what) = self.monitor.process_state.borrow().restore_quickly() {
            self.report_process_change(called, what, stage, None);
        }
        self.report_unassigned_breaches();
        self.monitor.called_since_full_check.set(self.monitor.called_since_full_check.get() | called);
        self.monitor.checks.set(self.monitor.checks.get().wrapping_add(1));
        if self.monitor.checks.get().is_multiple_of(QUICK_CHECKS_PER_FULL) {
            self.restore_process("the last steps");
        }
    }
    /// Like `restore_process_state`, but for state whose check requires system calls: the working folder, signal
    /// handlers, standard output.
    pub fn restore_process(&self, place: &str) {
        let called = self.monitor.called_since_full_check.take();
        if let Some(what) = self.monitor.process_state.borrow().restore() {
            self.report_process_change(called, &what, place, None);
        }
    }
    #[cold]
    fn report_process_change(&self, suspects: u64, what: &str, place: &str, object: Option<String>) {
        let plugins = &self.model.registry.plugins;
        let mut all: Vec<usize> = (0..plugins.len()).filter(|i| suspects & 1 << (*i).min(63) != 0).collect();
        // The program's own plugins are tested for such changes, so the change is attributed to other plugins if any
        // were called.
        if all.iter().any(|i| !self.model.registry.is_of_program(*i)) {
            all.retain(|i| !self.model.registry.is_of_program(*i));
        }
        let ids: Vec<&str> = all.iter().map(|i| plugins[*i].id.as_str()).collect();
        let who = match ids.as_slice() {
            [one] => format!("plugin `{one}`"),
            [] => "a plugin, in a separate thread,".to_owned(),
            many => format!("one of the plugins `{}`", many.join("`, `")),
        };
        let mut fault = Fault::new(FaultKind::Plugin, format!("{who} changed {what} in {place}"));
        fault.plugin = ids.first().filter(|_| ids.len() == 1).map(|id| (*id).to_owned());
        fault.object = object;
        fault.help = Some(protected_state::RESTORED_HELP.into());
        self.report(fault);
    }
}
