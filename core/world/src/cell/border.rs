//! State that the host monitors while plugins run.

use std::{
    cell::{Cell, RefCell},
    sync::Arc,
};

use tatu_plugins::{guard::ProcessState, watchdog::Watch};

/// The running plugin call, and the process and thread state to restore after plugin calls.
pub(crate) struct Border {
    /// The plugin call that is running.
    pub watch: Arc<Watch>,
    /// The process and thread state that plugins must leave unchanged.
    pub home: RefCell<ProcessState>,
    /// Plugins called since the last quick check of `home`, as a bit mask; bit 63 represents all plugins from index 63
    /// on.
    pub called: Cell<u64>,
    /// Plugins called since the last full check of `home`, as a bit mask like `called`.
    pub called_lately: Cell<u64>,
    /// Number of quick checks so far.
    pub checks: Cell<u32>,
    /// Whether a plugin has changed the floating-point mode. If it is set, the mode is checked after every call.
    pub suspicious: Cell<bool>,
}

impl Border {
    pub fn new(watch: Arc<Watch>) -> Self {
        Border {
            watch,
            home: RefCell::new(ProcessState::now()),
            called: Cell::default(),
            called_lately: Cell::default(),
            checks: Cell::default(),
            suspicious: Cell::default(),
        }
    }
    /// Records calls into plugins that bypass [`cross`](super::WorldCell::cross).
    pub fn note_called(&self, plugins: impl Iterator<Item = usize>) {
        self.called.set(plugins.fold(self.called.get(), |called, plugin| called | 1 << plugin.min(63)));
    }
}
