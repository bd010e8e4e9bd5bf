//! Which objects scripts mean: by names, handles and sets of them. It knows the state of a world, and no subject.
//!
//! - `names`: old unique names with their suffix, and paths; `sets`: lists of handles, trees and chains;
//! - `entities`: collections, or everything; `registered`: collision objects and their like.

pub(crate) mod entities;
pub(crate) mod names;
pub(crate) mod registered;
pub(crate) mod sets;
