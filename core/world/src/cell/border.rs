//! What is watched while plugins run.

use std::{
    cell::{Cell, RefCell},
    sync::Arc,
};

use tatu_plugins::{guard::ProcessState, watchdog::Watch};

/// What is watched while plugins run: which call is running, and how the process and its thread are to be left.
pub(crate) struct Border {
    /// Which plugin call is running.
    pub watch: Arc<Watch>,
    /// Thread and process as they are to be.
    pub home: RefCell<ProcessState>,
    /// Plugins that were called since `home` was last checked: one bit each, the last for all beyond.
    pub called: Cell<u64>,
    /// The same since all of `home` was checked, and the number of checks.
    pub called_lately: Cell<u64>,
    pub checks: Cell<u32>,
    /// Some plugin has changed the floating-point mode: from then on every call is checked.
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
    /// Plugins are called, and not by way of [`cross`](super::WorldCell::cross).
    pub fn note_called(&self, plugins: impl Iterator<Item = usize>) {
        self.called.set(plugins.fold(self.called.get(), |called, plugin| called | 1 << plugin.min(63)));
    }
}
