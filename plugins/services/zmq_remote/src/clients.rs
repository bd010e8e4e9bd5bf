//! Tracks clients and their connections, and whether they hold the simulation.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::mpsc::Sender,
};

/// The channel for the answer to a request.
pub type Answer = Sender<Vec<u8>>;

/// A client. In the second version of the protocol, a client may have several connections; in the first, each
/// connection is a separate client.
#[derive(Default)]
pub struct Client {
    /// Number that identifies the client in the input log.
    pub number: u64,
    /// Stepping level: the number of times that the client has enabled stepping, minus the number of times that it has
    /// disabled it. Never negative.
    pub level: i64,
    /// Number of locks that the client holds. The simulation does not advance unless it is 0.
    pub holds: i64,
    /// The pending step requests of the client: the step at which a request ends, and the channel for its answer. The
    /// channel is `None` in the first version of the protocol, in which such requests are answered immediately.
    pub until: Vec<(u64, Option<Answer>)>,
    connections: BTreeSet<u64>,
}

impl Client {
    /// Returns whether the client holds the simulation: by a lock, or because it has enabled stepping and has not
    /// requested a step.
    pub fn holds(&self) -> bool {
        self.holds > 0 || self.level > 0 && self.until.is_empty()
    }
    /// Releases all locks of the client, and disables stepping.
    pub fn release(&mut self) {
        (self.level, self.holds) = (0, 0);
    }
}

/// All clients.
#[derive(Default)]
pub struct Clients {
    /// The clients, by key: the id that a client sends, or a name derived from its connection.
    all: BTreeMap<String, Client>,
    /// Number of clients created so far.
    made: u64,
}

impl Clients {
    /// Returns the client with a key, and creates it if it is new. Records that it uses the connection.
    pub fn of(&mut self, key: &str, connection: u64) -> &mut Client {
        if !self.all.contains_key(key) {
            self.made += 1;
            self.all.insert(key.to_owned(), Client { number: self.made, ..Client::default() });
        }
        let client = self.all.entry(key.to_owned()).or_default();
        client.connections.insert(connection);
        client
    }
    /// Returns the number of the client that a connection belongs to.
    pub fn of_connection(&self, connection: u64) -> Option<u64> {
        self.all.values().find(|c| c.connections.contains(&connection)).map(|c| c.number)
    }
    /// Removes a connection, and clients without any other connection, so that they no longer hold the simulation.
    /// Returns the keys of the removed clients.
    pub fn gone(&mut self, connection: u64) -> Vec<String> {
        let last = |c: &mut Client| c.connections.remove(&connection) && c.connections.is_empty();
        self.all.extract_if(.., |_, c| last(c)).map(|(key, _)| key).collect()
    }
    /// Removes a client that has announced that it will disconnect.
    pub fn end(&mut self, key: &str) {
        self.all.remove(key);
    }
    /// Returns an iterator over all clients, in the order of their keys.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Client> {
        self.all.values_mut()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_steps_holds_until_it_asks_and_no_longer_than_it_is_there() {
        let mut all = Clients::default();
        all.of("a", 1).level = 1;
        all.of("a", 2);
        assert!(all.of("a", 1).holds());
        all.of("a", 1).until.push((5, None));
        assert!(!all.of("a", 1).holds());
        all.gone(1);
        assert_eq!(all.iter_mut().count(), 1);
        all.gone(2);
        assert_eq!(all.iter_mut().count(), 0);
        assert_eq!(all.of("a", 3).number, 2);
    }
}
