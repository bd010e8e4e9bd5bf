//! Helpers for all tests.
//!
//! - `base`: runs the program, creates scenes in temporary folders, compiles plugins;
//! - `made`: plugins in C with replaceable parts; `said`: snapshots of standard error;
//! - `served`: a running `tatu serve`, and Python clients; `browser`: a real browser.

mod base;
pub mod browser;
pub mod made;
pub mod said;
pub mod served;

pub use base::*;
