//! Clients, and whether they hold the simulation.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::mpsc::Sender,
};

/// Receives the answer to a request.
pub type Answer = Sender<Vec<u8>>;

/// A client. In the second protocol it may have several connections; in the first, each connection is a client.
#[derive(Default)]
pub struct Client {
    /// Number of the client in the input log.
    pub number: u64,
    /// Stepping level: how often the client enabled stepping, less how often it disabled it.
    pub level: i64,
    /// Number of locks that the client holds; while it is not 0, the simulation does not advance.
    pub holds: i64,
    /// The steps that the client waits for: the step at which a wait ends, and where to send the answer then. A client
    /// of the first protocol has been answered already.
    pub until: Vec<(u64, Option<Answer>)>,
    connections: BTreeSet<u64>,
}

impl Client {
    /// Returns whether the simulation must wait until the client requests a step.
    pub fn holds(&self) -> bool {
        self.holds > 0 || self.level > 0 && self.until.is_empty()
    }
    /// Drops the client's locks and its stepping mode.
    pub fn release(&mut self) {
        (self.level, self.holds) = (0, 0);
    }
}

/// All clients, by their key.
#[derive(Default)]
pub struct Clients {
    all: BTreeMap<String, Client>,
    made: u64,
}

impl Clients {
    /// Returns the client of a request, creating it if it is new.
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
    /// Removes a connection, and the clients that have no other one, so that they do not hold the simulation any more;
    /// returns the keys of these clients.
    pub fn gone(&mut self, connection: u64) -> Vec<String> {
        let last = |c: &mut Client| c.connections.remove(&connection) && c.connections.is_empty();
        self.all.extract_if(.., |_, c| last(c)).map(|(key, _)| key).collect()
    }
    /// Removes a client that announces its end.
    pub fn end(&mut self, key: &str) {
        self.all.remove(key);
    }
    /// Returns all clients, ordered by key.
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
