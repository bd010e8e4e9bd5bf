//! Helpers for all tests.
//!
//! - `base`: runs the program, creates scenes in temporary folders, compiles plugins;
//! - `plugin_sources`: plugins in C with replaceable parts; `said`: snapshots of standard error;
//! - `served_scene`: a running `tatu serve`, and Python clients; `browser`: a real browser.

mod base;
pub mod browser;
pub mod plugin_sources;
pub mod said;
pub mod served_scene;

pub use base::*;
