//! Conversion of values between Lua and the ABI.

mod put;
mod read;
mod single;

pub(crate) use put::{put, put_args};
pub(crate) use read::{Reader, Room, take_results, word};
pub(crate) use single::{put_single, to_single};

/// Nesting limit of lists and maps.
const MAX_DEPTH: u32 = 32;
