//! Events of a world, delivered in order to their subscribers.
//!
//! - `deliver`: handing out, at the moments that `docs/reference/events.md` states;
//! - `contacts`: shapes that begin, go on and cease to touch.
//!
//! An event without subscribers is not even created: see `Outside::wants`.

mod contacts;
mod deliver;

pub(crate) use contacts::compare as compare_contacts;
pub(crate) use deliver::deliver;
