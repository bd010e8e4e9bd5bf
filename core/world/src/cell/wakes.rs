//! Results of threads of plugins, and the commands that wait for them.

use std::{
    cell::{Cell, RefCell},
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use tatu_plugins::{HostTables, Mailbox};

use super::Due;

/// The waits for a plugin's threads.
#[derive(Default)]
pub(crate) struct Wakes {
    mailbox: Arc<Mailbox>,
    /// Number of the last wait for which a ticket was issued.
    last: Cell<u64>,
    /// The wait for which the running command took a ticket.
    pub issued: Cell<Option<u64>>,
    /// Results that have entered the world, by the number of their wait.
    arrived: RefCell<BTreeMap<u64, Vec<u8>>>,
    /// Waits whose result can no longer arrive, since no thread was started for them in this process.
    lost: RefCell<BTreeSet<u64>>,
    /// Waits of a replayed run for which no ticket was issued, because the log is expected to contain their results.
    unissued: RefCell<BTreeSet<u64>>,
    /// The result that the command being resumed has waited for, or `None` if it was lost.
    pub current: RefCell<Option<Vec<u8>>>,
}

impl Wakes {
    /// Issues a ticket for a wait of the running command.
    pub fn ticket(&self, host: &HostTables) -> u64 {
        host.ticket(&self.mailbox, self.next())
    }
    /// Assigns a number to a wait of the running command in a replay. No ticket is issued, since the log contains the
    /// result.
    pub fn next_of_replay(&self) {
        let number = self.next();
        self.unissued.borrow_mut().insert(number);
    }
    fn next(&self) -> u64 {
        let number = self.last.get() + 1;
        self.last.set(number);
        self.issued.set(Some(number));
        number
    }
    /// Marks the waits whose results the replayed log did not contain as lost. It is called when the replay has ended.
    pub fn lose_unissued(&self) {
        self.lost.borrow_mut().append(&mut self.unissued.borrow_mut());
    }
    /// Takes the results that threads have delivered, each with the number of its wait.
    pub fn take(&self) -> Vec<(u64, Vec<u8>)> {
        self.mailbox.take()
    }
    /// Adds a result to the world.
    pub fn arrive(&self, number: u64, result: Vec<u8>) {
        self.unissued.borrow_mut().remove(&number);
        self.arrived.borrow_mut().insert(number, result);
    }
    /// Returns whether the result for a wait has been added to the world, or has been lost.
    pub fn has_arrived(&self, number: u64) -> bool {
        self.arrived.borrow().contains_key(&number) || self.lost.borrow().contains(&number)
    }
    /// Makes the result available to the command whose wait has ended, before it is resumed.
    pub fn resume(&self, due: &Due) {
        let Due::Wake(number) = due else { return };
        self.lost.borrow_mut().remove(number);
        *self.current.borrow_mut() = self.arrived.borrow_mut().remove(number);
    }
    /// Returns the number of the last wait, for snapshots.
    pub fn last(&self) -> u64 {
        self.last.get()
    }
    /// Restores the number of the last wait. The results of all pending waits are lost, because a snapshot does not
    /// contain threads.
    pub fn restore(&self, last: u64) {
        self.last.set(last);
        *self.lost.borrow_mut() = (1..=last).collect();
        self.arrived.borrow_mut().clear();
        self.mailbox.take();
    }
}
