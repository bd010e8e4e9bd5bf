//! Finds the objects to which scripts refer by names, handles or sets of handles. The module depends on the state of a
//! world, but not on any subject.
//!
//! - `names`: old unique names with a suffix, and paths; `sets`: lists of handles, trees and chains;
//! - `entities`: collections, or the whole scene; `registered`: collision objects and other entities registered by
//!   name.

pub(crate) mod entities;
pub(crate) mod names;
pub(crate) mod registered;
pub(crate) mod sets;
