//! Commands that wait and resume later.

use serde::{Deserialize, Serialize};
use tatu_plugin_api::abi::*;

/// The condition under which a command that waits is resumed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum WaitCondition {
    /// In the pass with this number, as counted by `Clock::pass`.
    Step(u64),
    /// At this simulation time, s.
    Time(f64),
    /// When a signal of any kind with this name exists.
    Signal(Vec<u8>),
    /// In every pass, because the command checks its condition itself.
    Poll,
    /// When the result with this number has arrived from a plugin's thread.
    Wake(u64),
}

/// The script or service on whose behalf a command waits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum WaitOwner {
    /// A script, by its instance id.
    Script(u64),
    /// A service of the session, counted from 1.
    Service(u32),
}

/// A command that waits on behalf of a script's coroutine or of a service's client.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WaitingCommand {
    /// The waiting script or service.
    pub owner: WaitOwner,
    /// The coroutine or client, as numbered by the owner.
    pub token: u64,
    /// Id of the command, which is called again when it has finished waiting.
    pub command: u32,
    /// Index of the name under which it was called.
    pub alias: u32,
    /// The value that the command chose when it began to wait, and receives when it is called again.
    pub resume: u64,
    /// The condition under which it resumes.
    pub due: WaitCondition,
}

/// The commands that wait, in the order in which they began to wait.
#[derive(Debug, Default)]
pub struct WaitList {
    list: Vec<WaitingCommand>,
    /// The request of the running command to wait: its token, condition and resume value.
    pub requested: Option<(u64, WaitCondition, u64)>,
}

impl WaitList {
    /// Adds a command that begins to wait.
    pub fn begin(&mut self, wait: WaitingCommand) {
        self.list.push(wait);
    }
    /// Returns whether any command is waiting.
    pub fn any(&self) -> bool {
        !self.list.is_empty()
    }
    /// Returns whether a command of this owner is waiting.
    pub fn any_of(&self, owner: WaitOwner) -> bool {
        self.list.iter().any(|w| w.owner == owner)
    }
    /// Removes and returns the commands of an owner that have finished waiting.
    pub fn take_due(&mut self, owner: WaitOwner, over: impl Fn(&WaitCondition) -> bool) -> Vec<WaitingCommand> {
        self.take(|w| w.owner == owner && over(&w.due))
    }
    /// Returns all commands that wait, for snapshots.
    pub fn all(&self) -> Vec<WaitingCommand> {
        self.list.clone()
    }
    /// Restores the commands that waited when a snapshot was taken.
    pub fn restore(&mut self, list: Vec<WaitingCommand>) {
        *self = WaitList { list, requested: None };
    }
    /// Removes and returns the commands of services that have finished waiting, in the order in which they began to
    /// wait.
    pub fn take_due_of_services(&mut self, over: impl Fn(&WaitCondition) -> bool) -> Vec<WaitingCommand> {
        self.take(|w| matches!(w.owner, WaitOwner::Service(_)) && over(&w.due))
    }
    fn take(&mut self, which: impl Fn(&WaitingCommand) -> bool) -> Vec<WaitingCommand> {
        let mut taken = Vec::new();
        self.list.retain(|w| {
            let is = which(w);
            if is {
                taken.push(w.clone());
            }
            !is
        });
        taken
    }
    /// Removes the commands that wait on behalf of an owner that has ended.
    pub fn remove_of(&mut self, owner: WaitOwner) {
        self.list.retain(|w| w.owner != owner);
    }
}

/// Converts the arguments of a command's `wait` to a condition. `step` is the number of the current pass. `ticket` is
/// the number of the result for which the command has taken a ticket, if it has taken one.
pub(crate) fn parse(
    until: u32,
    value: f64,
    name: &[u8],
    step: u64,
    ticket: Option<u64>,
) -> Result<WaitCondition, &'static str> {
    match until {
        TATU_UNTIL_WAKE => {
            ticket.map(WaitCondition::Wake).ok_or("a wait for a wake requires a ticket, which this call has not taken")
        }
        TATU_UNTIL_STEPS if value >= 0.0 => Ok(WaitCondition::Step(step + (value.ceil() as u64).max(1))),
        TATU_UNTIL_TIME if value.is_finite() => Ok(WaitCondition::Time(value)),
        TATU_UNTIL_SIGNAL if !name.is_empty() => Ok(WaitCondition::Signal(name.to_vec())),
        TATU_UNTIL_POLL => Ok(WaitCondition::Poll),
        _ => Err(
            "invalid wait; expected a number of steps of at least 0, a finite time, the name of a signal, a poll or a wake",
        ),
    }
}
