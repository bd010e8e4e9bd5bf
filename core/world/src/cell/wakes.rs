//! Results of plugins' own threads, for commands that wait for them.

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
    /// Waits whose result cannot arrive any more, since no thread was started for them here.
    lost: RefCell<BTreeSet<u64>>,
    /// Waits of a replayed run for which no ticket was issued, and whose result the log may still contain.
    unissued: RefCell<BTreeSet<u64>>,
    /// The result for the command that is being resumed, or `None` if it was lost.
    pub current: RefCell<Option<Vec<u8>>>,
}

impl Wakes {
    /// Issues a ticket for a wait of the running command.
    pub fn ticket(&self, host: &HostTables) -> u64 {
        host.ticket(&self.mailbox, self.next())
    }
    /// Counts a wait of the running command for which no ticket is needed, since the replayed log contains its result.
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
    /// Marks the waits whose results the replayed log did not contain as lost. Called when the replay is over.
    pub fn lose_unissued(&self) {
        self.lost.borrow_mut().append(&mut self.unissued.borrow_mut());
    }
    /// Takes the results that have arrived from threads, each with the number of its wait.
    pub fn take(&self) -> Vec<(u64, Vec<u8>)> {
        self.mailbox.take()
    }
    /// Lets a result enter the world.
    pub fn arrive(&self, number: u64, result: Vec<u8>) {
        self.unissued.borrow_mut().remove(&number);
        self.arrived.borrow_mut().insert(number, result);
    }
    /// Returns whether the result for a wait has entered the world, or cannot any more.
    pub fn has_arrived(&self, number: u64) -> bool {
        self.arrived.borrow().contains_key(&number) || self.lost.borrow().contains(&number)
    }
    /// Prepares to resume a command whose wait has ended: makes the result available to it.
    pub fn resume(&self, due: &Due) {
        let Due::Wake(number) = due else { return };
        self.lost.borrow_mut().remove(number);
        *self.current.borrow_mut() = self.arrived.borrow_mut().remove(number);
    }
    /// Returns the number of the last wait, for snapshots.
    pub fn last(&self) -> u64 {
        self.last.get()
    }
    /// Restores the number of the last wait. The results of all pending waits are lost: a snapshot contains no threads.
    pub fn restore(&self, last: u64) {
        self.last.set(last);
        *self.lost.borrow_mut() = (1..=last).collect();
        self.arrived.borrow_mut().clear();
        self.mailbox.take();
    }
}
