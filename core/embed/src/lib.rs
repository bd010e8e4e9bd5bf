//! The simulator inside another program: an interpreter, a C program, a test.
//!
//! - [`search`]: where plugins and models are found; `restart`: starting this program again;
//! - [`Setup`]: what a world is made of, and [`Seat`]: a world with what it was made of;
//! - [`Host`]: a world on a thread of its own, which any thread may use; [`Batch`]: many worlds on several threads;
//! - `line`: how work is handed to such a thread;
//! - [`sweep`]: many runs that differ in parameters and seeds, each of which gives a row;
//! - [`picture`]: what a camera of a world sees.
//!
//! A world belongs to the thread that made it: this is part of the contract with plugins. So a world that several
//! threads of the program use needs a thread of its own, to which their calls are handed.
//!
//! As a guest in a process it installs no signal handler and no exit hook, and never ends the process.

mod batch;
mod host;
mod line;
mod picture;
mod restart;
pub mod search;
mod seat;
mod setup;
pub mod sweep;

pub use batch::Batch;
pub use host::Host;
pub use picture::{View, picture};
pub use restart::{restart_command, started_by};
pub use seat::{Seat, Stepped};
pub use setup::{Engine, Scene, Setup};
