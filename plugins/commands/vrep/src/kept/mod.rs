//! What the plugin keeps for a world, as plain data: a file per subject. `state` above holds all of it.

pub(crate) mod collections;
pub(crate) mod consoles;
pub(crate) mod dialogs;
pub(crate) mod messages;
pub(crate) mod motions;
pub(crate) mod profiles;
pub(crate) mod registered;
pub(crate) mod seen;
pub(crate) mod tubes;
pub(crate) mod windows;
pub(crate) mod wireless;
