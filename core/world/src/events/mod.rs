//! Events of a world, delivered in order to their subscribers.
//!
//! - `deliver`: delivery, at the moments that `docs/reference/events.md` states;
//! - `contacts`: pairs of shapes that begin, continue and cease to touch.
//!
//! An event without subscribers is not even created: see `Outside::wants`.

mod contacts;
mod deliver;

pub(crate) use contacts::compare as compare_contacts;
pub(crate) use deliver::deliver;
