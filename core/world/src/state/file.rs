//! The snapshot file, which consists of a magic number, the format version, a checksum, the header and sections.

use std::path::Path;

use serde::{Deserialize, Serialize};
use tatu_errors::{Error, Result};
use tatu_plugins::Registry;
use tatu_scene::document::Document;
use xxhash_rust::xxh3::xxh3_64;

use super::fingerprint;
use crate::instances::UnsavedInstance;

/// The first bytes of every snapshot.
const MAGIC: &[u8; 8] = b"tatusnap";
/// Format version, increased when the meaning of a section changes.
const FORMAT_VERSION: u32 = 16;
/// Number of bytes before the checksummed part: magic number, format version and checksum.
const PREFIX_BYTES: usize = MAGIC.len() + 4 + 8;

/// The state of a world at a step, which may be incomplete.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// Header of the snapshot.
    pub head: SnapshotHeader,
    /// Serialized parts of the world, by name.
    sections: Vec<(String, Vec<u8>)>,
}

/// The header of a snapshot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SnapshotHeader {
    /// Version of the program that wrote the snapshot.
    pub tatu: String,
    /// [`fingerprint`] of the scene's document.
    pub document: u64,
    /// Id and version of every loaded plugin, in order.
    pub plugins: Vec<(String, String)>,
    /// Number of steps since the start.
    pub step: u64,
    /// Simulation time, s.
    pub time: f64,
    /// Total state hash.
    pub hash: u64,
    /// Instances whose state could not be saved; the snapshot is complete if there are none.
    pub missed: Vec<UnsavedInstance>,
    /// External inputs up to this step, one JSON line each, for a replay.
    pub log: Vec<u8>,
}

/// Returns the id and version of every plugin.
pub(super) fn plugins(registry: &Registry) -> Vec<(String, String)> {
    registry.plugins.iter().map(|p| (p.id.clone(), p.version.clone())).collect()
}

impl Snapshot {
    pub(super) fn new(head: SnapshotHeader) -> Self {
        Snapshot { head, sections: Vec::new() }
    }

    /// Returns whether every instance could be saved.
    pub fn is_complete(&self) -> bool {
        self.head.missed.is_empty()
    }

    pub(super) fn put(&mut self, name: &str, part: &impl Serialize) -> Result {
        let bytes = postcard::to_stdvec(part)
            .map_err(|e| Error::new("E501", format!("the part `{name}` of a snapshot cannot be written: {e}")))?;
        self.sections.push((name.to_owned(), bytes));
        Ok(())
    }

    /// Reads a section.
    pub(super) fn get<'a, T: Deserialize<'a>>(&'a self, name: &str) -> Result<T> {
        let bytes = self.sections.iter().find(|(n, _)| n == name).map(|(_, b)| b.as_slice());
        let bytes = bytes.ok_or_else(|| damaged(format!("its part `{name}` is missing")))?;
        postcard::from_bytes(bytes).map_err(|e| damaged(format!("its part `{name}` cannot be read: {e}")))
    }

