//! Who is there, and how each client stands to the steps.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::mpsc::Sender,
};

/// Where an answer goes.
pub type Answer = Sender<Vec<u8>>;

/// A client. One of the second protocol may have several connections; one of the first is a connection.
#[derive(Default)]
pub struct Client {
    /// For the input log.
    pub number: u64,
    /// How often it asked for steps of its own, less how often it took that back.
    pub level: i64,
    /// Locks that it holds: time stands.
    pub holds: i64,
    /// The step at which what it waits for is over, and who is answered then; a client of the first protocol was answered
    /// already.
    pub until: Vec<(u64, Option<Answer>)>,
    connections: BTreeSet<u64>,
}

impl Client {
    /// Whether time stands until it asks for a step.
    pub fn holds(&self) -> bool {
        self.holds > 0 || self.level > 0 && self.until.is_empty()
    }
    /// It lets time pass again.
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
    /// The client of a request, which may be new.
    pub fn of(&mut self, key: &str, connection: u64) -> &mut Client {
        if !self.all.contains_key(key) {
            self.made += 1;
            self.all.insert(key.to_owned(), Client { number: self.made, ..Client::default() });
        }
        let client = self.all.entry(key.to_owned()).or_default();
        client.connections.insert(connection);
        client
    }
    /// The number of the client that a connection belongs to.
    pub fn of_connection(&self, connection: u64) -> Option<u64> {
        self.all.values().find(|c| c.connections.contains(&connection)).map(|c| c.number)
    }
    /// A connection has ended: who has no other is gone, and holds nothing any more. Their keys.
    pub fn gone(&mut self, connection: u64) -> Vec<String> {
        let last = |c: &mut Client| c.connections.remove(&connection) && c.connections.is_empty();
        self.all.extract_if(.., |_, c| last(c)).map(|(key, _)| key).collect()
    }
    /// A client says that it goes.
    pub fn end(&mut self, key: &str) {
        self.all.remove(key);
    }
    /// All of them, in the order of their keys.
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
