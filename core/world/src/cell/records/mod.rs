//! What a world records and stores.
//!
//! - `events`: published events; `lines`, `report`: log lines and faults;
//! - `history`: edits, and the states of the scene between them; `changes`: changes of properties;
//! - `stores`, `quotas`: data that scripts store in a world, and its limits; `instance_image`: a plugin instance in a
//!   snapshot.

pub(in crate::cell) mod changes;
pub(in crate::cell) mod events;
pub(crate) mod history;
pub(in crate::cell) mod instance_image;
pub(in crate::cell) mod lines;
pub(in crate::cell) mod quotas;
pub(in crate::cell) mod report;
pub(in crate::cell) mod stores;