    /// Converts the snapshot to bytes, for [`Snapshot::from_bytes`].
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let body = postcard::to_stdvec(&(&self.head, &self.sections))
            .map_err(|e| Error::new("E501", format!("the snapshot cannot be written: {e}")))?;
        let mut out = Vec::with_capacity(PREFIX_BYTES + body.len());
        out.extend_from_slice(MAGIC);
        out.extend_from_slice(&FORMAT_VERSION.to_le_bytes());
        out.extend_from_slice(&xxh3_64(&body).to_le_bytes());
        out.extend_from_slice(&body);
        Ok(out)
    }

    /// Reads a snapshot from bytes. Truncated or modified bytes, and snapshots of a different format, are refused.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let rest = bytes.strip_prefix(MAGIC).ok_or_else(|| {
            Error::new("E501", "the file is not a snapshot")
                .expected("a file that `tatu run SCENE --snapshot-at T FILE` wrote")
        })?;
        let (format, rest) = rest.split_first_chunk::<4>().ok_or_else(|| damaged("it is truncated"))?;
        let format = u32::from_le_bytes(*format);
        if format != FORMAT_VERSION {
            let text = format!("the snapshot has format {format}, but this program reads format {FORMAT_VERSION}");
            return Err(Error::new("E502", text).help("write it again with this version of the program"));
        }
        let (sum, body) = rest.split_first_chunk::<8>().ok_or_else(|| damaged("it is truncated"))?;
        // The sections refer to each other by index, so damage must be detected before they are read.
        if xxh3_64(body) != u64::from_le_bytes(*sum) {
            return Err(damaged("it is truncated, or bytes in it were changed (the checksum differs)"));
        }
        let (head, sections) = postcard::from_bytes(body).map_err(damaged)?;
        Ok(Snapshot { head, sections })
    }

    /// Writes the file atomically, so that a partly written file never exists under its name.
    pub fn write(&self, path: &Path) -> Result {
        let bytes = self.to_bytes()?;
        let fail = |e: std::io::Error| Error::new("E105", format!("cannot write the snapshot {}: {e}", path.display()));
        super::write_atomically(path, &bytes).map_err(fail)
    }

    /// Reads a snapshot from a file.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = tatu_plugin_api::safe::read_plain(path, crate::session::file::MAX_OWN_FILE_BYTES)
            .map_err(|e| Error::new("E105", format!("cannot read the snapshot {}: {e}", path.display())))?;
        Self::from_bytes(&bytes).map_err(|mut e| {
            e.text = format!("{}: {}", path.display(), e.text);
            e
        })
    }

    /// Checks that a snapshot is of this scene, with these plugins and from this version of the program.
    pub fn check(&self, document: &Document, registry: &Registry) -> Result {
        let own = env!("CARGO_PKG_VERSION");
        if self.head.tatu != own {
            let text = format!("the snapshot was written by version {}, but this is version {own}", self.head.tatu);
            return Err(Error::new("E502", text).help("write it again with this version of the program"));
        }
        if self.head.document != fingerprint(document) {
            return Err(Error::new(
                "E502",
                "the snapshot belongs to a different scene, or to an earlier version of this scene",
            )
            .expected("the same scene file, scripts, `--seed`, `--set` and `--script` as in the run that wrote it"));
        }
        let here = plugins(registry);
        if self.head.plugins == here {
            return Ok(());
        }
        let show = |p: &(String, String)| format!("{} {}", p.0, p.1);
        let lost = self.head.plugins.iter().find(|p| !here.contains(p));
        let new = here.iter().find(|p| !self.head.plugins.contains(p));
        let what = match (lost, new) {
            (Some(l), Some(n)) if l.0 == n.0 => format!("plugin {} has been replaced by version {}", show(l), n.1),
            (Some(l), _) => format!("plugin {} is missing", show(l)),
            (None, Some(n)) => format!("plugin {} was not loaded when the snapshot was written", show(n)),
            (None, None) => "plugins were found in a different order".to_owned(),
        };
        let text = format!("the snapshot was written with different plugins: {what}");
        Err(Error::new("E502", text).help("run with the same plugins, or write the snapshot again"))
    }
}

pub(super) fn damaged(what: impl std::fmt::Display) -> Error {
    Error::new("E501", format!("the snapshot is damaged: {what}"))
        .help("write it again, or copy it again from an intact original")
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn sample() -> Snapshot {
        let missed = UnsavedInstance { object: "/a".into(), plugin: "p".into(), reason: "r".into() };
        let head = SnapshotHeader {
            tatu: "1".into(),
            document: 7,
            plugins: vec![("p".into(), "1.0".into())],
            step: 100,
            time: 5.0,
            hash: 9,
            missed: vec![missed],
            log: vec![1, 2, 3],
        };
        let mut s = Snapshot::new(head);
        s.put("core", &vec![1.5f64; 50]).unwrap();
        s
    }

    #[test]
    fn snapshot_round_trips_through_bytes() {
        let s = sample();
        let back = Snapshot::from_bytes(&s.to_bytes().unwrap()).unwrap();
        assert_eq!(back, s);
        assert_eq!(back.get::<Vec<f64>>("core").unwrap(), vec![1.5; 50]);
        assert_eq!(back.get::<Vec<f64>>("else").unwrap_err().code, "E501");
    }

    proptest! {
        #[test]
        fn truncated_or_modified_bytes_are_refused(at in any::<prop::sample::Index>(), bit in 0u8..8, cut in any::<bool>()) {
            let mut bytes = sample().to_bytes().unwrap();
            let at = at.index(bytes.len());
            if cut { bytes.truncate(at) } else { bytes[at] ^= 1 << bit }
            prop_assert!(Snapshot::from_bytes(&bytes).is_err());
        }

        /// Even with a correct checksum, arbitrary bytes must result in an error or a snapshot, never in a crash.
        #[test]
        fn arbitrary_bodies_never_crash_the_reader(body in prop::collection::vec(any::<u8>(), 0..300)) {
            let mut bytes = MAGIC.to_vec();
            bytes.extend_from_slice(&FORMAT_VERSION.to_le_bytes());
            bytes.extend_from_slice(&xxh3_64(&body).to_le_bytes());
            bytes.extend_from_slice(&body);
            if let Ok(s) = Snapshot::from_bytes(&bytes) {
                let _ = s.get::<super::super::image::CoreImage>("core");
            }
        }
    }
}
