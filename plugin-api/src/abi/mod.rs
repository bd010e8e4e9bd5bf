//! The header `include/tatu.h` in Rust, with the same names, order and sizes; a test compiles the header and compares
//! them.
//!
//! The header contains the documentation; comments in this module only cover what is specific to Rust. Function fields
//! are `Option`, so that a zeroed table is valid.

#![allow(non_camel_case_types, reason = "names as in the header")]
#![allow(clippy::type_complexity, reason = "types of functions are as long as the header's lines")]
#![allow(missing_docs, reason = "the header is the manual; a second copy of its sentences would drift")]

mod args;
mod ext;
mod frozen;
mod host;
mod part;
mod test;
mod types;

pub use args::*;
pub use ext::*;
pub use frozen::*;
pub use host::*;
pub use part::*;
pub use test::*;
pub use types::*;
