//! What programs print on a terminal.
//!
//! - [`report`]: errors, warnings and notes, with the source lines to which they refer; progress;
//! - `table`: tables with columns as wide as their cells;
//! - [`watchdog`]: ends a run in which a plugin call does not return, after writing its output.

pub mod report;
mod table;
pub mod watchdog;

pub use table::table;
pub use watchdog::Watchdog;
