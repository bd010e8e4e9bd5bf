//! Limits on what scripts and plugins may store in a world: signals, drawings, custom data, queued events, logged
//! lines.
//!
//! The memory budget of a script does not include data that it stores in the world. The same limit applies to each of
//! these stores separately.

use std::{cell::Cell, collections::BTreeMap, ops::Deref};

use tatu_plugin_api::safe::Value;
use tatu_scene::Scene;

/// The value of a signal.
pub(crate) struct Signal {
    pub value: Value,
    /// Whether it was set by a script whose state ends with the run. Such a signal is removed when the run ends.
    pub ends_with_run: bool,
}

/// Approximate overhead of a table entry, bytes.
const ENTRY_OVERHEAD_BYTES: u64 = 64;

/// Returns the approximate size of a value, bytes.
pub(crate) fn bytes_of(value: &Value) -> u64 {
    ENTRY_OVERHEAD_BYTES
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

/// The signals of a world, and their total size.
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
    ENTRY_OVERHEAD_BYTES + name.len() as u64 + bytes_of(&signal.value)
}

impl Signals {
    /// Sets a signal. Returns `false`, and changes nothing, if the total size would grow beyond `room`.
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
    /// Keeps the signals for which `keep` returns `true`.
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

/// An upper bound of the size of all custom data, bytes: the size at the last count plus everything written since.
/// Removing an object removes its data as well, so the actual size is known only by counting.
#[derive(Default)]
pub(crate) struct CustomDataSize(Cell<u64>);

impl CustomDataSize {
    /// Returns whether `more` bytes fit into `room` bytes as the custom data of an object, or of the world if `slot` is
    /// 0.
    pub fn try_reserve(&self, scene: &Scene, slot: u32, more: u64, room: u64) -> bool {
        let sum = self.0.get() + more;
        self.0.set(sum);
        if sum <= room {
            return true;
        }
        let of = |notes: &BTreeMap<Vec<u8>, Vec<u8>>| {
            notes.iter().map(|(k, v)| ENTRY_OVERHEAD_BYTES + (k.len() + v.len()) as u64).sum::<u64>()
        };
        // The previous data of this object is not counted, because it is about to be replaced.
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
        Signal { value: Value::Text(vec![b'x'; n]), ends_with_run: true }
    }

    #[test]
    fn signal_table_tracks_its_size_and_enforces_the_limit() {
        let mut all = Signals::default();
        let key = |n: &str| (1, n.as_bytes().to_vec());
        assert!(all.set(key("a"), signal(1000), 2000));
        assert!(!all.set(key("b"), signal(1000), 2000));
        assert!(all.set(key("a"), signal(1500), 2000));
        // A signal that shrinks is accepted even if the total exceeds the limit.
        assert!(all.set(key("a"), signal(900), 10));
        all.remove(&key("a"));
        assert_eq!((all.bytes, all.len()), (0, 0));
    }
}
