//! Values across the border, both ways.

mod put;
mod read;
mod single;

pub(crate) use put::{put, put_args};
pub(crate) use read::{Reader, Room, take_results, word};
pub(crate) use single::{put_single, to_single};

/// Lists and maps nest at most this deep.
const MAX_DEPTH: u32 = 32;
