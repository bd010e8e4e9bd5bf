//! The simulator embedded in another program: an interpreter, a C program, a test.
//!
//! - [`search`]: locates plugins and models; `restart`: starts this program again;
//! - [`Setup`]: the inputs from which a world is built; [`Seat`]: a world together with these inputs;
//! - [`Host`]: a world on a thread of its own that any thread may use; [`Batch`]: many worlds on several threads;
//! - `line`: hands work to such a thread;
//! - [`sweep`]: many runs that differ in parameters and seeds, each of which produces a row;
//! - [`picture`]: renders what a camera of a world sees.
//!
//! A world belongs to the thread that created it: this is part of the contract with plugins. A world that several
//! threads of the program use therefore needs a thread of its own, to which their calls are handed.
//!
//! The simulator is a guest in the process: it installs no signal handler and no exit hook, and never exits the
//! process.

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
