//! Finds the objects that scripts name: by names, handles and sets of them. It depends on the state of a world, and on
//! no subject.
//!
//! - `names`: old unique names with their suffix, and paths; `sets`: lists of handles, trees and chains;
//! - `entities`: collections, or the whole scene; `registered`: collision objects and similar registrations.

pub(crate) mod entities;
pub(crate) mod names;
pub(crate) mod registered;
pub(crate) mod sets;
