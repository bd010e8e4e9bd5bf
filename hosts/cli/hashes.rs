//! The hashes of a recorded run: of the world after every step, and of each object after some steps.
//!
//! As a file, they are JSON lines, one per step: `{"step":3,"hash":"9f..."}`, and `"objects"` with the hashes by path in
//! some of them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tatu_core::state::StateHash;

/// Maximum size of the hashes of objects, bytes. Beyond it, every second step with such hashes loses them.
const MAX_OBJECT_BYTES: usize = 4 << 20;
/// Size of the hash of an object besides its path, bytes.
const ENTRY_BYTES: usize = 24;

/// The hashes after a step.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct StepHashes {
    step: u64,
    hash: String,
    /// The hash of each object, by its path; `None` if they are not recorded for this step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    objects: Option<BTreeMap<String, String>>,
}

/// The hashes of a run that is being recorded or repeated.
#[derive(Debug)]
pub struct RunHashes {
    steps: Vec<StepHashes>,
    /// Number of steps from one with hashes of objects to the next.
    interval: u64,
    object_bytes: usize,
}

fn hexadecimal(hash: u64) -> String {
    format!("{hash:016x}")
}

impl Default for RunHashes {
    fn default() -> Self {
        RunHashes { steps: Vec::new(), interval: 1, object_bytes: 0 }
    }
}

impl RunHashes {
    /// Appends the hashes after a step. Steps must be in increasing order.
    pub fn push(&mut self, step: u64, hash: &StateHash) {
        let has_objects = step.is_multiple_of(self.interval);
        let objects =
            has_objects.then(|| hash.objects.iter().map(|(path, hash)| (path.clone(), hexadecimal(*hash))).collect());
        self.object_bytes += objects.as_ref().map_or(0, size_of_objects);
        self.steps.push(StepHashes { step, hash: hexadecimal(hash.total), objects });
        while self.object_bytes > MAX_OBJECT_BYTES && self.interval < u64::MAX / 2 {
            self.interval *= 2;
            for of_step in self.steps.iter_mut().filter(|s| !s.step.is_multiple_of(self.interval)) {
                of_step.objects = None;
            }
            self.object_bytes = self.steps.iter().filter_map(|s| s.objects.as_ref()).map(size_of_objects).sum();
        }
    }

    /// Returns the contents of the file.
    pub fn to_bytes(&self) -> Vec<u8> {
        // This cannot fail: all map keys are strings.
        let lines = self.steps.iter().map(|step| serde_json::to_string(step).unwrap_or_default() + "\n");
        lines.collect::<String>().into_bytes()
    }

    /// Reads the contents of a file. An error names the line.
    pub fn parse(bytes: &[u8]) -> Result<Self, (usize, String)> {
        let lines = bytes.split(|b| *b == b'\n').enumerate().filter(|(_, line)| !line.is_empty());
        let steps = lines.map(|(i, line)| serde_json::from_slice(line).map_err(|e| (i + 1, e.to_string())));
        let steps: Vec<StepHashes> = steps.collect::<Result<_, _>>()?;
        match steps.windows(2).position(|two| two[0].step >= two[1].step) {
            Some(i) => Err((i + 2, "the steps are not in increasing order".to_owned())),
            None => Ok(RunHashes { steps, ..RunHashes::default() }),
        }
    }

    /// Returns the number of the last step.
    pub fn last_step(&self) -> u64 {
        self.steps.last().map_or(0, |step| step.step)
    }

    /// Returns the hash of the world after a step, if it is recorded.
    pub fn total(&self, step: u64) -> Option<&str> {
        let i = self.steps.binary_search_by_key(&step, |s| s.step).ok()?;
        Some(&self.steps[i].hash)
    }

    /// Returns the paths of the objects whose hashes differ from those recorded for a step, in alphabetical order;
    /// `None` if none are recorded.
    pub fn differing_objects(&self, step: u64, hash: &StateHash) -> Option<Vec<String>> {
        let i = self.steps.binary_search_by_key(&step, |s| s.step).ok()?;
        let then = self.steps[i].objects.as_ref()?;
        let now: BTreeMap<&String, String> = hash.objects.iter().map(|(path, h)| (path, hexadecimal(*h))).collect();
        let mut differing: Vec<String> =
            then.iter().filter(|(path, hash)| now.get(path) != Some(hash)).map(|(path, _)| path.clone()).collect();
        differing.extend(now.into_keys().filter(|path| !then.contains_key(*path)).cloned());
        differing.sort();
        Some(differing)
    }
}

fn size_of_objects(objects: &BTreeMap<String, String>) -> usize {
    objects.keys().map(|path| path.len() + ENTRY_BYTES).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(total: u64, objects: &[(&str, u64)]) -> StateHash {
        StateHash { total, objects: objects.iter().map(|(path, hash)| ((*path).to_owned(), *hash)).collect() }
    }

    #[test]
    fn hashes_are_read_as_written() {
        let mut hashes = RunHashes::default();
        hashes.push(0, &state(1, &[("/a", 2), ("/b", 3)]));
        hashes.push(1, &state(4, &[("/a", 2), ("/b", 5)]));
        let read = RunHashes::parse(&hashes.to_bytes()).unwrap();
        assert_eq!((read.last_step(), read.total(1), read.total(2)), (1, Some("0000000000000004"), None));
        let now = state(9, &[("/a", 2), ("/b", 6), ("/c", 7)]);
        assert_eq!(read.differing_objects(1, &now).unwrap(), ["/b", "/c"]);
        assert!(read.differing_objects(2, &now).is_none());
        assert_eq!(RunHashes::parse(b"{\"step\":1,\"hash\":\"a\"}\nnothing\n").unwrap_err().0, 2);
        assert_eq!(RunHashes::parse(b"{\"step\":1,\"hash\":\"a\"}\n{\"step\":1,\"hash\":\"a\"}\n").unwrap_err().0, 2);
    }

    #[test]
    fn hashes_of_objects_are_bounded() {
        let mut hashes = RunHashes::default();
        let path = format!("/{}", "a".repeat(1000));
        let objects: Vec<(&str, u64)> = vec![(&path, 1); 1];
        for step in 0..10_000 {
            hashes.push(step, &state(step, &objects));
        }
        let recorded: Vec<u64> = hashes.steps.iter().filter(|s| s.objects.is_some()).map(|s| s.step).collect();
        assert!(hashes.object_bytes <= MAX_OBJECT_BYTES && recorded.len() > 1000, "{}", recorded.len());
        assert!(recorded.windows(2).all(|two| two[1] - two[0] == hashes.interval));
        assert_eq!(hashes.steps.len(), 10_000);
    }
}
