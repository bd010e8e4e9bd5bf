//! Tickets: numbers by which a plugin's own threads deliver the results of commands that wait for them.

use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex, PoisonError, Weak},
};

/// Maximum size of a result, bytes.
pub const MAX_RESULT_BYTES: usize = 1 << 28;

/// Receives the results for one world, from any thread.
#[derive(Debug, Default)]
pub struct Mailbox(Mutex<Vec<(u64, Vec<u8>)>>);

impl Mailbox {
    /// Removes and returns all results that have arrived, in order of arrival, each with the number under which the
    /// world waits for it.
    pub fn take(&self) -> Vec<(u64, Vec<u8>)> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// The tickets that have been issued but not used yet.
#[derive(Default)]
pub(crate) struct TicketTable(Mutex<IssuedTickets>);

#[derive(Default)]
struct IssuedTickets {
    last: u64,
    open: BTreeMap<u64, (Weak<Mailbox>, u64)>,
}

impl TicketTable {
    /// Issues a ticket for a result that a world waits for under the number `wait`.
    pub fn issue(&self, mailbox: &Arc<Mailbox>, wait: u64) -> u64 {
        let mut issued = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // Tickets of worlds that have ended can no longer deliver a result.
        issued.open.retain(|_, (mailbox, _)| mailbox.strong_count() > 0);
        issued.last += 1;
        let ticket = issued.last;
        issued.open.insert(ticket, (Arc::downgrade(mailbox), wait));
        ticket
    }

    /// Delivers a result. A ticket can be used once; returns whether this one was valid.
    pub fn deliver(&self, ticket: u64, result: &[u8]) -> bool {
        let found = self.0.lock().unwrap_or_else(PoisonError::into_inner).open.remove(&ticket);
        let Some((mailbox, wait)) = found else { return false };
        if let Some(mailbox) = mailbox.upgrade() {
            mailbox.0.lock().unwrap_or_else(PoisonError::into_inner).push((wait, result.to_vec()));
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ticket_is_used_once_and_outlives_its_world() {
        let (tickets, mailbox) = (TicketTable::default(), Arc::new(Mailbox::default()));
        let (a, b) = (tickets.issue(&mailbox, 7), tickets.issue(&mailbox, 8));
        std::thread::scope(|s| {
            s.spawn(|| assert!(tickets.deliver(b, b"later")));
        });
        assert!(!tickets.deliver(b, b"again") && !tickets.deliver(99, b"unknown"));
        assert_eq!(mailbox.take(), [(8, b"later".to_vec())]);
        drop(mailbox);
        assert!(tickets.deliver(a, b"to nobody"));
    }
}
