//! How much scripts and plugins may leave in a world: signals, drawings, free data, queued events, logged lines.
//!
//! A script's own memory has a budget; what it hands over is not in it. Each of these stores has the same room.

use std::{cell::Cell, collections::BTreeMap, ops::Deref};

use tatu_plugin_api::safe::Value;
use tatu_scene::Scene;

/// The value of a signal.
pub(crate) struct Signal {
    pub value: Value,
    /// Set by a script of the run: it ends with it.
    pub of_run: bool,
}

/// What an entry of a table costs beside its content, roughly, bytes.
const ENTRY: u64 = 64;

/// Bytes of a value, roughly.
pub(crate) fn bytes_of(value: &Value) -> u64 {
    ENTRY
        + match value {
            Value::Text(t) => t.len() as u64,
            Value::Bytes(b) => b.len() as u64,
            Value::Floats(x) => 8 * x.len() as u64,
            Value::Ints(x) => 8 * x.len() as u64,
            Value::List(all) => all.iter().map(bytes_of).sum(),
            Value::Map(all) => all.iter().map(|(k, v)| bytes_of(k) + bytes_of(v)).sum(),
            _ => 0,
        }
}

/// Named values of a world, with the room that they take.
#[derive(Default)]
pub(crate) struct Signals {
    all: BTreeMap<(u32, Vec<u8>), Signal>,
    bytes: u64,
}

impl Deref for Signals {
    type Target = BTreeMap<(u32, Vec<u8>), Signal>;
    fn deref(&self) -> &Self::Target {
        &self.all
    }
}

fn signal_bytes((_, name): &(u32, Vec<u8>), signal: &Signal) -> u64 {
    ENTRY + name.len() as u64 + bytes_of(&signal.value)
}

impl Signals {
    /// Sets one; `false`: all together would take more than `room`.
    pub fn set(&mut self, key: (u32, Vec<u8>), signal: Signal, room: u64) -> bool {
        let before = self.all.get(&key).map_or(0, |s| signal_bytes(&key, s));
        let now = self.bytes - before + signal_bytes(&key, &signal);
        if now > room && now > self.bytes {
            return false;
        }
        self.bytes = now;
        self.all.insert(key, signal);
        true
    }
    /// Keeps those for which `keep` holds.
    pub fn retain(&mut self, keep: impl Fn(&(u32, Vec<u8>), &Signal) -> bool) {
        self.all.retain(|key, signal| keep(key, signal));
        self.bytes = self.all.iter().map(|(key, s)| signal_bytes(key, s)).sum();
    }
    pub fn remove(&mut self, key: &(u32, Vec<u8>)) {
        if let Some(signal) = self.all.remove(key) {
            self.bytes -= signal_bytes(key, &signal);
        }
    }
}

impl FromIterator<((u32, Vec<u8>), Signal)> for Signals {
    fn from_iter<I: IntoIterator<Item = ((u32, Vec<u8>), Signal)>>(all: I) -> Self {
        let mut signals = Signals { all: all.into_iter().collect(), bytes: 0 };
        signals.retain(|_, _| true);
        signals
    }
}

/// Free data that was written since it was last counted, bytes: objects take theirs away with them, so that only a count
/// tells what is there.
#[derive(Default)]
pub(crate) struct Noted(Cell<u64>);

impl Noted {
    /// Whether there is room for the free data of an object; 0: of the world.
    pub fn has_room(&self, scene: &Scene, slot: u32, more: u64, room: u64) -> bool {
        let sum = self.0.get() + more;
        self.0.set(sum);
        if sum <= room {
            return true;
        }
        let of = |notes: &BTreeMap<Vec<u8>, Vec<u8>>| {
            notes.iter().map(|(k, v)| ENTRY + (k.len() + v.len()) as u64).sum::<u64>()
        };
        // What is replaced makes room.
        let other = scene.slots().filter(|(s, _)| *s != slot).map(|(_, o)| of(&o.notes)).sum::<u64>();
        let there = other + if slot == 0 { 0 } else { of(&scene.notes) };
        let fits = there + more <= room;
        self.0.set(if fits { there + more } else { there });
        fits
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signal(n: usize) -> Signal {
        Signal { value: Value::Text(vec![b'x'; n]), of_run: true }
    }

    #[test]
    fn signals_know_what_they_take() {
        let mut all = Signals::default();
        let key = |n: &str| (1, n.as_bytes().to_vec());
        assert!(all.set(key("a"), signal(1000), 2000));
        assert!(!all.set(key("b"), signal(1000), 2000));
        assert!(all.set(key("a"), signal(1500), 2000));
        // One that shrinks is taken even where there is too little room.
        assert!(all.set(key("a"), signal(900), 10));
        all.remove(&key("a"));
        assert_eq!((all.bytes, all.len()), (0, 0));
    }
}
