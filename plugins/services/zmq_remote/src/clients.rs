//! Tracks clients and their connections, and whether they hold the simulation.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::mpsc::Sender,
};

use tatu_services_common::hold_limit::{HoldLimit, HoldTimer};

/// The channel for the answer to a request.
pub type AnswerSender = Sender<Vec<u8>>;

/// A client. In the second version of the protocol, a client may have several connections; in the first, each
/// connection is a separate client.
#[derive(Default)]
pub struct ZmqClient {
    /// Number that identifies the client in the input log.
    pub number: u64,
    /// Stepping level: the number of times that the client has enabled stepping, minus the number of times that it has
    /// disabled it. Never negative.
    pub stepping_level: i64,
    /// Number of locks that the client holds. The simulation does not advance unless it is 0.
    pub lock_count: i64,
    /// The pending step requests of the client: the step at which a request ends, and the channel for its answer. The
    /// channel is `None` in the first version of the protocol, in which such requests are answered immediately.
    pub until: Vec<(u64, Option<AnswerSender>)>,
    connections: BTreeSet<u64>,
    /// Measures how long the client has held the simulation in silence.
    pub hold: HoldTimer,
}

impl ZmqClient {
    /// Returns whether the client has held the simulation in silence for too long; if so, releases it.
    pub fn release_if_silent(&mut self, running: bool, limit: HoldLimit) -> bool {
        let holds = running && self.holds_simulation();
        let over = self.hold.is_over(holds, limit);
        if over {
            self.release();
        }
        over
    }
    /// Returns whether the client holds the simulation: by a lock, or because it has enabled stepping and has not
    /// requested a step.
    pub fn holds_simulation(&self) -> bool {
        self.lock_count > 0 || self.stepping_level > 0 && self.until.is_empty()
    }
    /// Releases all locks of the client, and disables stepping.
    pub fn release(&mut self) {
        (self.stepping_level, self.lock_count) = (0, 0);
    }
}

/// The connected clients of the service.
#[derive(Default)]
pub struct ZmqClients {
    /// The clients, by key: the id that a client sends, or a name derived from its connection.
    all: BTreeMap<String, ZmqClient>,
    /// Number of clients created so far.
    created: u64,
}

impl ZmqClients {
    /// Returns the client with a key, and creates it if it is new. Records that it uses the connection.
    pub fn get_or_create(&mut self, key: &str, connection: u64) -> &mut ZmqClient {
        if !self.all.contains_key(key) {
            self.created += 1;
            self.all.insert(key.to_owned(), ZmqClient { number: self.created, ..ZmqClient::default() });
        }
        let client = self.all.entry(key.to_owned()).or_default();
        client.connections.insert(connection);
        client
    }
    /// Returns the number of the client that a connection belongs to.
    pub fn number_of_connection(&self, connection: u64) -> Option<u64> {
        self.all.values().find(|c| c.connections.contains(&connection)).map(|c| c.number)
    }
    /// Removes a connection, and clients without any other connection, so that they no longer hold the simulation.
    /// Returns the keys of the removed clients.
    pub fn remove_connection(&mut self, connection: u64) -> Vec<String> {
        let last = |c: &mut ZmqClient| c.connections.remove(&connection) && c.connections.is_empty();
        self.all.extract_if(.., |_, c| last(c)).map(|(key, _)| key).collect()
    }
    /// Removes a client that has announced that it will disconnect.
    pub fn remove(&mut self, key: &str) {
        self.all.remove(key);
    }
    /// Returns an iterator over all clients, in the order of their keys.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut ZmqClient> {
        self.all.values_mut()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stepping_client_blocks_until_it_requests_a_step_or_disconnects() {
        let mut all = ZmqClients::default();
        all.get_or_create("a", 1).stepping_level = 1;
        all.get_or_create("a", 2);
        assert!(all.get_or_create("a", 1).holds_simulation());
        all.get_or_create("a", 1).until.push((5, None));
        assert!(!all.get_or_create("a", 1).holds_simulation());
        all.remove_connection(1);
        assert_eq!(all.iter_mut().count(), 1);
        all.remove_connection(2);
        assert_eq!(all.iter_mut().count(), 0);
        assert_eq!(all.get_or_create("a", 3).number, 2);
    }
}
