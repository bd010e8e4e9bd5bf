//! Events of a world, delivered in order to their subscribers.
//!
//! - `deliver`: delivers events, at the times that `docs/reference/events.md` specifies;
//! - `contacts`: pairs of shapes that begin, continue and cease to touch.
//!
//! The payload of an event is built only if the event has subscribers; see `Connections::publish`.

mod contacts;
mod deliver;

pub(crate) use contacts::compare as compare_contacts;
pub(crate) use deliver::deliver;
