//! Results of plugins' own threads, for commands that wait for them.

use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
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
    /// The result for the command that is being resumed.
    pub current: RefCell<Vec<u8>>,
}

impl Wakes {
    /// Issues a ticket for a wait of the running command.
    pub fn ticket(&self, host: &HostTables) -> u64 {
        host.ticket(&self.mailbox, self.next())
    }
    /// Counts a wait of the running command for which no ticket is needed, since a replay has its result.
    pub fn next(&self) -> u64 {
        let number = self.last.get() + 1;
        self.last.set(number);
        self.issued.set(Some(number));
        number
    }
    /// Takes the results that have arrived from threads, each with the number of its wait.
    pub fn take(&self) -> Vec<(u64, Vec<u8>)> {
        self.mailbox.take()
    }
    /// Lets a result enter the world.
    pub fn arrive(&self, number: u64, result: Vec<u8>) {
        self.arrived.borrow_mut().insert(number, result);
    }
    /// Returns whether the result for a wait has entered the world.
    pub fn has_arrived(&self, number: u64) -> bool {
        self.arrived.borrow().contains_key(&number)
    }
    /// Prepares for a command whose wait has ended: it gets the result.
    pub fn resume(&self, due: &Due) {
        let result = if let Due::Wake(number) = due { self.arrived.borrow_mut().remove(number) } else { None };
        *self.current.borrow_mut() = result.unwrap_or_default();
    }
    /// Returns the number of the last wait, for snapshots.
    pub fn last(&self) -> u64 {
        self.last.get()
    }
    /// Restores the number of the last wait. Results on their way from threads are lost.
    pub fn restore(&self, last: u64) {
        self.last.set(last);
        self.arrived.borrow_mut().clear();
        self.mailbox.take();
    }
}
