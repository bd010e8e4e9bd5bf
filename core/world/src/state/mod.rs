//! The state of a world: its hash, and snapshots of it.
//!
//! - `hash`: over the dynamic state, with a table of contents;
//! - [`Snapshot`]: everything that decides the future, as a file (`file`);
//! - `snapshot`, `restore`: out of a world, and into one;
//! - `image`: the parts of a world as they stand in the file;
//! - `document`: which scene a snapshot is of; `save`: a world as a document; `whole`: files that are written as a whole.
//!
//! A world whose state a plugin cannot write comes back by *replay*: a new world of the same scene runs to the step.

mod document;
mod file;
mod hash;
mod image;
pub(crate) mod restore;
pub(crate) mod save;
mod snapshot;
mod whole;

pub use crate::instances::Missed;
pub use document::fingerprint;
pub use file::{Head, Snapshot};
pub use hash::Hash;
pub(crate) use hash::{hash, hash_of};
pub(crate) use snapshot::take;
pub use whole::write_whole;
