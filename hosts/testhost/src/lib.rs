//! The test host: opens worlds for tests of plugins, in C, Rust or any other language that can load a library.
//!
//! The library `tatuhost` is installed beside the program and exports one function, which returns the table that
//! `plugin-api/include/tatu/test.h` documents. The program itself uses the same table for `tatu plugin test`.
//!
//! - `table`: the functions of the table, and the exported function; `answer`: errors, and the guard around each
//!   function;
//! - `worlds`: the worlds that each thread has opened; `open`: builds a world;
//! - `report`: readings, faults and log lines in the form that tests receive.

mod answer;
mod open;
mod report;
mod table;
mod worlds;

pub use open::set_call_watches;
pub use table::{TABLE, tatu_test_host_get};
