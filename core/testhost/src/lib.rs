//! The host of tests: opens worlds for tests of plugins, in C, Rust or any other language that can load a library.
//!
//! The library `tatuhost` lies beside the program and exports one function, which gives the table that
//! `plugin-api/include/tatu/test.h` describes. The program itself uses the same table for `tatu plugin test`.
//!
//! - `table`: the functions, and the one that is exported; `answer`: errors, and the guard around each function;
//! - `worlds`: the worlds that are open; `open`: how one is made;
//! - `told`: readings, faults and lines as tests get them.

mod answer;
mod open;
mod table;
mod told;
mod worlds;

pub use open::note_calls_in;
pub use table::{TABLE, tatu_test_host_get};
