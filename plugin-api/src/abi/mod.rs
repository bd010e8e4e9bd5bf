//! The header `include/tatu.h` in Rust: same names, same order, same sizes (a test compiles C and compares).
//!
//! The header has the documentation; comments here only cover what is specific to Rust. Function fields are `Option`,
//! so that a zeroed table is valid.

#![allow(non_camel_case_types, reason = "names as in the header")]
#![allow(clippy::type_complexity, reason = "types of functions are as long as the header's lines")]
#![allow(missing_docs, reason = "the header is the manual; a second copy of its sentences would drift")]

mod args;
mod ext;
mod frozen;
mod host;
mod test;
mod types;

pub use args::*;
pub use ext::*;
pub use frozen::*;
pub use host::*;
pub use test::*;
pub use types::*;
