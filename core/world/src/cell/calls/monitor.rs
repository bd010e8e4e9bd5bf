//! State that the host monitors while plugins run.

use std::{
    cell::{Cell, RefCell},
    sync::Arc,
};

use tatu_plugins::{protected_state::ProcessState, watchdog::CallWatch};

/// The running plugin call, and the process and thread state to restore after plugin calls.
pub(crate) struct PluginMonitor {
    /// The plugin call that is running.
    pub watch: Arc<CallWatch>,
    /// The process and thread state that plugins must leave unchanged.
    pub process_state: RefCell<ProcessState>,
    /// Plugins called since the last quick check of `process_state`, as a bit mask; bit 63 represents all plugins from
    /// index 63 on.
    pub called: Cell<u64>,
    /// Plugins called since the last full check of `process_state`, as a bit mask like `called`.
    pub called_since_full_check: Cell<u64>,
    /// Number of quick checks so far.
    pub checks: Cell<u32>,
    /// Whether a plugin has changed the floating-point mode. If it is set, the mode is checked after every call.
    pub suspicious: Cell<bool>,
}

impl PluginMonitor {
    pub fn new(watch: Arc<CallWatch>) -> Self {
        PluginMonitor {
            watch,
            process_state: RefCell::new(ProcessState::now()),
            called: Cell::default(),
            called_since_full_check: Cell::default(),
            checks: Cell::default(),
            suspicious: Cell::default(),
        }
    }
    /// Records calls into plugins that bypass [`cross`](super::WorldCell::cross).
    pub fn note_called(&self, plugins: impl Iterator<Item = usize>) {
        self.called.set(plugins.fold(self.called.get(), |called, plugin| called | 1 << plugin.min(63)));
    }
}
