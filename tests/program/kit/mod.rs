//! Helpers of all tests.
//!
//! - `base`: runs the program, creates scenes in temporary folders, compiles plugins;
//! - `made`: a plugin in C whose parts can be replaced; `said`: snapshots of standard error;
//! - `served`: a program that serves, and Python clients; `browser`: a real browser.

mod base;
pub mod browser;
pub mod made;
pub mod said;
pub mod served;

pub use base::*;
