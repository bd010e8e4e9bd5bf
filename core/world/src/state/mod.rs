//! The state of a world: its hash, and snapshots of it.
//!
//! - `hash`: a hash of the dynamic state, with a hash per object;
//! - [`Snapshot`]: all state that determines the future of a run, as a file (`file`);
//! - `snapshot`, `restore`: take and restore a snapshot;
//! - `image`: the serialized parts of a world;
//! - `memento`: states to which a stop or an undo returns; `edits`: makes, undoes and redoes edits;
//! - `source`: converts an edited scene to a scene file; `saving`: writes this file; `recovery`: copies of unsaved
//!   edits;
//! - `document`: the fingerprint of a scene; `save`: a world as a document; `atomic_write`: atomic writing of files.
//!
//! If a plugin cannot save its state, a world can be restored by *replay* instead: a new world of the same scene is run
//! up to the step of the snapshot.

mod atomic_write;
mod document;
pub(crate) mod edits;
mod file;
mod hash;
mod image;
pub(crate) mod memento;
pub(crate) mod recovery;
pub(crate) mod restore;
pub(crate) mod save;
pub(crate) mod saving;
mod snapshot;
mod source;

pub use crate::instances::UnsavedInstance;
pub use atomic_write::write_atomically;
pub use document::fingerprint;
pub use file::{Snapshot, SnapshotHeader};
pub use hash::StateHash;
pub(crate) use hash::{hash, hash_of};
pub(crate) use snapshot::take_snapshot;
