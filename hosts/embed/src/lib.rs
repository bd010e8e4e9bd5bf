//! Embeds the simulator in another program, such as an interpreter, a C program or a test.
//!
//! - [`search`]: locates plugins and models; `restart`: starts this program again;
//! - [`WorldSetup`]: the inputs from which a world is built; [`WorldSlot`]: a world together with these inputs;
//! - [`WorldHost`]: a world on a separate thread, which any thread may use; [`WorldBatch`]: many worlds on several
//!   threads;
//! - [`pack`]: scenes in one file;
//! - `job_queue`: passes jobs to the thread of a host or a batch;
//! - [`sweep`]: many runs with different parameters and seeds, each of which produces a row of results;
//! - [`picture`]: renders the view of a camera.
//!
//! The contract with plugins requires that a world is used only by the thread that created it. A world that several
//! threads of the program use therefore runs on a separate thread, to which their calls are passed.
//!
//! The simulator is a guest in the process: it installs no signal handler and no exit hook, and never exits the
//! process.

mod batch;
pub mod exercise;
mod host;
mod job_queue;
pub mod pack;
mod picture;
mod restart;
pub mod search;
mod setup;
pub mod sweep;
mod world_slot;

pub use batch::WorldBatch;
pub use host::WorldHost;
pub use picture::{CameraView, picture};
pub use restart::{restart_command, set_restart_command};
pub use setup::{SceneSource, WorldSetup, WorldTemplate};
pub use world_slot::{StepOutcome, WorldSlot};
