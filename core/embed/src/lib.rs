//! Embeds the simulator in another program, such as an interpreter, a C program or a test.
//!
//! - [`search`]: locates plugins and models; `restart`: starts this program again;
//! - [`Setup`]: the inputs from which a world is built; [`Seat`]: a world together with these inputs;
//! - [`Host`]: a world on a separate thread, which any thread may use; [`Batch`]: many worlds on several threads;
//! - `line`: passes jobs to the thread of a host or a batch;
//! - [`sweep`]: many runs with different parameters and seeds, each of which produces a row of results;
//! - [`picture`]: renders the view of a camera.
//!
//! The contract with plugins requires that a world is used only by the thread that created it. A world that several
//! threads of the program use therefore runs on a separate thread, to which their calls are passed.
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
