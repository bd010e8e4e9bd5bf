//! The jobs of a sweep.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};
use tatu_core::errors::{Error, Result};

use super::Metric;

/// Longest simulation time of a job, s: about ten years.
const MAX_SECONDS: f64 = 3.2e8;

/// One run of the scene of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweepJob {
    /// Seed of all random numbers; if `None`, the scene's own seed is used.
    #[serde(default)]
    pub seed: Option<u64>,
    /// Changes to the scene, by the keys that `--set` accepts.
    #[serde(default)]
    pub set: BTreeMap<String, Value>,
    /// Simulation time to run, s.
    pub seconds: f64,
    /// Metrics of the run, by name.
    #[serde(default)]
    pub metrics: BTreeMap<String, Metric>,
}

impl SweepJob {
    /// Parses a job from JSON.
    ///
    /// # Errors
    /// The text is not a job; the message contains the line and what was expected.
    pub fn parse(text: &str) -> Result<Self> {
        serde_json::from_str(text).map_err(|e| Error::new("E102", format!("the text is not a valid sweep job: {e}")))
    }

    pub(super) fn check(&self) -> Result {
        match self.seconds {
            s if s.is_finite() && (0.0..=MAX_SECONDS).contains(&s) => Ok(()),
            s => Err(Error::new("E102", format!("`seconds` is out of range: {s}")).expected("0 to 3.2e8 s")),
        }
    }

    /// Returns the changes in the form `KEY=VALUE`, as `--set` accepts them.
    pub(super) fn settings(&self) -> impl Iterator<Item = String> {
        self.set.iter().map(|(key, value)| format!("{key}={}", toml(value)))
    }

    /// Returns the key that identifies the results of this job: a hash of the job and of `base`, the hash of the scene
    /// and its plugins.
    pub(super) fn key(&self, base: &[u8; 32]) -> String {
        let mut hash = Sha256::new();
        hash.update(base);
        // Maps are ordered, and numbers are written with all their digits, so equal jobs are serialised to equal text.
        hash.update(serde_json::to_vec(self).unwrap_or_default());
        hash.finalize().iter().take(16).map(|b| format!("{b:02x}")).collect()
    }
}

/// Formats a JSON value as TOML.
fn toml(value: &Value) -> String {
    match value {
        Value::Array(all) => format!("[{}]", all.iter().map(toml).collect::<Vec<_>>().join(", ")),
        Value::Object(all) => {
            let pairs = all.iter().map(|(k, v)| format!("{} = {}", Value::from(k.as_str()), toml(v)));
            format!("{{{}}}", pairs.collect::<Vec<_>>().join(", "))
        }
        // The syntax of numbers, strings and Booleans is the same in both formats.
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_jobs_have_equal_keys() {
        let job = |text: &str| SweepJob::parse(text).unwrap();
        let a = job(r#"{"seconds": 1.0, "seed": 3, "set": {"/a.b": 1.5, "/c.d": [1, 2]}}"#);
        let b = job(r#"{"set": {"/c.d": [1, 2], "/a.b": 1.50}, "seed": 3, "seconds": 1}"#);
        assert_eq!((a.key(&[0; 32]), a.key(&[0; 32]).len()), (b.key(&[0; 32]), 32));
        assert_ne!(a.key(&[0; 32]), a.key(&[1; 32]));
        assert_ne!(a.key(&[0; 32]), SweepJob { seed: None, ..a.clone() }.key(&[0; 32]));
        assert_eq!(a.settings().collect::<Vec<_>>(), ["/a.b=1.5", "/c.d=[1, 2]"]);
        assert!(SweepJob::parse(r#"{"seconds": 1, "sed": 3}"#).unwrap_err().text.contains("sed"));
        assert!(job(r#"{"seconds": -1}"#).check().is_err());
    }
}
