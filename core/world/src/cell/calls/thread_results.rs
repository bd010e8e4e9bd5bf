//! Results of threads of plugins, and the commands that wait for them.

use std::{
    cell::{Cell, RefCell},
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use tatu_plugins::{HostTables, Mailbox};

use crate::cell::WaitCondition;

/// The results of plugins' threads. Each result, and the command that waits for it, is identified by a number.
#[derive(Default)]
pub(crate) struct ThreadResults {
    mailbox: Arc<Mailbox>,
    /// The last number that was assigned.
    last: Cell<u64>,
    /// The number of the result for which the running command took a ticket.
    pub issued: Cell<Option<u64>>,
    /// Results that have been added to the world, by number.
    arrived: RefCell<BTreeMap<u64, Vec<u8>>>,
    /// Numbers of results that can no longer arrive, since no thread was started for them in this process.
    lost: RefCell<BTreeSet<u64>>,
    /// Numbers of results in a replay for which no ticket was issued, because the log is expected to contain them.
    unissued: RefCell<BTreeSet<u64>>,
    /// The result that the command being resumed has waited for, or `None` if it was lost.
    pub current: RefCell<Option<Vec<u8>>>,
}

impl ThreadResults {
    /// Issues a ticket for a result for which the running command is about to wait.
    pub fn ticket(&self, host: &HostTables) -> u64 {
        host.ticket(&self.mailbox, self.next())
    }
    /// Assigns a number to a result for which the running command is about to wait in a replay. No ticket is issued,
    /// since the log contains the result.
    pub fn assign_replayed_number(&self) {
        let number = self.next();
        self.unissued.borrow_mut().insert(number);
    }
    fn next(&self) -> u64 {
        let number = self.last.get() + 1;
        self.last.set(number);
        self.issued.set(Some(number));
        number
    }
    /// Marks the results that the replayed log did not contain as lost. It is called when the replay has ended.
    pub fn mark_unissued_lost(&self) {
        self.lost.borrow_mut().append(&mut self.unissued.borrow_mut());
    }
    /// Takes the results that threads have delivered, each with its number.
    pub fn take(&self) -> Vec<(u64, Vec<u8>)> {
        self.mailbox.take()
    }
    /// Adds a result to the world.
    pub fn add_result(&self, number: u64, result: Vec<u8>) {
        self.unissued.borrow_mut().remove(&number);
        self.arrived.borrow_mut().insert(number, result);
    }
    /// Returns whether a result has been added to the world, or has been lost.
    pub fn has_arrived(&self, number: u64) -> bool {
        self.arrived.borrow().contains_key(&number) || self.lost.borrow().contains(&number)
    }
    /// Makes the result for which a command has waited available to it, before the command is resumed.
    pub fn resume(&self, due: &WaitCondition) {
        let WaitCondition::Wake(number) = due else { return };
        self.lost.borrow_mut().remove(number);
        *self.current.borrow_mut() = self.arrived.borrow_mut().remove(number);
    }
    /// Returns the last number that was assigned, for snapshots.
    pub fn last(&self) -> u64 {
        self.last.get()
    }
    /// Restores the last number that was assigned. The results of all earlier numbers are lost, because a snapshot does
    /// not contain threads.
    pub fn restore(&self, last: u64) {
        self.last.set(last);
        *self.lost.borrow_mut() = (1..=last).collect();
        self.arrived.borrow_mut().clear();
        self.mailbox.take();
    }
}
