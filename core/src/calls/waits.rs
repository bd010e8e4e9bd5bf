//! Commands that go on later.

use serde::{Deserialize, Serialize};
use tatu_plugin_api::abi::*;

/// When a wait is over.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Due {
    /// At the beginning of this step.
    Step(u64),
    /// At this simulation time, s.
    Time(f64),
    /// When this signal exists, of any kind.
    Signal(Vec<u8>),
    /// In each step.
    Poll,
}

/// A command that waits on behalf of a script's coroutine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Wait {
    /// Instance id of the script.
    pub script: u64,
    /// The coroutine, by the script language's number.
    pub token: u64,
    /// The command, to be called again.
    pub command: u32,
    /// The name that was used.
    pub alias: u32,
    /// The command's own word.
    pub resume: u64,
    /// When.
    pub due: Due,
}

/// All waits, in order of their beginning.
#[derive(Debug, Default)]
pub struct Waits {
    list: Vec<Wait>,
    /// What the running command asked for, by its token.
    pub asked: Option<(u64, Due, u64)>,
}

impl Waits {
    /// Begins a wait.
    pub fn begin(&mut self, wait: Wait) {
        self.list.push(wait);
    }
    /// Takes out those of a script that are over.
    pub fn take_due(&mut self, script: u64, over: impl Fn(&Due) -> bool) -> Vec<Wait> {
        let mut due = Vec::new();
        self.list.retain(|w| {
            let is_over = w.script == script && over(&w.due);
            if is_over {
                due.push(w.clone());
            }
            !is_over
        });
        due
    }
    /// All, for snapshots.
    pub fn all(&self) -> Vec<Wait> {
        self.list.clone()
    }
    /// Takes all back.
    pub fn restore(&mut self, list: Vec<Wait>) {
        *self = Waits { list, asked: None };
    }
    /// Forgets the waits of a script that has ended.
    pub fn forget(&mut self, script: u64) {
        self.list.retain(|w| w.script != script);
    }
}

/// What a command asked `wait` for.
pub fn parse(until: u32, value: f64, name: &[u8], step: u64) -> Result<Due, &'static str> {
    match until {
        TATU_UNTIL_STEPS if value >= 0.0 => Ok(Due::Step(step + (value.ceil() as u64).max(1))),
        TATU_UNTIL_TIME if value.is_finite() => Ok(Due::Time(value)),
        TATU_UNTIL_SIGNAL if !name.is_empty() => Ok(Due::Signal(name.to_vec())),
        TATU_UNTIL_POLL => Ok(Due::Poll),
        _ => Err("a wait is for a number of steps, a time, the name of a signal, or a poll"),
    }
}
