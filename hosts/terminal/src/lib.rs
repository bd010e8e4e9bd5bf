//! What programs print on a terminal, also when they end early.
//!
//! - [`report`]: errors, warnings and notes, with the source lines to which they refer; progress;
//! - `crash`: reports crashes, and plugins that end the process;
//! - `table`: tables with columns as wide as their cells;
//! - [`stuck_run`]: ends a run in which a plugin call does not return, after writing its output.

#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub mod crash;
pub mod report;
pub mod stuck_run;
mod table;

pub use stuck_run::Watchdog;
pub use table::table;
