//! Conversion of values between Lua and the ABI.

mod float32;
mod from_lua;
mod to_lua;

pub(crate) use float32::{put_single, to_single};
pub(crate) use from_lua::{ValueAllocator, ValueReader, take_results};
pub(crate) use to_lua::{put, put_args};

/// Nesting limit of lists and maps.
const MAX_DEPTH: u32 = 32;
