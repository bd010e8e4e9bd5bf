//! What all tests share.
//!
//! - `base`: running the program, scenes in folders of their own, plugins compiled on the way;
//! - `made`: a plugin in C whose parts can be replaced; `said`: what is written to standard error, as snapshots;
//! - `served`: a program that serves, and Python clients; `browser`: a real browser.

mod base;
pub mod browser;
pub mod made;
pub mod said;
pub mod served;

pub use base::*;
