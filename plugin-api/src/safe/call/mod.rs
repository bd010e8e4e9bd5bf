//! The interfaces that a plugin uses: the host, worlds, and running calls to commands.

pub(crate) mod catalogue;
pub(crate) mod edits;
pub(crate) mod figures;
pub(crate) mod files;
pub(crate) mod frame;
pub(crate) mod host;
pub(crate) mod outgoing;
pub(crate) mod running;
pub(crate) mod shared_world;
pub(crate) mod stand_ins;
pub(crate) mod talk;
pub(crate) mod world;
