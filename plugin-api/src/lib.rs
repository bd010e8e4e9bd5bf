//! The ABI between Tatu and its plugins.
//!
//! - `include/tatu.h`: the ABI and its manual, for plugins in C, C++ and any other language;
//! - [`abi`]: the same declarations in Rust, type by type;
//! - [`safe`]: traits over the ABI and [`tatu_plugin!`], with which a Rust plugin needs no `unsafe`.
//!
//! A Rust plugin is a crate of type `cdylib` (and `rlib`, if a program lists it as a dependency):
//!
//! ```
//! use tatu_plugin_api::safe::*;
//!
//! struct Greeter;
//!
//! impl Plugin for Greeter {
//!     fn start(_: &Host) -> Result<Self> {
//!         Ok(Greeter)
//!     }
//!     fn offer(offer: &mut Offer<Self>) {
//!         offer.command(
//!             Command::new("greeter.double", |c| {
//!                 let x = c.f64(0)?;
//!                 c.ret(2.0 * x);
//!                 Ok(())
//!             })
//!             .param(Param::float("x").text("any number"))
//!             .text("Doubles a number."),
//!         );
//!     }
//! }
//!
//! tatu_plugin_api::tatu_plugin! {
//!     plugin: Greeter,
//!     id: "org.example.greeter",
//!     name: "Greeter",
//!     version: "1.0.0",
//!     licence: "MIT",
//! }
//! # fn main() {}
//! ```

/// Compiles the example of the README as a documentation test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub mod abi;
pub mod safe;
pub mod schemas;
